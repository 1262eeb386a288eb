//! The list `[[motion]]`: what the robot does, one after the other.

use serde::Deserialize;
use visloc_core::geom::PlanarPose;

use super::{check::Check, load::ScenarioError};

/// A pose on the floor as files write it.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacedPose {
    /// Along the x axis of the map, meters.
    pub x_m: f64,
    /// Along the y axis of the map, meters.
    pub y_m: f64,
    /// Heading from the x axis, counter-clockwise, degrees.
    pub yaw_deg: f64,
}

impl PlacedPose {
    /// The same with the heading in radians.
    pub fn pose(&self) -> PlanarPose {
        PlanarPose::new(self.x_m, self.y_m, self.yaw_deg.to_radians())
    }

    pub(super) fn check(&self, check: &Check<'_>, key: &str) -> Result<(), ScenarioError> {
        check.range(&format!("{key}.x_m"), self.x_m, -100.0..=100.0)?;
        check.range(&format!("{key}.y_m"), self.y_m, -100.0..=100.0)?;
        check.range(&format!("{key}.yaw_deg"), self.yaw_deg, -360.0..=360.0)
    }
}

/// One thing that the robot does or that is done to it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Motion {
    /// Stands still.
    Stand(Stand),
    /// Turns on the spot.
    Turn(Turn),
    /// Walks a smooth way through given points.
    Walk(Walk),
    /// Walks a random way that stays on the carpet, avoids everything and comes by everywhere.
    Wander(Wander),
    /// Somebody lifts the robot and puts it down elsewhere.
    Carry(Carry),
}

visloc_core::with_defaults! {
    /// Standing still.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct Stand {
        /// How long.
        pub secs: f64 = 3.0,
    }
}

visloc_core::with_defaults! {
    /// Turning on the spot.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct Turn {
        /// How far, counter-clockwise, degrees.
        pub angle_deg: f64 = 90.0,
        /// Mean speed, degrees per second.
        pub speed_deg_per_s: f64 = 40.0,
    }
}

visloc_core::with_defaults! {
    /// Walking through points.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct Walk {
        /// Points (x, y) in meters that the way passes.
        pub through_m: Vec<[f64; 2]> = Vec::new(),
        /// Speed after speeding up and before slowing down.
        pub speed_m_per_s: f64 = 0.2,
        /// How far the heading swings away from the way's direction, so that the robot side-steps, degrees.
        pub heading_swing_deg: f64 = 20.0,
    }
}

visloc_core::with_defaults! {
    /// Walking freely.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct Wander {
        /// How long.
        pub secs: f64 = 30.0,
        /// As in [`Walk`].
        pub speed_m_per_s: f64 = 0.2,
        /// As in [`Walk`].
        pub heading_swing_deg: f64 = 30.0,
    }
}

visloc_core::with_defaults! {
    /// Kidnapping the robot.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct Carry {
        /// How long, from lifting to putting down.
        pub secs: f64 = 2.0,
        /// Where the robot is put down; somewhere far from here if absent.
        pub to: Option<PlacedPose> = None,
        /// How high the robot is lifted, meters.
        pub lift_m: f64 = 0.35,
        /// Whether the feet notice. If not, pressure stays normal and odometry marches on the spot.
        pub has_foot_signal: bool = true,
    }
}

impl Motion {
    /// How long it takes, as far as the file says.
    pub(super) fn planned_secs(&self) -> f64 {
        match self {
            Self::Stand(stand) => stand.secs,
            Self::Wander(wander) => wander.secs,
            Self::Carry(carry) => carry.secs,
            Self::Turn(_) | Self::Walk(_) => 0.0,
        }
    }

    pub(super) fn check(&self, check: &Check<'_>, key: &str) -> Result<(), ScenarioError> {
        let key = |part: &str| format!("{key}.{part}");
        match self {
            Self::Stand(stand) => check.range(&key("stand.secs"), stand.secs, 0.0..=3600.0),
            Self::Turn(turn) => {
                check.range(&key("turn.angle_deg"), turn.angle_deg, -3600.0..=3600.0)?;
                check.range(&key("turn.speed_deg_per_s"), turn.speed_deg_per_s, 1.0..=360.0)
            }
            Self::Walk(walk) => {
                let has_points = !walk.through_m.is_empty();
                check.that(has_points, &key("walk.through_m"), "at least one point", "none")?;
                for value in walk.through_m.iter().flatten() {
                    check.range(&key("walk.through_m"), *value, -100.0..=100.0)?;
                }
                check.range(&key("walk.speed_m_per_s"), walk.speed_m_per_s, 0.01..=3.0)?;
                check.range(&key("walk.heading_swing_deg"), walk.heading_swing_deg, 0.0..=180.0)
            }
            Self::Wander(wander) => {
                check.range(&key("wander.secs"), wander.secs, 2.0..=3600.0)?;
                check.range(&key("wander.speed_m_per_s"), wander.speed_m_per_s, 0.01..=3.0)?;
                check.range(&key("wander.heading_swing_deg"), wander.heading_swing_deg, 0.0..=180.0)
            }
            Self::Carry(carry) => {
                check.range(&key("carry.secs"), carry.secs, 0.1..=60.0)?;
                check.range(&key("carry.lift_m"), carry.lift_m, 0.01..=2.0)?;
                carry.to.iter().try_for_each(|to| to.check(check, &key("carry.to")))
            }
        }
    }
}
