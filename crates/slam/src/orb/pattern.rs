//! The pairs of places that the bits of a descriptor compare.

use std::sync::LazyLock;

use rand::RngExt;
use visloc_core::{Rng, RngTree};

/// Bits of a descriptor.
pub(super) const NUM_BITS: usize = 256;
/// Steps of a full turn. Source: Rublee et al., "ORB", 2011, section 4.1 (12 degrees).
pub(super) const NUM_TURNS: usize = 30;
/// Farthest place of a turned pattern from its center on each axis, pixels.
pub(super) const REACH_PX: i32 = 14;
/// Side of the square that the pattern covers, pixels.
pub(super) const SIDE: usize = 2 * REACH_PX as usize + 1;

/// Farthest place from the center before it is turned and rounded, pixels.
const RADIUS_PX: f64 = 13.0;
/// Standard deviation of the places: a fifth of the patch of 31 px. Source: Calonder et al., "BRIEF", 2010, section 3.2
/// (the distribution G II).
const SIGMA_PX: f64 = 31.0 / 5.0;
/// Two tests whose places are all nearer to each other than this would nearly be the same bit, pixels.
const LEAST_DIFFERENCE_PX: i32 = 3;

type Place = (i32, i32);

/// For each turn the pairs of places of all bits, as indices into the square, row by row.
pub(super) type Pattern = Vec<[[u16; 2]; NUM_BITS]>;

/// The pattern. ORB's authors chose their pairs from a training set, for much variance and little correlation; these are drawn
/// from the distribution of BRIEF with a fixed seed. Pairs that resemble an earlier one are left out, and so are pairs that lie
/// along x: every patch is turned until it is brightest there, so their bits are nearly always the same.
pub(super) static PATTERN: LazyLock<Pattern> = LazyLock::new(|| {
    let tests = draw_tests();
    (0..NUM_TURNS).map(|turn| turned(&tests, turn)).collect()
});

fn draw_tests() -> Vec<(Place, Place)> {
    let mut rng = RngTree::new(2011).stream("orb pattern", 0);
    let mut tests: Vec<(Place, Place)> = Vec::with_capacity(NUM_BITS);
    while tests.len() < NUM_BITS {
        let test = (draw_place(&mut rng), draw_place(&mut rng));
        let is_flat = is_near(test.0, test.1) || (test.0.0 - test.1.0).abs() > (test.0.1 - test.1.1).abs();
        let is_known = tests.iter().any(|other| is_alike(*other, test) || is_alike((other.1, other.0), test));
        if !(is_flat || is_known) {
            tests.push(test);
        }
    }
    tests
}

/// Normally distributed around the center (Box and Muller), inside of the radius.
fn draw_place(rng: &mut Rng) -> Place {
    loop {
        let (u, v): (f64, f64) = (rng.random(), rng.random());
        let radius = SIGMA_PX * (-2.0 * (1.0 - u).ln()).sqrt();
        if radius <= RADIUS_PX {
            let angle = std::f64::consts::TAU * v;
            return ((radius * angle.cos()).round() as i32, (radius * angle.sin()).round() as i32);
        }
    }
}

fn is_near(a: Place, b: Place) -> bool {
    (a.0 - b.0).abs() < LEAST_DIFFERENCE_PX && (a.1 - b.1).abs() < LEAST_DIFFERENCE_PX
}

fn is_alike(a: (Place, Place), b: (Place, Place)) -> bool {
    is_near(a.0, b.0) && is_near(a.1, b.1)
}

fn turned(tests: &[(Place, Place)], turn: usize) -> [[u16; 2]; NUM_BITS] {
    let angle = std::f64::consts::TAU * turn as f64 / NUM_TURNS as f64;
    let (sin, cos) = angle.sin_cos();
    let index = |(x, y): Place| {
        let (x, y) = (f64::from(x), f64::from(y));
        let column = (cos * x - sin * y).round() as i32 + REACH_PX;
        let row = (sin * x + cos * y).round() as i32 + REACH_PX;
        (row * SIDE as i32 + column) as u16
    };
    let mut pairs = [[0; 2]; NUM_BITS];
    for (pair, (a, b)) in pairs.iter_mut().zip(tests) {
        *pair = [index(*a), index(*b)];
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_turn_has_different_places_inside_of_the_square() {
        assert_eq!(PATTERN.len(), NUM_TURNS);
        for pairs in PATTERN.iter() {
            for [a, b] in pairs {
                assert!(usize::from((*a).max(*b)) < SIDE * SIDE && a != b);
            }
        }
    }
}
