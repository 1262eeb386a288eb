//! What the calibration of the lens lacks, estimated from the map.
//!
//! A focal length that is off by half a percent, or a rectified image that is still a little curved, hardly shows in a single
//! image. But the depths of landmarks at the border of the image are wrong with it, all in the same direction, and each turn
//! changes the scale of the map: by a quarter in a single turn of a car. The same views tell what is wrong: no depths make
//! them agree.
//!
//! Source for what it does to drives: Cvisic, Markovic and Petrovic, "Recalibrating the KITTI dataset camera setup for improved
//! odometry accuracy", 2021.

use nalgebra::{Point2, Vector2};
use visloc_core::{
    geom::{Camera, Distortion},
    median,
};

use super::adjust::{CHI2, adjust_all, collect};
use crate::{
    config::MappingConfig,
    map::{KeyframeId, LandmarkId, Map},
    solve::{Bundle, BundleLens, BundleObservation, BundleSettings},
    track::focal_px,
};

/// Standard deviation of what a calibration leaves of the first radial coefficient. Other values of the camera are not
/// estimated: a camera that goes ahead tells the focal length and the principal point from depths and its own turns too badly.
/// What rectified images keep of it nobody has measured.
const SIGMA_RECTIFIED: f64 = 0.02;
/// The same where the calibration has a lens: it was fitted to pictures of a board, whose corners tell it to some thousandths.
const SIGMA_CALIBRATED: f64 = 0.003;
/// Step of numeric derivatives by parameters of a lens.
pub(crate) const STEP: f64 = 1e-4;
/// Keyframes with which a map is settled for the first time: fewest that the lens is estimated from.
pub(super) const FIRST_SETTLED_AT: usize = 10;
/// Growth of the number of keyframes after which the map is settled again.
const WAIT: f64 = 1.25;
/// The same if nothing has changed.
const SETTLED_WAIT: f64 = 1.4;
/// Change of the scale, in logarithms, that counts as none.
const SETTLED: f64 = 0.01;
/// Keyframes beyond which it is believed to be known: the whole map would have to move with it.
const MOST_KEYFRAMES: usize = 120;
/// Least gain in squared residuals for which the calibration is taken to be wrong, in units of what is usual for one landmark: the errors of a
/// landmark in several keyframes are alike, so that each landmark counts once.
const LEAST_GAIN: f64 = 15.0;

/// Keeps a map and the lens that it was seen through in agreement.
#[derive(Debug, Clone)]
pub struct LensEstimator {
    /// As calibrated.
    calibrated: Camera,
    change: f64,
    /// Keyframes at which it is estimated next.
    next_at: usize,
}

impl LensEstimator {
    /// For a camera as calibrated.
    pub fn new(calibrated: &Camera) -> Self {
        Self { calibrated: *calibrated, change: 0.0, next_at: FIRST_SETTLED_AT }
    }

    /// For a camera that an earlier session knows better than its calibration does, and a map that was settled then.
    pub fn resume(calibrated: &Camera, camera: &Camera, num_keyframes: usize) -> Self {
        let first = |camera: &Camera| camera.distortion().coefficients().first().copied().unwrap_or(0.0);
        let next_at = FIRST_SETTLED_AT.max((num_keyframes as f64 * SETTLED_WAIT).ceil() as usize);
        Self { calibrated: *calibrated, change: first(camera) - first(calibrated), next_at }
    }

    /// Starts over with a new map; what is known of the lens stays.
    pub fn restart(&mut self) {
        self.next_at = FIRST_SETTLED_AT;
    }

    /// Adjusts the whole map, and the lens with it if that explains the views clearly better. The camera as it is known now; `None` if it
    /// is not yet time to.
    pub fn settle(&mut self, map: &mut Map, camera: &Camera, config: &MappingConfig) -> Option<Camera> {
        // A map that is fixed cannot move with the lens.
        if map.has_fixed() {
            return None;
        }
        let free: Vec<KeyframeId> = map.keyframes().map(|(id, _)| id).collect();
        if free.len() < self.next_at || free.len() > MOST_KEYFRAMES {
            return None;
        }
        let before: Vec<Vec<(LandmarkId, f64)>> = free.iter().map(|id| depths(map, *id)).collect();
        let better = if config.adjust_lens { self.better(map, &free, camera) } else { None };
        let camera = better.unwrap_or(*camera);
        adjust_all(map, config, focal_px(&camera));
        let growth: Vec<(KeyframeId, f64)> =
            free.iter().zip(&before).map(|(id, before)| (*id, growth(map, *id, before))).collect();
        for (id, factor) in &growth {
            map.note_growth(*id, *factor);
        }
        let wait = match (better, growth.iter().all(|(_, factor)| factor.ln().abs() < SETTLED)) {
            (None, true) => SETTLED_WAIT,
            // What was left out as wrong and what was found where it should be were so for the lens of before.
            (Some(_), false) => 1.0,
            _ => WAIT,
        };
        self.next_at = ((free.len() as f64 * wait).ceil() as usize).max(free.len() + 1);
        Some(camera)
    }

    /// The camera as it explains the map clearly better; the map is seen through it then. Once the calibration has proved to be wrong, every
    /// further estimate counts: what it is compared with is no better founded.
    fn better(&mut self, map: &mut Map, keyframes: &[KeyframeId], camera: &Camera) -> Option<Camera> {
        let expected = (-self.change, sigma_of(&self.calibrated));
        let least_gain = if self.change == 0.0 { LEAST_GAIN } else { 0.0 };
        let total = self.change + estimate(map, keyframes, camera, expected, least_gain)?;
        let camera = changed(&self.calibrated, total)?;
        self.change = total;
        map.look_through(&camera);
        Some(camera)
    }
}

/// A camera whose first radial coefficient is changed; `None` if there is no such lens.
fn changed(camera: &Camera, change: f64) -> Option<Camera> {
    let distortion = match camera.distortion() {
        Distortion::None => Distortion::RadialTangential([change, 0.0, 0.0, 0.0, 0.0]),
        Distortion::RadialTangential([k1, k2, p1, p2, k3]) => {
            Distortion::RadialTangential([k1 + change, k2, p1, p2, k3])
        }
        Distortion::KannalaBrandt([k1, k2, k3, k4]) => Distortion::KannalaBrandt([k1 + change, k2, k3, k4]),
        _ => return None,
    };
    Camera::checked(camera.size_px(), camera.focal_px(), camera.center_px(), distortion).ok()
}

/// The change of the lens that explains the views best, if it gains so much. The change that is expected comes
/// with its standard deviation.
fn estimate(
    map: &Map,
    keyframes: &[KeyframeId],
    camera: &Camera,
    (expected, sigma): (f64, f64),
    least_gain: f64,
) -> Option<f64> {
    let (mut bundle, index) = collect(map, keyframes, focal_px(camera));
    // What another camera sees does not depend on this lens.
    let px = |o: &BundleObservation| {
        let (landmark, keyframe) = (map.landmark(index.landmarks[o.point]), index.keyframes[o.camera]);
        let observation = landmark.observation_in(keyframe)?;
        Some(map.keyframe(keyframe).foreign.is_none().then_some(observation.px))
    };
    let px = bundle.observations.iter().map(px).collect::<Option<Vec<_>>>()?;
    let ray_by_change = derivatives(&bundle, camera, &px)?;
    let mut plain = bundle.clone();
    bundle.lens.push(BundleLens { change: 0.0, expected, sigma, ray_by_change, size_by_change: Vec::new() });
    let settings = BundleSettings { max_iterations: 10, huber: CHI2.sqrt() };
    let cost = plain.solve(&settings).last_cost;
    let gain = cost - bundle.solve(&settings).last_cost;
    let usual = cost / bundle.points.len().max(1) as f64;
    bundle.lens.first().map(|lens| lens.change).filter(|_| gain > least_gain * usual)
}

fn sigma_of(calibrated: &Camera) -> f64 {
    match calibrated.distortion() {
        Distortion::None => SIGMA_RECTIFIED,
        _ => SIGMA_CALIBRATED,
    }
}

/// Derivatives of the ray of each observation by the change of the lens.
fn derivatives(bundle: &Bundle, camera: &Camera, px: &[Option<Point2<f64>>]) -> Option<Vec<Vector2<f64>>> {
    let camera = changed(camera, STEP)?;
    let of_one = |(observation, px): (&BundleObservation, &Option<Point2<f64>>)| {
        px.map_or_else(Vector2::zeros, |px| (camera.bearing(&px).xy() - observation.ray) / STEP)
    };
    Some(bundle.observations.iter().zip(px).map(of_one).collect())
}

/// Landmarks of a keyframe with their depths.
fn depths(map: &Map, id: KeyframeId) -> Vec<(LandmarkId, f64)> {
    let keyframe = map.keyframe(id);
    let depth = |id: &LandmarkId| {
        let landmark = map.landmark(*id);
        let depth = keyframe.camera_from_world().transform(&landmark.point_in_world).z;
        (landmark.is_converged() && depth > 0.0).then_some((*id, depth))
    };
    keyframe.landmarks.iter().filter_map(depth).collect()
}

/// Median factor by which the landmarks of a keyframe have gone away from it.
fn growth(map: &Map, id: KeyframeId, before: &[(LandmarkId, f64)]) -> f64 {
    let keyframe = map.keyframe(id);
    let factor = |(id, before): &(LandmarkId, f64)| {
        let landmark = map.landmark(*id);
        let depth = keyframe.camera_from_world().transform(&landmark.point_in_world).z;
        (landmark.is_alive() && depth > 0.0).then_some(depth / before)
    };
    median(before.iter().filter_map(factor)).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_can_be_taken_back_and_is_refused_where_no_lens_has_it() {
        let camera = Camera::pinhole((640, 480), (525.0, 525.0), (319.5, 239.5)).unwrap();
        let bent = changed(&camera, 0.02).unwrap();
        let corner = Point2::new(0.0, 0.0);
        assert!((bent.bearing(&corner) - camera.bearing(&corner)).norm() > 5e-3);
        assert_eq!(changed(&bent, -0.02).unwrap(), camera);
        assert!(changed(&camera, -1000.0).is_none());
    }
}
