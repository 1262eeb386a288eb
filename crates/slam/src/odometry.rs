//! What a robot's odometry says of the camera's way: it predicts motion, holds the map together and gives it its unit of length, and
//! carries the pose over what the camera cannot see.
//!
//! Odometry is used as motion between images only, so its slow drift is left to the map. A map that is started with odometry is in
//! meters.

use visloc_core::geom::{CameraFrame, Odom, Rigid3};

use crate::map::{Map, MapId};

/// Pose of the camera by odometry and kinematics, meters.
pub type OdomFromCamera = Rigid3<Odom, CameraFrame>;

/// Motion of the camera.
pub type CameraMotion = Rigid3<CameraFrame, CameraFrame>;

/// Noise of the kinematics between two images: a head that is turned by joints with play. Standard deviations, meters and radians.
const KINEMATICS_M: f64 = 0.005;
const KINEMATICS_RAD: f64 = 0.009;
/// Error of odometry, share of the way and of the turn. Its factor on lengths is that of the map as well and does not count.
const ODOMETRY_SHARE: f64 = 0.03;
/// Way by odometry whose length is sure, meters: the noise of the kinematics is 2 % of it.
pub(crate) const SURE_WAY_M: f64 = 50.0 * KINEMATICS_M;

/// Where the odometry has the camera.
#[derive(Debug, Clone, Copy)]
pub struct OdomPose {
    /// The pose.
    pub odom_from_camera: OdomFromCamera,
    /// Number of the unbroken stretch of odometry that it belongs to: nothing is known of the motion between two of them.
    pub stretch: usize,
}

impl OdomPose {
    /// Motion from here to another pose, meters: takes points of this camera to the other one.
    #[must_use]
    pub fn motion_to(&self, other: &Self) -> Option<CameraMotion> {
        let motion = other.odom_from_camera.inverse() * self.odom_from_camera;
        (self.stretch == other.stretch).then_some(motion)
    }
}

/// Standard deviations of the motion at the end of a way by odometry, of which the length and all turns are given, meters and radians: meters
/// along each axis, radians about each.
#[must_use]
pub fn deviations(length_m: f64, turn_rad: f64) -> (f64, f64) {
    (KINEMATICS_M.hypot(ODOMETRY_SHARE * length_m), KINEMATICS_RAD.hypot(ODOMETRY_SHARE * turn_rad))
}

/// Standard deviations of a motion that was made straight on, see [`deviations`].
#[must_use]
pub(crate) fn motion_deviations(motion: &CameraMotion) -> (f64, f64) {
    deviations(motion.translation().norm(), motion.rotation_angle_rad())
}

/// A map's unit of length as the odometry tells it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MetricScale {
    /// Map units for each meter.
    pub units_per_meter: f64,
    /// Its relative standard deviation, from the spread along the way; never below that of the way by odometry, since few pieces tell
    /// little of their spread. The factor that the odometry has on all lengths is not in it.
    pub deviation: f64,
    /// Way by odometry that was compared, meters.
    pub way_m: f64,
}

impl MetricScale {
    /// Compares the way along the keyframes of a map with the odometry, piece by piece. `None` without odometry, or if the camera has
    /// hardly moved.
    #[must_use]
    pub fn of_map(map: &Map, of: MapId) -> Option<Self> {
        let mut pieces = Vec::new();
        let mut last: Option<(OdomPose, nalgebra::Point3<f64>)> = None;
        for (_, keyframe) in map.all_keyframes().filter(|(_, keyframe)| keyframe.map == of) {
            let Some(odometry) = keyframe.odometry else { continue };
            let here = (odometry, *keyframe.center_in_world());
            let motion = last.and_then(|(before, center)| Some((before.motion_to(&odometry)?, center)));
            let Some((motion, center)) = motion else {
                last = Some(here);
                continue;
            };
            let meters = motion.translation().norm();
            if meters >= SURE_WAY_M {
                pieces.push(((here.1 - center).norm() / meters, meters));
                last = Some(here);
            }
        }
        Self::of_pieces(&pieces)
    }

    /// From pieces of the way: map units for each meter, and meters.
    fn of_pieces(pieces: &[(f64, f64)]) -> Option<Self> {
        let units_per_meter = weighted_median(pieces).filter(|units| *units > 0.0)?;
        let spread = pieces.iter().map(|(ratio, meters)| ((ratio / units_per_meter - 1.0).abs(), *meters));
        // For a normal distribution the median of the deviations is 0.6745 sigma, and the median of n values has 1.25 times the
        // deviation of their mean.
        let sigma = weighted_median(&spread.collect::<Vec<_>>())? / 0.6745;
        let spread = 1.25 * sigma / (pieces.len() as f64).sqrt();
        let way_m: f64 = pieces.iter().map(|(_, meters)| meters).sum();
        let of_way_m =
            pieces.iter().map(|(_, meters)| deviations(*meters, 0.0).0.powi(2)).sum::<f64>().sqrt();
        Some(Self { units_per_meter, deviation: spread.max(of_way_m / way_m), way_m })
    }
}

fn weighted_median(values: &[(f64, f64)]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * sorted.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut sum = 0.0;
    sorted.into_iter().find_map(|(value, weight)| {
        sum += weight;
        (sum >= half).then_some(value)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_that_slipped_do_not_count() {
        let mut pieces = vec![(2.0, 0.2); 20];
        pieces.extend([(0.1, 0.2), (9.0, 0.2), (2.1, 0.2)]);
        let scale = MetricScale::of_pieces(&pieces).unwrap();
        assert!((scale.units_per_meter - 2.0).abs() < 1e-9, "{scale:?}");
        assert!((scale.way_m - 4.6).abs() < 1e-9 && scale.deviation < 0.01, "{scale:?}");
        assert!(MetricScale::of_pieces(&[]).is_none());
    }

    #[test]
    fn a_short_way_is_not_sure_though_its_pieces_agree() {
        for (num, expected) in [(1, 0.034), (2, 0.024), (100, 0.0034)] {
            let scale = MetricScale::of_pieces(&vec![(2.0, 0.3); num]).unwrap();
            assert!((scale.deviation / expected - 1.0).abs() < 0.02, "{num}: {scale:?}");
        }
    }

    #[test]
    fn nothing_is_known_across_a_gap() {
        let pose = |stretch| OdomPose { odom_from_camera: OdomFromCamera::identity(), stretch };
        assert!(pose(1).motion_to(&pose(1)).is_some());
        assert!(pose(1).motion_to(&pose(2)).is_none());
    }
}
