//! What a recording tells over time.

use serde_json::{Map, Value};

/// One frame in short.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Row {
    /// Since the first frame.
    pub secs: f64,
    /// Whether somebody carried the robot.
    pub is_carried: bool,
    /// Where the robot was: x, y, heading.
    pub truth: Option<[f64; 3]>,
    /// The algorithms.
    pub lanes: Vec<Lane>,
    /// Values of each plot, for what has no algorithms.
    pub values: Vec<Vec<Option<f64>>>,
    /// Whether a camera without a map was lost.
    pub is_lost: bool,
}

/// An algorithm at one frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Lane {
    /// Its name.
    pub name: String,
    /// Where it believes the robot to be.
    pub pose: [f64; 3],
    /// How far that can be trusted, 0 to 1.
    pub reliability: f64,
    /// Whether it claims to know the place.
    pub is_localized: bool,
    /// Distance to the truth, meters, if that is known.
    pub error_m: Option<f64>,
    /// Quality of the image, 0 to 1.
    pub quality: f64,
    /// Time for image and pose, milliseconds.
    pub ms: [f64; 2],
}

/// The short form of a state. What is missing counts as unknown.
pub fn row_of(state: &Map<String, Value>) -> Row {
    let truth = state.get("truth");
    let height_m = truth.and_then(|truth| truth.get("height_m")).and_then(Value::as_f64);
    let lanes = state.get("contenders").and_then(Value::as_array).into_iter().flatten();
    let values = state.get("values").and_then(Value::as_array).into_iter().flatten();
    let numbers = |plot: &Value| plot.as_array().into_iter().flatten().map(Value::as_f64).collect();
    Row {
        secs: number(state.get("secs")),
        is_carried: height_m.unwrap_or(0.0) > 0.0,
        truth: truth.and_then(|truth| triple(truth.get("pose")?)),
        lanes: lanes.map(lane_of).collect(),
        values: values.map(numbers).collect(),
        is_lost: state.get("is_lost").and_then(Value::as_bool).unwrap_or(false),
    }
}

fn lane_of(contender: &Value) -> Lane {
    let ms = contender.get("ms");
    let of = |part: &str| number(ms.and_then(|ms| ms.get(part)));
    Lane {
        name: contender.get("name").and_then(Value::as_str).unwrap_or_default().to_owned(),
        pose: contender.get("pose").and_then(triple).unwrap_or_default(),
        reliability: number(contender.get("reliability")),
        is_localized: contender.get("is_localized").and_then(Value::as_bool).unwrap_or(false),
        error_m: contender.get("error").and_then(|error| error.get(0)?.as_f64()),
        quality: number(contender.get("quality")),
        ms: [of("image"), of("pose")],
    }
}

fn number(value: Option<&Value>) -> f64 {
    value.and_then(Value::as_f64).unwrap_or(0.0)
}

fn triple(value: &Value) -> Option<[f64; 3]> {
    Some([value.get(0)?.as_f64()?, value.get(1)?.as_f64()?, value.get(2)?.as_f64()?])
}
