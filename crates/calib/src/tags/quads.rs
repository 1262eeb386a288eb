//! Dark squares whose corners are saddle points.

use nalgebra::Point2;

use crate::saddles::{FloatImage, Saddle, SaddleIndex};

/// Four saddle points, clockwise in the image, with dark inside along all sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quad {
    /// Their numbers in the list of saddle points.
    pub saddles: [usize; 4],
    /// Where they are, pixels.
    pub corners_px: [Point2<f64>; 4],
}

/// How far a side may turn away from the direction of the edge at its start: lenses bend it.
const MAX_BEND_RAD: f64 = 0.22;
/// How far beside a side it has to be dark and bright, as a share of its length.
const BESIDE: f64 = 0.05;
/// Turn from a side to the next one: perspective makes it anything but straight or back.
const TURN_RAD: (f64, f64) = (0.5, 2.64);
/// So many candidates along an edge are tried.
const MAX_TRIED: usize = 6;

/// Finds all dark squares.
pub fn find_quads(
    image: &FloatImage,
    saddles: &[Saddle],
    index: &SaddleIndex,
    max_side_px: f64,
) -> Vec<Quad> {
    let next: Vec<Vec<(f64, usize)>> =
        (0..saddles.len()).map(|i| dark_edges(image, saddles, index, i, max_side_px)).collect();
    let mut quads = Vec::new();
    for (a, edges) in next.iter().enumerate() {
        for &(angle, b) in edges {
            let mut chain = [a, b, 0, 0];
            let mut direction = angle;
            let is_closed = (1..4).all(|i| {
                let Some((turned, to)) = following(&next[chain[i]], direction) else { return false };
                direction = turned;
                if i < 3 {
                    chain[i + 1] = to;
                }
                i < 3 || to == a
            });
            let is_first = chain.iter().all(|i| *i >= a) && chain[1] != chain[3] && chain[2] != a;
            if is_closed && is_first {
                quads.push(Quad { saddles: chain, corners_px: chain.map(|i| saddles[i].px) });
            }
        }
    }
    quads
}

/// The edge that goes on along the same dark square: turned clockwise.
fn following(edges: &[(f64, usize)], direction: f64) -> Option<(f64, usize)> {
    edges.iter().copied().find(|(angle, _)| {
        let turn = (angle - direction).rem_euclid(std::f64::consts::TAU);
        (TURN_RAD.0..=TURN_RAD.1).contains(&turn)
    })
}

/// Angle and end of the edges of a saddle point that have the dark on their right side.
fn dark_edges(
    image: &FloatImage,
    saddles: &[Saddle],
    index: &SaddleIndex,
    from: usize,
    max_side_px: f64,
) -> Vec<(f64, usize)> {
    let saddle = &saddles[from];
    let mut found = Vec::with_capacity(2);
    for angle in saddle.edge_angles() {
        // Right of the direction is clockwise, since y points down.
        if saddle.edge_contrast(image, angle) <= 0.0 {
            continue;
        }
        let mut near: Vec<(f64, usize)> = index
            .within(&saddle.px, max_side_px)
            .filter(|i| *i != from)
            .filter_map(|i| {
                let d = saddles[i].px - saddle.px;
                let bend = visloc_core::geom::angle::difference(d.y.atan2(d.x), angle).abs();
                (bend < MAX_BEND_RAD).then_some((d.norm(), i))
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let end = near.iter().take(MAX_TRIED).find(|(_, i)| is_side(image, saddle, &saddles[*i], angle));
        found.extend(end.map(|(_, i)| {
            let d = saddles[*i].px - saddle.px;
            (d.y.atan2(d.x), *i)
        }));
    }
    found
}

/// Whether it is dark at the right and bright at the left all along.
fn is_side(image: &FloatImage, a: &Saddle, b: &Saddle, angle: f64) -> bool {
    let along = b.px - a.px;
    let (back, bend) = b.nearest_edge(angle + std::f64::consts::PI);
    if bend > 2.0 * MAX_BEND_RAD || b.edge_contrast(image, back) >= 0.0 {
        return false;
    }
    let right = nalgebra::Vector2::new(-along.y, along.x) * BESIDE.max(1.5 / along.norm()).min(0.3);
    let contrast = |share: f64| {
        let p = a.px + along * share;
        image.sample(&(p - right)) - image.sample(&(p + right))
    };
    let least = 0.4 * 0.5 * (a.contrast + b.contrast);
    [0.2, 0.35, 0.5, 0.65, 0.8].into_iter().all(|share| contrast(share) > least)
}
