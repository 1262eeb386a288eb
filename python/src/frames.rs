//! Frames of a robot, images of a camera, and where they come from.

use std::path::PathBuf;

use numpy::{PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::prelude::*;
use visloc::{
    GroundContact, ImageSource, Mount, PlanarPose, Source, SourceFrame, Timestamp, Truth,
    io::sources::{Host, SourceOptions, open_frames, open_images},
};

use crate::{
    arrays::{color_array, gray_array, matrix, rgb_image, transform},
    refused,
    world::{Camera, Map},
};

/// A pose on the ground: x and y in meters, heading in radians.
pub type Planar = (f64, f64, f64);

/// What a robot senses at a moment.
#[pyclass(frozen, module = "visloc")]
pub struct Frame {
    pub frame: visloc::Frame,
    truth: Option<Truth>,
}

#[pymethods]
impl Frame {
    #[new]
    #[pyo3(signature = (at_s, image, camera, *, height_m = None, tilt_rad = 0.0, pan_rad = 0.0, roll_rad = 0.0, forward_m = 0.0,
                        robot_from_camera = None, odometry = None, is_on_ground = None))]
    #[allow(clippy::too_many_arguments)] // They have names.
    fn new(
        at_s: f64,
        image: &Bound<'_, PyAny>,
        camera: &Camera,
        height_m: Option<f64>,
        tilt_rad: f64,
        pan_rad: f64,
        roll_rad: f64,
        forward_m: f64,
        robot_from_camera: Option<PyReadonlyArray2<'_, f64>>,
        odometry: Option<Planar>,
        is_on_ground: Option<bool>,
    ) -> PyResult<Self> {
        let robot_from_camera = match (robot_from_camera, height_m) {
            (Some(matrix), None) => transform(&matrix)?,
            (None, Some(height_m)) => {
                Mount { height_m, forward_m, tilt_rad, pan_rad, roll_rad }.robot_from_camera()
            }
            _ => {
                return crate::refuse(
                    "frame: expected either height_m (with tilt_rad, pan_rad, roll_rad, forward_m) or robot_from_camera",
                );
            }
        };
        let mut frame =
            visloc::Frame::new(Timestamp::from_secs(at_s), rgb_image(image)?, camera.0, robot_from_camera);
        frame.odometry = odometry.map(|(x_m, y_m, yaw_rad)| PlanarPose::new(x_m, y_m, yaw_rad));
        frame.ground_contact = is_on_ground.map(GroundContact::Contact);
        Ok(Self { frame, truth: None })
    }

    /// Seconds.
    #[getter]
    fn at_s(&self) -> f64 {
        self.frame.at.secs()
    }

    /// height x width x 3, red first.
    #[getter]
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        color_array(py, self.frame.image.clone())
    }

    #[getter]
    fn camera(&self) -> Camera {
        Camera(self.frame.camera)
    }

    #[getter]
    fn robot_from_camera<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        matrix(py, &self.frame.robot_from_camera)
    }

    #[getter]
    fn odometry(&self) -> Option<Planar> {
        self.frame.odometry.map(|pose| (pose.x_m, pose.y_m, pose.yaw_rad))
    }

    /// Where the robot really was, if the source knows it.
    #[getter]
    fn truth(&self) -> Option<Planar> {
        self.truth.map(|truth| {
            let pose = truth.world_from_robot;
            (pose.x_m, pose.y_m, pose.yaw_rad)
        })
    }
}

/// The frames of a source, one after the other.
// Sources may hold handles of the system that stay on one thread.
#[pyclass(unsendable, module = "visloc")]
pub struct Frames {
    source: Box<dyn Source<SourceFrame>>,
    map: Option<visloc::Map>,
    warnings: Vec<String>,
}

#[pymethods]
impl Frames {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__(&mut self) -> PyResult<Option<Frame>> {
        let next = self.source.next_item().transpose().map_err(refused)?;
        Ok(next.map(|next| Frame { frame: next.frame, truth: next.truth }))
    }

    /// The map that the frames belong to, if the source knows it.
    #[getter]
    fn map(&self) -> Option<Map> {
        self.map.clone().map(Map)
    }

    /// What the user should know.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// What was left out so far, with reasons.
    #[getter]
    fn skipped(&self) -> Vec<String> {
        self.source.status().skipped.iter().map(|it| format!("{}: {}", it.origin, it.reason)).collect()
    }
}

fn options(camera: Option<PathBuf>, seed: Option<u64>, scale: Option<f64>) -> SourceOptions {
    SourceOptions { camera, seed, scale, ..SourceOptions::default() }
}

/// Opens everything that a robot senses: a bag, a simulation (`sim:robocup`), a dataset with a mount.
#[pyfunction]
#[pyo3(signature = (source, *, camera = None, seed = None))]
pub fn frames(source: &str, camera: Option<PathBuf>, seed: Option<u64>) -> PyResult<Frames> {
    let open = open_frames(source, &options(camera, seed, None), &Host::silent()).map_err(refused)?;
    Ok(Frames { source: open.frames, map: open.map, warnings: open.warnings })
}

/// The gray images of a source with the calibration of their camera.
#[pyclass(unsendable, module = "visloc")]
pub struct Images {
    source: Box<dyn ImageSource>,
    truth: Option<visloc::CameraTrajectory>,
    warnings: Vec<String>,
}

#[pymethods]
impl Images {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__<'py>(&mut self, py: Python<'py>) -> PyResult<Option<(f64, Bound<'py, PyArray2<u8>>)>> {
        let Some(next) = self.source.next_item().transpose().map_err(refused)? else { return Ok(None) };
        Ok(Some((next.at.secs(), gray_array(py, &next.image)?)))
    }

    #[getter]
    fn camera(&self) -> Camera {
        Camera(*self.source.camera())
    }

    /// True poses, `(seconds, world_from_camera)`, if they are known.
    #[getter]
    fn truth<'py>(&self, py: Python<'py>) -> Option<Vec<(f64, Bound<'py, PyArray2<f64>>)>> {
        let poses = self.truth.as_ref()?.poses().iter();
        Some(poses.map(|pose| (pose.at.secs(), matrix(py, &pose.world_from_camera))).collect())
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }
}

/// Opens the images of a camera: a folder, a dataset, a bag, a video, a simulation (`sim:room`).
#[pyfunction]
#[pyo3(signature = (source, *, camera = None, seed = None, scale = None))]
pub fn images(
    source: &str,
    camera: Option<PathBuf>,
    seed: Option<u64>,
    scale: Option<f64>,
) -> PyResult<Images> {
    let open = open_images(source, &options(camera, seed, scale), &Host::silent()).map_err(refused)?;
    Ok(Images { source: open.images, truth: open.truth, warnings: open.warnings })
}
