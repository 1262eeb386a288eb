//! Robots that lie, for experiments and demonstrations: what a team has to bear.

use nalgebra::Matrix3;
use rand::RngExt as _;
use serde::{Deserialize, Serialize};
use visloc_core::{Rng, geom::PlanarPose};

use super::message::{Sighting, SightingKind, TeamMessage, ToldHypothesis};

/// How a robot lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Liar {
    /// It is sure of the wrong half, and tells truly what it sees.
    WrongHalf,
    /// It is sure of a place some meters from where it is.
    Elsewhere,
    /// It is sure of the wrong half, and sees robots and balls everywhere.
    Inventing,
}

impl Liar {
    /// Puts the lie into what a robot tells that is at `world_from_robot` in truth.
    pub fn lie(self, message: &mut TeamMessage, world_from_robot: &PlanarPose, rng: &mut Rng) {
        let truth = world_from_robot;
        let world_from_robot = match self {
            Self::WrongHalf | Self::Inventing => {
                PlanarPose::new(-truth.x_m, -truth.y_m, truth.yaw_rad + std::f64::consts::PI)
            }
            Self::Elsewhere => {
                PlanarPose::new(truth.x_m - 2.0 * truth.x_m.signum(), truth.y_m + 1.0, truth.yaw_rad + 1.5)
            }
        };
        let covariance = Matrix3::identity() * 1e-4;
        message.hypotheses = vec![ToldHypothesis { id: 0, world_from_robot, covariance, probability: 1.0 }];
        message.reliability = 1.0;
        message.half = None;
        if self == Self::Inventing {
            message.sightings.clear();
            for i in 0..4 {
                let kind = if i == 0 { SightingKind::Ball } else { SightingKind::Teammate };
                let (bearing, range) = (rng.random_range(-1.0..1.0), rng.random_range(0.5..4.0));
                message.sightings.push(Sighting::polar(
                    message.at,
                    kind,
                    (bearing, 0.02),
                    (range, 0.05 * range),
                ));
            }
        }
    }
}
