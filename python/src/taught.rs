//! Maps that SLAM has made, and cameras in them.

use std::{path::PathBuf, sync::Mutex};

use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2, ndarray::Array2};
use pyo3::prelude::*;
use visloc::{
    GrayFrame, SlamConfig, Timestamp,
    vmap::{self, ScaleSource, Support},
};

use crate::{
    arrays::{gray_image, matrix, transform},
    localizer::toml_of,
    locked, refused,
    world::Camera,
};

/// A map that SLAM has made.
#[pyclass(frozen, module = "visloc")]
pub struct VisualMap {
    map: vmap::VisualMap,
    damages: Vec<String>,
}

#[pymethods]
impl VisualMap {
    /// Reads a file.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        let opened = vmap::load(&path).map_err(refused)?;
        let damages = opened.damages.iter().map(ToString::to_string).collect();
        Ok(Self { map: opened.map, damages })
    }

    #[getter]
    fn num_keyframes(&self) -> usize {
        self.map.map.all_keyframes().count()
    }

    /// What of the file is damaged.
    #[getter]
    fn damages(&self) -> Vec<String> {
        self.damages.clone()
    }

    /// Whether lengths are meters.
    #[getter]
    fn is_in_meters(&self) -> bool {
        self.map.largest().is_some_and(|map| self.map.scale(map).source != ScaleSource::Unknown)
    }
}

/// Where a camera is in a map.
#[pyclass(frozen, module = "visloc")]
pub struct CameraEstimate(vmap::CameraEstimate);

#[pymethods]
impl CameraEstimate {
    #[getter]
    fn world_from_camera<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        matrix(py, &self.0.world_from_camera)
    }

    /// 6 x 6, translation first, in the frame of the camera.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        Array2::from_shape_fn((6, 6), |(row, column)| self.0.covariance[(row, column)]).into_pyarray(py)
    }

    #[getter]
    fn reliability(&self) -> f64 {
        self.0.reliability
    }

    #[getter]
    fn is_localized(&self) -> bool {
        self.0.is_localized()
    }

    /// `map`, `motion` or `odometry`.
    #[getter]
    fn support(&self) -> &'static str {
        match self.0.support {
            Support::Map => "map",
            Support::Motion => "motion",
            Support::Odometry => "odometry",
        }
    }
}

/// Finds a camera in a map and follows it there.
#[pyclass(frozen, module = "visloc")]
pub struct MapLocalizer(Mutex<vmap::MapLocalizer>);

#[pymethods]
impl MapLocalizer {
    #[new]
    #[pyo3(signature = (map, camera, *, parameters = None, seed = 1))]
    fn new(
        map: &VisualMap,
        camera: &Camera,
        parameters: Option<&Bound<'_, PyAny>>,
        seed: u64,
    ) -> PyResult<Self> {
        let mut config = SlamConfig::default();
        if let Some(text) = toml_of(parameters)? {
            config = config.with_toml(&text).map_err(refused)?;
        }
        let meters_per_unit = map.is_in_meters().then_some(1.0);
        let made = vmap::MapLocalizer::new(&map.map.map, meters_per_unit, &camera.0, &config, seed);
        Ok(Self(Mutex::new(made.map_err(refused)?)))
    }

    /// Takes in an image, color or gray; images come in the order of time.
    #[pyo3(signature = (at_s, image, *, odom_from_camera = None))]
    fn step(
        &self,
        py: Python<'_>,
        at_s: f64,
        image: &Bound<'_, PyAny>,
        odom_from_camera: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Option<CameraEstimate>> {
        let odom_from_camera = odom_from_camera.as_ref().map(transform).transpose()?;
        let frame = GrayFrame::new(Timestamp::from_secs(at_s), gray_image(image)?);
        let frame = GrayFrame { odom_from_camera, ..frame };
        let localizer = &self.0;
        let step = || locked(localizer).step(frame);
        Ok(py.detach(step).map_err(refused)?.map(CameraEstimate))
    }
}
