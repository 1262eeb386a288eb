//! Localization on a known map.

use std::sync::Mutex;

use numpy::PyArray2;
use pyo3::{prelude::*, types::PyDict};
use visloc::{ALGORITHMS, Pipeline, StartPrior, locate::PosePrior};

use crate::{
    arrays::matrix3,
    frames::{Frame, Planar},
    locked, refuse, refused,
    world::Map,
};

/// Names of the algorithms and what each does.
#[pyfunction]
pub fn algorithms() -> Vec<(&'static str, &'static str)> {
    ALGORITHMS.map(|algorithm| (algorithm.name, algorithm.summary)).to_vec()
}

/// One place where the robot may be.
#[pyclass(frozen, get_all, module = "visloc")]
pub struct Hypothesis {
    x_m: f64,
    y_m: f64,
    yaw_rad: f64,
    probability: f64,
}

/// Where the robot is, as far as the localizer knows.
#[pyclass(frozen, module = "visloc")]
pub struct Estimate(visloc::Estimate);

#[pymethods]
impl Estimate {
    #[getter]
    fn x_m(&self) -> f64 {
        self.0.world_from_robot.x_m
    }

    #[getter]
    fn y_m(&self) -> f64 {
        self.0.world_from_robot.y_m
    }

    #[getter]
    fn yaw_rad(&self) -> f64 {
        self.0.world_from_robot.yaw_rad
    }

    /// Over (x, y, heading), meters and radians.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        matrix3(py, &self.0.covariance)
    }

    #[getter]
    fn reliability(&self) -> f64 {
        self.0.reliability
    }

    #[getter]
    fn reliability_up_to_symmetry(&self) -> f64 {
        self.0.reliability_up_to_symmetry
    }

    #[getter]
    fn likelihood(&self) -> f64 {
        self.0.likelihood
    }

    #[getter]
    fn is_localized(&self) -> bool {
        self.0.is_localized()
    }

    /// The most probable first.
    #[getter]
    fn hypotheses(&self) -> Vec<Hypothesis> {
        let each = self.0.hypotheses.iter().map(|it| {
            let pose = it.world_from_robot;
            Hypothesis { x_m: pose.x_m, y_m: pose.y_m, yaw_rad: pose.yaw_rad, probability: it.probability }
        });
        each.collect()
    }

    fn __repr__(&self) -> String {
        let pose = self.0.world_from_robot;
        format!(
            "Estimate(x_m={:.3}, y_m={:.3}, yaw_rad={:.3}, reliability={:.2})",
            pose.x_m, pose.y_m, pose.yaw_rad, self.0.reliability
        )
    }
}

/// Parameters as text of TOML, or as a dict.
pub fn toml_of(parameters: Option<&Bound<'_, PyAny>>) -> PyResult<Option<String>> {
    let Some(parameters) = parameters else { return Ok(None) };
    if let Ok(text) = parameters.extract::<String>() {
        return Ok(Some(text));
    }
    if parameters.cast::<PyDict>().is_err() {
        return refuse(format!("parameters: expected TOML or a dict, found {}", parameters.get_type()));
    }
    let json = parameters.py().import("json")?.call_method1("dumps", (parameters,))?.extract::<String>()?;
    let table: toml::Table = serde_json::from_str(&json).map_err(refused)?;
    toml::to_string(&table).map(Some).map_err(refused)
}

/// Finds and follows a robot on a map.
#[pyclass(frozen, module = "visloc")]
pub struct Localizer {
    pipeline: Mutex<Pipeline>,
    start: StartPrior,
}

#[pymethods]
impl Localizer {
    #[new]
    #[pyo3(signature = (map, algorithm = "evolutionary", *, seed = 1, parameters = None, pipeline = None, start = None,
                        start_spread_m = 0.3, start_spread_rad = 0.2))]
    #[allow(clippy::too_many_arguments)] // They have names.
    fn new(
        map: &Map,
        algorithm: &str,
        seed: u64,
        parameters: Option<&Bound<'_, PyAny>>,
        pipeline: Option<&Bound<'_, PyAny>>,
        start: Option<Planar>,
        start_spread_m: f64,
        start_spread_rad: f64,
    ) -> PyResult<Self> {
        let config = match toml_of(pipeline)? {
            Some(text) => toml::from_str(&text).map_err(refused)?,
            None => visloc::PipelineConfig::default(),
        };
        let start = start.map_or(StartPrior::Uniform, |(x_m, y_m, yaw_rad)| {
            StartPrior::Poses(vec![PosePrior {
                world_from_robot: visloc::PlanarPose::new(x_m, y_m, yaw_rad),
                position_spread_m: start_spread_m,
                heading_spread_rad: start_spread_rad,
                weight: 1.0,
            }])
        });
        let parameters = toml_of(parameters)?;
        let builder = Pipeline::builder(&map.0).named(algorithm, parameters.as_deref()).config(config);
        // As the program, so that a seed gives the same bits there and here.
        let rng = visloc::RngTree::new(seed).subtree("pipeline", 0);
        let pipeline = builder.rng(rng).start(start.clone()).build().map_err(refused)?;
        Ok(Self { pipeline: Mutex::new(pipeline), start })
    }

    /// Takes in a frame; frames come in the order of time.
    fn step(&self, py: Python<'_>, frame: &Frame) -> PyResult<Estimate> {
        let (pipeline, frame) = (&self.pipeline, &frame.frame);
        py.detach(|| locked(pipeline).step(frame).cloned()).map(Estimate).map_err(refused)
    }

    /// The answer to the last frame.
    #[getter]
    fn estimate(&self) -> Estimate {
        Estimate(locked(&self.pipeline).estimate().clone())
    }

    /// Forgets where the robot was.
    fn reset(&self) {
        locked(&self.pipeline).reset_to(&self.start);
    }
}
