//! From images to the first two keyframes.

use std::sync::Arc;

use nalgebra::{Matrix2, Point2, Rotation3};
use visloc_core::{
    Rng, Timestamp,
    geom::{Camera, CameraFrame, Rigid3},
    median,
};

use super::{
    Follower, KnownMotion, LostTracks, PendingStart, RayPair, SAME_DEVIATION, SIGMA_PX, SURE, Sight,
    StartWait, Track, TwoView, TwoViewMotion, TwoViewSettings, VerifiedStart, ViewRays, are_alike, confirm,
    followed_covariance, is_clearly_better, negative_log_likelihood, shape_deviation, solve_two_view, verify,
};
use crate::{
    atlas::Similarity,
    backfill::MOST_WAITING,
    config::SlamConfig,
    feature::CornerGrid,
    image::Pyramid,
    lie::CameraFromWorld,
    map::{Correction, KeyframeId, LandmarkId, LandmarkState, Map, NewKeyframe, Observation, scaled},
    mapping::{DepthFilter, adjust_all, corner_covariance, corners_in_two_passes},
    odometry::{CameraMotion, OdomPose, motion_deviations},
    solve::{BundleMotion, PoseObservation, Rejection, robust_pose},
    track::{Feature, Frame, Incoming, RotationAligner, focal_px, whitening},
};

/// What came of a frame.
#[derive(Debug)]
pub enum StartStep {
    /// No map yet, and why.
    Waiting(StartWait),
    /// A map.
    Started(Box<StartedMap>),
}

/// The first map.
#[derive(Debug)]
pub struct StartedMap {
    /// Two keyframes and their landmarks; the median depth of the first is 1.
    pub map: Map,
    /// The first keyframe.
    pub first: KeyframeId,
    /// The newest keyframe.
    pub second: KeyframeId,
    /// Frame of the newest keyframe.
    pub frame: Frame,
    /// Poses of the frames between the two keyframes, found afterwards: number and pose.
    pub between: Vec<(usize, CameraFromWorld)>,
}

impl StartedMap {
    /// Takes the map to another frame and unit of length.
    pub fn move_by(&mut self, similarity: &Similarity) {
        let correction = |id| Correction {
            keyframe: id,
            camera_from_world: similarity.pose(self.map.keyframe(id).camera_from_world()),
            scale: similarity.scale,
        };
        let corrections = [correction(self.first), correction(self.second)];
        self.map.correct(&corrections);
        self.frame.camera_from_world = similarity.pose(&self.frame.camera_from_world);
        for (_, pose) in &mut self.between {
            *pose = similarity.pose(pose);
        }
    }

    /// Leaves odometry out of it.
    pub fn forget_odometry(&mut self) {
        self.map.forget_odometry();
        self.frame.odometry = None;
    }
}

/// Waits for two views that start a map.
#[derive(Debug, Clone)]
pub struct Initializer {
    camera: Camera,
    config: SlamConfig,
    rotation_aligner: RotationAligner,
    attempt: Option<Attempt>,
}

/// Corners by their number, where they were found, and the covariance of that; pixels of level 0.
type Places = Vec<(usize, Point2<f64>, Matrix2<f64>)>;

/// Corners of one image on their way.
#[derive(Debug, Clone)]
struct Attempt {
    follower: Follower,
    number: usize,
    at: Timestamp,
    /// Where the odometry has the camera in the first frame.
    odometry: Option<OdomPose>,
    num_corners: usize,
    /// Corners found in the first frame after that.
    num_followable: Option<usize>,
    last: Arc<Pyramid>,
    /// For each frame since: its number and the corners found in it.
    history: Vec<(usize, Places)>,
    /// Motions that explained the frame before.
    hints: Vec<TwoViewMotion>,
    /// An earlier start that waits for more parallax to prove it.
    pending: Option<PendingStart>,
    /// Number of the first frame, of this attempt or one before it, that had one motion which explains it.
    explained_since: Option<usize>,
}

impl Attempt {
    /// Whether waiting for a motion that is known better begins to cost something, in a frame that one motion explains: frames that wait
    /// get their poses afterwards, as many as are kept. What is wrong after that tracking will tell.
    fn has_waited_enough(&mut self, number: usize) -> bool {
        number - *self.explained_since.get_or_insert(number) >= MOST_WAITING
    }
}

impl Initializer {
    /// For one camera.
    #[must_use]
    pub fn new(camera: &Camera, config: &SlamConfig) -> Self {
        Self {
            camera: *camera,
            config: config.clone(),
            rotation_aligner: RotationAligner::new(camera, 4),
            attempt: None,
        }
    }

    /// Takes over a camera that is known better.
    pub fn set_camera(&mut self, camera: &Camera) {
        self.camera = *camera;
        self.rotation_aligner = RotationAligner::new(camera, 4);
    }

    /// Looks at the next frame. With odometry, only a start that agrees with it counts.
    pub fn add(&mut self, incoming: &Incoming<'_>, rng: &mut Rng) -> StartStep {
        let Incoming { number, pyramid, .. } = *incoming;
        let Some(attempt) = &mut self.attempt else {
            return StartStep::Waiting(self.begin(incoming));
        };
        let camera = &self.camera;
        let min_points = least_points(&self.config, incoming);
        let turn = self.rotation_aligner.align(&attempt.last, pyramid, &Rotation3::identity());
        attempt
            .follower
            .follow(pyramid, |px| camera.project(&(turn * camera.bearing(px)).into()).unwrap_or(*px));
        attempt.last = Arc::clone(pyramid);
        let place = |track: &Track| (track.number, track.px, track.covariance_px);
        let places = attempt.follower.tracks().iter().map(place).collect();
        attempt.history.push((number, places));
        let num = attempt.follower.tracks().len();
        // Corners of noise are gone after one frame and do not count.
        let num_followable = *attempt.num_followable.get_or_insert(num);
        let least = (self.config.start.min_followed_ratio * num_followable as f64) as usize;
        if num < least.max(min_points) {
            let lost = LostTracks { num, of: attempt.num_corners };
            self.begin(incoming);
            return StartStep::Waiting(StartWait::TracksLost(lost));
        }
        let shift = attempt.follower.median_shift_px();
        if attempt.history.len() > self.config.start.max_frames {
            self.begin(incoming);
            return StartStep::Waiting(StartWait::LittleMotion(shift));
        }
        if shift < self.config.start.min_shift_px {
            return StartStep::Waiting(StartWait::LittleMotion(shift));
        }
        let odometry = attempt.odometry.zip(incoming.odometry);
        let motion = odometry.and_then(|(first, last)| first.motion_to(&last));
        let known = motion.and_then(|motion| known_by_odometry(&motion));
        if motion.is_some() && known.is_none() {
            return StartStep::Waiting(StartWait::LittleMotion(shift));
        }
        match self.try_start(incoming, known.as_ref(), rng) {
            Ok(started) => {
                self.attempt = None;
                StartStep::Started(Box::new(started))
            }
            Err(wait) => StartStep::Waiting(wait),
        }
    }

    /// Forgets what it has seen.
    pub fn reset(&mut self) {
        self.attempt = None;
    }

    fn begin(&mut self, incoming: &Incoming<'_>) -> StartWait {
        let Incoming { number, at, pyramid, .. } = *incoming;
        let grid = CornerGrid::new(self.camera.size_px(), self.config.features.cell_px);
        let corners = corners_in_two_passes(pyramid, &grid, &self.config.features);
        if corners.len() < least_points(&self.config, incoming) {
            self.attempt = None;
            return StartWait::FewCorners(corners.len());
        }
        let follower = Follower::new(Arc::clone(pyramid), &corners);
        let explained_since = self.attempt.as_ref().and_then(|earlier| earlier.explained_since);
        self.attempt = Some(Attempt {
            follower,
            number,
            at,
            odometry: incoming.odometry,
            num_corners: corners.len(),
            num_followable: None,
            last: Arc::clone(pyramid),
            history: Vec::new(),
            hints: Vec::new(),
            pending: None,
            explained_since,
        });
        StartWait::LittleMotion(0.0)
    }

    fn try_start(
        &mut self,
        incoming: &Incoming<'_>,
        known: Option<&KnownMotion>,
        rng: &mut Rng,
    ) -> Result<StartedMap, StartWait> {
        let Some(mut attempt) = self.attempt.take() else { return Err(StartWait::FewCorners(0)) };
        let started = self.try_attempt(&mut attempt, incoming, known, rng);
        self.attempt = Some(attempt);
        started
    }

    fn try_attempt(
        &self,
        attempt: &mut Attempt,
        incoming: &Incoming<'_>,
        known: Option<&KnownMotion>,
        rng: &mut Rng,
    ) -> Result<StartedMap, StartWait> {
        let Incoming { number, at, pyramid, .. } = *incoming;
        let config = &self.config.start;
        let focal = focal_px(&self.camera);
        let min_points = least_points(&self.config, incoming);
        let settings = TwoViewSettings {
            inlier_sigmas: config.inlier_px / SIGMA_PX,
            min_points,
            min_inlier_ratio: config.min_inlier_ratio,
            min_parallax_rad: config.min_parallax_deg.to_radians(),
            num_samples: config.num_samples,
        };
        let num_tracks = attempt.follower.tracks().len();
        let pairs: Vec<RayPair> =
            attempt.follower.tracks().iter().map(|track| self.rays_of(track, focal)).collect();
        let candidates = solve_two_view(&pairs, (&attempt.hints, known), &settings, rng)?;
        attempt.hints = candidates.iter().map(|candidate| candidate.motion).collect();
        let (start, parallax_rad) = self.choose(attempt, &candidates, known)?;
        // A motion that is known need not be waited for.
        if known.is_none() {
            let inliers: Vec<RayPair> =
                pairs.iter().zip(&start.points).filter_map(|(pair, point)| point.map(|_| *pair)).collect();
            // Corners that were followed wrongly are lost as well. Few that are left agree on a motion that they did not make.
            let share = inliers.len() as f64 / attempt.num_followable.unwrap_or(num_tracks) as f64;
            if share < config.min_followed_ratio {
                return Err(StartWait::NoCommonMotion(share));
            }
            if !attempt.has_waited_enough(number)
                && shape_deviation(&direction_only(&start.last_from_first), &inliers) > SAME_DEVIATION
            {
                return Err(StartWait::LittleParallax(parallax_rad));
            }
            let depths = depths_of(attempt, &start);
            confirm(&mut attempt.pending, depths, parallax_rad)?;
        }
        let (mut map, landmarks) = self.build(attempt, &start, incoming);
        adjust_all(&mut map, &self.config.mapping, focal);
        let num_left = landmarks.iter().filter(|(id, _)| map.landmark(*id).is_alive()).count();
        if num_left < min_points {
            return Err(StartWait::NoCommonMotion(num_left as f64 / num_tracks as f64));
        }
        let (first, second) = (KeyframeId(0), KeyframeId(1));
        normalize_depth(&mut map, first, second);
        let between = self.poses_between(attempt, &map, &landmarks, rng);
        let features = landmarks.iter().filter_map(|(id, _)| {
            let observation = map.landmark(*id).observation_in(second)?;
            let Observation { px, ray, level, covariance_px, .. } = observation;
            Some(Feature { landmark: *id, px, ray, level, covariance_px })
        });
        let frame = Frame {
            number,
            at,
            pyramid: Arc::clone(pyramid),
            camera_from_world: *map.keyframe(second).camera_from_world(),
            features: features.collect(),
            turned_from: None,
            odometry: incoming.odometry,
        };
        Ok(StartedMap { first, second, frame, between, map })
    }

    /// Where a corner was seen in the first and in the newest frame.
    fn rays_of(&self, track: &Track, focal_px: f64) -> RayPair {
        let on_plane = 1.0 / (focal_px * focal_px);
        RayPair {
            first: self.camera.bearing(&track.first_px),
            second: self.camera.bearing(&track.px),
            first_covariance: corner_covariance(track.level) * on_plane,
            second_covariance: followed_covariance(&track.covariance_px) * on_plane,
        }
    }

    /// The motion that explains the frames on the way best, if it does so clearly better than the others.
    fn choose(
        &self,
        attempt: &Attempt,
        candidates: &[TwoView],
        known: Option<&KnownMotion>,
    ) -> Result<(VerifiedStart, f64), StartWait> {
        let views = self.views(attempt);
        let known = known.map(|known| BundleMotion {
            cameras: (0, views.len() - 1),
            second_from_first: known.motion,
            deviations: known.deviations,
        });
        let focal = focal_px(&self.camera);
        let verified =
            candidates.iter().filter_map(|c| Some((verify(c, &views, known, focal)?, c.parallax_rad)));
        let mut verified: Vec<(VerifiedStart, f64)> = verified.collect();
        let inlier_cost = verified.iter().map(|(start, _)| start.inlier_cost).fold(f64::INFINITY, f64::min);
        verified.sort_by(|a, b| {
            negative_log_likelihood(&a.0, inlier_cost).total_cmp(&negative_log_likelihood(&b.0, inlier_cost))
        });
        let least_parallax_rad = self.config.start.min_parallax_deg.to_radians();
        let Some(((best, parallax_rad), others)) = verified.split_first() else {
            return Err(StartWait::NoCommonMotion(0.0));
        };
        // Motions that make the same of the corners are one.
        let depths = depths_of(attempt, best);
        let rival = others.iter().find(|(other, _)| !are_alike(&depths, &depths_of(attempt, other)));
        if rival.is_some_and(|(rival, _)| !is_clearly_better(best, rival)) {
            return Err(StartWait::Ambiguous);
        }
        if best.cost > 1.0 {
            return Err(StartWait::NoCommonMotion(0.0));
        }
        if *parallax_rad < least_parallax_rad {
            return Err(StartWait::LittleParallax(*parallax_rad));
        }
        Ok((best.clone(), *parallax_rad))
    }

    /// Rays of the corners that are still followed: in the first frame, in some on the way, and in the last.
    fn views(&self, attempt: &Attempt) -> Vec<ViewRays> {
        const MOST_BETWEEN: usize = 6;
        let tracks = attempt.follower.tracks();
        let sight = |px: &Point2<f64>, covariance_px| Sight { ray: self.camera.bearing(px), covariance_px };
        let first =
            tracks.iter().map(|track| Some(sight(&track.first_px, corner_covariance(track.level)))).collect();
        let mut views: Vec<ViewRays> = vec![first];
        let num = attempt.history.len();
        let step = num.div_ceil(MOST_BETWEEN + 1).max(1);
        // Counted from the end, so that the last frame is one of them.
        for (_, places) in attempt.history.iter().rev().step_by(step).collect::<Vec<_>>().into_iter().rev() {
            let mut rays = vec![None; attempt.num_corners];
            for (track, px, covariance_px) in places {
                rays[*track] = Some(sight(px, *covariance_px));
            }
            views.push(tracks.iter().map(|track| rays[track.number]).collect());
        }
        views
    }

    /// Both keyframes and a landmark for each point, with the number of its corner.
    fn build(
        &self,
        attempt: &Attempt,
        start: &VerifiedStart,
        incoming: &Incoming<'_>,
    ) -> (Map, Vec<(LandmarkId, usize)>) {
        let mut map = Map::new();
        let first = map.add_keyframe(NewKeyframe {
            frame: attempt.number,
            at: attempt.at,
            pyramid: Arc::clone(attempt.follower.first()),
            camera_from_world: CameraFromWorld::identity(),
            turned_from: None,
            odometry: attempt.odometry,
        });
        let turn = Rotation3::from_matrix_unchecked(*start.last_from_first.rotation());
        let second = map.add_keyframe(NewKeyframe {
            frame: incoming.number,
            at: incoming.at,
            pyramid: Arc::clone(incoming.pyramid),
            camera_from_world: CameraFromWorld::new(turn, *start.last_from_first.translation()),
            turned_from: None,
            odometry: incoming.odometry,
        });
        let mut landmarks = Vec::new();
        for (track, point) in attempt.follower.tracks().iter().zip(&start.points) {
            let Some(point) = point else { continue };
            let observation = |keyframe, px: Point2<f64>, covariance_px| Observation {
                keyframe,
                px,
                ray: self.camera.bearing(&px),
                level: track.level,
                covariance_px,
            };
            let filter = DepthFilter::new(1.0 / point.z, 0.05 / point.z);
            let id = map.add_landmark(
                observation(first, track.first_px, corner_covariance(track.level)),
                filter,
                LandmarkState::Converged,
            );
            map.add_observation(id, observation(second, track.px, track.covariance_px));
            landmarks.push((id, track.number));
        }
        (map, landmarks)
    }

    /// Poses of the frames on the way, from where the corners were in them.
    fn poses_between(
        &self,
        attempt: &Attempt,
        map: &Map,
        landmarks: &[(LandmarkId, usize)],
        rng: &mut Rng,
    ) -> Vec<(usize, CameraFromWorld)> {
        let mut landmark_of = vec![None; attempt.num_corners];
        for (id, track) in landmarks {
            landmark_of[*track] = Some(*id);
        }
        let rejection = Rejection { max_hypotheses: None, has_robust_weights: true };
        let mut pose = CameraFromWorld::identity();
        let mut poses = Vec::new();
        let (_, before_last) =
            attempt.history.split_last().map_or((None, &[][..]), |(last, rest)| (Some(last), rest));
        for (number, places) in before_last {
            let observation = |(track, px, _): &(usize, Point2<f64>, Matrix2<f64>)| {
                let landmark = map.landmark(landmark_of[*track]?);
                let weight = whitening(focal_px(&self.camera), &(Matrix2::identity() * 0.25));
                let ray = self.camera.bearing(px);
                landmark.is_alive().then(|| PoseObservation::of_point(landmark.point_in_world, ray, weight))
            };
            let observations: Vec<PoseObservation> = places.iter().filter_map(observation).collect();
            let robust = robust_pose(&pose, None, (&observations, rejection), rng);
            if robust.num_inliers * 2 >= observations.len()
                && robust.num_inliers >= self.config.tracking.min_matches
            {
                pose = robust.camera_from_world;
                poses.push((*number, pose));
            }
        }
        poses
    }
}

/// Fewest points of a start: with a motion that is known, fewer are enough.
fn least_points(config: &SlamConfig, incoming: &Incoming<'_>) -> usize {
    let least = config.start.min_points;
    if incoming.odometry.is_some() { least.min(config.relocation.min_matches) } else { least }
}

/// What odometry knows of a motion; `None` if its direction is lost in the noise.
fn known_by_odometry(motion: &CameraMotion) -> Option<KnownMotion> {
    let length = motion.translation().norm();
    let (length_deviation, turn) = motion_deviations(motion);
    let deviations = (length_deviation / length, turn);
    (length >= SURE * length_deviation)
        .then(|| KnownMotion { motion: scaled(motion, 1.0 / length), deviations })
}

/// A motion with a translation of length 1.
fn direction_only(motion: &TwoViewMotion) -> TwoViewMotion {
    scaled(motion, 1.0 / motion.translation().norm().max(f64::MIN_POSITIVE))
}

/// Scales a map of two keyframes, the first at the origin, so that the median depth of the first is 1.
fn normalize_depth(map: &mut Map, first: KeyframeId, second: KeyframeId) {
    let ids: Vec<LandmarkId> = map.keyframe(first).landmarks.clone();
    let depths = ids.iter().map(|id| map.landmark(*id).point_in_world.z);
    let scale = 1.0 / median(depths).unwrap_or(1.0).max(1e-9);
    let pose = map.keyframe(second).camera_from_world();
    let rotation = Rotation3::from_matrix_unchecked(*pose.rotation());
    let scaled: Rigid3<CameraFrame, _> = Rigid3::new(rotation, pose.translation() * scale);
    map.set_pose(second, scaled);
    for id in ids {
        map.landmark_mut(id).point_in_world.coords *= scale;
    }
}

/// Depth of each corner in the first camera, by its number.
fn depths_of(attempt: &Attempt, start: &VerifiedStart) -> Vec<Option<f64>> {
    let mut depths = vec![None; attempt.num_corners];
    for (track, point) in attempt.follower.tracks().iter().zip(&start.points) {
        depths[track.number] = point.map(|point| point.z);
    }
    depths
}
