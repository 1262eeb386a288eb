//! Whether an image shows the place of a keyframe, and from where.

use nalgebra::Matrix2;
use rand::RngExt;
use visloc_core::{Rng, geom::Camera};

use super::{Pair, Refusal, View, pair_views};
use crate::{
    config::SlamConfig,
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkId, Map, MapId},
    solve::{PoseObservation, State, poses_from_three_points, refine_pose},
    track::{Feature, Frame, FrameWork, Incoming, TrackReport, Tracker, focal_px, whitening},
};

/// Connected keyframes whose landmarks are compared together with those of a candidate.
const NEIGHBORS: usize = 3;
/// Fewest landmarks that two keyframes share to be neighbors.
const NEIGHBORS_SHARE: u32 = 15;
/// Fewest pairs of places and landmarks that look alike.
const LEAST_PAIRS: usize = 12;
/// Fewest pairs that agree on a pose. Four are enough to find it: eight more by chance, within a few pixels, are not to be expected.
const LEAST_AGREEING: usize = 12;
/// The same where a wrong place harms nobody, since it is doubted until more is seen: three pairs find a pose, and five more are rare by chance.
const LEAST_AGREEING_DOUBTED: usize = 8;
/// Pairs from which poses are found: the six numbers of a pose need three; the other pairs say which of the solutions it is.
const SAMPLE: usize = 3;
/// Most samples: enough where one pair in six is right.
const MOST_SAMPLES: usize = 1000;
/// Probability of one sample without a wrong pair.
const CONFIDENCE: f64 = 0.995;
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
        let mut around = vec![candidate];
        let neighbors = map.connected(candidate, NEIGHBORS_SHARE);
        around.extend(neighbors.into_iter().map(|(id, _)| id).take(NEIGHBORS));
        let pairs = pair_views(map, view, &around);
        if pairs.len() < LEAST_PAIRS {
            return Err(Refusal::FewAlike { num: pairs.len() });
        }
        let observations = self.observations(map, view, &pairs);
        let start = *map.keyframe(candidate).camera_from_world();
        let order = self.is_doubting.then(|| most_alike_first(&pairs));
        let state = agreed_pose(&start, &observations, order.as_deref(), work.rng);
        let is_agreeing = |observation: &PoseObservation| observation.chi2(&state) <= AGREEING_CHI2;
        let agreeing: Vec<Pair> =
            pairs.iter().zip(&observations).filter(|(_, o)| is_agreeing(o)).map(|(pair, _)| *pair).collect();
        let least = if self.is_doubting { LEAST_AGREEING_DOUBTED } else { LEAST_AGREEING };
        if agreeing.len() < least {
            return Err(Refusal::NoCommonPose { num: agreeing.len(), of: pairs.len() });
        }
        let report = self.follow(map, (candidate, &state.pose), incoming, work)?;
        Ok(Located { report, keyframe: candidate, pairs: agreeing, rivals: Vec::new() })
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
        let few =
            |report: &TrackReport| Refusal::FewFound { num: report.num_matched, of: report.num_searched };
        let Some(reference) = frame_of(map, around) else { return Err(Refusal::FewFound { num: 0, of: 0 }) };
        // The pose is only about right: look around first, then as in tracking.
        let wide = self.tracker.track_near(map, incoming, (pose, SEARCH_RADIUS), &reference, work);
        if wide.num_matched < self.min_matches / 2 {
            return Err(few(&wide));
        }
        let pose = wide.frame.camera_from_world;
        let report = self.tracker.track_near(map, incoming, (&pose, 0), &reference, work);
        if report.quality != crate::track::Quality::Good || report.num_converged < self.min_matches {
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

/// Pairs by how alike they are: the fewer bits differ, the more probably a pair is right.
fn most_alike_first(pairs: &[Pair]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..pairs.len()).collect();
    order.sort_by_key(|i| pairs[*i].distance);
    order
}

/// The pose that most observations agree on: from samples, then from all that agree. With an order, samples are drawn from the first ones,
/// then from ever more. Source: Chum and Matas, "Matching with PROSAC", 2005; here the number grows evenly.
fn agreed_pose(
    start: &CameraFromWorld,
    observations: &[PoseObservation],
    order: Option<&[usize]>,
    rng: &mut Rng,
) -> State {
    let start = State::new(start);
    let count = |state: &State| observations.iter().filter(|o| o.chi2(state) <= AGREEING_CHI2).count();
    let mut best = (count(&start), start);
    let (num, mut num_drawn) = (observations.len(), 0);
    while num_drawn < needed(best.0 as f64 / num as f64) {
        num_drawn += 1;
        let drawn = match order {
            None => num,
            Some(_) => (LEAST_PAIRS + num * num_drawn / MOST_SAMPLES).min(num),
        };
        let sample: [&PoseObservation; SAMPLE] = std::array::from_fn(|_| {
            let i = rng.random_range(0..drawn);
            &observations[order.map_or(i, |order| order[i])]
        });
        let points = sample.map(|observation| observation.anchor_in_world);
        for pose in poses_from_three_points(&points, &sample.map(|observation| observation.ray)) {
            let state = State::new(&pose);
            let num = count(&state);
            if num > best.0 {
                best = (num, state);
            }
        }
    }
    for _ in 0..2 {
        let is_agreeing: Vec<bool> = observations.iter().map(|o| o.chi2(&best.1) <= AGREEING_CHI2).collect();
        let state = refine_pose(&best.1, None, observations, |i| is_agreeing[i], f64::INFINITY, 5);
        let num = count(&state);
        if num >= best.0 {
            best = (num, state);
        }
    }
    best.1
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
