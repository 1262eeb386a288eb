//! SLAM: one camera without a map.

use std::{cmp::Reverse, collections::BTreeMap, path::PathBuf, sync::Mutex};

use numpy::{IntoPyArray, PyArray2, ndarray::Array2};
use pyo3::prelude::*;
use visloc::{
    FrameOutcome, Schedule, SlamConfig, Timestamp,
    vmap::{Session, VisualMap, save},
};

use crate::{
    arrays::{gray_image, matrix},
    localizer::toml_of,
    locked, refused,
    world::Camera,
};

/// What became of an image.
#[pyclass(frozen, module = "visloc")]
pub struct SlamOutcome(FrameOutcome);

#[pymethods]
impl SlamOutcome {
    /// `starting`, `tracking`, `supposed` (where it may be; the map does not change), `carried` (by odometry) or `lost`.
    #[getter]
    fn state(&self) -> &'static str {
        self.0.state.name()
    }

    /// 4 x 4, in units of the map; `None` without a pose.
    #[getter]
    fn world_from_camera<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<f64>>> {
        self.0.camera_from_world.as_ref().map(|pose| matrix(py, &pose.inverse()))
    }

    /// Number of the map that the pose is in; `None` without a pose. Maps are joined later when they meet.
    #[getter]
    fn map(&self) -> Option<usize> {
        self.0.map.map(visloc::slam::map::MapId::index)
    }

    /// Landmarks that were recognized, and those that were looked for.
    #[getter]
    fn matches(&self) -> (usize, usize) {
        self.0.matches
    }
}

/// Follows one camera, and makes a map of what it sees.
#[pyclass(frozen, module = "visloc")]
pub struct Slam(Mutex<visloc::Slam>);

#[pymethods]
impl Slam {
    #[new]
    #[pyo3(signature = (camera, *, preset = None, parameters = None, seed = 1, threaded = false))]
    fn new(
        camera: &Camera,
        preset: Option<&str>,
        parameters: Option<&Bound<'_, PyAny>>,
        seed: u64,
        threaded: bool,
    ) -> PyResult<Self> {
        let mut config = preset.map_or(Ok(SlamConfig::default()), SlamConfig::preset).map_err(refused)?;
        if let Some(text) = toml_of(parameters)? {
            config = config.with_toml(&text).map_err(refused)?;
        }
        let schedule = if threaded { Schedule::Threaded } else { Schedule::Sequential };
        let mut slam = visloc::Slam::with_schedule(&camera.0, &config, seed, schedule).map_err(refused)?;
        slam.set_packing(visloc::vmap::packing());
        Ok(Self(Mutex::new(slam)))
    }

    /// Takes in an image, color or gray; images come in the order of time.
    fn add_image(&self, py: Python<'_>, at_s: f64, image: &Bound<'_, PyAny>) -> PyResult<SlamOutcome> {
        let image = gray_image(image)?;
        let slam = &self.0;
        let add = || locked(slam).add_frame(Timestamp::from_secs(at_s), image);
        py.detach(add).map(SlamOutcome).map_err(refused)
    }

    /// Waits until everything is mapped and adjusts the maps as a whole: no more images come.
    fn finish(&self, py: Python<'_>) {
        let slam = &self.0;
        py.detach(|| drop(locked(slam).complete()));
    }

    /// Final poses: `(seconds, world_from_camera)`, of one map or of all.
    #[pyo3(signature = (map = None))]
    fn trajectory<'py>(&self, py: Python<'py>, map: Option<usize>) -> Vec<(f64, Bound<'py, PyArray2<f64>>)> {
        let poses = locked(&self.0).trajectory();
        let wanted = poses.iter().filter(|pose| map.is_none_or(|map| pose.map.index() == map));
        wanted.map(|pose| (pose.at.secs(), matrix(py, &pose.world_from_camera))).collect()
    }

    /// Numbers of the maps that poses are in, the one with the most poses first.
    #[getter]
    fn maps(&self) -> Vec<usize> {
        let mut num_poses = BTreeMap::new();
        for pose in locked(&self.0).trajectory() {
            *num_poses.entry(pose.map.index()).or_insert(0_usize) += 1;
        }
        let mut maps: Vec<_> = num_poses.into_iter().collect();
        maps.sort_by_key(|(_, num_poses)| Reverse(*num_poses));
        maps.into_iter().map(|(map, _)| map).collect()
    }

    /// Positions of the landmarks, (N, 3), in units of the map.
    fn landmarks<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let slam = locked(&self.0);
        let map = slam.map();
        let points: Vec<_> = map.landmarks().map(|(_, landmark)| landmark.point_in_world).collect();
        Array2::from_shape_fn((points.len(), 3), |(i, axis)| points[i][axis]).into_pyarray(py)
    }

    /// Writes the map to a file. One that was there is kept as `NAME~`.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let slam = locked(&self.0);
        let session = Session {
            source: "images".to_owned(),
            program: concat!("visloc for Python ", env!("CARGO_PKG_VERSION")).to_owned(),
            num_images: slam.frames().len() as u64,
            seed: 0,
        };
        let map = VisualMap::default().after(&slam, session);
        save(&path, &map, &slam.session_camera()).map_err(refused)
    }

    #[getter]
    fn num_keyframes(&self) -> usize {
        locked(&self.0).map().keyframes().count()
    }
}
