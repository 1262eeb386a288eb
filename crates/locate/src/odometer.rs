//! Samples of the odometry, and what it means that one is missing.

use nalgebra::Vector3;
use visloc_core::{Timestamp, geom::PlanarPose};

/// Samples up to so far apart tell what happened between them, seconds. Whatever publishes the odometry takes longer to start anew, so
/// that it still counts from the same place.
const BRIDGED_SECS: f64 = 1.0;
/// Time in which a robot changes its speed, seconds: for a robot whose odometry is missing. As without odometry in the refinement.
const SPEED_SECS: f64 = 1.5;
/// No robot walks or drives or turns as fast as this: such a step is a jump of the odometry, even if it is short.
const MAX_SPEED_M_PER_S: f64 = 10.0;
const MAX_TURN_RAD_PER_S: f64 = 10.0;
/// Images that are closer together than this tell no speed, seconds.
const MIN_STEP_SECS: f64 = 0.02;

/// What the odometry says about the motion since the last image. Motions are new robot poses seen from old ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Odometry {
    /// The robot has had no odometry so far.
    Without,
    /// The first sample: there is nothing to compare it with.
    First,
    /// The motion since the last image.
    Moved(PlanarPose),
    /// The sample is missing, is not a number, or lies too far from the last one, as after a reset of the odometry.
    Missing {
        /// The motion of a robot that goes on as before, ever slower.
        guess: PlanarPose,
        /// The last speed that is known: ahead and to the left (m/s), turning (rad/s).
        velocity: Vector3<f64>,
    },
    /// The first sample after missing ones, and soon enough.
    Bridged {
        /// The motion since the last image that makes good what was wrong with the guesses that images have not corrected.
        correction: PlanarPose,
        /// The motion since the last sample.
        motion: PlanarPose,
        /// Time since that sample, seconds.
        secs: f64,
        /// The speed in that time, as for [`Odometry::Missing`].
        velocity: Vector3<f64>,
    },
}

impl Odometry {
    /// The most probable motion since the last image, if there is an odometry.
    pub fn step(&self) -> Option<PlanarPose> {
        match *self {
            Self::Without | Self::First => None,
            Self::Moved(step)
            | Self::Missing { guess: step, .. }
            | Self::Bridged { correction: step, .. } => Some(step),
        }
    }
}

/// A time without samples.
#[derive(Debug, Clone, Copy, Default)]
struct Gap {
    secs: f64,
    /// Time since images last corrected the pose, seconds, and all guesses since then.
    unseen_secs: f64,
    guessed: PlanarPose,
}

/// Turns accumulated odometry into motions between images. A gap or a jump of the odometry says nothing about the robot: the motion of
/// that time is unknown, and what comes later counts from the first sample after it.
#[derive(Debug, Clone)]
pub(crate) struct Odometer {
    max_motion_m: f64,
    last: Option<(Timestamp, PlanarPose)>,
    /// The reference before the last one.
    before_last: PlanarPose,
    last_image_at: Option<Timestamp>,
    secs: f64,
    velocity: Vector3<f64>,
    gap: Option<Gap>,
}

impl Odometer {
    /// An odometer that has seen nothing. A motion of more than `max_motion_m` between two images, or in a second if they are farther
    /// apart, is a jump.
    pub fn new(max_motion_m: f64) -> Self {
        Self {
            max_motion_m,
            last: None,
            before_last: PlanarPose::default(),
            last_image_at: None,
            secs: 0.0,
            velocity: Vector3::zeros(),
            gap: None,
        }
    }

    /// Takes in the accumulated odometry at an image.
    pub fn update(&mut self, at: Timestamp, sample: Option<PlanarPose>) -> Odometry {
        self.secs = self.last_image_at.map_or(0.0, |last| at.secs_since(last).max(0.0));
        self.last_image_at = Some(at);
        let Some(now) = sample.filter(PlanarPose::is_finite) else {
            return if self.last.is_some() { self.guess() } else { Odometry::Without };
        };
        let Some((last_at, last)) = self.last.replace((at, now)) else { return Odometry::First };
        self.before_last = last;
        let (motion, secs) = (now.relative_to(&last), at.secs_since(last_at).max(0.0));
        if self.is_jump(&motion, secs) || (self.gap.is_some() && secs > BRIDGED_SECS) {
            let guess = self.guess();
            self.gap = None;
            return guess;
        }
        if secs > 0.0 {
            self.velocity = Vector3::new(motion.x_m, motion.y_m, motion.yaw_rad) / secs;
        }
        match self.gap.take() {
            Some(gap) => {
                let share = if secs > 0.0 { ((gap.unseen_secs + self.secs) / secs).min(1.0) } else { 1.0 };
                let unseen = PlanarPose::new(share * motion.x_m, share * motion.y_m, share * motion.yaw_rad);
                let correction = unseen.relative_to(&gap.guessed);
                Odometry::Bridged { correction, motion, secs, velocity: self.velocity }
            }
            None => Odometry::Moved(motion),
        }
    }

    fn is_jump(&self, motion: &PlanarPose, secs: f64) -> bool {
        let distance_m = motion.x_m.hypot(motion.y_m);
        let step_secs = secs.max(MIN_STEP_SECS);
        let is_too_fast = distance_m > MAX_SPEED_M_PER_S * step_secs
            || motion.yaw_rad.abs() > MAX_TURN_RAD_PER_S * step_secs;
        distance_m >= self.max_motion_m * secs.max(1.0) || (secs > 0.0 && is_too_fast)
    }

    /// One more image without a sample.
    fn guess(&mut self) -> Odometry {
        let mut gap = self.gap.unwrap_or_default();
        let left_secs = |secs: f64| SPEED_SECS * (-secs / SPEED_SECS).exp();
        let way = self.velocity * (left_secs(gap.secs) - left_secs(gap.secs + self.secs));
        let guess = PlanarPose::new(way.x, way.y, way.z);
        gap.secs += self.secs;
        gap.unseen_secs += self.secs;
        gap.guessed = gap.guessed.compose(&guess);
        self.gap = Some(gap);
        Odometry::Missing { guess, velocity: self.velocity }
    }

    /// An image has corrected the pose: what was guessed before counts no more.
    pub fn note_evidence(&mut self) {
        if let Some(gap) = &mut self.gap {
            (gap.unseen_secs, gap.guessed) = (0.0, PlanarPose::default());
        }
    }

    /// The last motion was too small to be counted: the next one is to include it.
    pub fn keep_reference(&mut self) {
        if let Some((_, reference)) = &mut self.last {
            *reference = self.before_last;
        }
    }

    /// Time between the last two images, seconds.
    pub fn secs(&self) -> f64 {
        self.secs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(secs: f64) -> Timestamp {
        Timestamp::from_secs(secs)
    }

    fn ahead(x_m: f64) -> Option<PlanarPose> {
        Some(PlanarPose::new(x_m, 0.0, 0.0))
    }

    /// Walks 0.3 m/s until the time 1 s, with an image each 0.1 s.
    fn walked() -> Odometer {
        let mut odometer = Odometer::new(1.0);
        for i in 0..=10 {
            let secs = 0.1 * f64::from(i);
            odometer.update(at(secs), ahead(0.3 * secs));
        }
        odometer
    }

    #[test]
    fn a_robot_without_odometry_misses_nothing() {
        let mut odometer = Odometer::new(1.0);
        assert_eq!(odometer.update(at(0.0), None), Odometry::Without);
        assert_eq!(odometer.update(at(0.1), ahead(f64::NAN)), Odometry::Without);
        assert_eq!(odometer.update(at(0.2), ahead(7.0)), Odometry::First);
    }

    #[test]
    fn a_missing_sample_is_made_good_by_the_next_one() {
        let mut odometer = walked();
        let Odometry::Missing { guess, velocity } = odometer.update(at(1.1), ahead(f64::NAN)) else {
            panic!()
        };
        assert!((velocity.x - 0.3).abs() < 1e-6 && (0.028..0.03).contains(&guess.x_m), "{guess:?}");
        let Odometry::Bridged { correction, motion, secs, .. } = odometer.update(at(1.2), ahead(0.36)) else {
            panic!()
        };
        assert!((motion.x_m - 0.06).abs() < 1e-9 && (secs - 0.2).abs() < 1e-6);
        assert!((guess.x_m + correction.x_m - 0.06).abs() < 1e-9);
        odometer.update(at(1.25), None);
        odometer.note_evidence();
        let Odometry::Bridged { correction, .. } = odometer.update(at(1.3), ahead(0.48)) else { panic!() };
        assert!((correction.x_m - 0.06).abs() < 1e-6, "the image has told of the other half: {correction:?}");
        assert!(matches!(odometer.update(at(1.4), ahead(0.51)), Odometry::Moved(_)));
    }

    #[test]
    fn after_a_long_gap_and_after_a_jump_it_goes_on_from_the_new_value() {
        let mut odometer = walked();
        for i in 11..=30 {
            assert!(matches!(odometer.update(at(0.1 * f64::from(i)), None), Odometry::Missing { .. }));
        }
        let back = odometer.update(at(3.1), ahead(0.63));
        assert!(matches!(back, Odometry::Missing { .. }), "it may have begun anew: {back:?}");
        assert!(matches!(odometer.update(at(3.2), ahead(0.66)), Odometry::Moved(_)));
        assert!(matches!(odometer.update(at(3.3), ahead(-4.5)), Odometry::Missing { .. }));
        let Odometry::Moved(motion) = odometer.update(at(3.4), ahead(-4.47)) else { panic!() };
        assert!((motion.x_m - 0.03).abs() < 1e-9);
    }

    /// Images that stay away for four seconds of walking are no jump of the odometry.
    #[test]
    fn what_may_be_walked_grows_with_the_time() {
        let mut odometer = walked();
        assert!(matches!(odometer.update(at(5.0), ahead(1.5)), Odometry::Moved(_)));
        assert!(matches!(odometer.update(at(5.1), ahead(2.7)), Odometry::Missing { .. }));
    }

    /// An odometry that begins anew near its origin jumps by less than a robot may walk in a second, and turns.
    #[test]
    fn what_no_robot_does_so_fast_is_a_jump() {
        let image = |pose: PlanarPose| {
            let mut odometer = Odometer::new(1.0);
            odometer.update(at(0.0), Some(PlanarPose::default()));
            odometer.update(at(1.0 / 30.0), Some(pose))
        };
        assert!(matches!(image(PlanarPose::new(0.1, 0.0, 0.1)), Odometry::Moved(_)));
        assert!(matches!(image(PlanarPose::new(0.6, 0.0, 0.0)), Odometry::Missing { .. }));
        assert!(matches!(image(PlanarPose::new(0.0, 0.0, 2.0)), Odometry::Missing { .. }));
    }
}
