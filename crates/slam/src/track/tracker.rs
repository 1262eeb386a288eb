//! The pose of each frame.

use std::sync::Arc;

use nalgebra::{Matrix6, Rotation3, Vector2, Vector6};
use visloc_core::{
    Rng,
    geom::{Camera, Rigid3},
    median,
};

use super::{
    AlignFeature, AlignReference, Feature, Frame, FrameWork, Incoming, LocalMap, Matcher, MotionModel,
    RotationAligner, collect_local_map, matcher::whitening, only_turned, search::Search,
};
use crate::{
    config::{FeatureConfig, TrackingConfig},
    lie::CameraFromWorld,
    map::{KeyframeId, Landmark, LandmarkId, LandmarkState, Map},
    odometry::{CameraMotion, motion_deviations},
    orb::Recognition,
    patch::AlignLimits,
    shutter::Exposure,
    solve::{PoseObservation, PosePrior, Rejection, pose_covariance, robust_pose},
};

/// When the alignment of a landmark's patch counts.
pub const MATCH_LIMITS: AlignLimits =
    AlignLimits { max_iterations: 12, max_shift_px: 5.0, max_unexplained: 0.2, noise: 20.0 };

/// How well a frame was tracked. Thesis, section 6.9.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quality {
    /// Enough of what was searched was found.
    Good,
    /// Much was missed, but the pose is usable; no keyframe is made of it.
    Insufficient,
    /// The pose cannot be trusted.
    Bad,
}

impl Quality {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Insufficient => "insufficient",
            Self::Bad => "bad",
        }
    }
}

/// What became of a frame.
#[derive(Debug, Clone)]
pub struct TrackReport {
    /// The frame with its pose and features.
    pub frame: Frame,
    /// Where it was expected: how it has moved since the last frame, by odometry or the images of both.
    pub expected_from_world: CameraFromWorld,
    /// How well it went.
    pub quality: Quality,
    /// Landmarks that were looked for.
    pub tried: Vec<LandmarkId>,
    /// Places of the image that were searched.
    pub num_searched: usize,
    /// Of these, places of landmarks of a fixed map.
    pub num_fixed_searched: usize,
    /// Landmarks that agree with the pose.
    pub num_matched: usize,
    /// Of those, converged ones.
    pub num_converged: usize,
    /// The part of the map that was searched.
    pub local_map: LocalMap,
    /// Covariance of the pose, see [`crate::solve::pose_covariance`].
    pub covariance: Option<Matrix6<f64>>,
}

impl TrackReport {
    /// Whether more of what should be seen is found than missed. A door that looks like another one is not yet the place around that one.
    pub(crate) fn is_mostly_found(&self) -> bool {
        2 * self.num_matched > self.num_searched
    }
}

/// Whether nothing says how far the camera has moved to a frame: neither enough landmarks whose depth is known, nor odometry, nor that it has
/// only turned. Candidates alone would set the unit of length anew, and the map would go on in another one.
fn is_length_guessed(frame: &Frame, (num_known, fewest): (usize, usize)) -> bool {
    num_known < fewest && frame.turned_from.is_none() && frame.odometry.is_none()
}

/// Whether one count is above another one by more than two of its standard deviations.
fn is_clearly_more(count: usize, than: usize) -> bool {
    count as f64 > than as f64 + 2.0 * (than as f64).sqrt()
}

/// Follows the camera over a map.
#[derive(Debug, Clone)]
pub struct Tracker {
    camera: Camera,
    config: TrackingConfig,
    search_levels: usize,
    recognition: Recognition,
    rotation_aligner: RotationAligner,
    motion: MotionModel,
    last: Option<Frame>,
}

/// Level of the image on which whole views are compared.
const ROTATION_LEVEL: usize = 4;
/// Pixels (of its level) around a predicted place that are searched when a frame fails.
const WIDE_RADIUS: usize = 8;
/// The same after some frames that have failed.
const MOST_RADIUS: usize = 16;
/// Coarsest level of the image alignment.
const COARSEST_LEVEL: usize = 4;

impl Tracker {
    /// A tracker that has not seen anything.
    #[must_use]
    pub fn new(camera: &Camera, config: &TrackingConfig, features: &FeatureConfig) -> Self {
        Self {
            camera: *camera,
            config: config.clone(),
            search_levels: features.search_levels,
            recognition: features.recognition(),
            rotation_aligner: RotationAligner::new(camera, ROTATION_LEVEL),
            motion: MotionModel::default(),
            last: None,
        }
    }

    /// Takes over a camera that is known better.
    pub fn set_camera(&mut self, camera: &Camera) {
        self.camera = *camera;
        self.rotation_aligner = RotationAligner::new(camera, ROTATION_LEVEL);
        for feature in self.last.iter_mut().flat_map(|last| &mut last.features) {
            feature.ray = camera.bearing(&feature.px);
        }
    }

    /// How the scene moved before the camera when the last frame was taken, see [`Exposure::motion`]; `None` after a start.
    #[must_use]
    pub fn motion_before(&self, map: &Map) -> Option<Vector6<f64>> {
        Some(in_depths(self.motion.velocity()?, map, self.last.as_ref()?))
    }

    /// The same for an image that has just come in.
    #[must_use]
    pub fn motion_now(&self, map: &Map, incoming: &Incoming<'_>) -> Option<Vector6<f64>> {
        let last = self.last.as_ref()?;
        let motion = self.predict(map, last, incoming) * last.camera_from_world.inverse();
        let velocity = self.motion.velocity_after(&motion, incoming.at.secs_since(last.at))?;
        Some(in_depths(velocity, map, last))
    }

    /// The last frame that was tracked.
    #[must_use]
    pub fn last(&self) -> Option<&Frame> {
        self.last.as_ref()
    }

    /// Goes on from a frame whose pose is known, standing still.
    pub fn restart_from(&mut self, frame: Frame) {
        self.motion.reset();
        self.last = Some(frame);
    }

    /// Takes over another unit of length: all of the last motion times a factor.
    pub(crate) fn scale_motion(&mut self, factor: f64) {
        self.motion.scale(factor);
    }

    /// Forgets the last frame.
    pub fn forget(&mut self) {
        self.motion.reset();
        self.last = None;
    }

    /// Takes over the pose of the last frame after the map has changed.
    pub fn correct_last(&mut self, camera_from_world: CameraFromWorld) {
        if let Some(last) = &mut self.last {
            last.camera_from_world = camera_from_world;
        }
    }

    /// Accepts a tracked frame as the last one.
    pub fn accept(&mut self, frame: Frame) {
        if let Some(last) = &self.last {
            let motion = frame.camera_from_world * last.camera_from_world.inverse();
            self.motion.update(&motion, frame.at.secs_since(last.at));
        }
        self.last = Some(frame);
    }

    /// Finds the pose of the next frame. `None` if there is no last frame to go on from.
    #[must_use]
    pub fn track(&self, map: &Map, incoming: &Incoming<'_>, work: &mut FrameWork<'_>) -> Option<TrackReport> {
        let last = self.last.as_ref()?;
        let predicted = self.predict(map, last, incoming);
        work.timer.end("image alignment");
        let mut report = self.track_near(map, incoming, (&predicted, 0), last, work);
        if is_clearly_more(last.features.len(), report.num_matched) {
            // Where images tell little of a direction, as along the boards of a floor, their alignment slips by some pixels, and what is found
            // from there is drawn along. To go on as before is better where clearly more is found.
            let by_motion = self.expected_motion(last, incoming) * last.camera_from_world;
            let other = self.track_near(map, incoming, (&by_motion, 0), last, work);
            if is_clearly_more(other.num_matched, report.num_matched) {
                report = other;
            }
        }
        if report.quality == Quality::Bad {
            report = self.track_wide(map, incoming, &predicted, last, work).unwrap_or(report);
        }
        report.expected_from_world = predicted;
        self.hold_place(map, incoming, &mut report);
        if is_length_guessed(&report.frame, (report.num_converged, self.config.min_matches / 2)) {
            report.quality = Quality::Bad;
        }
        if report.quality != Quality::Bad {
            report.frame.exposure = self.exposure_of(map, &report.frame, last, incoming);
        }
        work.timer.end("pose");
        Some(report)
    }

    /// How a frame was exposed whose pose is known; `None` just after a start.
    fn exposure_of(
        &self,
        map: &Map,
        frame: &Frame,
        last: &Frame,
        incoming: &Incoming<'_>,
    ) -> Option<Exposure> {
        let motion = frame.camera_from_world * last.camera_from_world.inverse();
        let velocity = self.motion.velocity_after(&motion, incoming.at.secs_since(last.at))?;
        Some(Exposure { motion: in_depths(velocity, map, frame), readout: incoming.readout })
    }

    /// As [`Tracker::track_near`], but looks around each place first: the farther, the longer ago the last frame is.
    fn track_wide(
        &self,
        map: &Map,
        incoming: &Incoming<'_>,
        predicted: &CameraFromWorld,
        last: &Frame,
        work: &mut FrameWork<'_>,
    ) -> Option<TrackReport> {
        let num_missed = incoming.number.saturating_sub(last.number + 1);
        let radius = (WIDE_RADIUS + WIDE_RADIUS / 2 * num_missed).min(MOST_RADIUS);
        let by_motion = self.expected_motion(last, incoming) * last.camera_from_world;
        for start in [predicted, &by_motion] {
            let wide = self.track_near(map, incoming, (start, radius), last, work);
            if wide.num_matched >= self.config.min_matches / 2 {
                let report = self.track_near(map, incoming, (&wide.frame.camera_from_world, 0), last, work);
                if report.quality != Quality::Bad {
                    return Some(report);
                }
            }
        }
        None
    }

    /// Keeps the camera where the newest keyframe is as long as it only turns and has not gone on as before.
    pub(crate) fn hold_place(&self, map: &Map, incoming: &Incoming<'_>, report: &mut TrackReport) {
        let (Some((newest, _)), Some(last)) = (map.keyframes().next_back(), &self.last) else { return };
        if report.quality == Quality::Bad {
            return;
        }
        let focal = focal_px(&self.camera);
        let going_on = self.expected_motion(last, incoming) * last.camera_from_world;
        if let Some(turned) = only_turned(map, &report.frame, (newest, &going_on), focal) {
            report.frame.camera_from_world = turned;
            report.frame.turned_from = Some(newest);
        }
    }

    /// Motion since the last frame by odometry, meters.
    #[must_use]
    pub fn moved(&self, incoming: &Incoming<'_>) -> Option<CameraMotion> {
        self.last.as_ref()?.odometry?.motion_to(&incoming.odometry?)
    }

    /// Motion since the last frame: by odometry, or else as fast as before.
    fn expected_motion(&self, last: &Frame, incoming: &Incoming<'_>) -> CameraMotion {
        self.moved(incoming).unwrap_or_else(|| self.motion.predict(incoming.at.secs_since(last.at)))
    }

    /// Pose by motion prior and image alignment.
    fn predict(&self, map: &Map, last: &Frame, incoming: &Incoming<'_>) -> CameraFromWorld {
        let features = align_features(map, last);
        let pyramid = incoming.pyramid;
        let expected = self.expected_motion(last, incoming);
        let guess = Rotation3::from_matrix_unchecked(*expected.rotation());
        let turned = self.rotation_aligner.align(&last.pyramid, pyramid, &guess);
        let by_images = Rigid3::new(turned, *expected.translation());
        let mut reference = AlignReference::new(&self.camera, &last.pyramid, &features);
        let most = self.config.max_align_iterations;
        // The start that fits better on the coarsest level goes on to the finer ones.
        let coarse = (COARSEST_LEVEL, COARSEST_LEVEL - 1);
        let mut best = reference.align(pyramid, &expected, coarse, most);
        let other = reference.align(pyramid, &by_images, coarse, most);
        let residual = |alignment| reference.median_residual(pyramid, alignment);
        if other.num_features >= best.num_features / 2 && residual(&other) < residual(&best) {
            best = other;
        }
        let fine_levels = (COARSEST_LEVEL - 2, self.config.finest_align_level);
        let fine = reference.align(pyramid, &best.current_from_reference, fine_levels, most);
        let motion =
            if fine.num_features >= 4 { fine.current_from_reference } else { best.current_from_reference };
        motion * last.camera_from_world
    }

    /// Matches the local map around a predicted pose and finds the pose. With a `radius` above 0, all pixels (of the level)
    /// within it are searched.
    pub(crate) fn track_near(
        &self,
        map: &Map,
        incoming: &Incoming<'_>,
        (predicted, radius): (&CameraFromWorld, usize),
        last: &Frame,
        work: &mut FrameWork<'_>,
    ) -> TrackReport {
        let seen: Vec<LandmarkId> = last.features.iter().map(|feature| feature.landmark).collect();
        let depth = scene_depth(map, last);
        let local_map = collect_local_map(map, &seen, predicted, depth, self.config.max_local_keyframes);
        self.track_in(map, incoming, (predicted, radius, None), (last, local_map), work)
    }

    /// Matches only what one keyframe sees, as it looks from there; ends as soon as it is clear that the pose is wrong. All pixels (of the
    /// level) within a radius are searched.
    pub(crate) fn track_as_seen_by(
        &self,
        map: &Map,
        incoming: &Incoming<'_>,
        (predicted, radius): (&CameraFromWorld, usize),
        (keyframe, reference): (KeyframeId, &Frame),
        work: &mut FrameWork<'_>,
    ) -> TrackReport {
        let landmarks = reference.features.iter().map(|feature| feature.landmark).collect();
        let local_map = LocalMap { keyframes: vec![keyframe], landmarks };
        self.track_in(map, incoming, (predicted, radius, Some(keyframe)), (reference, local_map), work)
    }

    fn track_in(
        &self,
        map: &Map,
        incoming: &Incoming<'_>,
        (predicted, radius, seen_by): (&CameraFromWorld, usize, Option<KeyframeId>),
        (last, local_map): (&Frame, LocalMap),
        work: &mut FrameWork<'_>,
    ) -> TrackReport {
        let Incoming { number, at, pyramid, .. } = *incoming;
        let matcher = Matcher {
            camera: &self.camera,
            pyramid,
            camera_from_world: *predicted,
            limits: MATCH_LIMITS,
            num_levels: self.search_levels,
            recognition: self.recognition,
            seen_by,
        };
        work.timer.end("local map");
        let search = Search::run(map, &matcher, &local_map, (&self.config, radius), work);
        let focal = focal_px(&self.camera);
        let observations: Vec<PoseObservation> = search
            .features
            .iter()
            .map(|feature| self.observation(map.landmark(feature.landmark), feature, map, predicted, focal))
            .collect();
        let prior = last.odometry.zip(incoming.odometry).and_then(|(last_odometry, odometry)| {
            let moved = last_odometry.motion_to(&odometry)?;
            Some(PosePrior::new(moved * last.camera_from_world, motion_deviations(&moved)))
        });
        let robust = robust_pose(predicted, prior.as_ref(), (&observations, self.rejection()), work.rng);
        let mut features = search.features;
        let mut keep = robust.is_inlier.iter();
        features.retain(|_| *keep.next().unwrap_or(&false));
        let mut agreeing = observations;
        let mut keep = robust.is_inlier.iter();
        agreeing.retain(|_| *keep.next().unwrap_or(&false));
        let covariance = pose_covariance(&robust.camera_from_world, &agreeing);
        let num_converged = features.iter().filter(|f| map.landmark(f.landmark).is_converged()).count();
        let quality = self.quality(search.num_searched, features.len());
        work.timer.end("pose");
        TrackReport {
            num_matched: features.len(),
            num_converged,
            num_searched: search.num_searched,
            num_fixed_searched: search.num_fixed_searched,
            tried: search.tried,
            quality,
            local_map,
            covariance,
            expected_from_world: *predicted,
            frame: Frame {
                number,
                at,
                pyramid: Arc::clone(pyramid),
                camera_from_world: robust.camera_from_world,
                features,
                turned_from: None,
                odometry: incoming.odometry,
                exposure: None,
            },
        }
    }

    /// Where a frame was, by what was found in it, in a map that was adjusted since; `None` if too little of that still agrees.
    pub(crate) fn pose_again(
        &self,
        map: &Map,
        expected: &CameraFromWorld,
        features: &[Feature],
        rng: &mut Rng,
    ) -> Option<CameraFromWorld> {
        let focal = focal_px(&self.camera);
        let observations: Vec<PoseObservation> = features
            .iter()
            .map(|feature| (map.landmark(feature.landmark), feature))
            .filter(|(landmark, _)| landmark.is_alive())
            .map(|(landmark, feature)| self.observation(landmark, feature, map, expected, focal))
            .collect();
        // They agreed once.
        let rejection = Rejection { max_hypotheses: None, ..self.rejection() };
        let robust = robust_pose(expected, None, (&observations, rejection), rng);
        (robust.num_inliers >= self.config.min_matches).then_some(robust.camera_from_world)
    }

    fn quality(&self, num_searched: usize, num_matched: usize) -> Quality {
        let ratio = num_matched as f64 / num_searched.max(1) as f64;
        if num_matched < self.config.min_matches / 2 {
            Quality::Bad
        } else if ratio > self.config.min_match_ratio && num_matched >= self.config.min_matches {
            Quality::Good
        } else if num_matched < self.config.min_matches {
            Quality::Bad
        } else {
            Quality::Insufficient
        }
    }

    fn rejection(&self) -> Rejection {
        Rejection {
            max_hypotheses: self.config.reject_outliers.then_some(self.config.max_hypotheses),
            has_robust_weights: self.config.robust_weights,
        }
    }

    /// An observation whose covariance includes what is not known of a candidate's depth: a candidate seen from where it was
    /// made says all about the rotation and nothing about the distance.
    fn observation(
        &self,
        landmark: &Landmark,
        feature: &Feature,
        map: &Map,
        predicted: &CameraFromWorld,
        focal: f64,
    ) -> PoseObservation {
        let weight = whitening(focal, &feature.covariance_px);
        if landmark.state() != LandmarkState::Candidate {
            return PoseObservation::of_point(landmark.point_in_world, feature.ray, weight);
        }
        let spread = depth_spread(map, landmark, predicted).unwrap_or_default();
        let covariance_px = feature.covariance_px + spread * spread.transpose() * (focal * focal);
        let host = map.keyframe(landmark.host().keyframe);
        PoseObservation {
            anchor_in_world: *host.center_in_world(),
            direction_in_world: host.camera_from_world().rotation().transpose() * landmark.host().ray,
            inverse_depth: landmark.filter.as_ref().map(|filter| filter.inverse_depth()),
            ray: feature.ray,
            whitening: whitening(focal, &covariance_px),
        }
    }
}

/// Geometric mean of the focal lengths, pixels.
#[must_use]
pub fn focal_px(camera: &Camera) -> f64 {
    let (fx, fy) = camera.focal_px();
    (fx * fy).sqrt()
}

/// How far a candidate's image moves for one standard deviation of its inverse depth, on the plane z = 1.
#[must_use]
pub fn depth_spread(
    map: &Map,
    landmark: &Landmark,
    camera_from_world: &CameraFromWorld,
) -> Option<Vector2<f64>> {
    let host = landmark.host();
    let motion = *camera_from_world * map.keyframe(host.keyframe).camera_from_world().inverse();
    let filter = landmark.filter.as_ref()?;
    let inverse_depth = filter.inverse_depth();
    let point = motion.rotate(&host.ray) + motion.translation() * inverse_depth;
    if point.z <= 1e-6 {
        return None;
    }
    let t = motion.translation();
    let (x, y) = (point.x / point.z, point.y / point.z);
    let by_inverse_depth = Vector2::new(t.x - x * t.z, t.y - y * t.z) / point.z;
    Some(by_inverse_depth * filter.standard_deviation())
}

/// A motion per second in depths of the scene that a frame shows.
fn in_depths(v: Vector6<f64>, map: &Map, frame: &Frame) -> Vector6<f64> {
    let depth = scene_depth(map, frame);
    Vector6::new(v.x / depth, v.y / depth, v.z / depth, v.w, v.a, v.b)
}

/// Median depth of the landmarks of a frame, map units; 1 without landmarks.
#[must_use]
pub fn scene_depth(map: &Map, frame: &Frame) -> f64 {
    let depth = |feature: &Feature| {
        let landmark = map.landmark(feature.landmark);
        landmark.is_alive().then(|| frame.camera_from_world.transform(&landmark.point_in_world).z)
    };
    median(frame.features.iter().filter_map(depth).filter(|z| *z > 0.0)).unwrap_or(1.0)
}

/// Features of a frame as points in its camera, along their measured rays.
fn align_features(map: &Map, frame: &Frame) -> Vec<AlignFeature> {
    let feature = |feature: &Feature| {
        let landmark = map.landmark(feature.landmark);
        let depth = frame.camera_from_world.transform(&landmark.point_in_world).z;
        (landmark.is_alive() && depth > 0.0)
            .then(|| AlignFeature { px: feature.px, point: feature.ray * depth })
    };
    frame.features.iter().filter_map(feature).collect()
}

#[cfg(test)]
mod tests {
    use visloc_core::{GrayImage, Timestamp};

    use super::*;
    use crate::{
        image::Pyramid,
        odometry::{OdomFromCamera, OdomPose},
    };

    #[test]
    fn candidates_alone_do_not_say_how_far_a_camera_has_moved() {
        let frame = Frame {
            number: 1,
            at: Timestamp::default(),
            pyramid: Arc::new(Pyramid::new(GrayImage::new(40, 30), 1)),
            camera_from_world: CameraFromWorld::identity(),
            features: Vec::new(),
            turned_from: None,
            odometry: None,
            exposure: None,
        };
        assert!(is_length_guessed(&frame, (5, 6)) && !is_length_guessed(&frame, (6, 6)));
        let turned = Frame { turned_from: Some(KeyframeId(0)), ..frame.clone() };
        assert!(!is_length_guessed(&turned, (0, 6)));
        let odometry = Some(OdomPose { odom_from_camera: OdomFromCamera::identity(), stretch: 0 });
        assert!(!is_length_guessed(&Frame { odometry, ..frame }, (0, 6)));
    }
}
