//! What the robot does between two observations, and what comes of it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{ConfigError, require};

/// A motion in whole tiles or whole heading steps.
///
/// Deviation from the source, which has an advance and two turns: a humanoid also walks backwards and sideways, and a
/// turn can be finer than 90 degrees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// To the place so many tiles ahead and to the left of the robot.
    Walk {
        /// Ahead, negative for backwards.
        ahead: i32,
        /// To the left, negative for to the right.
        left: i32,
    },
    /// On the spot, by so many heading steps clockwise; negative turns counter-clockwise.
    Turn(i32),
}

impl Action {
    /// One tile ahead, as published.
    pub const ADVANCE: Self = Self::Walk { ahead: 1, left: 0 };
    /// One step clockwise: +90 degrees in the published grid.
    pub const TURN_RIGHT: Self = Self::Turn(1);
    /// One step counter-clockwise: -90 degrees in the published grid.
    pub const TURN_LEFT: Self = Self::Turn(-1);
}

/// How often an action has no effect, happens once, twice or three times: shares that sum to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Outcomes {
    /// Of walking.
    pub walk: [f64; 4],
    /// Of turning clockwise.
    pub turn_right: [f64; 4],
    /// Of turning counter-clockwise.
    pub turn_left: [f64; 4],
}

impl Outcomes {
    /// Measured in 50 executions of each action on a Nao that walks without odometry. Source: table 2.
    pub fn published() -> Self {
        Self {
            walk: [0.05, 0.80, 0.10, 0.05],
            turn_right: [0.02, 0.90, 0.08, 0.0],
            turn_left: [0.02, 0.93, 0.05, 0.0],
        }
    }

    /// Every action happens exactly once.
    #[cfg(test)]
    pub(super) fn exact() -> Self {
        let once = [0.0, 1.0, 0.0, 0.0];
        Self { walk: once, turn_right: once, turn_left: once }
    }

    /// For actions cut from odometry, which knows what happened but for a few percent, to either side alike.
    pub fn of_odometry() -> Self {
        let nearly_once = [0.06, 0.88, 0.06, 0.0];
        Self { walk: nearly_once, turn_right: nearly_once, turn_left: nearly_once }
    }

    /// The shares of an action.
    #[inline]
    pub fn of(&self, action: Action) -> &[f64; 4] {
        match action {
            Action::Walk { .. } => &self.walk,
            Action::Turn(steps) if steps >= 0 => &self.turn_right,
            Action::Turn(_) => &self.turn_left,
        }
    }

    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        for (key, shares) in [
            ("outcomes.walk", &self.walk),
            ("outcomes.turn_right", &self.turn_right),
            ("outcomes.turn_left", &self.turn_left),
        ] {
            let total: f64 = shares.iter().sum();
            let holds = shares.iter().all(|share| *share >= 0.0) && (total - 1.0).abs() < 1e-6;
            require(holds, key, "four shares of at least 0 that sum to 1", format!("{shares:?}"))?;
        }
        Ok(())
    }
}

impl Default for Outcomes {
    fn default() -> Self {
        Self::of_odometry()
    }
}
