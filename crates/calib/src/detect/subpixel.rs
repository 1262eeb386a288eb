//! Corners to a fraction of a pixel.

use nalgebra::{Matrix2, Point2, Vector2};

use crate::saddles::FloatImage;

/// Rounds until the corner stays where it is.
const MAX_ROUNDS: usize = 15;
const CONVERGED_PX: f64 = 0.002;

/// The point that all gradients around it point past at a right angle: at each pixel the line along the edge goes through
/// the corner. `radius_px` is where a pixel's weight has fallen to a tenth. `None` if the corner runs away.
///
/// Source: Foerstner and Guelch, "A fast operator for detection and precise location of distinct points, corners and centres
/// of circular features", 1987. Deviation: Gaussian weights around the latest estimate, so that no pixel enters or leaves with
/// a jump.
pub(super) fn refine(image: &FloatImage, start: &Point2<f64>, radius_px: f64) -> Option<Point2<f64>> {
    let reach = radius_px.ceil().max(2.0);
    let falloff = -(10.0_f64.ln()) / (radius_px * radius_px);
    let mut corner = *start;
    for _ in 0..MAX_ROUNDS {
        let next = one_round(image, &corner, reach, falloff)?;
        if (next - start).norm() > radius_px.max(2.0) {
            return None;
        }
        let moved = (next - corner).norm();
        corner = next;
        if moved < CONVERGED_PX {
            break;
        }
    }
    Some(corner)
}

fn one_round(image: &FloatImage, corner: &Point2<f64>, reach: f64, falloff: f64) -> Option<Point2<f64>> {
    let (width, height) = (image.width() as f64, image.height() as f64);
    let is_inside = corner.x - reach >= 2.0
        && corner.y - reach >= 2.0
        && corner.x + reach <= width - 3.0
        && corner.y + reach <= height - 3.0;
    if !is_inside {
        return None;
    }
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    let columns = (corner.x - reach).round() as usize..=(corner.x + reach).round() as usize;
    for y in (corner.y - reach).round() as usize..=(corner.y + reach).round() as usize {
        let (above, row, below) = (image.row(y - 1), image.row(y), image.row(y + 1));
        for x in columns.clone() {
            let gradient = Vector2::new(f64::from(row[x + 1] - row[x - 1]), f64::from(below[x] - above[x]));
            let offset = Vector2::new(x as f64 - corner.x, y as f64 - corner.y);
            let weight = (falloff * offset.norm_squared()).exp();
            let outer = gradient * gradient.transpose() * weight;
            normal += outer;
            right += outer * offset;
        }
    }
    // Gradients of one direction alone do not fix a point.
    let is_corner = normal.determinant() > 0.01 * (0.5 * normal.trace()).powi(2);
    let step = is_corner.then(|| normal.try_inverse()).flatten()? * right;
    step.iter().all(|v| v.is_finite()).then(|| corner + step)
}
