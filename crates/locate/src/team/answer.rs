//! The estimate with the help of the team in it.

use nalgebra::Matrix3;
use visloc_core::{Timestamp, geom::PlanarPose};

use super::{
    belief::Track,
    decision::Half,
    message::Root,
    names::side_of,
    placement::Placement,
    symmetry::{Symmetry, mirrored_covariance},
};
use crate::{Estimate, Hypothesis};

/// What the team has changed in an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Help {
    /// Nothing: it is what the robot knows by itself.
    Alone,
    /// The half of a symmetric map.
    Half {
        /// Who knew.
        root: Root,
        /// Probability of the half.
        probability: f64,
    },
    /// The robot knew no place, and another one sees it: this is a hint, and the reliability stays that of the robot itself.
    Placed {
        /// Number of the robot that sees it.
        by: u8,
        /// Probability that it is this one that was seen.
        probability: f64,
    },
}

/// The answer of a robot with its team.
#[derive(Debug, Clone, PartialEq)]
pub struct TeamEstimate {
    /// The estimate, with the help of the team in it.
    pub estimate: Estimate,
    /// What the help is.
    pub help: Help,
}

impl TeamEstimate {
    /// Takes a half that was decided for the track that the robot follows.
    pub(super) fn take_half(&mut self, half: &Half, track: &Track, symmetry: Symmetry) {
        let known = track.shares[half.side] / (track.shares[0] + track.shares[1]);
        if known >= half.share {
            return; // the robot knows by itself
        }
        let even = track.world_from_robot;
        let side = |pose: &PlanarPose| side_of(&even, pose, symmetry);
        let estimate = &mut self.estimate;
        let Some(answered) = side(&estimate.world_from_robot) else { return };
        if answered != half.side
            && let Some(mirrored) = symmetry.mirrored(&estimate.world_from_robot)
        {
            estimate.world_from_robot = mirrored;
            estimate.covariance = mirrored_covariance(&estimate.covariance);
        }
        let (pose, covariance) = (estimate.world_from_robot, estimate.covariance);
        let of_track = |h: &Hypothesis| side(&h.world_from_robot).is_some();
        let both: f64 = estimate.hypotheses.iter().filter(|h| of_track(h)).map(|h| h.probability).sum();
        estimate.hypotheses.retain(|h| !of_track(h));
        let hypothesis = Hypothesis { world_from_robot: pose, covariance, probability: both * half.share };
        estimate.hypotheses.push(hypothesis);
        if let Some(world_from_robot) = symmetry.mirrored(&pose) {
            let (covariance, probability) = (mirrored_covariance(&covariance), both * (1.0 - half.share));
            estimate.hypotheses.push(Hypothesis { world_from_robot, covariance, probability });
        }
        estimate.normalize_hypotheses();
        estimate.reliability = estimate.reliability_up_to_symmetry * (2.0 * half.share - 1.0).max(0.0);
        self.help = Help::Half { root: half.root, probability: half.share };
    }

    /// Takes the place where others see the robot.
    pub(super) fn take_placement(&mut self, placement: &Placement, symmetry: Symmetry) {
        let estimate = &mut self.estimate;
        let pose = placement.pose();
        let covariance: Matrix3<f64> = placement.pose_covariance();
        let all: Vec<PlanarPose> = std::iter::once(pose).chain(symmetry.mirrored(&pose)).collect();
        let probability = 1.0 / all.len() as f64;
        estimate.hypotheses.extend(all.iter().map(|world_from_robot| Hypothesis {
            world_from_robot: *world_from_robot,
            covariance,
            probability,
        }));
        estimate.world_from_robot = pose;
        estimate.covariance = covariance;
        self.help = Help::Placed { by: placement.by, probability: placement.probability };
    }
}

/// A teammate as this robot sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MateView {
    /// Its number.
    pub number: u8,
    /// Its most probable pose; `None` if it knows none.
    pub world_from_robot: Option<PlanarPose>,
    /// Probability that it is at one of the places that it tells, mirrored ones included, and makes up nothing: low for one that lies or is
    /// lost.
    pub trust: f64,
    /// When its last message arrived.
    pub heard_at: Timestamp,
}
