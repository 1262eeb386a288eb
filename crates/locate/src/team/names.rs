//! Names of hypotheses that stay the same from image to image.

use visloc_core::{Timestamp, geom::PlanarPose};

use super::{belief::Track, message::MAX_HYPOTHESES, symmetry::Symmetry};
use crate::Estimate;

/// Hypotheses less probable than this are not told.
const MIN_PROBABILITY: f64 = 0.05;
/// Tracks of a robot that are told: on a symmetric map each has two hypotheses.
pub(super) const MAX_TRACKS: usize = MAX_HYPOTHESES / 2;
/// A hypothesis that jumps by more is another one: far above what tracks are corrected by, far below how far places that look alike are apart.
const SAME_M: f64 = 0.7;
const SAME_RAD: f64 = 0.7;
/// A place that was a hypothesis so long ago is a new one, seconds.
const KEPT_SECS: f64 = 1.0;

/// One place with its name.
#[derive(Debug, Clone, Copy)]
struct Named {
    id: u16,
    /// Its pose if it moves by the odometry, as `world_from_odom`.
    world_from_odom: PlanarPose,
    seen_at: Timestamp,
}

/// Gives names to the hypotheses of the own localizer.
#[derive(Debug, Clone, Default)]
pub(super) struct Names {
    known: Vec<Named>,
    next: u16,
}

impl Names {
    /// The most probable tracks of an estimate. Both of two mirrored hypotheses are one track.
    pub fn tracks(
        &mut self,
        estimate: &Estimate,
        symmetry: Symmetry,
        odometry: &PlanarPose,
        at: Timestamp,
        out: &mut Vec<Track>,
    ) {
        out.clear();
        self.known.retain(|named| at.secs_since(named.seen_at) <= KEPT_SECS);
        let robot_from_odom = odometry.inverse();
        for hypothesis in estimate.hypotheses.iter().filter(|h| h.probability >= MIN_PROBABILITY) {
            let pose = hypothesis.world_from_robot;
            if let Some((track, side)) = out.iter_mut().find_map(|track| {
                let side = side_of(&track.world_from_robot, &pose, symmetry)?;
                Some((track, side))
            }) {
                track.shares[side] += hypothesis.probability;
                continue;
            }
            if out.len() == MAX_TRACKS {
                continue;
            }
            let (id, side) = self.name(&pose, symmetry, odometry, at);
            let (even, covariance) = match symmetry.mirrored(&pose) {
                Some(mirrored) if side == 1 => {
                    (mirrored, super::symmetry::mirrored_covariance(&hypothesis.covariance))
                }
                _ => (pose, hypothesis.covariance),
            };
            let mut shares = [0.0; 2];
            shares[side] = hypothesis.probability;
            if let Some(named) = self.known.iter_mut().find(|named| named.id == id) {
                named.world_from_odom = even.compose(&robot_from_odom);
                named.seen_at = at;
            }
            out.push(Track { id, world_from_robot: even, covariance, shares });
        }
    }

    /// The name of the track that is at a pose, and whether the pose is its mirrored one (1).
    fn name(
        &mut self,
        pose: &PlanarPose,
        symmetry: Symmetry,
        odometry: &PlanarPose,
        at: Timestamp,
    ) -> (u16, usize) {
        let found = self.known.iter().find_map(|named| {
            // Two hypotheses of one image are two tracks.
            let is_free = named.seen_at != at;
            let expected = named.world_from_odom.compose(odometry);
            side_of(&expected, pose, symmetry).filter(|_| is_free).map(|side| (named.id, side))
        });
        found.unwrap_or_else(|| {
            let id = self.next;
            self.next = self.next.wrapping_add(2);
            let world_from_odom = pose.compose(&odometry.inverse());
            self.known.push(Named { id, world_from_odom, seen_at: at });
            (id, 0)
        })
    }
}

/// Whether a pose is the expected one (0) or its mirrored one (1); `None` if it is neither.
pub(super) fn side_of(expected: &PlanarPose, pose: &PlanarPose, symmetry: Symmetry) -> Option<usize> {
    let is_same = |expected: &PlanarPose| {
        expected.distance_m(pose) < SAME_M && expected.heading_difference_rad(pose) < SAME_RAD
    };
    if is_same(expected) {
        return Some(0);
    }
    symmetry.mirrored(expected).filter(is_same).map(|_| 1)
}
