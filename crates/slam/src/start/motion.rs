//! Motion between two views from matched rays.

use nalgebra::{Matrix2, Matrix3, Point3, Rotation3, SMatrix, SVector, Vector3};
use visloc_core::geom::{CameraFrame, Rigid3};

use crate::{lie::skew, solve::STEP};

/// Motion between two views with a translation of length 1: `second_from_first`.
pub type TwoViewMotion = Rigid3<CameraFrame, CameraFrame>;

/// A motion that is known from elsewhere.
#[derive(Debug, Clone, Copy)]
pub struct KnownMotion {
    /// The motion.
    pub motion: TwoViewMotion,
    /// Standard deviations, radians: of the direction of the translation, and of the turn about each axis.
    pub deviations: (f64, f64),
}

impl KnownMotion {
    /// What a motion deviates by: the turn about each axis, and the direction along both of the basis; standard deviations.
    fn error(&self, motion: &TwoViewMotion, basis: &(Vector3<f64>, Vector3<f64>)) -> SVector<f64, 5> {
        let (direction, turn) = self.deviations;
        let axis =
            Rotation3::from_matrix_unchecked(*(*motion * self.motion.inverse()).rotation()).scaled_axis();
        let shift = motion.translation() - self.motion.translation();
        SVector::from([
            axis.x / turn,
            axis.y / turn,
            axis.z / turn,
            basis.0.dot(&shift) / direction,
            basis.1.dot(&shift) / direction,
        ])
    }

    /// Inverse deviations of the same.
    fn weights(&self) -> SVector<f64, 5> {
        let (direction, turn) = self.deviations;
        SVector::from_fn(|i, _| 1.0 / if i < 3 { turn } else { direction })
    }

    /// Whether a motion may be this one, with no error of more than so many standard deviations.
    #[must_use]
    pub fn may_be(&self, motion: &TwoViewMotion, most_sigmas: f64) -> bool {
        motion.translation().dot(self.motion.translation()) > 0.0
            && self.error(motion, &tangent(self.motion.translation())).amax() < most_sigmas
    }
}

/// A corner in two views: its rays (z = 1), and the covariances of where it was found, on the plane z = 1.
#[derive(Debug, Clone, Copy)]
pub struct RayPair {
    /// Ray in the first view.
    pub first: Vector3<f64>,
    /// Ray in the second view.
    pub second: Vector3<f64>,
    /// Covariance in the first view.
    pub first_covariance: Matrix2<f64>,
    /// Covariance in the second view.
    pub second_covariance: Matrix2<f64>,
}

impl RayPair {
    /// Signed error of the epipolar constraint in standard deviations: the Sampson distance for places that are known unequally well in
    /// each direction.
    ///
    /// Source: Kanatani, "Statistical optimization for geometric computation", 1996, chapter 11; for equal covariances Hartley and
    /// Zisserman, "Multiple view geometry", 2nd edition, section 11.4.3.
    #[inline]
    #[must_use]
    pub fn epipolar_error(&self, essential: &Matrix3<f64>) -> f64 {
        let line_in_second = essential * self.first;
        let line_in_first = essential.tr_mul(&self.second);
        let (across_second, across_first) = (line_in_second.xy(), line_in_first.xy());
        let variance = across_second.dot(&(self.second_covariance * across_second))
            + across_first.dot(&(self.first_covariance * across_first));
        self.second.dot(&line_in_second) / variance.sqrt().max(f64::MIN_POSITIVE)
    }

    /// The error, and its derivatives along the given changes of the essential matrix. `None` if the error is not below a limit.
    #[inline]
    fn linearized(
        &self,
        essential: &Matrix3<f64>,
        changes: &[Matrix3<f64>; 5],
        limit: f64,
    ) -> Option<(f64, SVector<f64, 5>)> {
        let line_in_second = essential * self.first;
        let line_in_first = essential.tr_mul(&self.second);
        let in_second = self.second_covariance * line_in_second.xy();
        let in_first = self.first_covariance * line_in_first.xy();
        let variance = line_in_second.xy().dot(&in_second) + line_in_first.xy().dot(&in_first);
        let inverse_deviation = 1.0 / variance.sqrt().max(f64::MIN_POSITIVE);
        let error = self.second.dot(&line_in_second) * inverse_deviation;
        if (error / limit).powi(2) >= 1.0 {
            return None;
        }
        let shrink = error * inverse_deviation * inverse_deviation;
        // Of the product, and of the deviation that divides it.
        let by_essential = (self.second * inverse_deviation - in_second.push(0.0) * shrink)
            * self.first.transpose()
            - self.second * (in_first.push(0.0) * shrink).transpose();
        Some((error, SVector::from_fn(|i, _| by_essential.dot(&changes[i]))))
    }

    /// Inverse depth in the first view, for a translation of length 1; below 0 where the rays meet behind it.
    fn inverse_depth(&self, motion: &TwoViewMotion) -> f64 {
        // second x (R first + inverse_depth t) = 0, in the least-squares sense.
        let turned = self.second.cross(&motion.rotate(&self.first));
        let moved = self.second.cross(motion.translation());
        -turned.dot(&moved) / moved.norm_squared().max(f64::MIN_POSITIVE)
    }
}

/// The essential matrix of a motion.
#[inline]
#[must_use]
pub fn essential_of(motion: &TwoViewMotion) -> Matrix3<f64> {
    skew(motion.translation()) * motion.rotation()
}

/// Tukey's constant: a biweight that is cut off there loses 5 % of the precision if all errors are normal.
const TUKEY: f64 = 4.685;
/// Standard deviation of a normal distribution, in medians of the absolute value.
const SIGMA_BY_MEDIAN: f64 = 1.4826;

/// Gauss-Newton on the epipolar error over rotation and direction of translation, and on the error of what is known. Errors are weighed
/// by Tukey's biweight in the scale that their median has by then, at least `least_sigma`: far from the solution all count.
#[must_use]
pub fn refine_motion(
    start: &TwoViewMotion,
    (pairs, known): (&[RayPair], Option<&KnownMotion>),
    least_sigma: f64,
    max_iterations: usize,
) -> TwoViewMotion {
    let mut motion = *start;
    let mut errors = Vec::with_capacity(pairs.len());
    for _ in 0..max_iterations {
        let basis = tangent(motion.translation());
        let essential = essential_of(&motion);
        let changes = changes(&motion, &basis);
        let cutoff = TUKEY * scale(&essential, pairs, &mut errors).max(least_sigma);
        let (mut hessian, mut gradient) = (SMatrix::<f64, 5, 5>::zeros(), SVector::<f64, 5>::zeros());
        for pair in pairs {
            let Some((error, jacobian)) = pair.linearized(&essential, &changes, cutoff) else { continue };
            let weight = (1.0 - (error / cutoff).powi(2)).powi(2);
            hessian += jacobian * jacobian.transpose() * weight;
            gradient -= jacobian * error * weight;
        }
        if let Some(known) = known {
            let weights = known.weights();
            hessian += SMatrix::<f64, 5, 5>::from_diagonal(&weights.component_mul(&weights));
            gradient -= known.error(&motion, &basis).component_mul(&weights);
        }
        for i in 0..5 {
            hessian[(i, i)] = hessian[(i, i)] * (1.0 + 1e-6) + 1e-12;
        }
        let Some(step) = hessian.cholesky().map(|c| c.solve(&gradient)) else { break };
        if step.norm().is_nan() || step.norm() >= 0.5 {
            break;
        }
        motion = apply(&motion, &basis, &step);
        if step.norm() < 1e-8 {
            break;
        }
    }
    motion
}

/// Robust standard deviation of the epipolar errors.
fn scale(essential: &Matrix3<f64>, pairs: &[RayPair], errors: &mut Vec<f64>) -> f64 {
    errors.clear();
    errors.extend(pairs.iter().map(|pair| pair.epipolar_error(essential).abs()));
    if errors.is_empty() {
        return 0.0;
    }
    let middle = errors.len() / 2;
    SIGMA_BY_MEDIAN * *errors.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// How far the errors of the corners may have bent what a motion makes of them: the deviation of inverse depths that is due to the motion
/// alone, relative to them and beside a factor that they have in common; root mean square over the corners. A motion that is near
/// another one in the image, a turn and a shift, bends all points together, which their residuals do not show.
#[must_use]
pub fn shape_deviation(motion: &TwoViewMotion, inliers: &[RayPair]) -> f64 {
    let basis = tangent(motion.translation());
    let neighbors = neighbors(motion, &basis);
    let (essential, changes) = (essential_of(motion), changes(motion, &basis));
    let (mut information, mut chi2) = (SMatrix::<f64, 5, 5>::zeros(), 0.0);
    let mut depths: Vec<(f64, SVector<f64, 5>)> = Vec::with_capacity(inliers.len());
    for pair in inliers {
        if let Some((error, jacobian)) = pair.linearized(&essential, &changes, f64::INFINITY) {
            chi2 += error * error;
            information += jacobian * jacobian.transpose();
        }
        let depth = pair.inverse_depth(motion);
        depths.push((depth, SVector::from_fn(|i, _| (pair.inverse_depth(&neighbors[i]) - depth) / STEP)));
    }
    let Some(covariance) = information.cholesky().map(|c| c.inverse()) else { return f64::INFINITY };
    // The corners are as exact as their residuals say.
    let covariance = covariance * (chi2 / inliers.len().saturating_sub(5).max(1) as f64);
    let norm2: f64 = depths.iter().map(|(depth, _)| depth * depth).sum::<f64>().max(f64::MIN_POSITIVE);
    let common: SVector<f64, 5> = depths.iter().map(|(depth, by_motion)| by_motion * (depth / norm2)).sum();
    let variance = |(depth, by_motion): &(f64, SVector<f64, 5>)| {
        let bent = by_motion - common * *depth;
        bent.dot(&(covariance * bent))
    };
    (depths.iter().map(variance).sum::<f64>() / norm2).sqrt()
}

/// How the essential matrix changes with each of the five degrees of freedom of a motion, see [`apply`].
fn changes(motion: &TwoViewMotion, basis: &(Vector3<f64>, Vector3<f64>)) -> [Matrix3<f64>; 5] {
    let across = skew(motion.translation());
    let turned = |axis: Vector3<f64>| across * skew(&axis) * motion.rotation();
    [
        turned(Vector3::x()),
        turned(Vector3::y()),
        turned(Vector3::z()),
        skew(&basis.0) * motion.rotation(),
        skew(&basis.1) * motion.rotation(),
    ]
}

/// The motion after a small step along each of its five degrees of freedom.
fn neighbors(motion: &TwoViewMotion, basis: &(Vector3<f64>, Vector3<f64>)) -> [TwoViewMotion; 5] {
    std::array::from_fn(|i| {
        let mut delta = SVector::<f64, 5>::zeros();
        delta[i] = STEP;
        apply(motion, basis, &delta)
    })
}

/// Two directions at right angles to `t`.
fn tangent(t: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let other = if t.x.abs() < 0.6 * t.norm() { Vector3::x() } else { Vector3::y() };
    let a = t.cross(&other).normalize();
    (a, t.cross(&a).normalize())
}

fn apply(
    motion: &TwoViewMotion,
    basis: &(Vector3<f64>, Vector3<f64>),
    delta: &SVector<f64, 5>,
) -> TwoViewMotion {
    let turn = Rotation3::from_scaled_axis(Vector3::new(delta[0], delta[1], delta[2]));
    let rotation = turn * Rotation3::from_matrix_unchecked(*motion.rotation());
    let direction = (motion.translation() + basis.0 * delta[3] + basis.1 * delta[4]).normalize();
    Rigid3::new(rotation, direction)
}

/// Triangulated pairs in front of both cameras, in the first camera, baseline 1; `None` for the others.
#[must_use]
pub fn triangulate_pairs(motion: &TwoViewMotion, pairs: &[RayPair]) -> Vec<Option<Point3<f64>>> {
    let point = |RayPair { first, second, .. }: &RayPair| {
        crate::solve::triangulate(motion, first, second).map(|(depth, _)| Point3::from(first * depth))
    };
    pairs.iter().map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_changes_as_its_derivatives_say() {
        let turn = Rotation3::from_scaled_axis(Vector3::new(0.02, -0.05, 0.03));
        let motion = TwoViewMotion::new(turn, Vector3::new(0.7, -0.2, -0.7).normalize());
        let pair = RayPair {
            first: Vector3::new(0.3, -0.2, 1.0),
            second: Vector3::new(0.4, 0.1, 1.0),
            first_covariance: Matrix2::new(2e-6, 5e-7, 5e-7, 1e-6),
            second_covariance: Matrix2::new(1e-6, -8e-7, -8e-7, 4e-6),
        };
        let basis = tangent(motion.translation());
        let essential = essential_of(&motion);
        let (error, jacobian) =
            pair.linearized(&essential, &changes(&motion, &basis), f64::INFINITY).unwrap();
        assert!((error - pair.epipolar_error(&essential)).abs() < 1e-9);
        for (i, neighbor) in neighbors(&motion, &basis).iter().enumerate() {
            let slope = (pair.epipolar_error(&essential_of(neighbor)) - error) / STEP;
            assert!((jacobian[i] - slope).abs() < 1e-3 * jacobian.norm(), "{i}: {} and {slope}", jacobian[i]);
        }
    }
}
