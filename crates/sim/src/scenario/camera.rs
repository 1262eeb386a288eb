//! The table `[camera]`.

use serde::Deserialize;
use visloc_core::geom::{Camera, Distortion};

use super::{HeadMount, check::Check, load::ScenarioError};
use crate::render::Sensor;

/// Most pixels of an image; each needs some 60 bytes on every thread that draws.
const MAX_PIXELS: u64 = 1 << 24;

visloc_core::with_defaults! {
    /// Calibration and imaging of the robot's camera.
    /// By default the camera of the known-map recordings: 46.4 degrees wide, no distortion.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct CameraSetup {
        /// Width and height, pixels.
        pub size_px: [u32; 2] = [320, 240],
        /// Focal lengths along x and y, pixels.
        pub focal_px: [f64; 2] = [373.3, 373.3],
        /// Principal point, pixels.
        pub center_px: [f64; 2] = [159.5, 119.5],
        /// The lens: `radial-tangential`, `kannala-brandt` (fisheye) or `pinhole`, as in camera files. Absent: radial-tangential, or
        /// pinhole without coefficients.
        pub model: Option<String> = None,
        /// k1, k2, p1, p2 and maybe k3, or k1 to k4 of the fisheye; none for no distortion.
        pub distortion: Vec<f64> = Vec::new(),
        /// How long the shutter is open: motion blur.
        pub shutter_secs: f64 = 0.012,
        /// Brightness against the scene's mean light, in powers of two.
        pub exposure_stops: f64 = 0.0,
        /// How far the automatic exposure wanders up and down, in powers of two.
        pub exposure_drift_stops: f64 = 0.15,
        /// How far the automatic exposure jumps up or down every few seconds, in powers of two.
        pub exposure_step_stops: f64 = 0.0,
        /// Share of light lost in the corners, 0 to 1.
        pub vignetting: f32 = 0.3,
        /// Variance of photon noise at full light, share of full scale.
        pub shot_noise: f32 = 0.0009,
        /// Standard deviation of noise in the dark, share of full scale.
        pub read_noise: f32 = 0.0032,
    }
}

visloc_core::with_defaults! {
    /// One of the tables `[[more_cameras]]`: a further camera on the same head, which takes its images at the same times.
    /// By default in the mouth of a Nao.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct FurtherCamera {
        /// Where it is.
        pub mount: HeadMount = HeadMount::NaoBottomV4,
        /// How far it is turned about the robot's axes against where it is reported (roll, pitch, yaw), constant, degrees.
        pub mount_deg: [f64; 3] = [0.0; 3],
        /// Calibration and imaging; its exposure wanders with that of the first camera.
        pub camera: CameraSetup = CameraSetup::default(),
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
