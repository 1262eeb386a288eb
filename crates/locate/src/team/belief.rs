//! What one robot believes by itself, and how it moves.

use std::collections::VecDeque;

use nalgebra::Matrix3;
use visloc_core::{
    Timestamp,
    geom::{PlanarPose, angle},
};

use super::symmetry::{Symmetry, mirrored_covariance};

/// Motion is remembered for so long, seconds: messages are about so much of the past at most.
const HISTORY_SECS: f64 = 2.5;
/// Moments that are remembered at most.
const MAX_MOMENTS: usize = 160;
/// Least probability of any option: everybody can be wrong about everything.
const LEAST: f64 = 1e-6;

/// A hypothesis with its mirrored one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Track {
    /// Name of the even one; the mirrored one has the odd number after it.
    pub id: u16,
    /// Pose of the even one.
    pub world_from_robot: PlanarPose,
    /// Its covariance.
    pub covariance: Matrix3<f64>,
    /// Probability of the even one and of its mirrored one.
    pub shares: [f64; 2],
}

/// What a robot believes by itself.
#[derive(Debug, Clone, Default)]
pub(super) struct Belief {
    /// For when it holds, by the robot's own clock.
    pub at: Timestamp,
    pub tracks: Vec<Track>,
    /// Up to the symmetry.
    pub reliability: f64,
    pub motion: Motion,
}

/// A pose where a robot may be, with its covariance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub pose: PlanarPose,
    pub covariance: Matrix3<f64>,
}

impl Belief {
    /// Number of options: elsewhere, and every hypothesis.
    pub fn num_options(&self, symmetry: Symmetry) -> usize {
        1 + self.tracks.len() * sides(symmetry)
    }

    /// Names of all options but elsewhere, in their order.
    pub fn ids(&self, symmetry: Symmetry) -> impl Iterator<Item = u16> + '_ {
        self.tracks
            .iter()
            .flat_map(move |track| (0..sides(symmetry)).map(|side| track.id + u16::from(side == 1)))
    }

    /// Where the robot is at a time of its clock, if an option holds; `None` for elsewhere. What it does between the moments that are known
    /// of it makes the place less certain.
    pub fn place(&self, option: usize, at: Timestamp, symmetry: Symmetry, spare: &Spare) -> Option<Place> {
        let index = option.checked_sub(1)?;
        let track = self.tracks.get(index / sides(symmetry))?;
        let (step, gap_secs) = self.motion.between(self.at, at);
        let pose = track.world_from_robot.compose(&step);
        let noise = |secs: f64| (spare.robot_m_per_s * secs).powi(2);
        let slack = noise(gap_secs) + noise(spare.clock_secs);
        let covariance =
            track.covariance + Matrix3::from_diagonal(&nalgebra::Vector3::new(slack, slack, 0.0));
        if index % sides(symmetry) == 1 {
            let pose = symmetry.mirrored(&pose)?;
            return Some(Place { pose, covariance: mirrored_covariance(&covariance) });
        }
        Some(Place { pose, covariance })
    }

    /// Probability of every option, by what the robot says. A robot that is sure may be wrong about its half or lie: that is `1 - honesty`.
    pub fn priors(&self, symmetry: Symmetry, honesty: f64, out: &mut Vec<f64>) {
        out.clear();
        let total: f64 = self.tracks.iter().flat_map(|track| track.shares).sum();
        if total <= 0.0 {
            out.resize(self.num_options(symmetry), LEAST);
            out[0] = 1.0;
            return;
        }
        let wrong = self.reliability * (1.0 - honesty);
        let mirrored = if symmetry == Symmetry::None { 0.0 } else { 0.5 * wrong };
        out.push(1.0 - self.reliability + wrong - mirrored);
        for track in &self.tracks {
            let either = 0.5 * (track.shares[0] + track.shares[1]) / total;
            for share in track.shares.iter().take(sides(symmetry)) {
                out.push(self.reliability * honesty * share / total + mirrored * either);
            }
        }
        out.iter_mut().for_each(|p| *p = p.max(LEAST));
        let sum: f64 = out.iter().sum();
        out.iter_mut().for_each(|p| *p /= sum);
    }
}

/// How sure places of other times are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spare {
    pub robot_m_per_s: f64,
    pub clock_secs: f64,
}

/// Hypotheses of a track.
pub(super) fn sides(symmetry: Symmetry) -> usize {
    if symmetry == Symmetry::None { 1 } else { 2 }
}

/// The odometry of the last seconds, by the robot's own clock.
#[derive(Debug, Clone, Default)]
pub(super) struct Motion {
    moments: VecDeque<(Timestamp, PlanarPose)>,
}

impl Motion {
    /// Takes in the odometry at a time. Odometry that begins anew forgets what was.
    pub fn push(&mut self, at: Timestamp, odom_from_robot: PlanarPose) {
        if self.moments.back().is_some_and(|(last, _)| at <= *last) {
            return;
        }
        self.moments.push_back((at, odom_from_robot));
        let is_old = |first: &(Timestamp, PlanarPose)| at.secs_since(first.0) > HISTORY_SECS;
        while self.moments.len() > MAX_MOMENTS || self.moments.front().is_some_and(is_old) {
            self.moments.pop_front();
        }
    }

    /// The newest odometry.
    pub fn last(&self) -> Option<PlanarPose> {
        self.moments.back().map(|(_, odom_from_robot)| *odom_from_robot)
    }

    /// The motion from one time to another, and for how much time beyond what is known of it.
    pub fn between(&self, from: Timestamp, to: Timestamp) -> (PlanarPose, f64) {
        let ((a, gap_a), (b, gap_b)) = (self.at(from), self.at(to));
        match (a, b) {
            (Some(a), Some(b)) => (b.relative_to(&a), gap_a + gap_b),
            _ => (PlanarPose::default(), to.secs_since(from).abs()),
        }
    }

    fn at(&self, at: Timestamp) -> (Option<PlanarPose>, f64) {
        let (Some(first), Some(last)) = (self.moments.front(), self.moments.back()) else {
            return (None, 0.0);
        };
        if at >= last.0 {
            return (Some(last.1), at.secs_since(last.0));
        }
        if at <= first.0 {
            return (Some(first.1), first.0.secs_since(at));
        }
        let after = self.moments.partition_point(|(moment, _)| *moment <= at);
        let ((from, a), (to, b)) = (self.moments[after - 1], self.moments[after]);
        let share = at.secs_since(from) / to.secs_since(from);
        let turn_rad = angle::difference(b.yaw_rad, a.yaw_rad);
        let pose = PlanarPose::new(
            a.x_m + share * (b.x_m - a.x_m),
            a.y_m + share * (b.y_m - a.y_m),
            a.yaw_rad + share * turn_rad,
        );
        (Some(pose), 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motion_between_known_moments() {
        let mut motion = Motion::default();
        for i in 0..=10 {
            motion.push(
                Timestamp::from_secs(f64::from(i) * 0.1),
                PlanarPose::new(f64::from(i) * 0.02, 0.0, 0.0),
            );
        }
        let (step, gap_secs) = motion.between(Timestamp::from_secs(0.25), Timestamp::from_secs(0.75));
        assert!((step.x_m - 0.1).abs() < 1e-9 && gap_secs == 0.0, "{step:?}");
        let (step, gap_secs) = motion.between(Timestamp::from_secs(0.5), Timestamp::from_secs(1.5));
        assert!((step.x_m - 0.1).abs() < 1e-9 && (gap_secs - 0.5).abs() < 1e-9, "{step:?}");
    }

    #[test]
    fn who_is_sure_may_still_be_wrong() {
        let track = Track {
            id: 4,
            world_from_robot: PlanarPose::new(1.0, 0.5, 0.2),
            covariance: Matrix3::identity() * 1e-4,
            shares: [1.0, 0.0],
        };
        let belief = Belief { tracks: vec![track], reliability: 1.0, ..Belief::default() };
        let mut priors = Vec::new();
        belief.priors(Symmetry::Point, 0.9, &mut priors);
        assert!((priors[0] - 0.05).abs() < 1e-4 && (priors[1] - 0.925).abs() < 1e-4, "{priors:?}");
        assert!((priors[2] - 0.025).abs() < 1e-4);
        belief.priors(Symmetry::None, 0.9, &mut priors);
        assert!(priors.len() == 2 && (priors[0] - 0.1).abs() < 1e-4, "{priors:?}");
    }
}
