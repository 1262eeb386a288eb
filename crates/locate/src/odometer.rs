//! Samples of the odometry, and what it means that one is missing.

use nalgebra::Vector3;
use visloc_base::Timestamp;
use visloc_geom::PlanarPose;

/// Samples up to so far apart tell what happened between them, seconds: as far as readers of recordings interpolate.
const BRIDGED_SECS: f64 = 0.5;

/// What the odometry says about the motion since the last image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Odometry {
    /// The robot has had no odometry so far.
    Without,
    /// The first sample: there is nothing to compare it with.
    First,
    /// The new robot pose seen from that of the last image.
    Moved(PlanarPose),
    /// The sample is missing, is not a number, or lies too far from the last one, as after a reset of the odometry. Ahead, to the left
    /// (m/s) and turning (rad/s), the robot moved like this when that was last known.
    Missing(Vector3<f64>),
    /// The first sample after missing ones, and soon enough: the motion since the last one before them.
    Bridged {
        /// The new robot pose seen from that at the last sample.
        motion: PlanarPose,
        /// Time since that sample, seconds.
        secs: f64,
        /// As for [`Odometry::Missing`].
        velocity: Vector3<f64>,
    },
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
    is_missing: bool,
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
            is_missing: false,
        }
    }

    /// Takes in the accumulated odometry at an image.
    pub fn update(&mut self, at: Timestamp, sample: Option<PlanarPose>) -> Odometry {
        self.secs = self.last_image_at.map_or(0.0, |last| at.secs_since(last).max(0.0));
        self.last_image_at = Some(at);
        let Some(now) = sample.filter(PlanarPose::is_finite) else {
            self.is_missing = self.last.is_some();
            return if self.is_missing { Odometry::Missing(self.velocity) } else { Odometry::Without };
        };
        let Some((last_at, last)) = self.last.replace((at, now)) else { return Odometry::First };
        self.before_last = last;
        let was_missing = std::mem::take(&mut self.is_missing);
        let (motion, secs) = (now.relative_to(&last), at.secs_since(last_at).max(0.0));
        let is_jump = motion.x_m.hypot(motion.y_m) >= self.max_motion_m * secs.max(1.0);
        if is_jump || (was_missing && secs > BRIDGED_SECS) {
            return Odometry::Missing(self.velocity);
        }
        if secs > 0.0 {
            self.velocity = Vector3::new(motion.x_m, motion.y_m, motion.yaw_rad) / secs;
        }
        if was_missing {
            Odometry::Bridged { motion, secs, velocity: self.velocity }
        } else {
            Odometry::Moved(motion)
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
        let Odometry::Missing(velocity) = odometer.update(at(1.1), ahead(f64::NAN)) else { panic!() };
        assert!((velocity.x - 0.3).abs() < 1e-6);
        let Odometry::Bridged { motion, secs, .. } = odometer.update(at(1.2), ahead(0.36)) else { panic!() };
        assert!((motion.x_m - 0.06).abs() < 1e-9 && (secs - 0.2).abs() < 1e-6);
        assert!(matches!(odometer.update(at(1.3), ahead(0.39)), Odometry::Moved(_)));
    }

    #[test]
    fn after_a_long_gap_and_after_a_jump_it_goes_on_from_the_new_value() {
        let mut odometer = walked();
        for i in 11..=20 {
            assert!(matches!(odometer.update(at(0.1 * f64::from(i)), None), Odometry::Missing(_)));
        }
        assert!(
            matches!(odometer.update(at(2.1), ahead(0.63)), Odometry::Missing(_)),
            "nobody knows of that time"
        );
        assert!(matches!(odometer.update(at(2.2), ahead(0.66)), Odometry::Moved(_)));
        assert!(matches!(odometer.update(at(2.3), ahead(-4.5)), Odometry::Missing(_)));
        let Odometry::Moved(motion) = odometer.update(at(2.4), ahead(-4.47)) else { panic!() };
        assert!((motion.x_m - 0.03).abs() < 1e-9);
    }

    /// Images that stay away for four seconds of walking are no jump of the odometry.
    #[test]
    fn what_may_be_walked_grows_with_the_time() {
        let mut odometer = walked();
        assert!(matches!(odometer.update(at(5.0), ahead(1.5)), Odometry::Moved(_)));
        assert!(matches!(odometer.update(at(5.1), ahead(2.7)), Odometry::Missing(_)));
    }
}
