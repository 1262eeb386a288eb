//! One contender on the frames of a run.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use visloc_core::{
    Frame, RngTree, Truth,
    geom::{PlanarPose, angle},
};
use visloc_locate::{ConfigError, Estimate, FeatureChoice, Pipeline, PipelineConfig, Region, StartPrior};
use visloc_world::Map;

use super::{
    mirror::{is_mirror_nearer, mirrored, mirrored_covariance},
    reliability::TRACKING,
};

/// How a contender plays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Contender {
    /// In tables.
    pub label: String,
    /// Of the registry.
    pub algorithm: String,
    /// What its pose is computed from.
    pub features: FeatureChoice,
    /// Whether it is told in which half of the field the robot stands, whenever it is put down.
    pub is_given_half: bool,
    /// Whether the mirror image of the true pose counts as right.
    pub may_be_mirrored: bool,
}

/// A frame and the answer to it. If the mirror image counts as right, the answer is the one of both that is nearer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment {
    pub secs: f64,
    pub truth: PlanarPose,
    pub is_carried: bool,
    pub estimate: PlanarPose,
    pub covariance: Matrix3<f64>,
    pub reliability: f64,
    /// Whether the true pose and its mirror image are both among the hypotheses.
    pub has_both: bool,
}

impl Moment {
    pub(super) fn position_error_m(&self) -> f64 {
        self.estimate.distance_m(&self.truth)
    }

    pub(super) fn heading_error_rad(&self) -> f64 {
        self.estimate.heading_difference_rad(&self.truth)
    }

    /// Normalized error squared over (x, y, heading) and over (x, y); `None` if the covariance has no inverse.
    pub(super) fn nees(&self) -> Option<(f64, f64)> {
        let (dx, dy) = (self.truth.x_m - self.estimate.x_m, self.truth.y_m - self.estimate.y_m);
        let error = Vector3::new(dx, dy, angle::difference(self.truth.yaw_rad, self.estimate.yaw_rad));
        let inverse = self.covariance.cholesky()?.inverse();
        let position: Matrix2<f64> = self.covariance.fixed_view::<2, 2>(0, 0).into_owned();
        let position_inverse = position.cholesky()?.inverse();
        let offset = Vector2::new(dx, dy);
        Some((error.dot(&(inverse * error)), offset.dot(&(position_inverse * offset))))
    }
}

/// A contender at work.
pub(super) struct Track {
    pub contender: Contender,
    pub moments: Vec<Moment>,
    pipeline: Pipeline,
    half_m: (f64, f64),
    was_carried: bool,
}

impl Track {
    pub(super) fn new(map: &Map, contender: &Contender, rng: RngTree) -> Result<Self, ConfigError> {
        let config = PipelineConfig { features: contender.features, ..PipelineConfig::default() };
        let half_m = match map {
            Map::Field(field) => field.half_carpet_m(),
            _ => (0.0, 0.0), // refused below
        };
        Ok(Self {
            contender: contender.clone(),
            moments: Vec::new(),
            pipeline: Pipeline::builder(map)
                .named(&contender.algorithm, None)
                .config(config)
                .rng(rng)
                .build()?,
            half_m,
            // At the start, too, the robot is put down.
            was_carried: true,
        })
    }

    /// Takes in a frame. The truth is for the referee: it decides which half is named, and what the answer is worth.
    pub(super) fn step(&mut self, frame: &Frame, secs: f64, truth: &Truth) {
        let is_carried = truth.height_m > 0.0;
        if self.contender.is_given_half && self.was_carried && !is_carried {
            self.pipeline.reset_to(&half_of(&truth.world_from_robot, self.half_m));
        }
        self.was_carried = is_carried;
        // An image that cannot be analyzed is left out, as on a robot.
        let Ok(estimate) = self.pipeline.step(frame) else { return };
        let moment = judge(estimate, secs, truth, self.contender.may_be_mirrored);
        self.moments.push(moment);
    }
}

/// The half of the field in which a pose lies.
fn half_of(pose: &PlanarPose, (x_m, y_m): (f64, f64)) -> StartPrior {
    let (min_x_m, max_x_m) = if pose.x_m < 0.0 { (-x_m, 0.0) } else { (0.0, x_m) };
    StartPrior::Region { region: Region { min_x_m, max_x_m, min_y_m: -y_m, max_y_m: y_m }, heading: None }
}

fn judge(estimate: &Estimate, secs: f64, truth: &Truth, may_be_mirrored: bool) -> Moment {
    let pose = truth.world_from_robot;
    let has = |pose: &PlanarPose| {
        estimate.hypotheses.iter().any(|hypothesis| {
            let found = &hypothesis.world_from_robot;
            found.distance_m(pose) < TRACKING.0 && found.heading_difference_rad(pose) < TRACKING.1
        })
    };
    let mut moment = Moment {
        secs,
        truth: pose,
        is_carried: truth.height_m > 0.0,
        estimate: estimate.world_from_robot,
        covariance: estimate.covariance,
        reliability: estimate.reliability,
        has_both: has(&pose) && has(&mirrored(&pose)),
    };
    if may_be_mirrored {
        moment.reliability = estimate.reliability_up_to_symmetry;
    }
    if may_be_mirrored && is_mirror_nearer(&moment.estimate, &pose) {
        moment.estimate = mirrored(&moment.estimate);
        moment.covariance = mirrored_covariance(&moment.covariance);
    }
    moment
}

#[cfg(test)]
mod tests {
    use visloc_locate::Hypothesis;

    use super::*;

    #[test]
    fn a_mirrored_answer_counts_only_where_it_may() {
        let truth = Truth { world_from_robot: PlanarPose::new(1.0, 0.5, 0.3), height_m: 0.0 };
        let hypothesis = |world_from_robot| Hypothesis {
            world_from_robot,
            covariance: Matrix3::identity(),
            probability: 0.5,
        };
        let mirror = mirrored(&truth.world_from_robot);
        let estimate = Estimate {
            world_from_robot: mirror,
            hypotheses: vec![hypothesis(mirror), hypothesis(truth.world_from_robot)],
            ..Estimate::unknown()
        };
        let free = judge(&estimate, 0.0, &truth, true);
        assert!(free.position_error_m() < 1e-9 && free.heading_error_rad() < 1e-9 && free.has_both);
        assert!(judge(&estimate, 0.0, &truth, false).position_error_m() > 2.0);
    }

    #[test]
    fn normalized_errors_by_hand() {
        let truth = Truth { world_from_robot: PlanarPose::new(0.1, 0.0, 0.2), height_m: 0.0 };
        let covariance = Matrix3::from_diagonal(&Vector3::new(0.01, 0.01, 0.04));
        let estimate = Estimate { covariance, ..Estimate::unknown() };
        let (nees, position) = judge(&estimate, 0.0, &truth, false).nees().unwrap();
        assert!((nees - 2.0).abs() < 1e-12 && (position - 1.0).abs() < 1e-12);
    }
}
