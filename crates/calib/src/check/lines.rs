//! Long edges and how much they bend.

use nalgebra::{DMatrix, DVector, Point2, Vector2};
use visloc_core::{GrayImage, geom::Camera};

use crate::saddles::FloatImage;

/// Shortest edge that counts, as a share of the image's diagonal.
const MIN_LENGTH: f64 = 0.2;
/// Gradient across an edge, of 255 a pixel.
const MIN_GRADIENT: f64 = 4.0;
/// Step along an edge, and how far beside it the next point is looked for, pixels.
const STEP_PX: f64 = 2.0;
const BESIDE_PX: i32 = 2;
/// An edge that turns more in one step than this ends, radians.
const MAX_TURN_RAD: f64 = 0.25;
/// Distance of edges that begin anew, pixels.
const SPACING: usize = 12;
/// Curved things are no lines: a bow above this share of the length, or points farther off the bow than this, pixels.
const MAX_BOW: f64 = 0.06;
const MAX_OFF_PX: f64 = 1.5;
/// A line through the middle stays straight under any lens; others pass it at this share of the diagonal or more.
const MIN_OFF_CENTER: f64 = 0.08;

/// Bends of the long edges of an image: as seen, and without the distortion; pixels, positive if the middle of the edge is
/// farther from the principal point than its ends let expect (barrel).
pub(super) fn bows_px(camera: &Camera, image: &GrayImage) -> Vec<(f64, f64)> {
    let smooth = FloatImage::from_gray(image).blurred(1.2);
    let diagonal = (image.width() as f64).hypot(image.height() as f64);
    let center = Point2::new(camera.center_px().0, camera.center_px().1);
    let mut is_taken = vec![false; (image.width() / 4 + 1) * (image.height() / 4 + 1)];
    let cell = |p: &Point2<f64>| cell_of(p, image.width());
    let mut bows = Vec::new();
    for y in (SPACING..image.height().saturating_sub(SPACING)).step_by(SPACING) {
        for x in SPACING..image.width().saturating_sub(SPACING) {
            let start = Point2::new(x as f64, y as f64);
            // Along rows and columns, so that no long edge is missed.
            for start in [
                start,
                Point2::new(
                    start.y * image.width() as f64 / image.height() as f64,
                    start.x * image.height() as f64 / image.width() as f64,
                ),
            ] {
                if is_taken.get(cell(&start)).copied().unwrap_or(true) || !is_peak(&smooth, &start) {
                    continue;
                }
                let points = trace(&smooth, &start);
                for p in &points {
                    if let Some(taken) = is_taken.get_mut(cell(p)) {
                        *taken = true;
                    }
                }
                let ideal: Vec<_> = points.iter().map(|p| camera.ideal_px(p)).collect();
                if let (Some(seen), Some(ideal)) =
                    (bow(&points, &center, diagonal), bow(&ideal, &center, diagonal))
                {
                    bows.push((seen, ideal));
                }
            }
        }
    }
    bows
}

fn cell_of(p: &Point2<f64>, width: usize) -> usize {
    (p.y.max(0.0) as usize / 4) * (width / 4 + 1) + p.x.max(0.0) as usize / 4
}

fn gradient(image: &FloatImage, p: &Point2<f64>) -> Vector2<f64> {
    let at = |dx: f64, dy: f64| image.sample(&Point2::new(p.x + dx, p.y + dy));
    Vector2::new(at(1.0, 0.0) - at(-1.0, 0.0), at(0.0, 1.0) - at(0.0, -1.0)) / 2.0
}

/// Whether the gradient is strong here and weaker at both sides.
fn is_peak(image: &FloatImage, p: &Point2<f64>) -> bool {
    let g = gradient(image, p);
    let norm = g.norm();
    if norm < MIN_GRADIENT {
        return false;
    }
    let across = g / norm;
    gradient(image, &(p + across)).norm() <= norm && gradient(image, &(p - across)).norm() <= norm
}

/// Points along an edge through `start`, in both directions.
fn trace(image: &FloatImage, start: &Point2<f64>) -> Vec<Point2<f64>> {
    let Some(start) = on_edge(image, start) else { return Vec::new() };
    let mut points: Vec<_> = walk(image, &start, 1.0);
    points.reverse();
    points.push(start);
    points.extend(walk(image, &start, -1.0));
    points
}

fn walk(image: &FloatImage, start: &Point2<f64>, sign: f64) -> Vec<Point2<f64>> {
    let mut points = Vec::new();
    let g = gradient(image, start);
    let mut direction = Vector2::new(-g.y, g.x).normalize() * sign;
    let mut at = *start;
    let (width, height) = (image.width() as f64, image.height() as f64);
    for _ in 0..4000 {
        let Some(next) = on_edge(image, &(at + direction * STEP_PX)) else { break };
        let is_inside = next.x > 3.0 && next.y > 3.0 && next.x < width - 4.0 && next.y < height - 4.0;
        let step = next - at;
        if !is_inside || step.norm() < 0.5 * STEP_PX || step.norm() > 2.0 * STEP_PX {
            break;
        }
        let g = gradient(image, &next);
        let along = Vector2::new(-g.y, g.x).normalize() * sign;
        // The brighter side stays the same, and the edge goes on in about the same direction.
        if along.dot(&direction) < MAX_TURN_RAD.cos() {
            break;
        }
        direction = (direction * 0.6 + along * 0.4).normalize();
        at = next;
        points.push(at);
    }
    points
}

/// The place of the strongest gradient beside a point, along the gradient, to a fraction of a pixel.
fn on_edge(image: &FloatImage, p: &Point2<f64>) -> Option<Point2<f64>> {
    let g = gradient(image, p);
    if g.norm() < 0.5 * MIN_GRADIENT {
        return None;
    }
    let across = g.normalize();
    let strength = |i: i32| gradient(image, &(p + across * f64::from(i) * 0.5)).dot(&across);
    let best = (-2 * BESIDE_PX..=2 * BESIDE_PX).max_by(|a, b| strength(*a).total_cmp(&strength(*b)))?;
    let (before, here, after) = (strength(best - 1), strength(best), strength(best + 1));
    let curvature = before - 2.0 * here + after;
    let offset = if curvature < 0.0 { (0.5 * (before - after) / curvature).clamp(-0.5, 0.5) } else { 0.0 };
    (here >= MIN_GRADIENT).then(|| p + across * (f64::from(best) + offset) * 0.5)
}

/// Height of the parabola through the points above the line through its ends; `None` if this is no line.
fn bow(points: &[Point2<f64>], center: &Point2<f64>, diagonal: f64) -> Option<f64> {
    let (first, last) = (points.first()?, points.last()?);
    let chord = last - first;
    let length = chord.norm();
    if length < MIN_LENGTH * diagonal || !length.is_finite() {
        return None;
    }
    let along = chord / length;
    let mut outwards = Vector2::new(-along.y, along.x);
    let off_center = (first - center).dot(&outwards);
    if off_center.abs() < MIN_OFF_CENTER * diagonal {
        return None;
    }
    outwards *= off_center.signum();
    let places: Vec<(f64, f64)> = points
        .iter()
        .map(|p| ((p - first).dot(&along) / length * 2.0 - 1.0, (p - first).dot(&outwards)))
        .collect();
    let powers = DMatrix::from_fn(places.len(), 3, |i, j| places[i].0.powi(j as i32));
    let heights = DVector::from_fn(places.len(), |i, _| places[i].1);
    let fit = powers.clone().svd(true, true).solve(&heights, 1e-12).ok()?;
    let mut off: Vec<f64> = (powers * &fit - heights).iter().map(|v| v.abs()).collect();
    off.sort_by(f64::total_cmp);
    let bow = -fit[2];
    let is_line = bow.abs() < MAX_BOW * length && off[off.len() * 9 / 10] < MAX_OFF_PX;
    is_line.then_some(bow)
}
