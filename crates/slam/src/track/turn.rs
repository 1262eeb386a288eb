//! Whether the camera has only turned since a keyframe.
//!
//! Under pure rotation nothing is learned of depths, and landmarks that come into view have none. An estimated translation is
//! noise then, and depths that are triangulated with it are wrong together with it. So a place that explains the image as well
//! as any other is kept exactly.

use nalgebra::{Rotation3, Vector3};
use visloc_core::median;

use super::{Frame, whitening};
use crate::{
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkState, Map},
    solve::{PoseObservation, State, refine_turn},
};

/// Least turn since the keyframe, radians: below, both see the same landmarks and there is no need for the test.
const LEAST_TURN_RAD: f64 = 0.03;
/// Known landmarks below which the test is made without any turn, and below which a pose hangs on landmarks whose depth is still guessed.
pub(crate) const FEW_KNOWN: usize = 40;
/// Fewest landmarks for the test.
const LEAST_LANDMARKS: usize = 12;
/// What a translation may gain in squared residuals: about three times what three degrees of freedom gain in one of a thousand
/// turns. A true translation by 1 % of the depth gains thousands.
const MOST_CHI2: f64 = 50.0;
/// Largest median of the candidates' squared residuals; 1.4 for exact covariances.
const MOST_MEDIAN_CHI2: f64 = 3.0;
/// Squared residual at which a landmark counts as an outlier of the turn.
const OUTLIER_CHI2: f64 = 25.0;

/// Pose of a frame at the exact place of a keyframe, if that explains the frame as well as its own pose, and its known landmarks as well as
/// the place where it would be if it had gone on as before: a handful of landmarks at the end of a quick turn fit any place by themselves.
#[must_use]
pub fn only_turned(
    map: &Map,
    frame: &Frame,
    (reference, going_on): (KeyframeId, &CameraFromWorld),
    focal_px: f64,
) -> Option<CameraFromWorld> {
    let keyframe = map.keyframe(reference);
    let turn = frame.camera_from_world * keyframe.camera_from_world().inverse();
    let (known, candidates) = observations(map, frame, reference, focal_px);
    let is_needed = turn.rotation_angle_rad() >= LEAST_TURN_RAD || known.len() < FEW_KNOWN;
    if !is_needed || known.len() + candidates.len() < LEAST_LANDMARKS {
        return None;
    }
    let all: Vec<PoseObservation> = known.iter().chain(&candidates).copied().collect();
    let rotation = Rotation3::from_matrix_unchecked(*frame.camera_from_world.rotation());
    let turned_at = |center: &Vector3<f64>, observations: &[PoseObservation]| {
        let start = CameraFromWorld::new(rotation, -(rotation * center));
        let wide = refine_turn(&start, observations, |_| true, 20.0, 5);
        refine_turn(&wide, observations, |_| true, 6.0, 5)
    };
    let here = keyframe.center_in_world().coords;
    let turned = turned_at(&here, &all);
    let sum = |pose: &CameraFromWorld| {
        let state = State::new(pose);
        known.iter().map(|observation| observation.chi2(&state).min(OUTLIER_CHI2)).sum::<f64>()
    };
    let (free_chi2, turned_chi2) = (sum(&frame.camera_from_world), sum(&turned));
    // The residuals themselves say how far to trust the covariances.
    let variance = if known.len() < 10 { 1.0 } else { free_chi2 / (2.0 * known.len() as f64 - 6.0) };
    let state = State::new(&turned);
    let usual = median(candidates.iter().map(|observation| observation.chi2(&state))).unwrap_or(0.0);
    let gain = (turned_chi2 - free_chi2) / variance.max(0.3);
    if gain > MOST_CHI2 || usual > MOST_MEDIAN_CHI2 {
        return None;
    }
    // Depths of candidates are not known: nothing that they show speaks against going on.
    let known_at = |center: &Vector3<f64>| sum(&turned_at(center, &known));
    (known_at(&here) <= known_at(going_on.inverse().translation())).then_some(turned)
}

/// Landmarks whose place is known, and candidates that were made at the same place, of whose depth nothing needs to be known.
fn observations(
    map: &Map,
    frame: &Frame,
    reference: KeyframeId,
    focal_px: f64,
) -> (Vec<PoseObservation>, Vec<PoseObservation>) {
    let place = first_at(map, reference);
    let (mut known, mut candidates) = (Vec::new(), Vec::new());
    for feature in &frame.features {
        let landmark = map.landmark(feature.landmark);
        let weight = whitening(focal_px, &feature.covariance_px);
        let observation = PoseObservation::of_point(landmark.point_in_world, feature.ray, weight);
        match landmark.state() {
            LandmarkState::Converged => known.push(observation),
            LandmarkState::Candidate if first_at(map, landmark.host().keyframe) == place => {
                candidates.push(observation);
            }
            _ => {}
        }
    }
    (known, candidates)
}

/// The first of the keyframes at the same place.
fn first_at(map: &Map, mut keyframe: KeyframeId) -> KeyframeId {
    while let Some(other) = map.turned_from(keyframe) {
        keyframe = other;
    }
    keyframe
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Matrix2, Point2, Vector6};
    use rand::RngExt;
    use visloc_core::{GrayImage, RngTree, Timestamp, gaussian};

    use super::*;
    use crate::{
        image::Pyramid,
        lie::moved,
        map::{NewKeyframe, Observation},
        mapping::DepthFilter,
        track::Feature,
    };

    const FOCAL_PX: f64 = 500.0;
    const SIGMA_PX: f64 = 0.3;

    /// A keyframe at the origin with landmarks, `num_known` of them converged and the others so many times as far away, and a frame that has
    /// moved by a twist. The frame believes that it has moved by 1 % of the depth besides.
    fn scene(seed: u64, (num_known, far): (usize, f64), twist: &Vector6<f64>) -> (Map, Frame, KeyframeId) {
        let mut rng = RngTree::new(seed).stream("turn", 0);
        let mut map = Map::new();
        let pyramid = Arc::new(Pyramid::new(GrayImage::new(40, 30), 1));
        let identity = CameraFromWorld::identity();
        let keyframe = map.add_keyframe(NewKeyframe {
            frame: 0,
            at: Timestamp::default(),
            pyramid: Arc::clone(&pyramid),
            camera_from_world: identity,
            turned_from: None,
            odometry: None,
        });
        let truth = moved(twist, &identity);
        let covariance_px = Matrix2::identity() * SIGMA_PX * SIGMA_PX;
        let mut features = Vec::new();
        for i in 0..80 {
            let is_known = i < num_known;
            let depth = rng.random_range(2.0..5.0) * if is_known { 1.0 } else { far };
            let ray = Vector3::new(rng.random_range(-0.5..0.5), rng.random_range(-0.4..0.4), 1.0);
            // Nothing is known of the depth of a candidate.
            let (believed, state) =
                if is_known { (depth, LandmarkState::Converged) } else { (3.0, LandmarkState::Candidate) };
            let px = Point2::new(0.0, 0.0);
            let host = Observation { keyframe, px, ray, level: 0, covariance_px };
            let id = map.add_landmark(host, DepthFilter::new(1.0 / believed, 0.2), state);
            let seen = truth.transform(&(ray * depth).into());
            let mut noise = || gaussian(&mut rng, SIGMA_PX / FOCAL_PX);
            let ray = Vector3::new(seen.x / seen.z + noise(), seen.y / seen.z + noise(), 1.0);
            features.push(Feature { landmark: id, px, ray, level: 0, covariance_px });
        }
        let is_still = twist.fixed_rows::<3>(0).norm() == 0.0;
        let error = if is_still && num_known == 0 { 0.03 } else { 0.0 };
        let frame = Frame {
            number: 1,
            at: Timestamp::from_secs(0.03),
            pyramid,
            camera_from_world: moved(&Vector6::new(error, 0.0, 0.0, 0.0, 0.0, 0.0), &truth),
            features,
            turned_from: None,
            odometry: None,
            exposure: None,
        };
        (map, frame, keyframe)
    }

    #[test]
    fn a_turning_camera_stays_exactly_where_it_is() {
        for seed in 0..10 {
            for num_known in [0, 5, 80] {
                let (map, frame, keyframe) =
                    scene(seed, (num_known, 1.0), &Vector6::new(0.0, 0.0, 0.0, 0.01, 0.08, 0.0));
                let pose =
                    only_turned(&map, &frame, (keyframe, &CameraFromWorld::identity()), FOCAL_PX).unwrap();
                assert!(pose.inverse().translation().norm() < 1e-9, "seed {seed}, {num_known} known");
            }
        }
    }

    #[test]
    fn a_camera_that_also_moves_is_let_go() {
        for seed in 0..10 {
            for num_known in [0, 20, 80] {
                // 1 % of the depth sideways.
                let (map, frame, keyframe) =
                    scene(seed, (num_known, 1.0), &Vector6::new(0.035, 0.0, 0.0, 0.01, 0.08, 0.0));
                assert!(
                    only_turned(&map, &frame, (keyframe, &CameraFromWorld::identity()), FOCAL_PX).is_none(),
                    "seed {seed}, {num_known} known"
                );
            }
        }
    }

    #[test]
    fn whoever_goes_on_is_not_taken_to_stand_for_want_of_landmarks() {
        for seed in 0..10 {
            let (map, frame, keyframe) =
                scene(seed, (2, 30.0), &Vector6::new(0.1, 0.0, 0.0, 0.01, 0.08, 0.0));
            let turned = |before| only_turned(&map, &frame, (keyframe, before), FOCAL_PX);
            assert!(turned(&frame.camera_from_world).is_none(), "seed {seed}");
            // By themselves, two landmarks say nothing: whoever stood before goes on standing.
            assert!(turned(&CameraFromWorld::identity()).is_some(), "seed {seed}");
        }
    }
}
