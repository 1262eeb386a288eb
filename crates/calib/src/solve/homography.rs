//! Plane to plane.

use nalgebra::{Matrix3, Point2, Rotation3, SMatrix, SymmetricEigen, Vector3};
use visloc_core::geom::Rigid3;

use super::CameraFromBoard;

/// The 3x3 homography that takes the first point of each pair to the second, by the normalized direct linear transform.
/// `None` with fewer than four pairs or points that do not span a plane.
///
/// Source: Hartley and Zisserman, "Multiple View Geometry", algorithm 4.2.
pub fn homography(pairs: &[(Point2<f64>, Point2<f64>)]) -> Option<Matrix3<f64>> {
    if pairs.len() < 4 {
        return None;
    }
    let from = normalization(pairs.iter().map(|pair| pair.0))?;
    let to = normalization(pairs.iter().map(|pair| pair.1))?;
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for (a, b) in pairs {
        let (a, b) = (from * a.to_homogeneous(), to * b.to_homogeneous());
        let rows = [
            [0.0, 0.0, 0.0, -a.x, -a.y, -1.0, b.y * a.x, b.y * a.y, b.y],
            [a.x, a.y, 1.0, 0.0, 0.0, 0.0, -b.x * a.x, -b.x * a.y, -b.x],
        ];
        for row in rows {
            let row = SMatrix::<f64, 9, 1>::from(row);
            normal += row * row.transpose();
        }
    }
    let eigen = SymmetricEigen::new(normal);
    let h = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    let normalized = Matrix3::new(h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8]);
    let matrix = to.try_inverse()? * normalized * from;
    let is_usable = matrix.iter().all(|v| v.is_finite()) && matrix.determinant().abs() > 1e-300;
    is_usable.then_some(matrix)
}

/// Moves points to their mean and scales their mean distance to sqrt(2).
fn normalization(points: impl Iterator<Item = Point2<f64>> + Clone) -> Option<Matrix3<f64>> {
    let count = points.clone().count() as f64;
    let mean = points.clone().map(|p| p.coords).sum::<nalgebra::Vector2<f64>>() / count;
    let spread = points.map(|p| (p.coords - mean).norm()).sum::<f64>() / count;
    let scale = std::f64::consts::SQRT_2 / spread;
    (spread > 1e-12 && scale.is_finite())
        .then(|| Matrix3::new(scale, 0.0, -scale * mean.x, 0.0, scale, -scale * mean.y, 0.0, 0.0, 1.0))
}

/// Pose of a plane z = 0 in front of a camera, from the homography that takes its points to the plane z = 1 of the camera.
/// `None` if it is not the image of a plane in front.
///
/// Source: Zhang, "A flexible new technique for camera calibration", PAMI 2000, section 3.1.
pub fn pose_of_plane(normalized_from_board: &Matrix3<f64>) -> Option<CameraFromBoard> {
    let h = normalized_from_board;
    let (mut x, mut y, mut t) =
        (h.column(0).into_owned(), h.column(1).into_owned(), h.column(2).into_owned());
    let scale = 2.0 / (x.norm() + y.norm()) * if t.z < 0.0 { -1.0 } else { 1.0 };
    x *= scale;
    y *= scale;
    t *= scale;
    let svd = Matrix3::from_columns(&[x, y, x.cross(&y)]).svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mut rotation = u * v_t;
    if rotation.determinant() < 0.0 {
        rotation = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0)) * v_t;
    }
    let is_usable = t.z > 1e-9 && rotation.iter().chain(t.iter()).all(|v| v.is_finite());
    is_usable.then(|| Rigid3::new(Rotation3::from_matrix_unchecked(rotation), t))
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    #[test]
    fn a_pose_comes_back_from_its_homography() {
        let truth =
            CameraFromBoard::new(Rotation3::from_euler_angles(0.3, -0.4, 1.0), Vector3::new(0.1, -0.05, 0.8));
        let pairs: Vec<_> = (0..12)
            .map(|i| {
                let board = Point2::new(f64::from(i % 4) * 0.05, f64::from(i / 4) * 0.05);
                let p = truth.transform(&Point3::new(board.x, board.y, 0.0));
                (board, Point2::new(p.x / p.z, p.y / p.z))
            })
            .collect();
        let found = pose_of_plane(&homography(&pairs).unwrap()).unwrap();
        assert!((found.rotation() - truth.rotation()).norm() < 1e-6);
        assert!((found.translation() - truth.translation()).norm() < 1e-6);
        assert!(homography(&pairs[..3]).is_none());
    }
}
