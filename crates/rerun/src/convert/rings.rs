//! Rings on the ground.

use std::f32::consts::TAU;

/// Pieces of a closed ring.
const NUM_PIECES: u8 = 40;
/// Dashes of a ring of an estimate that is not to be trusted.
const NUM_DASHES: u8 = 14;

/// A part of a ring around a place, from an angle over another one, radians.
pub(super) fn arc([x, y, z]: [f32; 3], radius: f32, from: f32, over: f32) -> Vec<[f32; 3]> {
    let num_pieces = (f32::from(NUM_PIECES) * over / TAU).ceil().max(2.0);
    let mut points = Vec::new();
    let mut i = 0.0;
    while i <= num_pieces {
        let angle = from + over * i / num_pieces;
        points.push([x + radius * angle.cos(), y + radius * angle.sin(), z]);
        i += 1.0;
    }
    points
}

/// A closed ring.
pub(super) fn ring(center: [f32; 3], radius: f32) -> Vec<[f32; 3]> {
    arc(center, radius, 0.0, TAU)
}

/// A dashed ring.
pub(super) fn dashes(center: [f32; 3], radius: f32) -> Vec<Vec<[f32; 3]>> {
    let step = TAU / f32::from(NUM_DASHES);
    (0..NUM_DASHES).map(|i| arc(center, radius, step * f32::from(i), 0.55 * step)).collect()
}

/// A line from a place in a direction.
pub(super) fn ray([x, y, z]: [f32; 3], yaw_rad: f32, from: f32, to: f32) -> Vec<[f32; 3]> {
    let at = |far: f32| [x + far * yaw_rad.cos(), y + far * yaw_rad.sin(), z];
    vec![at(from), at(to)]
}
