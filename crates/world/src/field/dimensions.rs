//! The dimensions of a field as its file gives them, checked.

use serde::{Deserialize, Serialize};

use crate::MapError;

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
        let check = Check { name };
        for (key, value) in [
            ("length_m", self.length_m),
            ("width_m", self.width_m),
            ("line_width_m", self.line_width_m),
            ("center_circle_diameter_m", self.center_circle_diameter_m),
            ("penalty_mark_from_goal_line_m", self.penalty_mark_from_goal_line_m),
            ("penalty_mark_size_m", self.penalty_mark_size_m),
            ("center_mark_size_m", self.center_mark_size_m),
            ("ball_diameter_m", self.ball_diameter_m),
            ("goals.inner_width_m", self.goals.inner_width_m),
            ("goals.inner_height_m", self.goals.inner_height_m),
            ("goals.post_diameter_m", self.goals.post_diameter_m),
        ] {
            check.that(value > 0.0 && value.is_finite(), key, "a length above 0", value)?;
        }
        check.that(
            (0.0..100.0).contains(&self.border_m),
            "border_m",
            "a length of at least 0",
            self.border_m,
        )?;
        for (key, value) in [("length_m", self.length_m), ("width_m", self.width_m)] {
            check.that(value <= 200.0, key, "at most 200 m (lengths are in meters)", value)?;
        }
        let half_length_m = self.length_m / 2.0;
        check.that(
            self.line_width_m < self.width_m / 4.0,
            "line_width_m",
            "less than a quarter of width_m",
            self.line_width_m,
        )?;
        check.that(
            self.center_circle_diameter_m < self.width_m.min(self.length_m),
            "center_circle_diameter_m",
            "less than the field's width and length",
            self.center_circle_diameter_m,
        )?;
        check.that(
            self.penalty_mark_from_goal_line_m < half_length_m,
            "penalty_mark_from_goal_line_m",
            "less than half of length_m",
            self.penalty_mark_from_goal_line_m,
        )?;
        check.that(
            self.goals.inner_width_m + 2.0 * self.goals.post_diameter_m < self.width_m,
            "goals.inner_width_m",
            "goals narrower than the field",
            self.goals.inner_width_m,
        )?;
        self.check_boxes(&check)
    }

    fn check_boxes(&self, check: &Check<'_>) -> Result<(), MapError> {
        for (i, area) in self.boxes.iter().enumerate() {
            let depth_fits = area.depth_m > 0.0 && area.depth_m < self.length_m / 2.0;
            let key = |part| format!("boxes[{i}].{part}");
            check.that(
                depth_fits,
                &key("depth_m"),
                "above 0 and less than half of length_m",
                area.depth_m,
            )?;
            let width_fits = area.width_m > 0.0 && area.width_m < self.width_m;
            check.that(width_fits, &key("width_m"), "above 0 and less than width_m", area.width_m)?;
        }
        Ok(())
    }
}

struct Check<'a> {
    name: &'a str,
}

impl Check<'_> {
    fn that(&self, holds: bool, key: &str, expected: &'static str, found: f64) -> Result<(), MapError> {
        if holds {
            return Ok(());
        }
        Err(MapError::Value {
            name: self.name.to_owned(),
            key: key.to_owned(),
            expected,
            found: found.to_string(),
        })
    }
}
