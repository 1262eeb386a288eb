//! A map of views whose poses are known: nothing has to be followed, only the landmarks are found.
//!
//! Corners of each view are looked for along their epipolar lines in other views, by descriptors; what two views agree on is searched by its
//! patch in all views around, and stays if enough of them see it. The poses stay as they are.

use std::sync::Arc;

use nalgebra::{Matrix3, Point3, Vector3};
use visloc_core::{GrayImage, Timestamp, geom::Camera};

use super::{DepthFilter, candidate::corner_covariance, candidate::new_corners};
use crate::{
    config::{ConfigError, SlamConfig},
    image::{Pyramid, level_from_px},
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkId, LandmarkState, Map, NewKeyframe, Observation, Observations},
    orb::OrbDescriptor,
    outcome::FrameError,
    recognize::{LESS_THAN_SECOND, MOST_DIFFERENT, View},
    solve::{cos_parallax, triangulate},
    track::{MATCH_LIMITS, Matcher, focal_px},
};

/// Views around one, by their distance from it, in which its corners are looked for: the nearest, and some that are farther away where views are
/// dense.
const RANKS: [usize; 9] = [0, 1, 2, 3, 5, 8, 13, 21, 34];
/// Views around one in which what was found is searched by its patch.
const SEARCHED: usize = 24;
/// Cosine of the angle between two views up to which they may see the same: 50 degrees.
const LEAST_COS_VIEWS: f64 = 0.643;
/// Distance of a corner from the epipolar line, pixels of its level.
const FROM_LINE_PX: f64 = 2.5;
/// The same where no third view confirms it.
const MOST_DIFFERENT_OF_TWO: u32 = 40;
const LESS_THAN_SECOND_OF_TWO: f64 = 0.7;
/// Distance of a view of a landmark from where it should be, pixels of its level.
const MOST_ERROR_PX: f64 = 2.0;
/// Cosine of the least angle under which two views see a landmark: one degree.
const MOST_COS_PARALLAX: f64 = 0.999_85;
/// Corners of other views that are tried for a corner.
const TRIES: usize = 4;

/// Takes views with their poses, and makes a map of them.
#[derive(Debug)]
pub struct GivenViews {
    camera: Camera,
    config: SlamConfig,
    map: Map,
    last_at: Option<Timestamp>,
}

/// A corner of another view that may be the same.
#[derive(Debug, Clone, Copy)]
struct Alike {
    keyframe: KeyframeId,
    ray: Vector3<f64>,
    distance: u32,
    /// Share of the different bits of the second most alike.
    ratio: f64,
}

impl GivenViews {
    /// For one camera.
    ///
    /// # Errors
    /// If a parameter is out of range.
    pub fn new(camera: &Camera, config: &SlamConfig) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self { camera: *camera, config: config.clone(), map: Map::new(), last_at: None })
    }

    /// Takes a view and its pose, in any unit of length.
    ///
    /// # Errors
    /// If the image has another size than the camera, or the time is not later than that of the view before; the view is left out.
    pub fn add(
        &mut self,
        at: Timestamp,
        image: GrayImage,
        camera_from_world: CameraFromWorld,
    ) -> Result<(), FrameError> {
        let (width, height) = self.camera.size_px();
        let (expected, found) = ((width as usize, height as usize), (image.width(), image.height()));
        if expected != found {
            return Err(FrameError::Size { expected, found });
        }
        if let Some(last) = self.last_at.filter(|last| *last >= at) {
            return Err(FrameError::Time { last, found: at });
        }
        self.last_at = Some(at);
        let pyramid = Arc::new(Pyramid::new(image, self.config.features.pyramid_levels));
        let frame = self.map.num_keyframe_ids();
        let view = NewKeyframe { frame, at, pyramid, camera_from_world, turned_from: None, odometry: None };
        self.map.add_keyframe(view);
        Ok(())
    }

    /// How many views there are.
    #[must_use]
    pub fn num_views(&self) -> usize {
        self.map.num_keyframe_ids()
    }

    /// The map of all views.
    #[must_use]
    pub fn finish(mut self) -> Map {
        let ids: Vec<KeyframeId> = self.map.keyframes().map(|(id, _)| id).collect();
        let corners: Vec<View> = ids.iter().map(|id| self.described(*id)).collect();
        for id in &ids {
            self.make_landmarks(*id, &corners);
        }
        for id in ids {
            let view = View::of_keyframe(&self.map, id);
            self.map.describe(id, view);
        }
        self.map
    }

    /// The corners of a view with their descriptors.
    fn described(&self, id: KeyframeId) -> View {
        let pyramid = self.map.keyframe(id).pyramid();
        pyramid
            .map(|pyramid| View::of_image(&pyramid, &self.camera, &self.config.features))
            .unwrap_or_default()
    }

    /// Views that may see the same as one, the nearest first.
    fn around(&self, id: KeyframeId) -> Vec<KeyframeId> {
        let own = self.map.keyframe(id);
        let ahead = own.camera_from_world().rotation().row(2).transpose();
        let looks_alike = |other: KeyframeId| {
            let other = self.map.keyframe(other).camera_from_world().rotation().row(2).transpose();
            other.dot(&ahead) > LEAST_COS_VIEWS
        };
        let distance =
            |other: KeyframeId| (self.map.keyframe(other).center_in_world() - own.center_in_world()).norm();
        let mut around: Vec<KeyframeId> = self
            .map
            .keyframes()
            .map(|(other, _)| other)
            .filter(|other| *other != id && looks_alike(*other))
            .collect();
        around.sort_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        around
    }

    /// Makes landmarks of the corners of a view where nothing is known yet.
    fn make_landmarks(&mut self, id: KeyframeId, corners: &[View]) {
        let around = self.around(id);
        let most = self.config.mapping.max_new_candidates.max(1);
        let new = new_corners(&self.map, id, &self.camera, &self.config.features, most);
        let Some(pyramid) = self.map.keyframe(id).pyramid() else { return };
        for corner in new {
            let at = level_from_px(&corner.px, corner.level);
            let (x, y) = (at.x.round().max(0.0) as usize, at.y.round().max(0.0) as usize);
            let Some(descriptor) = OrbDescriptor::new(pyramid.level(corner.level), x, y) else { continue };
            let host = Observation {
                keyframe: id,
                px: corner.px,
                ray: self.camera.bearing(&corner.px),
                level: corner.level,
                covariance_px: corner_covariance(corner.level),
            };
            let near = RANKS.iter().filter_map(|rank| around.get(*rank));
            let mut alike: Vec<Alike> = near
                .filter_map(|other| self.alike(&host, &descriptor, *other, &corners[other.index()]))
                .collect();
            alike.sort_by_key(|alike| alike.distance);
            for alike in alike.into_iter().take(TRIES) {
                if self.add_landmark(&host, &alike, &around) {
                    break;
                }
            }
        }
    }

    /// The corner of another view on the epipolar line of a corner that looks most like it.
    fn alike(
        &self,
        host: &Observation,
        descriptor: &OrbDescriptor,
        other: KeyframeId,
        corners: &View,
    ) -> Option<Alike> {
        let motion = *self.map.keyframe(other).camera_from_world()
            * self.map.keyframe(host.keyframe).camera_from_world().inverse();
        let line = motion.translation().cross(&motion.rotate(&host.ray));
        let length = line.xy().norm();
        let focal = focal_px(&self.camera);
        let mut best: Option<(u32, crate::recognize::Described, Vector3<f64>)> = None;
        let mut second = u32::MAX;
        for place in corners.iter() {
            let distance = descriptor.distance(&place.descriptor);
            if distance > 2 * MOST_DIFFERENT {
                continue;
            }
            let ray = self.camera.bearing(&place.px);
            let from_line_px = focal * (line.dot(&ray)).abs() / length;
            // Without a way between the views there is no line.
            if from_line_px.is_nan() || from_line_px > FROM_LINE_PX * f64::from(place.level).exp2() {
                continue;
            }
            match best {
                Some((least, known, _))
                    if (known.px - place.px).norm() < 3.0 * f64::from(place.level).exp2() =>
                {
                    if distance < least {
                        best = Some((distance, place, ray));
                    }
                }
                Some((least, ..)) if distance >= least => second = second.min(distance),
                _ => {
                    second = best.map_or(second, |(least, ..)| second.min(least));
                    best = Some((distance, place, ray));
                }
            }
        }
        let (distance, _, ray) = best.filter(|(distance, ..)| *distance <= MOST_DIFFERENT)?;
        let ratio = f64::from(distance) / f64::from(second.max(1));
        (ratio < LESS_THAN_SECOND).then_some(Alike { keyframe: other, ray, distance, ratio })
    }

    /// Makes a landmark of two corners that may be the same; whether enough views see it.
    fn add_landmark(&mut self, host: &Observation, alike: &Alike, around: &[KeyframeId]) -> bool {
        let motion = *self.map.keyframe(alike.keyframe).camera_from_world()
            * self.map.keyframe(host.keyframe).camera_from_world().inverse();
        let Some((depth, _)) = triangulate(&motion, &host.ray, &alike.ray) else { return false };
        let (own, other) = (self.map.keyframe(host.keyframe), self.map.keyframe(alike.keyframe));
        let point = own.camera_from_world().inverse().transform(&Point3::from(host.ray * depth));
        if cos_parallax(&point, own.center_in_world(), other.center_in_world()) > MOST_COS_PARALLAX {
            return false;
        }
        let filter = DepthFilter::new(1.0 / depth, 0.01 / depth);
        let id = self.map.add_landmark(*host, filter, LandmarkState::Converged);
        self.search(id, std::iter::once(alike.keyframe));
        self.search(id, around.iter().copied().take(SEARCHED));
        self.refine(id);
        let is_clear = alike.distance <= MOST_DIFFERENT_OF_TWO && alike.ratio < LESS_THAN_SECOND_OF_TWO;
        let least = if is_clear { 2 } else { 3 };
        let landmark = self.map.landmark(id);
        let is_kept = landmark.is_alive() && landmark.observations.len() >= least && self.has_parallax(id);
        if is_kept {
            let num = landmark.observations.len() as u32;
            let landmark = self.map.landmark_mut(id);
            (landmark.num_visible, landmark.num_found) = (num, num);
        } else {
            self.map.remove_landmark(id);
        }
        is_kept
    }

    /// Looks for a landmark in views where it should be.
    fn search(&mut self, id: LandmarkId, views: impl Iterator<Item = KeyframeId>) {
        for other in views {
            let landmark = self.map.landmark(id);
            let keyframe = self.map.keyframe(other);
            if landmark.observation_in(other).is_some() {
                continue;
            }
            let Some(pyramid) = keyframe.pyramid() else { continue };
            let matcher = Matcher {
                camera: &self.camera,
                pyramid: &pyramid,
                camera_from_world: *keyframe.camera_from_world(),
                limits: MATCH_LIMITS,
                num_levels: self.config.features.search_levels,
                recognition: self.config.features.recognition(),
                seen_by: None,
            };
            let Some(predicted) = matcher.project(&landmark.point_in_world) else { continue };
            let Some(found) = matcher.find(&self.map, landmark) else { continue };
            if (found.px - predicted).norm() < MOST_ERROR_PX * f64::from(1_u32 << found.level) {
                self.map.add_observation(id, found.in_keyframe(other));
            }
        }
    }

    /// Moves a landmark to where its rays meet, and leaves out those that do not meet there.
    fn refine(&mut self, id: LandmarkId) {
        let focal = focal_px(&self.camera);
        for _ in 0..2 {
            let landmark = self.map.landmark(id);
            let Some(point) = self.meeting_point(&landmark.observations, landmark.point_in_world) else {
                return;
            };
            let host = landmark.observations.keyframe_at(0);
            let is_off = |o: &Observation| {
                let seen = self.map.keyframe(o.keyframe).camera_from_world().transform(&point);
                let error = (seen.coords / seen.z - o.ray).xy().norm() * focal;
                seen.z <= 0.0 || error.is_nan() || error > MOST_ERROR_PX * f64::from(1_u32 << o.level)
            };
            let off: Vec<KeyframeId> =
                landmark.observations.iter().filter(|o| is_off(o)).map(|o| o.keyframe).collect();
            self.map.landmark_mut(id).point_in_world = point;
            if off.contains(&host) {
                self.map.remove_landmark(id);
                return;
            }
            if off.is_empty() {
                return;
            }
            off.into_iter().for_each(|keyframe| self.map.remove_candidate_observation(id, keyframe));
        }
    }

    /// Where rays meet: Gauss and Newton on the plane z = 1, a few steps.
    fn meeting_point(&self, observations: &Observations, start: Point3<f64>) -> Option<Point3<f64>> {
        let mut point = start;
        for _ in 0..5 {
            let (mut hessian, mut gradient) = (Matrix3::zeros(), Vector3::zeros());
            for observation in observations.iter() {
                let pose = self.map.keyframe(observation.keyframe).camera_from_world();
                let seen = pose.transform(&point);
                if seen.z <= 0.0 {
                    return None;
                }
                let weight = 1.0 / f64::from(1_u32 << (2 * observation.level));
                let (u, v) = (seen.x / seen.z, seen.y / seen.z);
                let rows = [
                    (Vector3::new(1.0, 0.0, -u) / seen.z, u - observation.ray.x),
                    (Vector3::new(0.0, 1.0, -v) / seen.z, v - observation.ray.y),
                ];
                for (in_camera, error) in rows {
                    let row = pose.rotation().transpose() * in_camera;
                    hessian += row * row.transpose() * weight;
                    gradient += row * error * weight;
                }
            }
            point -= hessian.try_inverse()? * gradient;
        }
        point.iter().all(|value| value.is_finite()).then_some(point)
    }

    /// Whether two views see a landmark under an angle that tells its depth.
    fn has_parallax(&self, id: LandmarkId) -> bool {
        let landmark = self.map.landmark(id);
        let mut centers = landmark.observations.keyframes().map(|id| self.map.keyframe(id).center_in_world());
        let host = self.map.keyframe(landmark.observations.keyframe_at(0)).center_in_world();
        centers.any(|center| cos_parallax(&landmark.point_in_world, host, center) < MOST_COS_PARALLAX)
    }
}
