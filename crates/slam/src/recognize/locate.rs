//! Whether an image shows the place of a keyframe, and from where.

use nalgebra::{Matrix2, Point3, Vector3};
use rand::RngExt;
use visloc_core::{Rng, geom::Camera};

use super::{Pair, Refusal, View, guided::Guide, pair_views, pair_views_by_support, pairs::Known};
use crate::{
    config::SlamConfig,
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkId, Map, MapId},
    solve::{PoseObservation, State, poses_from_three_points, refine_pose},
    track::{Feature, Frame, FrameWork, Incoming, Quality, TrackReport, Tracker, focal_px, whitening},
};

/// Connected keyframes whose landmarks are compared together with those of a candidate.
const NEIGHBORS: usize = 3;
/// Keyframes that a pose is proposed from in a fixed map: pairs are told apart by how they lie in the image of one of them.
const COMPARED: usize = 2;
/// Connected keyframes whose landmarks are looked for around a proposed pose.
const AROUND: usize = 10;
/// How much farther from where they should be places are compared with landmarks, in units of the distance up to which they agree.
const WIDER: f64 = 4.0;
/// How often a pose is settled by all that is alike around it: from a few pairs, then from most.
const ROUNDS: usize = 2;
/// Least evidence for a pose that landmarks are looked for from: e^14, since some ten thousand poses are looked at in an image and one in a
/// hundred images may have one by chance.
const LEAST_EVIDENCE: f64 = 14.0;
/// The same before it is settled. Of the right ones of a development scene one in a thousand had less, of wrong ones three in five.
const LEAST_AT_FIRST: f64 = 3.0;
/// How often more is looked for around what was found, at most.
const MOST_ROUNDS: usize = 2;
/// Fewest landmarks that two keyframes share to be neighbors.
pub(super) const NEIGHBORS_SHARE: u32 = 15;
/// Fewest pairs of places and landmarks that look alike.
const LEAST_PAIRS: usize = 12;
/// Fewest pairs that agree on a pose. Four are enough to find it: eight more by chance, within a few pixels, are not to be expected.
const LEAST_AGREEING: usize = 12;
/// Pairs from which poses are found: the six numbers of a pose need three; the other pairs say which of the solutions it is.
const SAMPLE: usize = 3;
/// Most samples: enough where one pair in six is right.
const MOST_SAMPLES: usize = 1000;
/// The same where those most alike come first.
const MOST_SAMPLES_OF_ALIKE: usize = 300;
/// Probability of one sample without a wrong pair.
const CONFIDENCE: f64 = 0.995;
/// Pairs that agree beyond all doubt that it is a pose by chance: no more samples are drawn. What is there twice is told apart by patches.
const ENOUGH_AGREEING: usize = 16;
/// Cosine of the farthest angle between two views that look alike: 60 degrees.
const LEAST_COS: f64 = 0.5;
/// Squared ratio of the distances of two views that look alike.
const FARTHEST2: f64 = 16.0;
/// Standard deviation of the place of a corner, pixels of its level.
const CORNER_SIGMA_PX: f64 = 1.2;
/// Largest squared residual of an agreeing pair in standard deviations: 99 % of two degrees of freedom.
const AGREEING_CHI2: f64 = 9.2;
/// Pixels (of its level) around a predicted place that are searched for a landmark at first.
const SEARCH_RADIUS: usize = 8;
/// Parts of the image on each axis, to see whether landmarks are spread over it.
const PARTS: usize = 4;
/// Fewest parts with a landmark.
const LEAST_PARTS: usize = 5;

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

/// Where an image may have been taken by what looks like it.
#[derive(Debug, Clone)]
pub(super) struct Proposal {
    /// The keyframe that shows the place.
    pub keyframe: KeyframeId,
    /// The pose there.
    pub pose: CameraFromWorld,
    /// Pairs that agree with it.
    pub pairs: Vec<Pair>,
    /// Logarithm of how much more probable so many are there than by chance.
    pub evidence: f64,
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
        if self.is_doubting {
            let connected = map.connected(candidate, NEIGHBORS_SHARE);
            let guide = Guide::new(view, &self.camera);
            let proposal = self.propose(map, (candidate, &connected), &guide, work.rng)?;
            return self.confirm(map, proposal, incoming, work);
        }
        let mut around = vec![candidate];
        let neighbors = map.connected(candidate, NEIGHBORS_SHARE);
        around.extend(neighbors.into_iter().map(|(id, _)| id).take(NEIGHBORS));
        let pairs = pair_views(map, view, &around);
        if pairs.len() < LEAST_PAIRS {
            return Err(Refusal::FewAlike { num: pairs.len() });
        }
        let observations = self.observations(map, view, &pairs);
        let state = agreed_pose(map.keyframe(candidate).camera_from_world(), &observations, work.rng);
        let agreeing = agreeing(&pairs, &observations, &state);
        if agreeing.len() < LEAST_AGREEING {
            return Err(Refusal::NoCommonPose { num: agreeing.len(), of: pairs.len() });
        }
        let report = self.follow(map, (candidate, &state.pose), incoming, work)?;
        Ok(Located { report, keyframe: candidate, pairs: agreeing, rivals: Vec::new() })
    }

    /// Where an image may have been taken by what looks like it in a keyframe and those that are connected to it; the map is the one of the keyframe.
    ///
    /// # Errors
    /// If no more agrees there than by chance.
    pub(super) fn propose(
        &self,
        map: &Map,
        (candidate, connected): (KeyframeId, &[(KeyframeId, u32)]),
        guide: &Guide<'_>,
        rng: &mut Rng,
    ) -> Result<Proposal, Refusal> {
        let mut around = vec![candidate];
        around.extend(connected.iter().map(|(id, _)| *id).take(AROUND));
        let pairs =
            pair_views_by_support(map, &self.camera, guide.view, &around[..around.len().min(COMPARED)]);
        if pairs.len() < LEAST_PAIRS {
            return Err(Refusal::FewAlike { num: pairs.len() });
        }
        let observations = self.observations(map, guide.view, &pairs);
        let mut state = probable_pose(&Surroundings::of(map, candidate), &observations, rng);
        let known = Known::of(map, &around);
        let focal_ratio = focal_px(&self.camera) / focal_px(map.keyframe(candidate).camera(&self.camera));
        let near = |state: &State, least: f64| {
            let radius_px = WIDER * AGREEING_CHI2.sqrt() * CORNER_SIGMA_PX;
            let pairs = guide.pairs_near(map, (&known, focal_ratio), &state.pose, radius_px);
            let observations = self.observations(map, guide.view, &pairs);
            let agreeing = agreeing(&pairs, &observations, state);
            let evidence = evidence(agreeing.len(), pairs.len());
            if evidence < least {
                return Err(Refusal::NoCommonPose { num: agreeing.len(), of: pairs.len() });
            }
            Ok((observations, agreeing, evidence))
        };
        for _ in 0..ROUNDS {
            let (observations, ..) = near(&state, LEAST_AT_FIRST)?;
            for cutoff in [WIDER, 0.5 * WIDER, 1.0] {
                state = refine_pose(&state, None, &observations, |_| true, cutoff * AGREEING_CHI2.sqrt(), 4);
            }
        }
        let (_, pairs, evidence) = near(&state, LEAST_EVIDENCE)?;
        Ok(Proposal { keyframe: candidate, pose: state.pose, pairs, evidence })
    }

    /// Looks for landmarks by their patches where an image may have been taken.
    ///
    /// # Errors
    /// Why it is another place.
    pub(super) fn confirm(
        &self,
        map: &Map,
        proposal: Proposal,
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> Result<Located, Refusal> {
        let Proposal { keyframe, pose, pairs, .. } = proposal;
        let reference = frame_of(map, keyframe).ok_or(Refusal::FewFound { num: 0, of: 0 })?;
        let mut report = self.tracker.track_near(map, incoming, (&pose, 0), &reference, work);
        if report.num_matched < self.min_matches / 2 {
            return Err(few(&report));
        }
        // A thing that was moved pulls the pose to it: around what was found there may be more that says otherwise.
        for _ in 0..MOST_ROUNDS {
            let here = Frame { odometry: None, ..report.frame.clone() };
            let next = self.tracker.track_near(map, incoming, (&here.camera_from_world, 0), &here, work);
            if next.num_matched <= report.num_matched {
                break;
            }
            report = next;
        }
        let pose = report.frame.camera_from_world;
        let report = self.tracker.track_near(map, incoming, (&pose, 0), &reference, work);
        Ok(Located { report: self.shown(map, report)?, keyframe, pairs, rivals: Vec::new() })
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
        let reference = frame_of(map, around).ok_or(Refusal::FewFound { num: 0, of: 0 })?;
        // The pose is only about right: look around first, then as in tracking.
        let wide = self.tracker.track_near(map, incoming, (pose, SEARCH_RADIUS), &reference, work);
        if wide.num_matched < self.min_matches / 2 {
            return Err(few(&wide));
        }
        let pose = wide.frame.camera_from_world;
        self.shown(map, self.tracker.track_near(map, incoming, (&pose, 0), &reference, work))
    }

    /// A tracked image, if it shows enough of the place.
    fn shown(&self, map: &Map, report: TrackReport) -> Result<TrackReport, Refusal> {
        if report.quality != Quality::Good || report.num_converged < self.min_matches {
            return Err(few(&report));
        }
        let parts = self.num_parts(map, &report.frame.features);
        if parts < LEAST_PARTS {
            return Err(Refusal::SmallPart { parts });
        }
        Ok(report)
    }

    fn observations(&self, map: &Map, view: &View, pairs: &[Pair]) -> Vec<PoseObservation> {
        let focal = focal_px(&self.camera);
        let observation = |pair: &Pair| {
            let place = &view.places[pair.place];
            let sigma = CORNER_SIGMA_PX * f64::from(1_u32 << place.level);
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

fn few(report: &TrackReport) -> Refusal {
    Refusal::FewFound { num: report.num_matched, of: report.num_searched }
}

/// Pairs that agree with a state.
fn agreeing(pairs: &[Pair], observations: &[PoseObservation], state: &State) -> Vec<Pair> {
    let all = pairs.iter().zip(observations);
    all.filter(|(_, observation)| is_agreeing(observation, state)).map(|(pair, _)| *pair).collect()
}

/// Logarithm of how much more probable it is that so many pairs of those around agree at the right place than by chance: what is alike by chance
/// is alike all around (Poisson).
fn evidence(num_agreeing: usize, num_around: usize) -> f64 {
    let by_chance = (num_around - num_agreeing + 1) as f64 / (WIDER * WIDER - 1.0);
    let more = (num_agreeing as f64 / by_chance).max(1.0);
    by_chance * (more * more.ln() - more + 1.0)
}

/// The pose that most observations agree on: from samples, then from all that agree.
fn agreed_pose(start: &CameraFromWorld, observations: &[PoseObservation], rng: &mut Rng) -> State {
    let start = State::new(start);
    let mut best = Agreed { num: count_agreeing(observations, &start, 0).unwrap_or(0), state: start };
    let (num, mut num_drawn) = (observations.len(), 0);
    while num_drawn < needed(best.num as f64 / num as f64) {
        num_drawn += 1;
        let sample = std::array::from_fn(|_| &observations[rng.random_range(0..num)]);
        poses_of(sample).for_each(|pose| best.offer(pose, observations));
    }
    best.refined(observations)
}

/// The same where most pairs are wrong: samples are drawn from the first pairs, then from ever more, and only poses count
/// from which things look as they do from the keyframe. So many that agree are not there by chance, and no more samples are drawn.
/// Source: Chum and Matas, "Matching with PROSAC", 2005; here the number grows evenly.
fn probable_pose(around: &Surroundings, observations: &[PoseObservation], rng: &mut Rng) -> State {
    let start = State::new(&around.camera_from_world);
    let mut best = Agreed { num: count_agreeing(observations, &start, 0).unwrap_or(0), state: start };
    let num = observations.len();
    for num_drawn in 1..=MOST_SAMPLES_OF_ALIKE {
        if best.num >= ENOUGH_AGREEING {
            break;
        }
        let drawn = (LEAST_PAIRS + num * num_drawn / MOST_SAMPLES_OF_ALIKE).min(num);
        let sample = std::array::from_fn(|_| &observations[rng.random_range(0..drawn)]);
        poses_of(sample)
            .filter(|pose| around.look_alike_from(pose))
            .for_each(|pose| best.offer(pose, observations));
    }
    best.refined(observations)
}

fn poses_of(sample: [&PoseObservation; SAMPLE]) -> impl Iterator<Item = CameraFromWorld> {
    let points = sample.map(|observation| observation.anchor_in_world);
    poses_from_three_points(&points, &sample.map(|observation| observation.ray))
}

/// A pose and how many observations agree with it.
struct Agreed {
    num: usize,
    state: State,
}

impl Agreed {
    /// Takes over a pose that more agree with.
    fn offer(&mut self, pose: CameraFromWorld, observations: &[PoseObservation]) {
        let state = State::new(&pose);
        if let Some(num) = count_agreeing(observations, &state, self.num + 1) {
            *self = Self { num, state };
        }
    }

    /// The pose by all that agree.
    fn refined(mut self, observations: &[PoseObservation]) -> State {
        for _ in 0..2 {
            let is_used: Vec<bool> = observations.iter().map(|o| is_agreeing(o, &self.state)).collect();
            let state = refine_pose(&self.state, None, observations, |i| is_used[i], f64::INFINITY, 5);
            if let Some(num) = count_agreeing(observations, &state, self.num) {
                self = Self { num, state };
            }
        }
        self.state
    }
}

/// What a keyframe looks at.
struct Surroundings {
    camera_from_world: CameraFromWorld,
    /// What is in its middle.
    middle: Point3<f64>,
    /// From its center to there.
    view: Vector3<f64>,
}

impl Surroundings {
    fn of(map: &Map, id: KeyframeId) -> Self {
        let keyframe = map.keyframe(id);
        let camera_from_world = *keyframe.camera_from_world();
        let depth = map.depth_of(id).unwrap_or(1.0);
        let view = camera_from_world.rotation().transpose() * Vector3::z() * depth;
        Self { camera_from_world, middle: keyframe.center_in_world() + view, view }
    }

    /// Whether a camera at this pose would see the same from a like direction and distance: else its patches would not be recognized.
    fn look_alike_from(&self, camera_from_world: &CameraFromWorld) -> bool {
        let there = camera_from_world.transform(&self.middle).coords;
        let view = camera_from_world.rotation().transpose() * there;
        let (here2, there2) = (self.view.norm_squared(), there.norm_squared());
        let cos = self.view.dot(&view) / (here2 * there2).sqrt();
        there.z > 0.0 && cos > LEAST_COS && there2 < here2 * FARTHEST2 && here2 < there2 * FARTHEST2
    }
}

fn is_agreeing(observation: &PoseObservation, state: &State) -> bool {
    observation.chi2(state) <= AGREEING_CHI2
}

/// How many observations agree with a state; `None` as soon as it is sure that they are fewer than a number.
fn count_agreeing(observations: &[PoseObservation], state: &State, least: usize) -> Option<usize> {
    let most_missed = observations.len().checked_sub(least)?;
    let mut num_missed = 0;
    for observation in observations {
        num_missed += usize::from(!is_agreeing(observation, state));
        if num_missed > most_missed {
            return None;
        }
    }
    Some(observations.len() - num_missed)
}

fn needed(share: f64) -> usize {
    let all_good = share.clamp(1e-3, 1.0 - 1e-9).powi(SAMPLE as i32);
    (((1.0 - CONFIDENCE).ln() / (1.0 - all_good).ln()).ceil() as usize).min(MOST_SAMPLES)
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
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_agrees_is_evidence_as_far_as_it_is_more_than_all_around() {
        let share = WIDER * WIDER;
        let (few, many) = (10, 40);
        assert!(evidence(few, few * share as usize) < 0.1, "as much as everywhere");
        assert!(evidence(few, 3 * few * share as usize) < 1e-9, "less than elsewhere");
        assert!(evidence(few, few) > LEAST_EVIDENCE, "nothing else is alike");
        assert!(evidence(many, 150) > LEAST_EVIDENCE && evidence(few, 150) < LEAST_AT_FIRST);
        assert!(evidence(0, 0) < 1e-9);
    }
}
