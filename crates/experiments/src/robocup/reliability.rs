//! Two proofs: that a reported reliability means something, and that a reported covariance does.

use visloc_locate::LOCALIZED_RELIABILITY;

use super::{
    chi_square::chi_square_quantile,
    record::{Calibration, Consistency},
    track::Moment,
};

/// An answer this near to the truth is good enough to act on, meters.
pub const NEAR_M: f64 = 0.30;
/// A frame tracks the robot if it is localized and its errors are below these: the same limits as for being right after a
/// kidnap. Meters and radians.
pub(super) const TRACKING: (f64, f64) = (0.5, 20.0 * std::f64::consts::PI / 180.0);

impl Calibration {
    /// Counts all frames on the ground.
    pub(super) fn of(moments: &[Moment]) -> Self {
        let mut calibration = Self::default();
        for moment in moments.iter().filter(|moment| !moment.is_carried) {
            let is_near = moment.position_error_m() <= NEAR_M;
            let bin = ((moment.reliability * 10.0) as usize).min(9);
            calibration.frames[bin] += 1;
            calibration.near[bin] += u64::from(is_near);
            calibration.reliability[bin] += moment.reliability;
            if moment.reliability > LOCALIZED_RELIABILITY {
                calibration.claimed += 1;
                calibration.claimed_near += u64::from(is_near);
            }
        }
        calibration
    }

    /// Adds the counts of another run.
    pub fn add(&mut self, other: &Self) {
        for bin in 0..self.frames.len() {
            self.frames[bin] += other.frames[bin];
            self.near[bin] += other.near[bin];
            self.reliability[bin] += other.reliability[bin];
        }
        self.claimed += other.claimed;
        self.claimed_near += other.claimed_near;
    }
}

impl Consistency {
    /// Sums up all frames that track the robot.
    pub(super) fn of(moments: &[Moment]) -> Self {
        let (limit, position_limit) = (chi_square_quantile(3, 0.95), chi_square_quantile(2, 0.95));
        let mut consistency = Self::default();
        for moment in moments.iter().filter(|moment| is_tracking(moment)) {
            consistency.frames += 1;
            let Some((nees, position_nees)) = moment.nees() else {
                consistency.singular += 1;
                continue;
            };
            consistency.sum += nees;
            consistency.in_ellipsoid += u64::from(nees <= limit);
            consistency.in_position_ellipse += u64::from(position_nees <= position_limit);
            let second = moment.secs as usize;
            if consistency.at_secs.len() <= second {
                consistency.at_secs.resize(second + 1, None);
            }
            consistency.at_secs[second].get_or_insert(nees as f32);
        }
        consistency
    }
}

fn is_tracking(moment: &Moment) -> bool {
    !moment.is_carried
        && moment.reliability > LOCALIZED_RELIABILITY
        && moment.position_error_m() < TRACKING.0
        && moment.heading_error_rad() < TRACKING.1
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;
    use visloc_core::{RngTree, gaussian, geom::PlanarPose};

    use super::*;

    fn moment(secs: f64, error_m: f64, reliability: f64) -> Moment {
        Moment {
            secs,
            truth: PlanarPose::default(),
            is_carried: false,
            estimate: PlanarPose::new(error_m, 0.0, 0.0),
            covariance: Matrix3::from_diagonal_element(0.01),
            reliability,
            has_both: false,
        }
    }

    #[test]
    fn frames_fall_into_the_interval_of_their_reliability() {
        let mut moments = vec![moment(0.0, 0.1, 0.95), moment(0.1, 1.0, 1.0), moment(0.2, 0.2, 0.35)];
        moments.push(Moment { is_carried: true, ..moments[0] });
        let calibration = Calibration::of(&moments);
        assert_eq!((calibration.frames[9], calibration.near[9]), (2, 1));
        assert_eq!((calibration.frames[3], calibration.near[3]), (1, 1));
        assert_eq!((calibration.claimed, calibration.claimed_near), (2, 1));
    }

    #[test]
    fn errors_drawn_from_the_covariance_are_consistent() {
        let mut rng = RngTree::new(1).stream("test", 0);
        let draws = (0..4000).map(|i| {
            let mut moment = moment(f64::from(i) / 30.0, 0.0, 0.9);
            moment.estimate =
                PlanarPose::new(gaussian(&mut rng, 0.02), gaussian(&mut rng, 0.05), gaussian(&mut rng, 0.03));
            moment.covariance = Matrix3::from_diagonal(&nalgebra::Vector3::new(4e-4, 2.5e-3, 9e-4));
            moment
        });
        let consistency = Consistency::of(&draws.collect::<Vec<_>>());
        let mean = consistency.sum / 4000.0;
        assert!((mean - 3.0).abs() < 0.15, "mean {mean}");
        let share = consistency.in_ellipsoid as f64 / 4000.0;
        assert!((share - 0.95).abs() < 0.012, "share {share}");
        assert_eq!(consistency.at_secs.len(), 134);
    }

    #[test]
    fn a_covariance_without_inverse_is_counted() {
        let flat = Moment { covariance: Matrix3::zeros(), ..moment(0.0, 0.1, 0.9) };
        let consistency = Consistency::of(&[flat, moment(0.1, 0.1, 0.9), moment(0.2, 2.0, 0.9)]);
        assert_eq!((consistency.frames, consistency.singular), (2, 1));
    }
}
