//! The pose that most of some pairs agree on.

use nalgebra::{Point3, Vector3};
use rand::RngExt;
use visloc_core::Rng;

use super::locate::LEAST_PAIRS;
use crate::{
    lie::CameraFromWorld,
    map::{KeyframeId, Map},
    solve::{PoseObservation, State, poses_from_three_points, refine_pose},
};

/// Pairs from which poses are found: the six numbers of a pose need three; the other pairs say which of the solutions it is.
const SAMPLE: usize = 3;
/// Most samples: enough where one pair in six is right.
const MOST_SAMPLES: usize = 1000;
/// The same where those that most others support come first: of the first twenty, half are right as a rule.
const MOST_SAMPLES_OF_SUPPORTED: usize = 300;
/// Probability of one sample without a wrong pair.
const CONFIDENCE: f64 = 0.995;
/// Pairs that agree beyond all doubt that it is a pose by chance: no more samples are drawn. What is there twice is told apart by patches.
const ENOUGH_AGREEING: usize = 16;
/// Cosine of the farthest angle between two views that look alike: 60 degrees.
const LEAST_COS: f64 = 0.5;
/// Squared ratio of the distances of two views that look alike.
const FARTHEST2: f64 = 16.0;
/// Largest squared residual of an agreeing pair in standard deviations: 99 % of two degrees of freedom.
const AGREEING_CHI2: f64 = 9.2;

/// The pose that most observations agree on: from samples, then from all that agree.
pub(super) fn agreed_pose(start: &CameraFromWorld, observations: &[PoseObservation], rng: &mut Rng) -> State {
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
pub(super) fn probable_pose(around: &Surroundings, observations: &[PoseObservation], rng: &mut Rng) -> State {
    let start = State::new(&around.camera_from_world);
    let mut best = Agreed { num: count_agreeing(observations, &start, 0).unwrap_or(0), state: start };
    let num = observations.len();
    for num_drawn in 1..=MOST_SAMPLES_OF_SUPPORTED {
        if best.num >= ENOUGH_AGREEING {
            break;
        }
        let drawn = (LEAST_PAIRS + num * num_drawn / MOST_SAMPLES_OF_SUPPORTED).min(num);
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
pub(super) struct Surroundings {
    camera_from_world: CameraFromWorld,
    /// What is in its middle.
    middle: Point3<f64>,
    /// From its center to there.
    view: Vector3<f64>,
}

impl Surroundings {
    pub fn of(map: &Map, id: KeyframeId) -> Self {
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

pub(super) fn is_agreeing(observation: &PoseObservation, state: &State) -> bool {
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
