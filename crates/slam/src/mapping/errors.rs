//! How far a map may be off.

use nalgebra::{Matrix3, Matrix6, Vector6};
use visloc_core::{geom::Camera, median};

use super::adjust::{CHI2, collect};
use crate::{
    lie::{CameraFromWorld, adjoint},
    map::{KeyframeId, LandmarkId, Map},
    solve::{Bundle, PoseObservation, pose_covariance_among},
    track::{Feature, focal_px, whitening},
};

/// Keyframes that are looked at: of a larger map every second, third and so on. What the others say is about the same.
const MOST_KEYFRAMES: usize = 200;

/// How far maps may be off, by how well their observations agree. It is told against each map as a whole: where that lies in the world, how
/// it is turned and how large it is are not in it.
#[derive(Debug, Clone, Default)]
pub struct MapErrors {
    /// Covariances of poses over twists in the frame of the keyframe, by its number, and by how much more errors add up around it than independent
    /// ones, see [`crate::solve::BundleErrors`].
    keyframes: Vec<Option<(Matrix6<f64>, f64)>>,
    /// Covariances of places beside the keyframes that see them, by the number of the landmark, zero where nothing is known.
    landmarks: Vec<ShortCovariance>,
}

impl MapErrors {
    /// Of all maps, for a camera that is followed now. A map for which the equations have no solution is left out.
    #[must_use]
    pub fn of(map: &Map, camera: &Camera) -> Self {
        let mut all = Self {
            keyframes: vec![None; map.num_keyframe_ids()],
            landmarks: vec![ShortCovariance::default(); map.num_landmark_ids()],
        };
        for id in map.maps() {
            all.add(&map.with_active(id), focal_px(camera));
        }
        all
    }

    fn add(&mut self, map: &Map, focal_px: f64) {
        let keyframes: Vec<KeyframeId> = map.keyframes().map(|(id, _)| id).collect();
        let step = keyframes.len().div_ceil(MOST_KEYFRAMES).max(1);
        let keyframes: Vec<KeyframeId> = keyframes.into_iter().step_by(step).collect();
        let Some(depth) = median(keyframes.iter().filter_map(|id| map.depth_of(*id))) else { return };
        let (bundle, landmarks) = among(map, &keyframes, focal_px);
        // No keyframe is off by more than the depth of what is seen, or by more than a radian.
        let Some(errors) = bundle.errors(CHI2.sqrt(), (depth, 1.0)) else { return };
        for (id, covariance) in keyframes.iter().zip(errors.cameras) {
            self.keyframes[id.index()] = Some((covariance * errors.design_effect, errors.design_effect));
        }
        for observation in &bundle.observations {
            let covariance = within(&errors.points[observation.point], depth) * errors.design_effect;
            self.landmarks[landmarks[observation.point].index()] = ShortCovariance::from(&covariance);
        }
    }

    /// Covariance of a pose by landmarks of a map as one image shows them, over a twist in the frame of the camera: translation first, map units
    /// and radians. `None` where nothing is known of the map around them.
    #[must_use]
    pub fn covariance(
        &self,
        map: &Map,
        features: &[Feature],
        (camera, camera_from_world): (&Camera, &CameraFromWorld),
    ) -> Option<Matrix6<f64>> {
        let landmarks: Vec<LandmarkId> = features.iter().map(|feature| feature.landmark).collect();
        let known = |(id, _): &(KeyframeId, u32)| Some((*id, (*self.keyframes.get(id.index())?)?));
        let (keyframe, (of_keyframe, design_effect)) = map.sharing(&landmarks, 1).iter().find_map(known)?;
        let focal = focal_px(camera);
        let seen = |feature: &Feature| {
            let point = map.landmark(feature.landmark).point_in_world;
            let whitening = whitening(focal, &(feature.covariance_px * design_effect));
            let of_point = self.landmarks.get(feature.landmark.index()).copied().unwrap_or_default();
            (PoseObservation::of_point(point, feature.ray, whitening), of_point.get())
        };
        let observations: Vec<(PoseObservation, Matrix3<f64>)> = features.iter().map(seen).collect();
        // Landmarks around a keyframe move with it.
        let moves = adjoint(&(*camera_from_world * map.keyframe(keyframe).camera_from_world().inverse()));
        let of_image = pose_covariance_among(camera_from_world, &observations)?;
        Some(of_image + moves * of_keyframe * moves.transpose())
    }
}

/// A covariance as its lower triangle, row by row: single precision is enough for large maps.
#[derive(Debug, Clone, Copy, Default)]
struct ShortCovariance(Vector6<f32>);

impl From<&Matrix3<f64>> for ShortCovariance {
    fn from(full: &Matrix3<f64>) -> Self {
        Self(Vector6::new(full.m11, full.m21, full.m22, full.m31, full.m32, full.m33).cast())
    }
}

impl ShortCovariance {
    fn get(&self) -> Matrix3<f64> {
        let [xx, xy, yy, xz, yz, zz] = self.0.cast().into();
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }
}

/// A covariance of which no direction is off by more than a length: along a ray next to nothing may be known, and so large a number would leave
/// single precision nothing to tell the other directions by.
fn within(covariance: &Matrix3<f64>, most: f64) -> Matrix3<f64> {
    let share = Matrix3::identity() + covariance / most.powi(2);
    share.try_inverse().map_or(*covariance, |share| covariance * share)
}

/// What some keyframes see, and the landmarks; the first keyframe is held.
fn among(map: &Map, keyframes: &[KeyframeId], focal_px: f64) -> (Bundle, Vec<LandmarkId>) {
    let (mut bundle, index) = collect(map, keyframes, focal_px);
    // Keyframes beside them would hold them.
    let is_one = |camera: usize| camera < keyframes.len();
    bundle.observations.retain(|observation| is_one(observation.camera));
    bundle.ties.retain(|tie| is_one(tie.cameras.0) && is_one(tie.cameras.1));
    bundle.motions.retain(|motion| is_one(motion.cameras.0) && is_one(motion.cameras.1));
    bundle.cameras.truncate(keyframes.len());
    bundle.is_free = (0..keyframes.len()).map(|camera| camera > 0).collect();
    let mut num_seen = vec![0; bundle.points.len()];
    bundle.observations.iter().for_each(|observation| num_seen[observation.point] += 1);
    bundle.observations.retain(|observation| num_seen[observation.point] >= 2);
    (bundle, index.landmarks)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;

    #[test]
    fn single_precision_is_enough_for_a_place_of_which_the_distance_is_not_known() {
        let turn = Rotation3::from_scaled_axis(Vector3::new(0.3, -0.7, 0.2));
        let of = |variances: [f64; 3]| turn * Matrix3::from_diagonal(&variances.into()) * turn.transpose();
        let limited = ShortCovariance::from(&within(&of([1e-5, 4e-5, 600.0]), 3.0)).get();
        let across = turn.transpose() * limited * turn;
        assert!((across.m11 / 1e-5 - 1.0).abs() < 0.2 && (across.m22 / 4e-5 - 1.0).abs() < 0.05, "{across}");
        assert!((across.m33 - 600.0 / (1.0 + 600.0 / 9.0)).abs() < 1e-3, "{across}");
        let known = of([1e-5, 2e-5, 4e-4]);
        assert!((within(&known, 3.0) - known).norm() < 1e-7);
    }
}
