//! How the image around each followed corner has been stretched and turned, from how its neighbors have moved.

use nalgebra::{Matrix2, Point2, Vector2};

/// Where a corner was first and where it is now, pixels.
pub type Moved = (Point2<f64>, Point2<f64>);

/// Distance within which corners count as neighbors, pixels.
const REACH_PX: f64 = 80.0;
/// How strongly the warp of the whole image is believed beside the neighbors: as two of them at half of the reach.
const PRIOR: f64 = 2.0 * (REACH_PX * REACH_PX) / 4.0;
/// Deviation from the warp that a neighbor may have before it counts less, pixels. Neighbors at another depth have more.
const HUBER_PX: f64 = 2.0;
/// Rounds of weighing.
const ROUNDS: usize = 3;

/// For each corner the linear warp around it: pixels of now per pixel of the first image. A patch that is compared under
/// this warp is found where it is, and not where a turned or stretched patch happens to fit best.
#[must_use]
pub fn local_warps(moved: &[Moved]) -> Vec<Matrix2<f64>> {
    let global = global_warp(moved);
    moved.iter().map(|corner| local_warp(corner, moved, &global)).collect()
}

/// The warp of the image as a whole, the identity where there are too few corners.
fn global_warp(moved: &[Moved]) -> Matrix2<f64> {
    let num = moved.len() as f64;
    if num < 4.0 {
        return Matrix2::identity();
    }
    let first = moved.iter().map(|m| m.0.coords).sum::<Vector2<f64>>() / num;
    let now = moved.iter().map(|m| m.1.coords).sum::<Vector2<f64>>() / num;
    let center = (first.into(), now.into());
    fit(&center, moved.iter(), &Matrix2::identity(), REACH_PX * REACH_PX, f64::INFINITY)
}

fn local_warp(corner: &Moved, moved: &[Moved], global: &Matrix2<f64>) -> Matrix2<f64> {
    let is_near = |other: &&Moved| (other.0 - corner.0).norm_squared() < REACH_PX * REACH_PX;
    fit(corner, moved.iter().filter(is_near), global, PRIOR, HUBER_PX)
}

/// Robust least squares of `now - now0 = warp (first - first0)` with a prior.
fn fit<'a>(
    center: &Moved,
    moved: impl Iterator<Item = &'a Moved> + Clone,
    prior: &Matrix2<f64>,
    strength: f64,
    huber_px: f64,
) -> Matrix2<f64> {
    let mut warp = *prior;
    for _ in 0..ROUNDS {
        let mut normal = Matrix2::identity() * strength;
        let mut right = prior * strength;
        for (first, now) in moved.clone() {
            let (before, after) = (first - center.0, now - center.1);
            let deviation = (after - warp * before).norm();
            let weight = if deviation > huber_px { huber_px / deviation } else { 1.0 };
            normal += before * before.transpose() * weight;
            right += after * before.transpose() * weight;
        }
        if let Some(inverse) = normal.try_inverse() {
            warp = right * inverse;
        }
    }
    warp
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_and_stretched_image_has_one_warp() {
        let truth = Matrix2::new(1.2, -0.3, 0.3, 1.1);
        let moved: Vec<Moved> = (0..60)
            .map(|i| {
                let first = Point2::new(f64::from(i * 37 % 640), f64::from(i * 91 % 480));
                (first, Point2::from(truth * first.coords + Vector2::new(5.0, -9.0)))
            })
            .collect();
        for warp in local_warps(&moved) {
            assert!((warp - truth).norm() < 0.02, "{warp}");
        }
    }

    #[test]
    fn neighbors_at_another_depth_hardly_count() {
        // Near things in the left half grow by a fifth, in the right half nothing changes.
        let moved: Vec<Moved> = (0..160)
            .map(|i| {
                let first = Point2::new(f64::from(i % 16 * 20), f64::from(i / 16 * 20));
                let scale = if first.x < 160.0 { 1.2 } else { 1.0 };
                (first, first * scale)
            })
            .collect();
        let warps = local_warps(&moved);
        assert!((warps[83] - Matrix2::identity() * 1.2).norm() < 0.05, "{}", warps[83]);
        assert!((warps[93] - Matrix2::identity()).norm() < 0.05, "{}", warps[93]);
    }

    #[test]
    fn without_corners_there_is_nothing_to_say() {
        assert!(local_warps(&[]).is_empty());
        let alone = (Point2::new(3.0, 4.0), Point2::new(10.0, 4.0));
        assert!((local_warps(&[alone])[0] - Matrix2::identity()).norm() < 1e-9);
    }
}
