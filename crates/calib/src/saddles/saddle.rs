//! Places where two black and two white corners meet.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix2, Point2, Vector2};

use super::FloatImage;

/// A saddle point of the brightness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Saddle {
    /// Where, pixels.
    pub px: Point2<f64>,
    /// Directions of the two edges that cross here, radians in [0, pi), ascending.
    pub edges_rad: [f64; 2],
    /// Difference between bright and dark around it.
    pub contrast: f64,
    strength: f32,
}

/// Blur before second derivatives are taken, pixels.
const SMOOTHING_PX: f32 = 1.5;
/// Radius of the ring on which black and white must alternate, pixels.
const RING_PX: f64 = 4.0;
const RING: usize = 32;
/// Weaker saddle points are noise: a contrast of 255 gives about 30 squared.
const MIN_STRENGTH: f32 = 0.8;
/// Bright and dark of the ring must differ by this, of 255.
const MIN_CONTRAST: f64 = 10.0;
/// Most saddle points of an image: clutter costs time.
const MAX_SADDLES: usize = 4000;
/// Angle beside an edge where its sides are compared.
const BESIDE_RAD: f64 = 0.35;

impl Saddle {
    /// Directions of all four edges that leave it, radians.
    pub fn edge_angles(&self) -> [f64; 4] {
        let [a, b] = self.edges_rad;
        [a, b, a + PI, b + PI]
    }

    /// How much brighter it is at the left of an edge that leaves in this direction (y points down).
    pub fn edge_contrast(&self, image: &FloatImage, angle_rad: f64) -> f64 {
        let at = |angle: f64| image.sample(&(self.px + Vector2::new(angle.cos(), angle.sin()) * RING_PX));
        at(angle_rad - BESIDE_RAD) - at(angle_rad + BESIDE_RAD)
    }

    /// Edge direction of this saddle point that is nearest to a direction, and how far off it is, radians.
    pub fn nearest_edge(&self, angle_rad: f64) -> (f64, f64) {
        let off = |edge: f64| visloc_core::geom::angle::difference(edge, angle_rad).abs();
        let angles = self.edge_angles();
        let best = angles.into_iter().min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(0.0);
        (best, off(best))
    }
}

/// All saddle points of an image, the strongest first, and the smoothed image that they were found in.
pub fn find_saddles(image: &FloatImage) -> (Vec<Saddle>, FloatImage) {
    let smooth = image.blurred(SMOOTHING_PX);
    let ring_image = image.blurred(0.8);
    let strength = strengths(&smooth);
    let mut peaks = peaks(&strength, image.width(), image.height());
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
    let saddles = peaks.into_iter().filter_map(|(strength, x, y)| {
        let px = refined(&smooth, x, y)?;
        let (edges_rad, contrast) = alternation(&ring_image, &px)?;
        Some(Saddle { px, edges_rad, contrast, strength })
    });
    (saddles.take(MAX_SADDLES).collect(), ring_image)
}

/// Negative determinant of the Hessian; 0 at the border.
fn strengths(image: &FloatImage) -> Vec<f32> {
    let (width, height) = (image.width(), image.height());
    let mut strength = vec![0.0_f32; width * height];
    for y in 1..height - 1 {
        let (above, row, below) = (image.row(y - 1), image.row(y), image.row(y + 1));
        let out = &mut strength[y * width..(y + 1) * width];
        for x in 1..width - 1 {
            let xx = row[x + 1] - 2.0 * row[x] + row[x - 1];
            let yy = below[x] - 2.0 * row[x] + above[x];
            let xy = 0.25 * (below[x + 1] - below[x - 1] - above[x + 1] + above[x - 1]);
            out[x] = xy * xy - xx * yy;
        }
    }
    strength
}

/// Local maxima with their strengths.
fn peaks(strength: &[f32], width: usize, height: usize) -> Vec<(f32, usize, usize)> {
    const RADIUS: usize = 2;
    let border = RING_PX as usize + 1;
    let mut found = Vec::new();
    for y in border..height.saturating_sub(border) {
        for x in border..width.saturating_sub(border) {
            let here = strength[y * width + x];
            if here < MIN_STRENGTH {
                continue;
            }
            let is_peak = (y - RADIUS..=y + RADIUS).all(|j| {
                strength[j * width + x - RADIUS..=j * width + x + RADIUS].iter().all(|other| *other <= here)
            });
            if is_peak {
                found.push((here, x, y));
            }
        }
    }
    found
}

/// The saddle point of the quadratic function through the neighbors.
fn refined(image: &FloatImage, x: usize, y: usize) -> Option<Point2<f64>> {
    let at = |dx: i32, dy: i32| {
        let row = image.row(y.checked_add_signed(dy as isize)?);
        row.get(x.checked_add_signed(dx as isize)?).map(|v| f64::from(*v))
    };
    let gradient = Vector2::new((at(1, 0)? - at(-1, 0)?) / 2.0, (at(0, 1)? - at(0, -1)?) / 2.0);
    let middle = 2.0 * at(0, 0)?;
    let xy = (at(1, 1)? - at(-1, 1)? - at(1, -1)? + at(-1, -1)?) / 4.0;
    let hessian = Matrix2::new(at(1, 0)? - middle + at(-1, 0)?, xy, xy, at(0, 1)? - middle + at(0, -1)?);
    let step = hessian.try_inverse()? * -gradient;
    (step.norm() < 1.5).then(|| Point2::new(x as f64, y as f64) + step)
}

/// The ring around a point changes between dark and bright four times, and opposite parts are alike. Directions of the two
/// edges and the difference of bright and dark.
fn alternation(image: &FloatImage, px: &Point2<f64>) -> Option<([f64; 2], f64)> {
    let mut ring = [0.0_f64; RING];
    for (i, value) in ring.iter_mut().enumerate() {
        let angle = i as f64 * TAU / RING as f64;
        *value = image.sample(&(px + Vector2::new(angle.cos(), angle.sin()) * RING_PX));
    }
    let low = ring.iter().copied().fold(f64::INFINITY, f64::min);
    let high = ring.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (threshold, contrast) = (f64::midpoint(low, high), high - low);
    if contrast < MIN_CONTRAST {
        return None;
    }
    let opposite: f64 =
        (0..RING / 2).map(|i| (ring[i] - ring[i + RING / 2]).abs()).sum::<f64>() / (RING / 2) as f64;
    if opposite > 0.35 * contrast {
        return None;
    }
    let mut crossings = [0.0; 4];
    let mut count = 0;
    for i in 0..RING {
        let (a, b) = (ring[i] - threshold, ring[(i + 1) % RING] - threshold);
        if (a > 0.0) != (b > 0.0) {
            *crossings.get_mut(count)? = (i as f64 + a / (a - b)) * TAU / RING as f64;
            count += 1;
        }
    }
    if count != 4 {
        return None;
    }
    let line = |a: f64, b: f64| {
        let bend = visloc_core::geom::angle::difference(b - PI, a);
        (bend.abs() < 0.6).then(|| (a + 0.5 * bend).rem_euclid(PI))
    };
    let (a, b) = (line(crossings[0], crossings[2])?, line(crossings[1], crossings[3])?);
    Some(([a.min(b), a.max(b)], contrast))
}
