//! From images to the first two keyframes.

use std::sync::Arc;

use nalgebra::Rotation3;
use visloc_core::{Rng, geom::Camera};

use super::{
    Follower, KnownMotion, LostTracks, RayPair, SAME_DEVIATION, SIGMA_PX, SURE, StartWait, StartedMap, Track,
    TwoView, TwoViewMotion, TwoViewSettings, VerifiedStart, are_alike, attempt::Attempt, confirm,
    followed_covariance, is_clearly_better, negative_log_likelihood, shape_deviation, solve_two_view,
    started::normalize_depth, verify,
};
use crate::{
    config::SlamConfig,
    feature::CornerGrid,
    map::{KeyframeId, Observation, scaled},
    mapping::{adjust_all, corner_covariance, corners_in_two_passes},
    odometry::{CameraMotion, motion_deviations},
    solve::BundleMotion,
    track::{Feature, Frame, Incoming, RotationAligner, focal_px},
};

/// What came of a frame.
#[derive(Debug)]
pub enum StartStep {
    /// No map yet, and why.
    Waiting(StartWait),
    /// A map.
    Started(Box<StartedMap>),
}

/// Waits for two views that start a map.
#[derive(Debug, Clone)]
pub struct Initializer {
    camera: Camera,
    config: SlamConfig,
    rotation_aligner: RotationAligner,
    attempt: Option<Attempt>,
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
            let lost = LostTracks { num, of: attempt.num_corners, num_images: attempt.history.len() };
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
            let depths = attempt.depths(&start);
            confirm(&mut attempt.pending, depths, parallax_rad)?;
        }
        let (mut map, landmarks) = attempt.build(&self.camera, &start, incoming);
        adjust_all(&mut map, &self.config.mapping, focal);
        let num_left = landmarks.iter().filter(|(id, _)| map.landmark(*id).is_alive()).count();
        if num_left < min_points {
            return Err(StartWait::NoCommonMotion(num_left as f64 / num_tracks as f64));
        }
        let (first, second) = (KeyframeId(0), KeyframeId(1));
        normalize_depth(&mut map, first, second);
        let between =
            attempt.poses_between((&self.camera, self.config.tracking.min_matches), &map, &landmarks, rng);
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
            exposure: None,
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
        let views = attempt.views(&self.camera);
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
        let depths = attempt.depths(best);
        let rival = others.iter().find(|(other, _)| !are_alike(&depths, &attempt.depths(other)));
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
