//! A first guess of the camera and of the poses.

use nalgebra::{DMatrix, DVector, Matrix3, Point2};
use visloc_core::median;

use super::{CameraFromBoard, Intrinsics, LensModel, Observation, homography, pose_of_plane};

/// A first guess.
#[derive(Debug, Clone)]
pub struct Start {
    /// The camera, with an ideal lens.
    pub intrinsics: Intrinsics,
    /// Pose of each picture; `None` where the corners are not the image of a board.
    pub poses: Vec<Option<CameraFromBoard>>,
}

/// Focal lengths that are tried, as shares of the image's longer side: from a fisheye to a long lens.
const FOCAL_SHARES: [f64; 16] =
    [0.22, 0.26, 0.3, 0.35, 0.42, 0.5, 0.6, 0.7, 0.82, 0.95, 1.1, 1.3, 1.6, 2.1, 2.8, 4.0];

/// Estimates focal length and poses from the homographies of the pictures, with the principal point in the middle. Zhang's
/// closed form competes with a list of focal lengths, and the smallest median error wins: on wide lenses pictures of a plane
/// are no homographies, but with a focal length the lens can be taken off before.
///
/// Source: Zhang, PAMI 2000, equations 3 and 4, with known principal point.
pub fn start(model: LensModel, size_px: (u32, u32), views: &[Vec<Observation>]) -> Option<Start> {
    let center = ((f64::from(size_px.0) - 1.0) / 2.0, (f64::from(size_px.1) - 1.0) / 2.0);
    let longer = f64::from(size_px.0.max(size_px.1));
    let mut guesses: Vec<(f64, f64)> =
        FOCAL_SHARES.iter().map(|share| (share * longer, share * longer)).collect();
    if model != LensModel::KannalaBrandt {
        guesses.extend(closed_form(center, views).filter(|f| f.0 > 0.1 * longer && f.1 > 0.1 * longer));
    }
    let tried = guesses.into_iter().map(|focal| {
        let intrinsics = Intrinsics::ideal(model, focal, center);
        let poses: Vec<_> = views.iter().map(|view| pose(&intrinsics, view)).collect();
        (median_error(&intrinsics, &poses, views), Start { intrinsics, poses })
    });
    let best = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
    best.0.is_finite().then_some(best.1)
}

/// Pose of one picture, given the camera.
pub(super) fn pose(intrinsics: &Intrinsics, view: &[Observation]) -> Option<CameraFromBoard> {
    let v = &intrinsics.values;
    let lens = intrinsics.distortion();
    let pairs: Vec<_> = view
        .iter()
        .map(|o| {
            let distorted = Point2::new((o.px.x - v[2]) / v[0], (o.px.y - v[3]) / v[1]);
            (Point2::new(o.point_in_board.x, o.point_in_board.y), lens.undistort(&distorted))
        })
        .collect();
    pose_of_plane(&homography(&pairs)?)
}

/// Median distance of all corners, pixels; infinite if less than half of the pictures have a pose.
fn median_error(
    intrinsics: &Intrinsics,
    poses: &[Option<CameraFromBoard>],
    views: &[Vec<Observation>],
) -> f64 {
    let num_posed = poses.iter().flatten().count();
    if 2 * num_posed < poses.len() || num_posed == 0 {
        return f64::INFINITY;
    }
    let mut errors = Vec::new();
    for (pose, view) in poses.iter().zip(views) {
        let Some(pose) = pose else { continue };
        errors.extend(view.iter().map(|o| {
            let seen = intrinsics.project(&pose.transform(&o.point_in_board).coords);
            seen.map_or(f64::INFINITY, |px| (px - o.px.coords).norm())
        }));
    }
    median(errors).unwrap_or(f64::INFINITY)
}

/// Zhang's constraints on 1 / fx^2 and 1 / fy^2.
fn closed_form(center: (f64, f64), views: &[Vec<Observation>]) -> impl Iterator<Item = (f64, f64)> {
    let mut rows: Vec<([f64; 2], f64)> = Vec::new();
    for view in views {
        let pairs: Vec<_> = view
            .iter()
            .map(|o| {
                let px = Point2::new(o.px.x - center.0, o.px.y - center.1);
                (Point2::new(o.point_in_board.x, o.point_in_board.y), px)
            })
            .collect();
        if let Some(h) = homography(&pairs) {
            rows.extend(constraints(&h));
        }
    }
    let a = DMatrix::from_fn(rows.len(), 2, |i, j| rows[i].0[j]);
    let b = DVector::from_fn(rows.len(), |i, _| rows[i].1);
    let solved = (rows.len() >= 2).then(|| a.svd(true, true).solve(&b, 1e-12).ok()).flatten();
    let focal =
        solved.filter(|w| w[0] > 0.0 && w[1] > 0.0).map(|w| (w[0].sqrt().recip(), w[1].sqrt().recip()));
    focal.into_iter()
}

/// The two columns of the rotation are perpendicular and of the same length.
fn constraints(h: &Matrix3<f64>) -> [([f64; 2], f64); 2] {
    let h = h / h.norm();
    let (a, b) = (h.column(0), h.column(1));
    let scale = a.norm() * b.norm();
    let perpendicular = ([a[0] * b[0] / scale, a[1] * b[1] / scale], -a[2] * b[2] / scale);
    let equal = (
        [(a[0] * a[0] - b[0] * b[0]) / scale, (a[1] * a[1] - b[1] * b[1]) / scale],
        -(a[2] * a[2] - b[2] * b[2]) / scale,
    );
    [perpendicular, equal]
}
