//! Our own form.

use serde::{Deserialize, Serialize};
use visloc_core::geom::{Camera, CameraError, Distortion};

/// A camera as a TOML table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CameraToml {
    /// `radial-tangential`, `kannala-brandt` or `pinhole`.
    pub model: String,
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// fx and fy, pixels.
    pub focal_px: [f64; 2],
    /// cx and cy, pixels; the center of the top-left pixel is (0, 0).
    pub center_px: [f64; 2],
    /// k1, k2, p1, p2, k3, or k1 to k4 of the fisheye.
    #[serde(default)]
    pub distortion: Vec<f64>,
}

impl From<&Camera> for CameraToml {
    fn from(camera: &Camera) -> Self {
        let model = match camera.distortion() {
            Distortion::RadialTangential(_) => "radial-tangential",
            Distortion::KannalaBrandt(_) => "kannala-brandt",
            _ => "pinhole",
        };
        Self {
            model: model.to_owned(),
            size_px: camera.size_px().into(),
            focal_px: camera.focal_px().into(),
            center_px: camera.center_px().into(),
            distortion: camera.distortion().coefficients().to_vec(),
        }
    }
}

impl CameraToml {
    /// The camera.
    ///
    /// # Errors
    /// What was expected and what was found.
    pub fn camera(&self) -> Result<Camera, String> {
        let lens = match (self.model.as_str(), &self.distortion[..]) {
            ("pinhole", []) => Distortion::None,
            ("radial-tangential", [k1, k2, p1, p2]) => {
                Distortion::RadialTangential([*k1, *k2, *p1, *p2, 0.0])
            }
            ("radial-tangential", [k1, k2, p1, p2, k3]) => {
                Distortion::RadialTangential([*k1, *k2, *p1, *p2, *k3])
            }
            ("kannala-brandt", [k1, k2, k3, k4]) => Distortion::KannalaBrandt([*k1, *k2, *k3, *k4]),
            (model, k) => {
                return Err(format!(
                    "expected model \"pinhole\" without distortion, \"radial-tangential\" with 4 or 5 coefficients or \
                     \"kannala-brandt\" with 4, found \"{model}\" with {}",
                    k.len()
                ));
            }
        };
        Camera::checked(self.size_px.into(), self.focal_px.into(), self.center_px.into(), lens)
            .map_err(|error: CameraError| error.to_string())
    }
}
