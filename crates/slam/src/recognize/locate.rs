//! Whether an image shows the place of a keyframe, and from where.

use nalgebra::Matrix2;
use visloc_core::{Rng, geom::Camera};

use super::{
    Pair, Refusal, View,
    agreement::{Surroundings, agreed_pose, is_agreeing, probable_pose},
    pair_views,
    pairs::ByPieces,
    support::pair_views_by_support,
};
use crate::{
    config::SlamConfig,
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkId, Map, MapId},
    solve::PoseObservation,
    track::{
        FOUND_AT_RIGHT, Feature, Frame, FrameWork, Incoming, Quality, TrackReport, Tracker, focal_px,
        whitening,
    },
};

/// Connected keyframes whose landmarks are compared together with those of a candidate.
const NEIGHBORS: usize = 3;
/// The same for those who doubt: what looks in the candidate as in another keyframe is described there only, and pairs are told apart by how they lie
/// in the candidate's own image. With four fewer places are found; a search takes 2 to 4 ms more than with one.
const NEIGHBORS_DOUBTED: usize = 6;
/// Fewest landmarks that two keyframes share to be neighbors.
pub(super) const NEIGHBORS_SHARE: u32 = 15;
/// Fewest pairs of places and landmarks that look alike.
pub(super) const LEAST_PAIRS: usize = 12;
/// Fewest pairs that agree on a pose. Four are enough to find it: eight more by chance, within a few pixels, are not to be expected.
const LEAST_AGREEING: usize = 12;
/// The same for those who doubt: three find it, and where six more are there by chance, a few patches tell.
const LEAST_AGREEING_DOUBTED: usize = 9;
/// Standard deviation of the place of a corner, pixels of its level.
const CORNER_SIGMA_PX: f64 = 1.2;
/// Pixels (of its level) around a predicted place that are searched for a landmark at first.
const SEARCH_RADIUS: usize = 8;
/// The same where so many pairs agree that the pose is known better.
const NEAR_RADIUS: usize = 4;
/// Parts of the image on each axis, to see whether landmarks are spread over it.
const PARTS: usize = 4;
/// Fewest parts with a landmark.
const LEAST_PARTS: usize = 5;
/// Landmarks from which on a place is sure enough, in units of the fewest that it is recognized by.
pub(crate) const SURE: usize = 2;

/// Where an image was taken.
#[derive(Debug, Clone)]
pub struct Located {
    /// The image tracked in the map that it was recognized in.
    pub report: TrackReport,
    /// The keyframe that it was recognized by.
    pub keyframe: KeyframeId,
    /// Pairs from descriptors that agree with the pose.
    pub pairs: Vec<Pair>,
    /// Other places where it may have been taken.
    pub rivals: Vec<Rival>,
}

/// Another place where an image may have been taken: it was found there, too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rival {
    /// The map.
    pub map: MapId,
    /// The pose there.
    pub camera_from_world: CameraFromWorld,
    /// Landmarks found.
    pub num_matched: usize,
    /// Places of the image that were searched.
    pub num_searched: usize,
}

impl Rival {
    /// The map, and the pose in it.
    pub(crate) fn pose(&self) -> (MapId, &CameraFromWorld) {
        (self.map, &self.camera_from_world)
    }
}

impl Located {
    /// As a place where an image may have been taken that was taken elsewhere.
    pub(crate) fn as_rival(&self, map: &Map) -> Rival {
        Rival {
            map: map.keyframe(self.keyframe).map,
            camera_from_world: self.report.frame.camera_from_world,
            num_matched: self.report.num_matched,
            num_searched: self.report.num_searched,
        }
    }

    /// Landmarks that were found at the second best place; 0 if there is none.
    #[must_use]
    pub fn num_elsewhere(&self) -> usize {
        self.rivals.iter().map(|rival| rival.num_matched).max().unwrap_or(0)
    }
}

/// Where an image may have been taken by what looks alike.
#[derive(Debug, Clone)]
pub(super) struct ProposedPlace {
    /// The keyframe that shows the place.
    pub keyframe: KeyframeId,
    /// The pose.
    pub pose: CameraFromWorld,
    /// Pairs from descriptors that agree with it.
    pub pairs: Vec<Pair>,
}

/// Checks candidates by geometry.
#[derive(Debug, Clone)]
pub struct Locator {
    camera: Camera,
    min_matches: usize,
    /// Whether more is found: a wrong place harms nobody, since it is doubted until more is seen.
    is_doubting: bool,
    tracker: Tracker,
}

impl Locator {
    /// Takes over a camera that is known better.
    pub fn set_camera(&mut self, camera: &Camera) {
        if *camera != self.camera {
            self.camera = *camera;
            self.tracker.set_camera(camera);
        }
    }

    /// For one camera.
    #[must_use]
    pub fn new(camera: &Camera, config: &SlamConfig) -> Self {
        Self {
            camera: *camera,
            min_matches: config.relocation.min_matches,
            is_doubting: false,
            tracker: Tracker::new(camera, &config.tracking, &config.features),
        }
    }

    /// Finds more from now on, for those who doubt what is found until they see more of it.
    pub fn doubt(&mut self) {
        self.is_doubting = true;
    }

    /// Whether [`Locator::doubt`] was called.
    pub fn is_doubting(&self) -> bool {
        self.is_doubting
    }

    /// Looks for an image around a keyframe. The map is the one of the keyframe.
    ///
    /// # Errors
    /// Why it is another place.
    pub fn locate(
        &self,
        map: &Map,
        candidate: KeyframeId,
        (view, incoming): (&View, &Incoming<'_>),
        work: &mut FrameWork<'_>,
    ) -> Result<Located, Refusal> {
        let connected = map.connected(candidate, NEIGHBORS_SHARE);
        let listed = self.listed(view);
        let proposal = self.propose(map, (candidate, &connected), (view, listed.as_ref()), work.rng)?;
        self.confirm(map, proposal, incoming, work)
    }

    /// The places of an image as they are compared in a fixed map.
    pub(super) fn listed(&self, view: &View) -> Option<ByPieces> {
        self.is_doubting.then(|| ByPieces::new(view))
    }

    /// Where an image may have been taken by what looks alike in it and in a keyframe, of which it is known what is connected to it.
    ///
    /// # Errors
    /// If too little looks alike.
    pub(super) fn propose(
        &self,
        map: &Map,
        (candidate, connected): (KeyframeId, &[(KeyframeId, u32)]),
        (view, listed): (&View, Option<&ByPieces>),
        rng: &mut Rng,
    ) -> Result<ProposedPlace, Refusal> {
        let mut around = vec![candidate];
        let num_neighbors = if self.is_doubting { NEIGHBORS_DOUBTED } else { NEIGHBORS };
        around.extend(connected.iter().map(|(id, _)| *id).take(num_neighbors));
        let pairs = match listed {
            Some(listed) => pair_views_by_support(map, &self.camera, (view, listed), &around),
            None => pair_views(map, view, &around),
        };
        if pairs.len() < LEAST_PAIRS {
            return Err(Refusal::FewAlike { num: pairs.len() });
        }
        let observations = self.observations(map, view, &pairs);
        let start = *map.keyframe(candidate).camera_from_world();
        let state = if self.is_doubting {
            let around = Surroundings::of(map, candidate);
            probable_pose(&around, &observations, rng)
        } else {
            agreed_pose(&start, &observations, rng)
        };
        let all = pairs.iter().zip(&observations);
        let agreeing: Vec<Pair> =
            all.filter(|(_, o)| is_agreeing(o, &state)).map(|(pair, _)| *pair).collect();
        let least = if self.is_doubting { LEAST_AGREEING_DOUBTED } else { LEAST_AGREEING };
        if agreeing.len() < least {
            return Err(Refusal::NoCommonPose { num: agreeing.len(), of: pairs.len() });
        }
        Ok(ProposedPlace { keyframe: candidate, pose: state.pose, pairs: agreeing })
    }

    /// Looks for the landmarks around a keyframe by their patches where an image may have been taken.
    ///
    /// # Errors
    /// Why it is another place.
    pub(super) fn confirm(
        &self,
        map: &Map,
        proposal: ProposedPlace,
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> Result<Located, Refusal> {
        let ProposedPlace { keyframe, pose, pairs } = proposal;
        let radius = if self.is_doubting { NEAR_RADIUS } else { SEARCH_RADIUS };
        let report = self.follow_within(map, (keyframe, &pose, radius), incoming, work)?;
        Ok(Located { report, keyframe, pairs, rivals: Vec::new() })
    }

    /// Looks for the landmarks around a keyframe in an image of which the pose is about known.
    ///
    /// # Errors
    /// If the landmarks are not found there.
    pub fn follow(
        &self,
        map: &Map,
        (around, pose): (KeyframeId, &CameraFromWorld),
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> Result<TrackReport, Refusal> {
        self.follow_within(map, (around, pose, SEARCH_RADIUS), incoming, work)
    }

    fn follow_within(
        &self,
        map: &Map,
        (around, pose, radius): (KeyframeId, &CameraFromWorld, usize),
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> Result<TrackReport, Refusal> {
        let few =
            |report: &TrackReport| Refusal::FewFound { num: report.num_matched, of: report.num_searched };
        let Some(reference) = frame_of(map, around) else { return Err(Refusal::FewFound { num: 0, of: 0 }) };
        // The pose is only about right: look around first, then as in tracking.
        let wide = if self.is_doubting {
            self.tracker.track_as_seen_by(map, incoming, (pose, radius), (around, &reference), work)
        } else {
            self.tracker.track_near(map, incoming, (pose, radius), &reference, work)
        };
        if wide.num_matched < self.min_matches / 2 {
            return Err(few(&wide));
        }
        let pose = wide.frame.camera_from_world;
        let mut report = self.tracker.track_near(map, incoming, (&pose, 0), &reference, work);
        if self.is_doubting && !self.is_shown(&report) {
            report = self.grown(map, report, incoming, work);
        }
        if !self.is_shown(&report) {
            return Err(few(&report));
        }
        let parts = self.num_parts(map, &report.frame.features);
        if parts < LEAST_PARTS {
            return Err(Refusal::SmallPart { parts });
        }
        Ok(report)
    }

    /// Looks again around what was found until no more is found: landmarks in a corner of the image, or on a thing that was moved, give
    /// a pose from which the others are missed.
    pub(super) fn grown(
        &self,
        map: &Map,
        mut report: TrackReport,
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> TrackReport {
        while report.num_matched >= self.min_matches / 2 {
            let here = Frame { odometry: None, ..report.frame.clone() };
            let next = self.tracker.track_near(map, incoming, (&here.camera_from_world, 0), &here, work);
            if next.num_matched <= report.num_matched {
                break;
            }
            report = next;
        }
        report
    }

    /// Whether an image shows enough of a place: a fair share of what should be seen, or so much that a smaller share will do.
    fn is_shown(&self, report: &TrackReport) -> bool {
        let is_sure = self.is_doubting
            && report.num_converged >= SURE * self.min_matches
            && report.num_matched as f64 > FOUND_AT_RIGHT * report.num_searched as f64;
        is_sure || (report.quality == Quality::Good && report.num_converged >= self.min_matches)
    }

    fn observations(&self, map: &Map, view: &View, pairs: &[Pair]) -> Vec<PoseObservation> {
        let focal = focal_px(&self.camera);
        let observation = |pair: &Pair| {
            let place = view.at(pair.place);
            let sigma = CORNER_SIGMA_PX * f64::from(place.level.max(0)).exp2();
            let whitening = whitening(focal, &(Matrix2::identity() * (sigma * sigma)));
            let point = map.landmark(pair.landmark).point_in_world;
            PoseObservation::of_point(point, self.camera.bearing(&place.px), whitening)
        };
        pairs.iter().map(observation).collect()
    }

    /// Parts of the image in which converged landmarks were found.
    fn num_parts(&self, map: &Map, features: &[Feature]) -> usize {
        let (width, height) = self.camera.size_px();
        let mut has_some = [false; PARTS * PARTS];
        for feature in features.iter().filter(|f| map.landmark(f.landmark).is_converged()) {
            has_some[part(feature.px.y, height) * PARTS + part(feature.px.x, width)] = true;
        }
        has_some.iter().filter(|has_some| **has_some).count()
    }
}

fn part(px: f64, size: u32) -> usize {
    ((px / f64::from(size) * PARTS as f64).max(0.0) as usize).min(PARTS - 1)
}

/// A keyframe as a frame with its converged landmarks.
pub(crate) fn frame_of(map: &Map, id: KeyframeId) -> Option<Frame> {
    let keyframe = map.keyframe(id);
    let feature = |landmark: &LandmarkId| {
        let observation = map.landmark(*landmark).observation_in(id)?;
        map.landmark(*landmark).is_converged().then_some(Feature {
            landmark: *landmark,
            px: observation.px,
            ray: observation.ray,
            level: observation.level,
            covariance_px: observation.covariance_px,
        })
    };
    Some(Frame {
        number: keyframe.frame,
        at: keyframe.at,
        pyramid: keyframe.pyramid()?,
        camera_from_world: *keyframe.camera_from_world(),
        features: keyframe.landmarks.iter().filter_map(feature).collect(),
        turned_from: None,
        odometry: None,
        exposure: None,
    })
}
