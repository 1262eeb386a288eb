//! Alignment of an estimate with the truth.

use nalgebra::{Matrix3, Vector3};

use super::PosePair;
use crate::geom::Similarity;

/// How freely an estimate may be moved before it is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Alignment {
    /// Not at all.
    None,
    /// Rotation and translation.
    Rigid,
    /// Rotation, translation and scale: for one camera, which knows no scale.
    Similarity,
}

/// The transform from the estimate to the truth that brings the estimated positions nearest to the true ones, in the least-squares sense. `None` with fewer
/// than three pairs or with positions that do not determine it.
///
/// Source: Umeyama, "Least-squares estimation of transformation parameters between two point patterns", 1991.
pub fn align(pairs: &[PosePair], alignment: Alignment) -> Option<Similarity> {
    if alignment == Alignment::None {
        return Some(Similarity::identity());
    }
    if pairs.len() < 3 {
        return None;
    }
    let n = pairs.len() as f64;
    let truth = |pair: &PosePair| *pair.truth.world_from_camera.translation();
    let estimate = |pair: &PosePair| *pair.estimate.world_from_camera.translation();
    let truth_mean = pairs.iter().map(truth).sum::<Vector3<f64>>() / n;
    let estimate_mean = pairs.iter().map(estimate).sum::<Vector3<f64>>() / n;
    let variance = pairs.iter().map(|p| (estimate(p) - estimate_mean).norm_squared()).sum::<f64>() / n;
    let product = |p: &PosePair| (truth(p) - truth_mean) * (estimate(p) - estimate_mean).transpose();
    let covariance = pairs.iter().map(product).sum::<Matrix3<f64>>() / n;
    let svd = covariance.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let d = svd.singular_values;
    if variance <= 0.0 || d.iter().filter(|v| **v > 1e-12 * d.max()).count() < 2 {
        return None;
    }
    let mut signs = Vector3::new(1.0, 1.0, 1.0);
    if u.determinant() * v_t.determinant() < 0.0 {
        signs[d.imin()] = -1.0;
    }
    let rotation = u * Matrix3::from_diagonal(&signs) * v_t;
    let scale =
        if alignment == Alignment::Similarity { d.component_mul(&signs).sum() / variance } else { 1.0 };
    Some(Similarity { scale, rotation, translation: truth_mean - rotation * estimate_mean * scale })
}
