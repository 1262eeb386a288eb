//! What is known about the pose before anything is seen: it chooses between mirrored poses.

use visloc_core::geom::PlanarPose;

use crate::{StartPrior, observation::features::FeatureModel};

/// How sure a prior makes one of two mirrored poses, and having been near one of them last for sure.
const SURE: f64 = 0.99;
/// So near is where the robot was last.
const NEAR_LAST_M: f64 = 1.0;
const NEAR_LAST_RAD: f64 = 1.0;
/// Error of the odometry, as a share of the way.
const DRIFT: f64 = 0.1;

/// A prior, and how the robot has moved since it held.
#[derive(Debug, Clone)]
pub(super) struct Known {
    prior: StartPrior,
    /// The robot seen from where it was when the prior held.
    start_from_robot: PlanarPose,
    way_m: f64,
    /// Where the last established track would be now, as the odometry has it, and its probability beside its mirrored one.
    last: Option<(PlanarPose, f64)>,
}

impl Known {
    /// Of a robot that is where the prior says.
    pub fn new(prior: StartPrior) -> Self {
        Self { prior, start_from_robot: PlanarPose::default(), way_m: 0.0, last: None }
    }

    /// The robot was carried: where it was last says nothing any more. A prior may have been given for where it is put
    /// down, so that stays.
    pub fn forget_last(&mut self) {
        self.last = None;
    }

    /// Takes in the motion since the last image, as the odometry has it.
    pub fn move_by(&mut self, motion: &PlanarPose) {
        self.start_from_robot = self.start_from_robot.compose(motion);
        self.way_m += motion.x_m.hypot(motion.y_m);
        if let Some((last, _)) = &mut self.last {
            *last = last.compose(motion);
        }
    }

    /// The robot seen from where it was in the first image, as the odometry has it.
    pub fn start_from_robot(&self) -> &PlanarPose {
        &self.start_from_robot
    }

    /// A track is established: it knows better from now on. `share` is its probability beside its mirrored one.
    pub fn establish(&mut self, pose: PlanarPose, share: f64) {
        self.prior = StartPrior::Uniform;
        self.last = Some((pose, share));
    }

    /// How far off the place where the prior held is, if the pose now is off by `spread_m`, meters.
    pub fn spread_m(&self, spread_m: f64) -> f64 {
        spread_m.hypot(DRIFT * self.way_m)
    }

    /// Probability of a pose beside its mirrored one if the prior tells them apart. The pose is known to `spread_m`: beside the line that parts two
    /// halves a half says little.
    pub fn share_by_prior(&self, model: &dyn FeatureModel, pose: &PlanarPose, spread_m: f64) -> Option<f64> {
        let mirrored = model.mirrored(pose)?;
        let agrees = |pose: &PlanarPose| {
            let start = pose.compose(&self.start_from_robot.inverse());
            (1.0 - SURE) + SURE * self.prior.agreement(&start, self.spread_m(spread_m))
        };
        let (here, there) = (agrees(pose), agrees(&mirrored));
        (here != there).then(|| (here / (here + there)).clamp(1.0 - SURE, SURE))
    }

    /// Probability of a pose beside its mirrored one: the prior decides, then where the robot was last.
    pub fn share(&self, model: &dyn FeatureModel, pose: &PlanarPose, spread_m: f64) -> f64 {
        let Some(mirrored) = model.mirrored(pose) else { return 1.0 };
        if let Some(share) = self.share_by_prior(model, pose, spread_m) {
            return share;
        }
        let Some((last, share_of_last)) = self.last else { return 0.5 };
        let is_near_last = |pose: &PlanarPose| {
            pose.distance_m(&last) < NEAR_LAST_M && pose.heading_difference_rad(&last) < NEAR_LAST_RAD
        };
        let is_of_last = match (is_near_last(pose), is_near_last(&mirrored)) {
            (true, false) => SURE,
            (false, true) => 1.0 - SURE,
            _ => 0.5,
        };
        // Who never knew the side of the field does not learn it by having been somewhere.
        is_of_last * share_of_last + (1.0 - is_of_last) * (1.0 - share_of_last)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use visloc_world::Map;

    use super::*;
    use crate::observation::field::FieldFeatureModel;

    /// A half tells a pose from its mirrored one as far as the line between the halves is away, measured by what the pose is known to.
    #[test]
    fn beside_the_middle_line_a_half_says_little() {
        let Ok(Map::Field(field)) = Map::load("robocup-spl-2024") else { panic!("built-in map") };
        let model = FieldFeatureModel::new(&field);
        let at = |x_m: f64| PlanarPose::new(x_m, 1.0, 0.5);
        let known = Known::new(StartPrior::half_of(&Map::Field(field), &at(1.0)));
        let share = |x_m: f64, spread_m: f64| known.share(&model, &at(x_m), spread_m);
        assert!((share(0.0, 0.05) - 0.5).abs() < 1e-9);
        assert!(share(0.02, 0.05) > 0.6 && share(0.02, 0.05) < 0.9 && share(-0.02, 0.05) < 0.4);
        assert!(share(0.02, 0.002) > 0.98 && share(1.0, 0.05) > 0.98 && share(-1.0, 0.05) < 0.02);
    }

    #[test]
    fn who_never_knew_the_side_does_not_learn_it_by_being_lost() {
        let Ok(Map::Field(field)) = Map::load("robocup-spl-2024") else { panic!("built-in map") };
        let model = FieldFeatureModel::new(&field);
        let pose = PlanarPose::new(2.0, 1.0, 0.5);
        let mut known = Known::new(StartPrior::Uniform);
        for (share, again) in [(0.5, 0.5), (1.0, SURE), (0.99, 0.98)] {
            known.establish(pose, share);
            assert!((known.share(&model, &pose, 0.1) - again).abs() < 0.001);
        }
        // The robot walks on while it is lost: ahead is where it was going.
        let step = PlanarPose::new(1.5, 0.0, 0.0);
        known.move_by(&step);
        let there = pose.compose(&step);
        assert!(known.share(&model, &there, 0.1) > 0.9);
        let mirrored = PlanarPose::new(-there.x_m, -there.y_m, there.yaw_rad + PI);
        assert!(known.share(&model, &mirrored, 0.1) < 0.1);
    }
}
