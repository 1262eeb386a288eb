//! Estimates compared with the truth.

use numpy::{PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3, ndarray::Axis};
use pyo3::{prelude::*, types::PyDict};
use visloc::{
    CameraTrajectory, PlanarPose, PlanarTrajectory, Rigid3, StampedPose, Timestamp,
    eval::{
        EstimateSample, EvaluationOptions,
        camera::{Alignment, absolute_error, associate, coverage},
        evaluate,
    },
};

use crate::{refuse, refused};

/// Rows of `t, x, y, heading`: seconds, meters, radians.
fn planar_rows(rows: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<(Timestamp, PlanarPose)>> {
    let rows = rows.as_array();
    if rows.ncols() != 4 {
        return refuse(format!(
            "trajectory: expected shape (N, 4) of t, x, y, heading, found {:?}",
            rows.shape()
        ));
    }
    let row = |row: numpy::ndarray::ArrayView1<'_, f64>| {
        (Timestamp::from_secs(row[0]), PlanarPose::new(row[1], row[2], row[3]))
    };
    Ok(rows.axis_iter(Axis(0)).map(row).collect())
}

/// Compares poses of a robot with the truth.
#[pyfunction]
#[pyo3(signature = (truth, estimate, reliability = None))]
pub fn evaluate_robot<'py>(
    py: Python<'py>,
    truth: PyReadonlyArray2<'py, f64>,
    estimate: PyReadonlyArray2<'py, f64>,
    reliability: Option<PyReadonlyArray1<'py, f64>>,
) -> PyResult<Bound<'py, PyAny>> {
    let mut trajectory = PlanarTrajectory::new();
    for (at, world_from_robot) in planar_rows(&truth)? {
        let pose = StampedPose { at, world_from_robot, height_m: 0.0 };
        if trajectory.push(pose).is_err() {
            return refuse(format!("truth: expected times that grow, found {} again or before", at.secs()));
        }
    }
    let rows = planar_rows(&estimate)?;
    let reliability = reliability.map(|values| values.as_array().to_vec());
    if reliability.as_ref().is_some_and(|values| values.len() != rows.len()) {
        return refuse("reliability: expected one for each row of the estimate");
    }
    let sample = |(i, (at, world_from_robot)): (usize, (Timestamp, PlanarPose))| EstimateSample {
        at,
        world_from_robot,
        reliability: reliability.as_ref().map(|values| values[i]),
    };
    let samples: Vec<_> = rows.into_iter().enumerate().map(sample).collect();
    let json = serde_json::to_string(&evaluate(&trajectory, &samples, &EvaluationOptions::default()));
    py.import("json")?.call_method1("loads", (json.map_err(refused)?,))
}

fn trajectory(
    times: &PyReadonlyArray1<'_, f64>,
    poses: &PyReadonlyArray3<'_, f64>,
) -> PyResult<CameraTrajectory> {
    let (times, poses) = (times.as_array(), poses.as_array());
    if poses.shape() != [times.len(), 4, 4] {
        return refuse(format!("poses: expected shape ({}, 4, 4), found {:?}", times.len(), poses.shape()));
    }
    let mut trajectory = CameraTrajectory::new();
    for (at_s, pose) in times.iter().zip(poses.axis_iter(Axis(0))) {
        let rotation = visloc::nalgebra::Matrix3::from_fn(|row, column| pose[(row, column)]);
        let translation = visloc::nalgebra::Vector3::from_fn(|row, _| pose[(row, 3)]);
        let rotation = visloc::nalgebra::Rotation3::from_matrix(&rotation);
        let world_from_camera = Rigid3::new(rotation, translation);
        let pose = visloc::CameraPose { at: Timestamp::from_secs(*at_s), world_from_camera };
        if trajectory.push(pose).is_err() {
            return refuse(format!("times: expected them to grow, found {at_s} again or before"));
        }
    }
    Ok(trajectory)
}

/// Absolute error of a camera's trajectory after alignment (`none`, `rigid` or `similarity`).
#[pyfunction]
#[pyo3(signature = (truth_times, truth_poses, times, poses, *, alignment = "similarity", tolerance_s = 0.02))]
pub fn evaluate_camera<'py>(
    py: Python<'py>,
    truth_times: PyReadonlyArray1<'py, f64>,
    truth_poses: PyReadonlyArray3<'py, f64>,
    times: PyReadonlyArray1<'py, f64>,
    poses: PyReadonlyArray3<'py, f64>,
    alignment: &str,
    tolerance_s: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let alignment = match alignment {
        "none" => Alignment::None,
        "rigid" => Alignment::Rigid,
        "similarity" => Alignment::Similarity,
        other => return refuse(format!("alignment: expected none, rigid or similarity, found '{other}'")),
    };
    let truth = trajectory(&truth_times, &truth_poses)?;
    let estimate = trajectory(&times, &poses)?;
    let pairs = associate(&truth, &estimate, tolerance_s);
    let Some(error) = absolute_error(&pairs, alignment) else {
        return refuse(format!("expected at least 3 poses of the same times, found {}", pairs.len()));
    };
    let result = PyDict::new(py);
    let found = error.statistics;
    for (name, value) in
        [("rmse", found.rmse), ("mean", found.mean), ("median", found.median), ("max", found.max)]
    {
        result.set_item(name, value)?;
    }
    result.set_item("scale", error.similarity.scale)?;
    result.set_item("pairs", pairs.len())?;
    result.set_item("coverage", coverage(&truth, &pairs))?;
    Ok(result)
}
