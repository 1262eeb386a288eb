//! The mapper: the only writer of the map once it is started.

use visloc_core::geom::Camera;

use super::{
    adjust::AdjustReport,
    adjust_local,
    candidate::{Verdict, add_candidates, is_short_of_known, judge, measure, new_corners},
    cull::{cull_keyframes, cull_landmarks},
    lens::LensEstimator,
};
use crate::{
    config::SlamConfig,
    map::{KeyframeId, LandmarkId, LandmarkState, Map, NewKeyframe, Observation, SessionCamera, most_shared},
    shutter::Readout,
    timing::StageTimer,
    track::{Frame, Matcher, focal_px, scene_depth},
};

/// Keyframes in which a new candidate is missed before it is left to the next frames, where it is searched anyway.
const MOST_MISSED: usize = 2;

/// What the mapper did with a frame.
#[derive(Debug, Clone, Default)]
pub struct MappingReport {
    /// The keyframe that was made of it.
    pub keyframe: Option<KeyframeId>,
    /// Candidates that became landmarks.
    pub num_promoted: usize,
    /// The adjustment after the keyframe.
    pub adjusted: AdjustReport,
    /// Whether the whole map was adjusted, and the lens with it if need be.
    pub has_settled: bool,
}

/// Makes keyframes and landmarks.
#[derive(Debug, Clone)]
pub struct Mapper {
    pub(super) camera: Camera,
    pub(super) config: SlamConfig,
    candidates: Vec<LandmarkId>,
    lens: LensEstimator,
}

impl Mapper {
    /// A mapper for a map that has just been started.
    #[must_use]
    pub fn new(camera: &Camera, config: &SlamConfig) -> Self {
        Self {
            camera: *camera,
            config: config.clone(),
            candidates: Vec::new(),
            lens: LensEstimator::new(camera),
        }
    }

    /// A mapper for maps of an earlier session.
    #[must_use]
    pub fn resume(map: &Map, known: &SessionCamera, config: &SlamConfig) -> Self {
        let num_keyframes = map.all_keyframes().count();
        let lens = LensEstimator::resume(known, num_keyframes);
        Self { lens, ..Self::new(&known.camera, config) }
    }

    /// The camera as it is known now.
    #[must_use]
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// How long the camera takes to expose an image, as the map tells it.
    #[must_use]
    pub fn readout(&self) -> Readout {
        self.lens.readout()
    }

    /// Starts over with a new map; what is known of the camera stays.
    pub fn restart(&mut self, map: &mut Map) {
        self.candidates.clear();
        self.lens.restart();
        map.look_through(&self.camera);
    }

    /// Makes candidates in the two keyframes of a map that has just been started, and adjusts it.
    pub fn populate(&mut self, map: &mut Map, newest: KeyframeId, first: KeyframeId) {
        for id in [newest, first] {
            self.make_candidates(map, id, 1.0);
        }
        if self.config.mapping.adjust_bundles {
            adjust_local(map, newest, &self.config.mapping, focal_px(&self.camera));
        }
    }

    /// Takes all candidates out: tracking goes on in another map.
    pub fn forget_candidates(&mut self, map: &mut Map) {
        for id in std::mem::take(&mut self.candidates) {
            if map.landmark(id).state() == LandmarkState::Candidate {
                map.remove_landmark(id);
            }
        }
    }

    /// Measures the candidates in a frame that does not become a keyframe.
    pub fn add_frame(&mut self, map: &mut Map, frame: &Frame) -> MappingReport {
        let mut candidates = std::mem::take(&mut self.candidates);
        let matcher = self.matcher(&frame.pyramid, frame.camera_from_world);
        let center = frame.camera_from_world.inverse();
        let center = (*center.translation()).into();
        let is_short = is_short_of_known(map, frame.features.iter().map(|feature| feature.landmark));
        let mut promoted = Vec::new();
        candidates.retain(|id| {
            if map.landmark(*id).state() != LandmarkState::Candidate {
                return false;
            }
            if measure(map, *id, &matcher).is_none() && map.landmark(*id).num_missed == 0 {
                return true;
            }
            match judge(map, *id, &center, (&self.config.mapping, is_short)) {
                Verdict::Wait => true,
                Verdict::Promote => {
                    promoted.push(*id);
                    false
                }
                Verdict::Drop => {
                    map.remove_landmark(*id);
                    false
                }
            }
        });
        self.candidates = candidates;
        self.promote(map, &promoted);
        MappingReport { num_promoted: promoted.len(), ..MappingReport::default() }
    }

    /// Makes a keyframe: links what was tracked, searches the rest of the local map, makes candidates, adjusts, culls.
    pub fn add_keyframe(
        &mut self,
        map: &mut Map,
        frame: &Frame,
        local: &[LandmarkId],
        timer: &mut StageTimer,
    ) -> MappingReport {
        let depth = scene_depth(map, frame);
        let id = map.add_keyframe(NewKeyframe {
            frame: frame.number,
            at: frame.at,
            pyramid: frame.pyramid.clone(),
            camera_from_world: frame.camera_from_world,
            turned_from: frame.turned_from,
            odometry: frame.odometry,
        });
        map.set_exposure(id, frame.exposure);
        for feature in &frame.features {
            map.add_observation(feature.landmark, feature.in_keyframe(id));
        }
        // Tracking had no need of all of them.
        self.link(map, id, &self.matcher(&frame.pyramid, frame.camera_from_world), local);
        timer.end("link points");
        let mut report = self.add_frame(map, frame);
        timer.end("update points");
        report.num_promoted += self.make_candidates(map, id, depth);
        timer.end("new points");
        if self.config.mapping.adjust_bundles {
            report.adjusted = adjust_local(map, id, &self.config.mapping, focal_px(&self.camera));
        }
        timer.end("bundle adjustment");
        if self.config.mapping.adjust_bundles
            && let Some(camera) = self.lens.settle(map, &self.camera, &self.config.mapping)
        {
            self.camera = camera;
            report.has_settled = true;
        }
        timer.end("settle");
        cull_landmarks(map, id);
        cull_keyframes(map, id, &self.config.mapping);
        self.forget_old_candidates(map, id);
        timer.end("upkeep");
        report.keyframe = Some(id);
        report
    }

    pub(super) fn matcher<'a>(
        &'a self,
        pyramid: &'a crate::image::Pyramid,
        camera_from_world: crate::lie::CameraFromWorld,
    ) -> Matcher<'a> {
        Matcher {
            camera: &self.camera,
            pyramid,
            camera_from_world,
            limits: crate::track::MATCH_LIMITS,
            num_levels: self.config.features.search_levels,
            recognition: self.config.features.recognition(),
            seen_by: None,
        }
    }

    /// Looks in a keyframe for landmarks that it is not linked to.
    pub(super) fn link(
        &self,
        map: &mut Map,
        id: KeyframeId,
        matcher: &Matcher<'_>,
        landmarks: &[LandmarkId],
    ) {
        for landmark_id in landmarks {
            let landmark = map.landmark(*landmark_id);
            if !landmark.is_converged() || landmark.observation_in(id).is_some() {
                continue;
            }
            let Some(observation) = self.observe(map, *landmark_id, id, matcher) else { continue };
            map.add_observation(*landmark_id, observation);
        }
    }

    /// A landmark found in a keyframe within 2 px (of its level) of where it should be.
    fn observe(
        &self,
        map: &Map,
        landmark: LandmarkId,
        keyframe: KeyframeId,
        matcher: &Matcher<'_>,
    ) -> Option<Observation> {
        let landmark = map.landmark(landmark);
        let predicted = matcher.project(&landmark.point_in_world)?;
        let found = matcher.find(map, landmark)?;
        let limit = 2.0 * f64::from(1_u32 << found.level);
        ((found.px - predicted).norm() < limit).then_some(found.in_keyframe(keyframe))
    }

    /// Makes candidates in the empty cells and measures them at once in the connected keyframes.
    fn make_candidates(&mut self, map: &mut Map, id: KeyframeId, depth: f64) -> usize {
        let config = &self.config;
        let corners = new_corners(map, id, &self.camera, &config.features, config.mapping.max_new_candidates);
        let is_short = is_short_of_known(map, map.keyframe(id).landmarks.iter().copied());
        let added = add_candidates(map, id, &self.camera, &corners, depth);
        let others: Vec<KeyframeId> = map
            .connected(id, 10)
            .into_iter()
            .map(|(other, _)| other)
            .take(config.mapping.search_keyframes)
            .collect();
        let mut promoted = Vec::new();
        for candidate in added {
            let mut num_missed = 0;
            for other in &others {
                let keyframe = map.keyframe(*other);
                let Some(pyramid) = keyframe.pyramid() else { continue };
                let camera = *keyframe.camera(&self.camera);
                let there = self.matcher(&pyramid, *keyframe.camera_from_world());
                let matcher = Matcher { camera: &camera, ..there };
                let other_center = *keyframe.center_in_world();
                match measure(map, candidate, &matcher) {
                    Some(found) => map.add_observation(candidate, found.in_keyframe(*other)),
                    None => num_missed += 1,
                }
                if num_missed >= MOST_MISSED {
                    break;
                }
                if judge(map, candidate, &other_center, (&config.mapping, is_short)) == Verdict::Promote {
                    promoted.push(candidate);
                    break;
                }
            }
            if promoted.last() != Some(&candidate) {
                map.landmark_mut(candidate).num_missed = 0;
                self.candidates.push(candidate);
            }
        }
        self.promote(map, &promoted);
        promoted.len()
    }

    /// Makes landmarks of candidates and looks for each in the keyframes around its host.
    fn promote(&self, map: &mut Map, candidates: &[LandmarkId]) {
        // What each keyframe shares with a host: the candidates of one follow each other.
        let (mut counted, mut num_shared) = (None, Vec::new());
        for id in candidates {
            self.converge(map, *id);
            let host = map.landmark(*id).host().keyframe;
            if counted == Some(host) {
                map.landmark(*id)
                    .observations
                    .keyframes()
                    .for_each(|seen_by| num_shared[seen_by.index()] += 1);
            } else {
                num_shared = map.num_shared(&map.keyframe(host).landmarks);
                counted = Some(host);
            }
            let connected = most_shared(&num_shared, 10).into_iter().map(|(other, _)| other);
            let mut around: Vec<KeyframeId> =
                connected.filter(|other| *other != host).take(self.config.mapping.search_keyframes).collect();
            around.sort();
            for keyframe in around {
                if map.landmark(*id).observation_in(keyframe).is_some() {
                    continue;
                }
                let frame = map.keyframe(keyframe);
                let Some(pyramid) = frame.pyramid() else { continue };
                let matcher = Matcher {
                    camera: frame.camera(&self.camera),
                    ..self.matcher(&pyramid, *frame.camera_from_world())
                };
                if let Some(observation) = self.observe(map, *id, keyframe, &matcher) {
                    map.add_observation(*id, observation);
                    num_shared[keyframe.index()] += 1;
                }
            }
        }
    }

    /// Makes a landmark of a candidate, without what was taken for it elsewhere.
    fn converge(&self, map: &mut Map, id: LandmarkId) {
        map.landmark_mut(id).filter = None;
        map.landmark_mut(id).num_missed = 0;
        let point = map.landmark(id).point_in_world;
        let observers: Vec<Observation> = map.landmark(id).observations.iter().skip(1).collect();
        for observation in observers {
            let keyframe = map.keyframe(observation.keyframe);
            let seen = keyframe.camera_from_world().transform(&point);
            let focal = focal_px(keyframe.camera(&self.camera));
            let error = (seen.coords / seen.z - observation.ray).xy().norm() * focal;
            if error.is_nan() || error >= 2.0 * f64::from(1_u32 << observation.level) {
                map.remove_candidate_observation(id, observation.keyframe);
            }
        }
    }

    fn forget_old_candidates(&mut self, map: &mut Map, newest: KeyframeId) {
        // From the same place nothing is learned of depths: keyframes that only turned make no candidate older.
        let made_by_moving = map.keyframes().filter(|(id, k)| k.turned_from.is_none() && *id <= newest);
        let oldest =
            made_by_moving.map(|(id, _)| id.index()).rev().nth(self.config.mapping.max_candidate_age);
        let oldest = oldest.unwrap_or_default();
        self.candidates.retain(|id| {
            let landmark = map.landmark(*id);
            if landmark.state() != LandmarkState::Candidate {
                return false;
            }
            let is_young = landmark.host().keyframe.index() >= oldest;
            if !is_young {
                map.remove_landmark(*id);
            }
            is_young
        });
    }
}
