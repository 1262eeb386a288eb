//! Odometry, cut into actions.

use std::f64::consts::TAU;

use visloc_core::geom::PlanarPose;

use super::{Action, Grid};

/// Adds up the robot's motion and turns it into actions of whole tiles and heading steps. What is left over, at most
/// half a tile and half a step to either side, is the residual: a robot "in state s" stands at the middle of s moved by
/// the residual. So walking across the headings of a coarse grid loses nothing, and all hypotheses share one residual.
///
/// Not in the source, whose robot stops after each tile.
#[derive(Debug, Clone, PartialEq)]
pub struct OdometryCutter {
    tile_m: f64,
    num_headings: usize,
    /// Ahead and to the left of the state's heading, meters, and the heading against the state's.
    residual: PlanarPose,
}

impl OdometryCutter {
    /// For a grid; nothing is left over yet.
    pub fn new(grid: &Grid) -> Self {
        Self { tile_m: grid.tile_m(), num_headings: grid.num_headings(), residual: PlanarPose::default() }
    }

    /// The robot's pose seen from the middle of its state.
    pub fn residual(&self) -> PlanarPose {
        self.residual
    }

    /// Forgets what is left over.
    pub fn reset(&mut self) {
        self.residual = PlanarPose::default();
    }

    /// Takes in a motion, `old_from_new`, and appends the actions that it completes.
    pub fn add(&mut self, old_from_new: &PlanarPose, out: &mut Vec<Action>) {
        if !old_from_new.is_finite() {
            return;
        }
        self.residual = self.residual.compose(old_from_new);
        let step_rad = TAU / self.num_headings as f64;
        let steps_left = whole(self.residual.yaw_rad / step_rad);
        if steps_left != 0 {
            // The new state's heading is turned: the same place seen from there.
            let turn = PlanarPose::new(0.0, 0.0, f64::from(steps_left) * step_rad);
            self.residual = self.residual.relative_to(&turn);
            out.push(Action::Turn(-steps_left));
        }
        let (ahead, left) = (whole(self.residual.x_m / self.tile_m), whole(self.residual.y_m / self.tile_m));
        if ahead != 0 || left != 0 {
            self.residual.x_m -= f64::from(ahead) * self.tile_m;
            self.residual.y_m -= f64::from(left) * self.tile_m;
            out.push(Action::Walk { ahead, left });
        }
    }
}

/// The nearest whole number; a little more than half a unit is needed, so that a robot that stands between two does not
/// go back and forth.
fn whole(units: f64) -> i32 {
    const MIN_UNITS: f64 = 0.6;
    if units.abs() < MIN_UNITS { 0 } else { units.round().clamp(-1e6, 1e6) as i32 }
}
