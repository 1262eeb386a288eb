//! Maps and cameras.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2, ndarray::Array2};
use pyo3::prelude::*;
use visloc::{
    Distortion,
    io::camera_file::{CameraFormat, read_camera, write_camera},
    nalgebra::{Point2, Point3},
    world::BUILT_IN_MAPS,
};

use crate::{refuse, refused};

/// A known map: the name of one that is built in, or a file.
#[pyclass(frozen, module = "visloc")]
pub struct Map(pub visloc::Map);

#[pymethods]
impl Map {
    #[new]
    fn new(name: &str) -> PyResult<Self> {
        visloc::Map::load(name).map(Self).map_err(refused)
    }

    /// The name that the map gives itself.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// The map as text of its file.
    fn to_toml(&self) -> PyResult<String> {
        self.0.to_toml().map_err(refused)
    }

    fn __repr__(&self) -> String {
        format!("Map({:?})", self.0.name())
    }
}

/// Names of the maps that are built in.
#[pyfunction]
pub fn map_names() -> Vec<&'static str> {
    BUILT_IN_MAPS.map(|(name, _)| name).to_vec()
}

/// The calibration of a camera.
#[pyclass(frozen, module = "visloc")]
#[derive(Clone, Copy)]
pub struct Camera(pub visloc::Camera);

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (size_px, focal_px, center_px, distortion = vec![], model = "radial-tangential"))]
    fn new(
        size_px: (u32, u32),
        focal_px: (f64, f64),
        center_px: (f64, f64),
        distortion: Vec<f64>,
        model: &str,
    ) -> PyResult<Self> {
        let lens = match (model, distortion.as_slice()) {
            (_, []) => Distortion::None,
            ("radial-tangential", [k1, k2, p1, p2]) => {
                Distortion::RadialTangential([*k1, *k2, *p1, *p2, 0.0])
            }
            ("radial-tangential", [k1, k2, p1, p2, k3]) => {
                Distortion::RadialTangential([*k1, *k2, *p1, *p2, *k3])
            }
            ("kannala-brandt", [k1, k2, k3, k4]) => Distortion::KannalaBrandt([*k1, *k2, *k3, *k4]),
            (model, values) => {
                return refuse(format!(
                    "camera: expected radial-tangential with 4 or 5 values or kannala-brandt with 4, found {model} with {}",
                    values.len()
                ));
            }
        };
        visloc::Camera::checked(size_px, focal_px, center_px, lens).map(Self).map_err(refused)
    }

    /// Reads a calibration: visloc's own form, ROS, Kalibr, OpenCV, and those of datasets.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        read_camera(&path).map(Self).map_err(refused)
    }

    /// The calibration as text of a file of visloc, which `load` reads.
    fn to_toml(&self) -> PyResult<String> {
        write_camera(&self.0, CameraFormat::Toml, "").or_else(refuse)
    }

    #[getter]
    fn size_px(&self) -> (u32, u32) {
        self.0.size_px()
    }

    #[getter]
    fn focal_px(&self) -> (f64, f64) {
        self.0.focal_px()
    }

    #[getter]
    fn center_px(&self) -> (f64, f64) {
        self.0.center_px()
    }

    /// Pixels of points in the camera's frame; NaN where a point has none.
    fn project<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = points.as_array();
        if points.ncols() != 3 {
            return refuse(format!("points: expected shape (N, 3), found {:?}", points.shape()));
        }
        let mut pixels = Array2::from_elem((points.nrows(), 2), f64::NAN);
        for (point, mut out) in points.rows().into_iter().zip(pixels.rows_mut()) {
            if let Ok(px) = self.0.project(&Point3::new(point[0], point[1], point[2])) {
                (out[0], out[1]) = (px.x, px.y);
            }
        }
        Ok(pixels.into_pyarray(py))
    }

    /// Directions of length 1 in the camera's frame towards pixels.
    fn bearing<'py>(
        &self,
        py: Python<'py>,
        pixels: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let pixels = pixels.as_array();
        if pixels.ncols() != 2 {
            return refuse(format!("pixels: expected shape (N, 2), found {:?}", pixels.shape()));
        }
        let mut directions = Array2::zeros((pixels.nrows(), 3));
        for (px, mut out) in pixels.rows().into_iter().zip(directions.rows_mut()) {
            let bearing = self.0.bearing(&Point2::new(px[0], px[1]));
            (out[0], out[1], out[2]) = (bearing.x, bearing.y, bearing.z);
        }
        Ok(directions.into_pyarray(py))
    }

    fn __repr__(&self) -> String {
        let (size, focal, center) = (self.0.size_px(), self.0.focal_px(), self.0.center_px());
        format!("Camera(size_px={size:?}, focal_px={focal:?}, center_px={center:?})")
    }
}
