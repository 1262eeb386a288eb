//! Pairs of places and landmarks that lie to each other in an image as they do in a keyframe.

use std::cmp::Reverse;

use nalgebra::{Point2, Vector2};
use visloc_core::geom::Camera;

use super::{
    Alike, Pair, View,
    lists::BLOCK,
    pairs::{ByPieces, Known},
};
use crate::{
    map::{Keyframe, KeyframeId, LandmarkId, Map},
    track::focal_px,
};

/// Distance of two pairs that may support each other, on the plane z = 1 of the keyframe: what is as near to each other is mostly on one thing.
const REACH: f64 = 0.08;
/// The same where few are known to look alike: those of a whole wall.
const REACH_OF_FEW: f64 = 0.3;
/// Most that the way from one to the other may differ between both images, share of its length: a surface that is seen 30 degrees from the
/// side, and a scale that is known to a half octave.
const LIKE: f64 = 0.5;
/// Least that it may differ, on the plane z = 1: corners are off by a few pixels.
const NEAR: f64 = 0.005;
/// Supporters from which on a pair counts, though its landmark is not clearly more alike than others: by chance there is less than one.
const LEAST_SUPPORT: u32 = 2;

/// A place that may show a landmark.
struct Proposal {
    pair: Pair,
    /// On the plane z = 1 of the image, and of the keyframe.
    here: Point2<f64>,
    there: Point2<f64>,
    /// How much larger things are here, by the levels.
    scale: f64,
    is_clear: bool,
    support: u32,
}

/// Landmarks of some keyframes that look like places of an image, each place and each landmark once, those first that most others support: they
/// lie to each other as they do in the first of the keyframes, seen the same way up. The others are clearly more alike than any other.
///
/// Source: Bian et al., "GMS: Grid-based motion statistics for fast, ultra-robust feature correspondence", 2017; here the support is counted pair by pair.
pub(super) fn pair_views_by_support(
    map: &Map,
    camera: &Camera,
    (view, listed): (&View, &ByPieces),
    keyframes: &[KeyframeId],
) -> Vec<Pair> {
    let known = Known::of(map, keyframes);
    let mut proposals = proposals(map, camera, (view, listed), (keyframes[0], &known));
    count_support(&mut proposals, REACH);
    proposals.retain(|proposal| proposal.is_clear || proposal.support >= LEAST_SUPPORT);
    proposals.sort_by_key(|it| (Reverse(it.support), it.pair.distance, it.pair.place));
    let (mut is_paired, mut is_seen) = (vec![false; view.len()], vec![false; map.num_landmark_ids()]);
    let mut pairs = Vec::new();
    for Proposal { pair, .. } in proposals {
        if !is_paired[pair.place] && !is_seen[pair.landmark.index()] {
            is_paired[pair.place] = true;
            is_seen[pair.landmark.index()] = true;
            pairs.push(pair);
        }
    }
    pairs
}

/// How many places of an image look like one of a keyframe that lies to others as it does here.
pub(super) fn num_supported<'a>(
    camera: &Camera,
    (image, places): (&View, impl Iterator<Item = &'a Alike>),
    keyframe: &Keyframe,
) -> usize {
    let Some(seen) = keyframe.view.as_deref() else { return 0 };
    let (focal, focal_there) = (focal_px(camera), focal_px(keyframe.camera(camera)));
    let mut proposals: Vec<Proposal> = places
        .map(|alike| {
            let (here, there) = (image.at(alike.place), seen.at(alike.known));
            let landmark = there.landmark.unwrap_or(LandmarkId(0));
            Proposal {
                pair: Pair { place: alike.place, landmark, distance: 0 },
                here: here.px / focal,
                there: there.px / focal_there,
                scale: larger(here.level, there.level) * focal_there / focal,
                is_clear: false,
                support: 0,
            }
        })
        .collect();
    count_support(&mut proposals, REACH_OF_FEW);
    proposals.iter().filter(|proposal| proposal.support > 0).count()
}

fn proposals(
    map: &Map,
    camera: &Camera,
    (view, listed): (&View, &ByPieces),
    (keyframe, known): (KeyframeId, &Known),
) -> Vec<Proposal> {
    let pose = map.keyframe(keyframe).camera_from_world();
    let there: Vec<Option<Point2<f64>>> = known
        .ids
        .iter()
        .map(|id| pose.transform(&map.landmark(*id).point_in_world))
        .map(|point| (point.z > 0.0).then(|| Point2::new(point.x / point.z, point.y / point.z)))
        .collect();
    let (focal, focal_there) = (focal_px(camera), focal_px(map.keyframe(keyframe).camera(camera)));
    let mut proposals = Vec::new();
    for (place, (described, nearest)) in view.iter().zip(listed.nearest(known)).enumerate() {
        let clear = nearest.clear().map(|(index, _)| index);
        let here = described.px / focal;
        for (index, distance) in nearest.alike() {
            let Some(there) = there[index] else { continue };
            proposals.push(Proposal {
                pair: Pair { place, landmark: known.ids[index], distance },
                here,
                there,
                scale: larger(described.level, known.levels[index]) * focal_there / focal,
                is_clear: clear == Some(index),
                support: 0,
            });
        }
    }
    proposals
}

/// How much larger a thing is that looks the same on another level, pixels of level 0.
fn larger(level_here: i32, level_there: i32) -> f64 {
    f64::from(level_here - level_there).exp2()
}

/// Counts for each pair how many others lie to it as they should.
fn count_support(proposals: &mut [Proposal], reach: f64) {
    proposals.sort_by(|a, b| a.scale.total_cmp(&b.scale).then(a.there.x.total_cmp(&b.there.x)));
    let place = |it: &Proposal| [it.there.x, it.there.y, it.here.x, it.here.y];
    let places: Vec<[f64; 4]> = proposals.iter().map(place).collect();
    let mut end = 0;
    for first in 0..proposals.len() {
        let (scale, left) = (proposals[first].scale, places[first][0]);
        let is_near = |other: usize| proposals[other].scale == scale && places[other][0] - left <= reach;
        end = end.max(first);
        end += (end..places.len()).take_while(|other| is_near(*other)).count();
        for start in (first + 1..end).step_by(BLOCK) {
            let others = start..end.min(start + BLOCK);
            if !may_support(&places[first], &places[others.clone()], scale, reach) {
                continue;
            }
            for second in others {
                if is_supporting(&proposals[first], &proposals[second], reach) {
                    proposals[first].support += 1;
                    proposals[second].support += 1;
                }
            }
        }
    }
}

/// Whether any of some places may support one, each as on the planes z = 1 there and here. Most are off by far on one axis alone, and roots take time.
#[inline]
fn may_support(first: &[f64; 4], others: &[[f64; 4]], scale: f64, reach: f64) -> bool {
    let may = |other: &[f64; 4]| {
        let [x, y, here_x, here_y]: [f64; 4] = std::array::from_fn(|i| other[i] - first[i]);
        let most = LIKE * scale * (x.abs() + y.abs()) + 2.0 * NEAR;
        (y.abs() <= reach) & ((here_x - x * scale).abs() < most) & ((here_y - y * scale).abs() < most)
    };
    others.iter().fold(false, |any, other| any | may(other))
}

fn is_supporting(first: &Proposal, second: &Proposal, reach: f64) -> bool {
    let there: Vector2<f64> = second.there - first.there;
    if there.y.abs() > reach || first.pair.landmark == second.pair.landmark || first.here == second.here {
        return false;
    }
    let expected = there * first.scale;
    (second.here - first.here - expected).norm() < LIKE * expected.norm() + NEAR
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use visloc_core::{Rng, RngTree};

    use super::*;

    fn anywhere(rng: &mut Rng) -> Point2<f64> {
        Point2::new(rng.random_range(-0.6..0.6), rng.random_range(-0.45..0.45))
    }

    /// Things of a few landmarks each that are seen twice as large and a bit from the side, among ten times as many pairs by chance.
    fn proposals(rng: &mut Rng) -> (Vec<Proposal>, usize) {
        let mut all = Vec::new();
        let mut add = |here, there, scale| {
            let pair = Pair { place: all.len(), landmark: LandmarkId(all.len() as u32), distance: 40 };
            all.push(Proposal { pair, here, there, scale, is_clear: false, support: 0 });
        };
        for _ in 0..8 {
            let (here, there) = (anywhere(rng), anywhere(rng));
            for _ in 0..5 {
                let way = Vector2::new(rng.random_range(-0.02..0.02), rng.random_range(-0.02..0.02));
                let seen = Vector2::new(1.6 * way.x, 2.2 * way.y) * 0.9;
                add(here + seen, there + way, 2.0);
            }
        }
        let num_right = 8 * 5;
        for _ in 0..10 * num_right {
            let scale = if rng.random_range(0..2) == 0 { 1.0 } else { 2.0 };
            add(anywhere(rng), anywhere(rng), scale);
        }
        (all, num_right)
    }

    #[test]
    fn what_lies_on_one_thing_supports_each_other_and_pairs_by_chance_do_not() {
        for seed in 0..5 {
            let (mut all, num_right) = proposals(&mut RngTree::new(seed).stream("support", 0));
            count_support(&mut all, REACH);
            let is_right = |it: &&Proposal| it.pair.place < num_right;
            let num_supported = |wanted: bool| {
                let counted = all.iter().filter(|it| it.support >= LEAST_SUPPORT);
                counted.filter(|it| is_right(it) == wanted).count()
            };
            assert_eq!(num_supported(true), num_right, "seed {seed}");
            assert!(num_supported(false) < 20, "seed {seed}: {}", num_supported(false));
        }
    }

    #[test]
    fn a_landmark_and_a_place_do_not_support_themselves() {
        let pair = |place, landmark| Pair { place, landmark: LandmarkId(landmark), distance: 40 };
        let proposal = |pair, here, there| Proposal {
            pair,
            here: Point2::new(here, 0.0),
            there: Point2::new(there, 0.0),
            scale: 1.0,
            is_clear: false,
            support: 0,
        };
        let first = proposal(pair(0, 0), 0.0, 0.0);
        assert!(is_supporting(&first, &proposal(pair(1, 1), 0.02, 0.02), REACH));
        assert!(!is_supporting(&first, &proposal(pair(1, 0), 0.004, 0.0), REACH), "the same landmark");
        assert!(!is_supporting(&first, &proposal(pair(1, 1), 0.0, 0.004), REACH), "the same corner");
        assert!(!is_supporting(&first, &proposal(pair(1, 1), -0.02, 0.02), REACH), "on the other side");
    }
}
