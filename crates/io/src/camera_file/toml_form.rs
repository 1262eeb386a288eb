//! Our own form.

use std::{collections::BTreeMap, ops::Range};

use serde::{Deserialize, Serialize, de::DeserializeOwned};
use toml::{Spanned, Value};
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

/// Why a value is not of a type.
fn fault_as<T: DeserializeOwned>(value: Value) -> Option<String> {
    T::deserialize(value).err().map(|error| error.message().to_owned())
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

/// The keys that every camera has, with what is expected there.
const NEEDED: [(&str, &str); 4] = [
    ("model", "\"pinhole\""),
    ("size_px", "[width, height]"),
    ("focal_px", "[fx, fy]"),
    ("center_px", "[cx, cy]"),
];

/// The keys that a camera may have: how well it is known is written by a calibration, where it stood by the page by hand.
const OTHERS: [&str; 3] = ["distortion", "quality", "pose"];

impl CameraToml {
    /// The table of a text.
    ///
    /// # Errors
    /// If it is not TOML, or all that cannot be used, each with its line, and all that is missing.
    pub fn read(text: &str) -> Result<Self, String> {
        let in_line = |span: Option<Range<usize>>, message: &str| {
            let line = span.map_or(1, |span| text[..span.start].lines().count().max(1));
            format!("line {line}: {message}")
        };
        let table: BTreeMap<String, Spanned<Value>> =
            toml::from_str(text).map_err(|error| in_line(error.span(), error.message()))?;
        let mut faults = Vec::new();
        let mut check = |key: &str, fault: fn(Value) -> Option<String>| {
            let Some(value) = table.get(key) else { return };
            if let Some(fault) = fault(value.get_ref().clone()) {
                faults.push(in_line(Some(value.span()), &format!("{key}: {fault}")));
            }
        };
        check("model", fault_as::<String>);
        check("size_px", fault_as::<[u32; 2]>);
        check("focal_px", fault_as::<[f64; 2]>);
        check("center_px", fault_as::<[f64; 2]>);
        check("distortion", fault_as::<Vec<f64>>);
        let is_known = |key: &str| OTHERS.contains(&key) || NEEDED.iter().any(|(known, _)| *known == key);
        for (key, value) in table.iter().filter(|(key, _)| !is_known(key)) {
            let known: Vec<&str> = NEEDED.iter().map(|(known, _)| *known).chain(OTHERS).collect();
            let message = format!("{key}: expected one of {}", known.join(", "));
            faults.push(in_line(Some(value.span()), &message));
        }
        let missing: Vec<String> = NEEDED
            .iter()
            .filter(|(key, _)| !table.contains_key(*key))
            .map(|(key, form)| format!("{key} = {form}"))
            .collect();
        if !missing.is_empty() {
            faults.push(format!("expected {}, found none", missing.join(", ")));
        }
        if !faults.is_empty() {
            return Err(faults.join("; "));
        }
        toml::from_str(text).map_err(|error| in_line(error.span(), error.message()))
    }

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
