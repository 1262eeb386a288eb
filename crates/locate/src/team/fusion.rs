//! Fusion of positions whose errors may have anything to do with each other.

use nalgebra::{Matrix2, Point2};

/// Shares that are tried.
const NUM_SHARES: u32 = 20;

/// Joins two estimates of a position by covariance intersection: the share of each is the one that gives the smallest variance, and the
/// result is consistent for any correlation of the two. So what is told twice, or comes back from where it was told, makes nothing more
/// certain. `None` if a covariance has no inverse. Source: Julier and Uhlmann, 1997.
pub fn covariance_intersection(
    (a, a_covariance): (Point2<f64>, Matrix2<f64>),
    (b, b_covariance): (Point2<f64>, Matrix2<f64>),
) -> Option<(Point2<f64>, Matrix2<f64>)> {
    let (a_information, b_information) = (a_covariance.try_inverse()?, b_covariance.try_inverse()?);
    let fused = |share: f64| (a_information * share + b_information * (1.0 - share)).try_inverse();
    let (share, covariance) = (0..=NUM_SHARES)
        .filter_map(|i| {
            let share = f64::from(i) / f64::from(NUM_SHARES);
            Some((share, fused(share)?))
        })
        .min_by(|one, other| one.1.trace().total_cmp(&other.1.trace()))?;
    let mean = covariance * (a_information * a.coords * share + b_information * b.coords * (1.0 - share));
    mean.iter().all(|value| value.is_finite()).then(|| (Point2::from(mean), covariance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_twice_makes_nothing_more_certain() {
        let told = (Point2::new(1.0, 2.0), Matrix2::new(0.04, 0.01, 0.01, 0.09));
        let (at, covariance) = covariance_intersection(told, told).unwrap();
        assert!((at - told.0).norm() < 1e-9 && (covariance - told.1).norm() < 1e-9);
    }

    #[test]
    fn each_gives_the_direction_that_it_knows() {
        let along = (Point2::new(0.0, 0.0), Matrix2::new(0.01, 0.0, 0.0, 1.0));
        let across = (Point2::new(0.5, 0.5), Matrix2::new(1.0, 0.0, 0.0, 0.01));
        let (at, covariance) = covariance_intersection(along, across).unwrap();
        assert!(at.x.abs() < 0.05 && (at.y - 0.5).abs() < 0.05, "{at}");
        assert!(covariance.trace() < 0.1, "{covariance}");
        assert!(covariance_intersection(along, (Point2::origin(), Matrix2::zeros())).is_none());
    }
}
