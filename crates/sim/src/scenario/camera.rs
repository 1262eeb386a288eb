//! The table `[camera]`.

use serde::Deserialize;
use visloc_core::geom::{Camera, Distortion};

use super::{HeadMount, check::Check, load::ScenarioError};
use crate::render::Sensor;

/// Most pixels of an image; each needs some 60 bytes on every thread that draws.
const MAX_PIXELS: u64 = 1 << 24;

/// Calibration and imaging of the robot's camera.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraSetup {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// Focal lengths along x and y, pixels.
    pub focal_px: [f64; 2],
    /// Principal point, pixels.
    pub center_px: [f64; 2],
    /// The lens: `radial-tangential`, `kannala-brandt` (fisheye) or `pinhole`, as in camera files. Absent: radial-tangential, or
    /// pinhole without coefficients.
    pub model: Option<String>,
    /// k1, k2, p1, p2 and maybe k3, or k1 to k4 of the fisheye; none for no distortion.
    pub distortion: Vec<f64>,
    /// How long the shutter is open: motion blur.
    pub shutter_secs: f64,
    /// Brightness against the scene's mean light, in powers of two.
    pub exposure_stops: f64,
    /// How far the automatic exposure wanders up and down, in powers of two.
    pub exposure_drift_stops: f64,
    /// How far the automatic exposure jumps up or down every few seconds, in powers of two.
    pub exposure_step_stops: f64,
    /// Share of light lost in the corners, 0 to 1.
    pub vignetting: f32,
    /// Variance of photon noise at full light, share of full scale.
    pub shot_noise: f32,
    /// Standard deviation of noise in the dark, share of full scale.
    pub read_noise: f32,
}

/// One of the tables `[[more_cameras]]`: a further camera on the same head, which takes its images at the same times.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FurtherCamera {
    /// Where it is.
    pub mount: HeadMount,
    /// How far it is turned about the robot's axes against where it is reported (roll, pitch, yaw), constant, degrees.
    pub mount_deg: [f64; 3],
    /// Calibration and imaging; its exposure wanders with that of the first camera.
    pub camera: CameraSetup,
}

impl Default for FurtherCamera {
    /// In the mouth of a Nao.
    fn default() -> Self {
        Self { mount: HeadMount::NaoBottomV4, mount_deg: [0.0; 3], camera: CameraSetup::default() }
    }
}

impl FurtherCamera {
    pub(super) fn check(&self, check: &Check<'_>) -> Result<(), ScenarioError> {
        for angle in self.mount_deg {
            check.range("more_cameras.mount_deg", angle, -45.0..=45.0)?;
        }
        self.camera.check(check)
    }
}

impl Default for CameraSetup {
    /// The camera of the known-map recordings: 46.4 degrees wide, no distortion.
    fn default() -> Self {
        Self {
            size_px: [320, 240],
            focal_px: [373.3, 373.3],
            center_px: [159.5, 119.5],
            model: None,
            distortion: Vec::new(),
            shutter_secs: 0.012,
            exposure_stops: 0.0,
            exposure_drift_stops: 0.15,
            exposure_step_stops: 0.0,
            vignetting: 0.3,
            shot_noise: 0.0009,
            read_noise: 0.0032,
        }
    }
}

impl CameraSetup {
    /// The calibration.
    ///
    /// # Errors
    /// If no camera can have these values; what was expected and what was found.
    pub fn camera(&self) -> Result<Camera, String> {
        let camera =
            Camera::checked(self.size_px.into(), self.focal_px.into(), self.center_px.into(), self.lens()?);
        camera.map_err(|error| error.to_string())
    }

    fn lens(&self) -> Result<Distortion, String> {
        let named = |name: &str| self.model.as_deref().is_none_or(|model| model == name);
        match self.distortion[..] {
            [] if named("pinhole") => Ok(Distortion::None),
            [k1, k2, p1, p2] if named("radial-tangential") => {
                Ok(Distortion::RadialTangential([k1, k2, p1, p2, 0.0]))
            }
            [k1, k2, p1, p2, k3] if named("radial-tangential") => {
                Ok(Distortion::RadialTangential([k1, k2, p1, p2, k3]))
            }
            [k1, k2, k3, k4] if named("kannala-brandt") => Ok(Distortion::KannalaBrandt([k1, k2, k3, k4])),
            _ => Err(format!(
                "{} with {} coefficients of distortion (\"pinhole\" has none, \"radial-tangential\" 4 or 5, \
                 \"kannala-brandt\" 4)",
                self.model.as_ref().map_or("no model".to_owned(), |model| format!("model \"{model}\"")),
                self.distortion.len()
            )),
        }
    }

    pub(crate) fn sensor(&self) -> Sensor {
        Sensor { vignetting: self.vignetting, shot_noise: self.shot_noise, read_noise: self.read_noise }
    }

    pub(super) fn check(&self, check: &Check<'_>) -> Result<(), ScenarioError> {
        for size in self.size_px {
            let expected = "a width and a height from 8 to 8192";
            check.that((8..=8192).contains(&size), "camera.size_px", expected, size)?;
        }
        let [width, height] = self.size_px.map(u64::from);
        let expected = format!("at most {MAX_PIXELS} pixels in all");
        check.that(width * height <= MAX_PIXELS, "camera.size_px", &expected, width * height)?;
        if let Err(error) = self.camera() {
            return check.that(false, "camera", "a possible calibration", error);
        }
        check.range("camera.shutter_secs", self.shutter_secs, 0.0..=0.1)?;
        check.range("camera.exposure_stops", self.exposure_stops, -6.0..=6.0)?;
        check.range("camera.exposure_drift_stops", self.exposure_drift_stops, 0.0..=4.0)?;
        check.range("camera.exposure_step_stops", self.exposure_step_stops, 0.0..=4.0)?;
        check.range("camera.vignetting", f64::from(self.vignetting), 0.0..=1.0)?;
        check.range("camera.shot_noise", f64::from(self.shot_noise), 0.0..=1.0)?;
        check.range("camera.read_noise", f64::from(self.read_noise), 0.0..=1.0)
    }
}
