//! The odometry motion model.
//!
//! Source: 2010 section 5.1.1 and 2017 section 4.1.2, equations 4.1 to 4.4. Deviation: the correction of the
//! systematic error acts on the motion in the robot's axes, where a walk's errors live; with one factor for both axes
//! it is the same as in the documents.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::{
    Rng, Timestamp, gaussian,
    geom::{PlanarPose, angle},
};

use crate::{
    ConfigError,
    odometer::{Odometer, Odometry},
    require,
};

visloc_core::with_defaults! {
    /// Parameters of the motion model.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct MotionConfig {
        /// Correction of the systematic error, true motion over measured motion, for forward, sideways and turning.
        pub correction: [f64; 3] = [1.0, 1.0, 1.0],
        /// Standard deviation of the position noise, meters per meter of motion.
        #[schemars(range(min = 0.0, max = 10.0))]
        pub noise_m_per_m: f64 = 0.25,
        /// Standard deviation of the position noise, meters per radian of turning.
        #[schemars(range(min = 0.0, max = 10.0))]
        pub noise_m_per_rad: f64 = 0.02,
        /// Standard deviation of the heading noise, radians per radian of turning.
        #[schemars(range(min = 0.0, max = 10.0))]
        pub noise_rad_per_rad: f64 = 0.15,
        /// Standard deviation of the heading noise, radians per meter of motion.
        #[schemars(range(min = 0.0, max = 10.0))]
        pub noise_rad_per_m: f64 = 0.1,
        /// Standard deviation of the position noise of a step without odometry, and of a second in which images show nothing, meters.
        #[schemars(range(min = 0.0, max = 10.0))]
        pub blind_noise_m: f64 = 0.03,
        /// Standard deviation of the heading noise of a step without odometry, and of a second in which images show nothing, radians.
        #[schemars(range(min = 0.0, max = 10.0))]
        pub blind_noise_rad: f64 = 0.04,
        /// A smaller motion counts as standing, meters.
        #[schemars(range(min = 0.0, max = 10.0))]
        pub min_motion_m: f64 = 1e-4,
        /// A smaller turn counts as standing, radians.
        #[schemars(range(min = 0.0, max = 10.0))]
        pub min_turn_rad: f64 = 1e-4,
        /// A larger motion between two images is a jump of the odometry and is not believed, meters; per second if they are farther apart
        /// than that.
        #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
        pub max_motion_m: f64 = 1.0,
    }
}

impl MotionConfig {
    /// A list has no range of its own.
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let is_near_one = |factor: &f64| (0.2..=5.0).contains(factor);
        let found = format!("{:?}", self.correction);
        require(self.correction.iter().all(is_near_one), "motion.correction", "factors from 0.2 to 5", found)
    }
}

/// A motion relative to the robot, with the noise that belongs to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarMotion {
    /// The new robot pose seen from the old one.
    pub old_from_new: PlanarPose,
    /// Standard deviation of x and y, meters.
    pub position_noise_m: f64,
    /// Standard deviation of the heading, radians.
    pub heading_noise_rad: f64,
    /// Whether no odometry told it.
    pub is_blind: bool,
}

impl PlanarMotion {
    /// A pose after the motion, without noise.
    #[inline]
    pub fn apply(&self, pose: &PlanarPose) -> PlanarPose {
        pose.compose(&self.old_from_new)
    }

    /// A pose after the motion, with noise.
    #[inline]
    pub fn sample(&self, pose: &PlanarPose, rng: &mut Rng) -> PlanarPose {
        let moved = self.apply(pose);
        PlanarPose::new(
            moved.x_m + gaussian(rng, self.position_noise_m),
            moved.y_m + gaussian(rng, self.position_noise_m),
            moved.yaw_rad + gaussian(rng, self.heading_noise_rad),
        )
    }
}

/// Turns accumulated odometry into motions between steps.
#[derive(Debug, Clone)]
pub struct MotionModel {
    config: MotionConfig,
    odometer: Odometer,
}

impl MotionModel {
    /// A model that has seen no odometry yet.
    pub fn new(config: MotionConfig) -> Self {
        Self { config, odometer: Odometer::new(config.max_motion_m) }
    }

    /// Time between the last two calls, seconds.
    pub fn secs(&self) -> f64 {
        self.odometer.secs()
    }

    /// An image has corrected the pose since the last call.
    pub(crate) fn note_evidence(&mut self) {
        self.odometer.note_evidence();
    }

    /// The motion since the last call, given the accumulated odometry at an image; `None` if the robot stood still.
    ///
    /// A robot without odometry may have moved in any way: no motion, but noise. One whose odometry is missing at the moment, or has
    /// jumped, is taken to go on as before, ever slower, with the same noise. If the next sample comes soon, it sets right what was
    /// guessed.
    pub fn update(&mut self, at: Timestamp, odometry: Option<PlanarPose>) -> Option<PlanarMotion> {
        match self.odometer.update(at, odometry) {
            Odometry::Without => Some(self.blind(&PlanarPose::default())),
            Odometry::First => None,
            Odometry::Missing { guess, .. } => Some(self.blind(&guess)),
            Odometry::Bridged { correction, motion, .. } => {
                Some(PlanarMotion { old_from_new: self.corrected(&correction), ..self.told(&motion) })
            }
            Odometry::Moved(motion) => {
                let (distance_m, turn_rad) = (motion.x_m.hypot(motion.y_m), motion.yaw_rad.abs());
                if distance_m < self.config.min_motion_m && turn_rad < self.config.min_turn_rad {
                    // So that a slow creep is not lost.
                    self.odometer.keep_reference();
                    return None;
                }
                Some(self.told(&motion))
            }
        }
    }

    fn told(&self, relative: &PlanarPose) -> PlanarMotion {
        let (distance_m, turn_rad) = (relative.x_m.hypot(relative.y_m), relative.yaw_rad.abs());
        let config = &self.config;
        PlanarMotion {
            old_from_new: self.corrected(relative),
            position_noise_m: config.noise_m_per_m * distance_m + config.noise_m_per_rad * turn_rad,
            heading_noise_rad: config.noise_rad_per_rad * turn_rad + config.noise_rad_per_m * distance_m,
            is_blind: false,
        }
    }

    fn corrected(&self, relative: &PlanarPose) -> PlanarPose {
        let [forward, sideways, turning] = self.config.correction;
        PlanarPose {
            x_m: relative.x_m * forward,
            y_m: relative.y_m * sideways,
            yaw_rad: angle::wrap(relative.yaw_rad * turning),
        }
    }

    fn blind(&self, guess: &PlanarPose) -> PlanarMotion {
        PlanarMotion {
            old_from_new: self.corrected(guess),
            position_noise_m: self.config.blind_noise_m,
            heading_noise_rad: self.config.blind_noise_rad,
            is_blind: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use visloc_core::RngTree;

    use super::*;

    /// Images each tenth of a second.
    fn at(image: u32) -> Timestamp {
        Timestamp::from_secs(0.1 * f64::from(image))
    }

    fn close(a: PlanarPose, b: PlanarPose) -> bool {
        a.distance_m(&b) < 1e-9 && a.heading_difference_rad(&b) < 1e-9
    }

    /// Equations 4.1 to 4.4 by hand: the odometry faces +y (90 degrees) and moves 0.3 m along +y, that is 0.3 m
    /// ahead; a particle that faces -x ends 0.3 m further along -x.
    #[test]
    fn motion_ahead_is_ahead_for_every_particle() {
        let mut model = MotionModel::new(MotionConfig::default());
        assert_eq!(model.update(at(0), Some(PlanarPose::new(5.0, 5.0, FRAC_PI_2))), None);
        let motion = model.update(at(1), Some(PlanarPose::new(5.0, 5.3, FRAC_PI_2))).unwrap();
        assert!(close(motion.apply(&PlanarPose::new(1.0, 2.0, PI)), PlanarPose::new(0.7, 2.0, PI)));
    }

    #[test]
    fn turn_and_sideways_step_by_hand() {
        let config = MotionConfig { correction: [1.0, 0.5, 2.0], ..MotionConfig::default() };
        let mut model = MotionModel::new(config);
        model.update(at(0), Some(PlanarPose::new(0.0, 0.0, 0.0)));
        let motion = model.update(at(1), Some(PlanarPose::new(0.1, 0.2, 0.15))).unwrap();
        // forward 0.1, left 0.2 * 0.5, turn 0.15 * 2; the particle faces +y, so forward is +y and left is -x
        let moved = motion.apply(&PlanarPose::new(0.0, 0.0, FRAC_PI_2));
        assert!(close(moved, PlanarPose::new(-0.1, 0.1, FRAC_PI_2 + 0.3)));
    }

    #[test]
    fn standing_and_missing_odometry() {
        let mut model = MotionModel::new(MotionConfig::default());
        model.update(at(0), Some(PlanarPose::new(0.0, 0.0, 0.0)));
        assert_eq!(model.update(at(1), Some(PlanarPose::new(0.000_05, 0.0, 0.0))), None);
        assert!(model.update(at(2), Some(PlanarPose::new(0.000_12, 0.0, 0.0))).is_some(), "a creep adds up");
        let mut without = MotionModel::new(MotionConfig::default());
        for i in 0..20 {
            let blind = without.update(at(i), None).unwrap();
            assert!(close(blind.old_from_new, PlanarPose::default()) && blind.position_noise_m > 0.0);
        }
    }

    /// Where a robot ends that walks 0.3 m/s while its odometry says what `sample` makes of it.
    fn walk(images: u32, sample: impl Fn(u32, PlanarPose) -> Option<PlanarPose>) -> f64 {
        let mut model = MotionModel::new(MotionConfig::default());
        let mut robot = PlanarPose::default();
        for i in 0..=images {
            let odometry = PlanarPose::new(0.03 * f64::from(i), 0.0, 0.0);
            if let Some(motion) = model.update(at(i), sample(i, odometry)) {
                robot = motion.apply(&robot);
            }
        }
        robot.x_m
    }

    #[test]
    fn gaps_and_jumps_neither_stop_a_robot_nor_carry_it_away() {
        let nan = PlanarPose { x_m: f64::NAN, y_m: 0.0, yaw_rad: 0.0 };
        assert!((walk(100, |_, pose| Some(pose)) - 3.0).abs() < 1e-9);
        assert!((walk(100, |i, pose| Some(if i == 50 { nan } else { pose })) - 3.0).abs() < 1e-9);
        assert!((walk(100, |i, pose| (i % 2 == 0).then_some(pose)) - 3.0).abs() < 1e-9, "every second one");
        let reset =
            walk(100, |i, pose| Some(if i < 50 { pose } else { PlanarPose { x_m: pose.x_m + 5.0, ..pose } }));
        assert!((reset - 3.0).abs() < 0.002, "{reset}");
        let gap = walk(100, |i, pose| (!(50..65).contains(&i)).then_some(pose));
        assert!((2.75..2.9).contains(&gap), "1.5 s at a speed that nobody knows: {gap}");
        let lost = walk(1000, |i, pose| (i < 50).then_some(pose));
        assert!((1.5..2.0).contains(&lost), "it is not taken to walk for ever: {lost}");
    }

    #[test]
    fn noise_grows_with_the_motion() {
        let mut rng = RngTree::new(2).stream("motion", 0);
        let spread = |distance: f64, rng: &mut Rng| {
            let mut model = MotionModel::new(MotionConfig::default());
            model.update(at(0), Some(PlanarPose::default()));
            let motion = model.update(at(1), Some(PlanarPose::new(distance, 0.0, 0.0))).unwrap();
            let draws = 4000;
            let squares: f64 =
                (0..draws).map(|_| motion.sample(&PlanarPose::default(), rng).y_m.powi(2)).sum();
            (squares / f64::from(draws)).sqrt()
        };
        let (near, far) = (spread(0.1, &mut rng), spread(0.4, &mut rng));
        assert!((near - 0.025).abs() < 0.002 && (far - 0.1).abs() < 0.008, "{near} {far}");
    }
}
