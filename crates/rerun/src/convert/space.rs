//! A camera without a map: what it has found, and its way.

use visloc_studio::Message;

use super::read::tuples;
use crate::{
    Color, Entry, Shape,
    entry::Radius::{Meters, Screen},
};

/// Points of a way that are drawn at most.
const MAX_WAY_POINTS: usize = 1000;

/// What there is to see of a moment.
pub(super) fn entries(state: &Message) -> Vec<Entry> {
    let [orange, blue, violet, _] = Color::LANES;
    let places = tuples(state, "landmarks").unwrap_or_default();
    let landmarks = Shape::Points { places, color: Color::rgb(0xd1_e0_f0), radius: Screen(1.3) };
    let keyframes = tuples::<12>(state, "keyframes").unwrap_or_default();
    let keyframes = keyframes.iter().flat_map(|pose| frustum(pose, 0.09)).collect();
    let camera = tuples::<12>(state, "camera").unwrap_or_default();
    let camera = camera.iter().flat_map(|pose| frustum(pose, 0.2)).collect();
    let lines = |strips, color, radius| Shape::Lines { strips, colors: vec![color], radius };
    let at = |name: &str, shape| Entry::now(format!("world/{name}"), shape);
    vec![
        at("slam/landmarks", landmarks),
        at("slam/candidates", lines(pairs(state, "candidates"), orange.dimmed(0.32), Screen(0.5))),
        at("slam/keyframes", lines(keyframes, violet, Screen(0.8))),
        at("slam/links", lines(pairs(state, "links"), violet.dimmed(0.45), Screen(0.5))),
        at("slam/way", lines(way(state, "trajectory"), blue, Meters(0.018))),
        at("slam/camera", lines(camera, blue, Screen(1.5))),
        at("truth/way", lines(way(state, "truth"), Color::TRUE_WAY, Meters(0.01))),
    ]
}

/// Both ends of each line.
fn pairs(state: &Message, name: &str) -> Vec<Vec<[f32; 3]>> {
    let ends = tuples::<6>(state, name).unwrap_or_default();
    ends.into_iter().map(|[a, b, c, d, e, f]| vec![[a, b, c], [d, e, f]]).collect()
}

/// A way; places that nobody knows interrupt it.
fn way(state: &Message, name: &str) -> Vec<Vec<[f32; 3]>> {
    let points = tuples::<3>(state, name).unwrap_or_default();
    let every = points.len().div_ceil(MAX_WAY_POINTS).max(1);
    let last = points.len().saturating_sub(1);
    let kept = points.into_iter().enumerate().filter(|(i, _)| i % every == 0 || *i == last);
    let kept: Vec<[f32; 3]> = kept.map(|(_, point)| point).collect();
    let known = kept.split(|point| point.iter().any(|value| value.is_nan()));
    known.filter(|piece| piece.len() > 1).map(<[_]>::to_vec).collect()
}

/// A camera: its place, then unit vectors to the right, down and ahead.
fn frustum(pose: &[f32; 12], size: f32) -> [Vec<[f32; 3]>; 3] {
    let at = |x: f32, y: f32, z: f32| {
        [0, 1, 2].map(|i| pose[i] + size * (pose[3 + i] * x + pose[6 + i] * y + pose[9 + i] * z))
    };
    let eye = at(0.0, 0.0, 0.0);
    let [a, b, c, d] = [at(-0.8, -0.6, 1.0), at(0.8, -0.6, 1.0), at(0.8, 0.6, 1.0), at(-0.8, 0.6, 1.0)];
    [vec![a, b, c, d, a], vec![a, eye, b], vec![c, eye, d]]
}
