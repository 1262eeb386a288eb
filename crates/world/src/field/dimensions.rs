//! The dimensions of a field as its file gives them, checked.

use serde::{Deserialize, Serialize};

use crate::{MapError, built_in::BUILT_IN_MAPS, error::HOW_TO_BEGIN};

/// Kind of the maps that are fields.
const KIND: &str = "robocup-field";

/// Color of a goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GoalColor {
    /// Yellow.
    Yellow,
    /// Blue.
    Blue,
    /// White, as in the modern rules: both goals look the same.
    White,
}

/// Color of the ball.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BallColor {
    /// Orange.
    Orange,
    /// White with black patches.
    BlackAndWhite,
}

/// A rectangle drawn in front of both goals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxDimensions {
    /// From the goal line into the field, meters.
    pub depth_m: f64,
    /// Along the goal line, meters.
    pub width_m: f64,
}

/// Both goals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoalDimensions {
    /// Color of the goal at +x and of the goal at -x.
    pub colors: [GoalColor; 2],
    /// Free width between the posts, meters.
    pub inner_width_m: f64,
    /// Free height under the crossbar, meters.
    pub inner_height_m: f64,
    /// Diameter of posts and crossbar, meters.
    pub post_diameter_m: f64,
}

/// Everything that a field file says. Lengths in meters between line centers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FieldDimensions {
    /// Always `robocup-field`.
    pub kind: String,
    /// Name of the map.
    pub name: String,
    /// Between the goal lines.
    pub length_m: f64,
    /// Between the side lines.
    pub width_m: f64,
    /// Carpet beyond the lines.
    pub border_m: f64,
    /// Width of every line.
    pub line_width_m: f64,
    /// Diameter of the center circle.
    pub center_circle_diameter_m: f64,
    /// Distance of the penalty marks from their goal line.
    pub penalty_mark_from_goal_line_m: f64,
    /// Length of each of the two bars of a penalty mark.
    pub penalty_mark_size_m: f64,
    /// Length of the bar that crosses the halfway line at the center.
    pub center_mark_size_m: f64,
    /// Diameter of the ball.
    pub ball_diameter_m: f64,
    /// Color of the ball.
    pub ball_color: BallColor,
    /// Boxes in front of each goal (goal area, penalty area).
    pub boxes: Vec<BoxDimensions>,
    /// The goals.
    pub goals: GoalDimensions,
}

impl FieldDimensions {
    /// Checks that the values describe a field: positive lengths, everything inside the lines.
    pub(super) fn check(&self, name: &str) -> Result<(), MapError> {
        if self.kind != KIND {
            return Err(MapError::Value {
                name: name.to_owned(),
                key: "kind".to_owned(),
                expected: "\"robocup-field\"",
                found: format!("{:?}", self.kind),
            });
        }
        let goals = &self.goals;
        let lengths = [
            ("length_m", self.length_m),
            ("width_m", self.width_m),
            ("line_width_m", self.line_width_m),
            ("center_circle_diameter_m", self.center_circle_diameter_m),
            ("penalty_mark_from_goal_line_m", self.penalty_mark_from_goal_line_m),
            ("penalty_mark_size_m", self.penalty_mark_size_m),
            ("center_mark_size_m", self.center_mark_size_m),
            ("ball_diameter_m", self.ball_diameter_m),
            ("goals.inner_width_m", goals.inner_width_m),
            ("goals.inner_height_m", goals.inner_height_m),
            ("goals.post_diameter_m", goals.post_diameter_m),
        ];
        let lengths =
            lengths.map(|(key, value)| (value > 0.0 && value.is_finite(), key, "a length above 0", value));
        let (length_m, width_m) = (self.length_m, self.width_m);
        let (circle_m, mark_m) = (self.center_circle_diameter_m, self.penalty_mark_from_goal_line_m);
        let goal_m = goals.inner_width_m + 2.0 * goals.post_diameter_m;
        let others = [
            ((0.0..100.0).contains(&self.border_m), "border_m", "a length of at least 0", self.border_m),
            (length_m <= 200.0, "length_m", "at most 200 m (lengths are in meters)", length_m),
            (width_m <= 200.0, "width_m", "at most 200 m (lengths are in meters)", width_m),
            (
                self.line_width_m < width_m / 4.0,
                "line_width_m",
                "less than a quarter of width_m",
                self.line_width_m,
            ),
            (
                circle_m < width_m.min(length_m),
                "center_circle_diameter_m",
                "less than the field's width and length",
                circle_m,
            ),
            (mark_m < length_m / 2.0, "penalty_mark_from_goal_line_m", "less than half of length_m", mark_m),
            (
                goal_m < width_m,
                "goals.inner_width_m",
                "goals narrower than the field, posts included",
                goal_m,
            ),
        ];
        let boxes = self.boxes.iter().enumerate().flat_map(
            |(i, &BoxDimensions { depth_m: depth, width_m: width })| {
                let depth_fits = depth > 0.0 && depth < length_m / 2.0;
                let width_fits = width > 0.0 && width < width_m;
                [
                    (
                        depth_fits,
                        format!("boxes[{i}].depth_m"),
                        "above 0 and less than half of length_m",
                        depth,
                    ),
                    (width_fits, format!("boxes[{i}].width_m"), "above 0 and less than width_m", width),
                ]
            },
        );
        let fixed = lengths.into_iter().chain(others);
        let all =
            fixed.map(|(holds, key, expected, found)| (holds, key.to_owned(), expected, found)).chain(boxes);
        for (holds, key, expected, found) in all {
            if !holds {
                return Err(MapError::Value {
                    name: name.to_owned(),
                    key,
                    expected,
                    found: found.to_string(),
                });
            }
        }
        Ok(())
    }
}

/// What a file lacks that has only some of a field's keys: all of it at once, `None` if it is one key at most.
pub(super) fn lacking(text: &str) -> Option<String> {
    let (_, whole) = BUILT_IN_MAPS.first()?;
    let (whole, found): (toml::Table, toml::Table) =
        (toml::from_str(whole).ok()?, toml::from_str(text).ok()?);
    let missing: Vec<&str> =
        whole.keys().map(String::as_str).filter(|key| !found.contains_key(*key)).collect();
    (missing.len() > 1).then(|| {
        let found: Vec<&str> = found.keys().map(String::as_str).collect();
        format!("expected also {}, found only {}; {HOW_TO_BEGIN}", missing.join(", "), found.join(", "))
    })
}
