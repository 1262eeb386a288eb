//! A robot on a known map: the truth and what algorithms believe.

use serde_json::Value;
use visloc_studio::{Message, recording::Row};

use super::{
    read::{list, number, numbers, single, singles, tuples},
    rings::{arc, dashes, ray, ring},
};
use crate::{
    Color, Entry, Shape,
    entry::Radius::{Meters, Screen},
};

/// A piece of a way is no longer than this, meters: the robot was carried, or the estimate jumped.
const LONGEST_PIECE_M: f64 = 0.5;
/// Where an algorithm knows less its way is not drawn.
const LEAST_RELIABILITY: f64 = 0.3;
const BODY_M: f32 = 0.13;
const ARROW_M: f32 = 0.42;
const VIEW_M: f32 = 1.6;
const PARTICLE_M: f32 = 0.11;

/// Paths whose whole past is to be shown.
pub(super) fn histories(lanes: &[String]) -> Vec<String> {
    let ways = lanes.iter().map(|lane| format!("world/{lane}/way"));
    std::iter::once("world/truth/way".to_owned()).chain(ways).collect()
}

/// What there is to see of a moment; `before` is the moment before it.
pub(super) fn entries(state: &Message, lanes: &[String], now: &Row, before: Option<&Row>) -> Vec<Entry> {
    let mut entries = truth(state, now, before);
    for ((i, contender), lane) in list(state.header.get("contenders")).enumerate().zip(lanes) {
        entries.extend(estimate(contender, lane, i));
        entries.push(hypotheses(contender, lane, i));
        entries.push(individuals(state, lane, i));
        entries.extend(way(lane, i, now, before));
    }
    entries
}

fn truth(state: &Message, now: &Row, before: Option<&Row>) -> Vec<Entry> {
    let at = |part: &str| format!("world/truth/{part}");
    let truth = state.header.get("truth");
    let height = truth.and_then(|truth| number(truth, "height_m")).unwrap_or(0.0);
    let Some([x, y, yaw]) = now.truth.map(singles) else {
        return ["robot", "heading", "view"].map(|part| Entry::now(at(part), Shape::Nothing)).into();
    };
    let center = [x, y, single(height) + BODY_M];
    let body = Shape::Points { places: vec![center], color: Color::TRUTH, radius: Meters(BODY_M) };
    let heading = Shape::Arrows {
        origins: vec![center],
        vectors: vec![[ARROW_M * yaw.cos(), ARROW_M * yaw.sin(), 0.0]],
        colors: vec![Color::TRUTH],
        radius: Meters(0.03),
    };
    let mut entries = vec![Entry::now(at("robot"), body), Entry::now(at("heading"), heading)];
    if let Some([turn, width]) = numbers(state.header.get("camera")).map(singles::<2>) {
        let ground = [x, y, 0.01];
        let mut wedge = vec![ground];
        wedge.extend(arc(ground, VIEW_M, yaw + turn - width / 2.0, width));
        wedge.push(ground);
        let color = vec![Color::TRUTH.dimmed(0.7)];
        entries.push(Entry::now(
            at("view"),
            Shape::Lines { strips: vec![wedge], colors: color, radius: Screen(0.8) },
        ));
    }
    let past = before.filter(|before| !now.is_carried && !before.is_carried).and_then(|before| before.truth);
    entries.extend(
        past.zip(now.truth)
            .and_then(|(a, b)| piece(at("way"), a, b, 0.012, Meters(0.022), Color::TRUTH.dimmed(0.85))),
    );
    entries
}

/// A piece of a way, unless it is a jump.
fn piece(
    path: String,
    a: [f64; 3],
    b: [f64; 3],
    z: f32,
    radius: crate::entry::Radius,
    color: Color,
) -> Option<Entry> {
    let length = (a[0] - b[0]).hypot(a[1] - b[1]);
    let strip = [a, b].map(|[x, y, _]| [single(x), single(y), z]).to_vec();
    (length < LONGEST_PIECE_M)
        .then(|| Entry::now(path, Shape::Lines { strips: vec![strip], colors: vec![color], radius }))
}

fn way(lane: &str, i: usize, now: &Row, before: Option<&Row>) -> Option<Entry> {
    let (a, b) = (before?.lanes.get(i)?, now.lanes.get(i)?);
    let is_known = a.name == b.name && a.reliability.min(b.reliability) >= LEAST_RELIABILITY;
    let path = format!("world/{lane}/way");
    is_known.then(|| piece(path, a.pose, b.pose, 0.02, Meters(0.016), Color::lane(i))).flatten()
}

/// The winning pose: a ring that shrinks as the reliability grows, dashed while the algorithm does not claim to know the place.
fn estimate(contender: &Value, lane: &str, i: usize) -> Option<Entry> {
    let [x, y, yaw] = singles(numbers(contender.get("pose"))?);
    let reliability = single(number(contender, "reliability").unwrap_or(0.0));
    let is_localized = contender.get("is_localized").and_then(Value::as_bool).unwrap_or(false);
    let place = [x, y, 0.015];
    // Each a little larger than the one before, so that none hides another.
    let radius = 0.17 + 0.05 * single(f64::from(u32::try_from(i).unwrap_or(0))) + 0.6 * (1.0 - reliability);
    let mut strips = if is_localized { vec![ring(place, radius)] } else { dashes(place, radius) };
    strips.push(ray(place, yaw, radius, radius + 0.2));
    let shape = Shape::Lines { strips, colors: vec![Color::lane(i)], radius: Meters(0.02) };
    Some(Entry::now(format!("world/{lane}/pose"), shape))
}

fn hypotheses(contender: &Value, lane: &str, i: usize) -> Entry {
    let (mut strips, mut colors) = (Vec::new(), Vec::new());
    // The first one is the winning pose.
    for hypothesis in list(contender.get("hypotheses")).skip(1) {
        let Some([x, y, yaw, probability]) = numbers(Some(hypothesis)).map(singles::<4>) else { continue };
        let place = [x, y, 0.01];
        let color = Color::lane(i).dimmed(0.4 + 0.5 * probability);
        strips.extend([ring(place, 0.15), ray(place, yaw, 0.0, 0.22)]);
        colors.extend([color; 2]);
    }
    Entry::now(format!("world/{lane}/hypotheses"), Shape::Lines { strips, colors, radius: Meters(0.01) })
}

/// Particles or exploiters, brighter where the image fits better.
fn individuals(state: &Message, lane: &str, i: usize) -> Entry {
    let all = tuples::<5>(state, &format!("individuals{i}")).unwrap_or_default();
    let shape = Shape::Arrows {
        origins: all.iter().map(|[x, y, ..]| [*x, *y, 0.008]).collect(),
        vectors: all
            .iter()
            .map(|[_, _, yaw, ..]| [PARTICLE_M * yaw.cos(), PARTICLE_M * yaw.sin(), 0.0])
            .collect(),
        colors: all.iter().map(|[.., likelihood, _]| Color::lane(i).dimmed(0.4 + 0.6 * likelihood)).collect(),
        radius: Meters(0.009),
    };
    Entry::now(format!("world/{lane}/particles"), shape)
}
