//! The pose of one camera from points that it sees.

use nalgebra::{Matrix2, Matrix2x3, Matrix6, Point3, Vector2, Vector3, Vector6};
use rand::RngExt;
use visloc_base::Rng;

use super::normal::solve_damped;
use crate::lie::{CameraFromWorld, image_by_twist, moved};

/// One point and where the camera sees it.
#[derive(Debug, Clone, Copy)]
pub struct PoseObservation {
    /// The point, map units.
    pub point_in_world: Point3<f64>,
    /// Where it is seen, on the plane z = 1 without distortion.
    pub ray: Vector3<f64>,
    /// Whitens a residual on that plane: square root of the inverse covariance.
    pub whitening: Matrix2<f64>,
}

impl PoseObservation {
    /// Whitened residual; `None` behind the camera.
    #[inline]
    fn residual(&self, pose: &CameraFromWorld) -> Option<(Vector2<f64>, Point3<f64>)> {
        let point = pose.transform(&self.point_in_world);
        if point.z <= 1e-9 {
            return None;
        }
        let error = Vector2::new(point.x / point.z - self.ray.x, point.y / point.z - self.ray.y);
        Some((self.whitening * error, point))
    }

    /// Squared length of the whitened residual; infinite behind the camera.
    #[inline]
    #[must_use]
    pub fn chi2(&self, pose: &CameraFromWorld) -> f64 {
        self.residual(pose).map_or(f64::INFINITY, |(error, _)| error.norm_squared())
    }
}

/// How outliers are found.
#[derive(Debug, Clone, Copy)]
pub struct RansacSettings {
    /// Whether hypotheses are drawn at all; otherwise only the robust weights reject.
    pub is_enabled: bool,
    /// Size of a sample.
    pub sample_size: usize,
    /// Probability of one sample without outliers.
    pub confidence: f64,
    /// Most hypotheses.
    pub max_hypotheses: usize,
    /// Largest squared whitened residual of an inlier.
    pub inlier_chi2: f64,
    /// Factor on the residual (not squared) within which outliers get a second chance.
    pub rescue_factor: f64,
}

/// A pose with the observations that agree.
#[derive(Debug, Clone)]
pub struct RobustPose {
    /// The pose.
    pub camera_from_world: CameraFromWorld,
    /// One entry for each observation.
    pub is_inlier: Vec<bool>,
    /// How many agree.
    pub num_inliers: usize,
}

/// Gauss-Newton on the reprojection error over the selected observations, with Tukey's biweight (cut off at `cutoff` whitened
/// units) or, with an infinite cutoff, plain least squares.
#[must_use]
pub fn refine_pose(
    start: &CameraFromWorld,
    observations: &[PoseObservation],
    is_used: impl Fn(usize) -> bool,
    cutoff: f64,
    max_iterations: usize,
) -> CameraFromWorld {
    let mut pose = *start;
    for _ in 0..max_iterations {
        let (mut hessian, mut gradient) = (Matrix6::zeros(), Vector6::zeros());
        for (_, observation) in observations.iter().enumerate().filter(|(i, _)| is_used(*i)) {
            let Some((error, point)) = observation.residual(&pose) else { continue };
            let ratio2 = error.norm_squared() / (cutoff * cutoff);
            if ratio2 >= 1.0 {
                continue;
            }
            let weight = (1.0 - ratio2).powi(2);
            let inv_z = 1.0 / point.z;
            let (x, y) = (point.x * inv_z, point.y * inv_z);
            let by_point = Matrix2x3::new(inv_z, 0.0, -x * inv_z, 0.0, inv_z, -y * inv_z);
            let jacobian = observation.whitening * image_by_twist(&by_point, &point.coords);
            hessian += jacobian.transpose() * jacobian * weight;
            gradient -= jacobian.transpose() * error * weight;
        }
        let Some(step) = solve_damped(hessian, &gradient, 1e-6) else { break };
        pose = moved(&step, &pose);
        if step.amax() < 1e-7 {
            break;
        }
    }
    pose
}

/// Pose with outliers rejected: hypotheses from small samples, least squares over the inliers of the best, rescue of outliers
/// within a larger threshold, least squares again. The start pose is the first hypothesis.
///
/// Source: Fischler and Bolles, "Random sample consensus", 1981, for the number of hypotheses.
#[must_use]
pub fn robust_pose(
    start: &CameraFromWorld,
    observations: &[PoseObservation],
    settings: &RansacSettings,
    rng: &mut Rng,
) -> RobustPose {
    let limit = settings.inlier_chi2;
    let cutoff = 2.0 * limit.sqrt();
    // Wide first: the start may be off by several pixels.
    let wide = refine_pose(start, observations, |_| true, 4.0 * cutoff, 5);
    let mut best = refine_pose(&wide, observations, |_| true, cutoff, 5);
    let mut best_count = count_inliers(&best, observations, limit);
    let at_start = refine_pose(start, observations, |_| true, cutoff, 5);
    let start_count = count_inliers(&at_start, observations, limit);
    if start_count > best_count {
        (best, best_count) = (at_start, start_count);
    }
    if settings.is_enabled && observations.len() >= 2 * settings.sample_size {
        let mut drawn = 0;
        while drawn < needed_hypotheses(settings, best_count as f64 / observations.len() as f64) {
            drawn += 1;
            let sample = draw(settings.sample_size, observations.len(), rng);
            let pose = refine_pose(start, observations, |i| sample.contains(&i), f64::INFINITY, 5);
            let count = count_inliers(&pose, observations, limit);
            if count > best_count {
                (best, best_count) = (pose, count);
            }
        }
    }
    let is_inlier = mark(&best, observations, limit);
    let pose = refine_pose(&best, observations, |i| is_inlier[i], cutoff, 5);
    let is_rescued = mark(&pose, observations, limit * settings.rescue_factor.powi(2));
    let pose = refine_pose(&pose, observations, |i| is_rescued[i], cutoff, 10);
    let is_inlier = mark(&pose, observations, limit);
    let num_inliers = is_inlier.iter().filter(|is_inlier| **is_inlier).count();
    RobustPose { camera_from_world: pose, is_inlier, num_inliers }
}

fn needed_hypotheses(settings: &RansacSettings, inlier_ratio: f64) -> usize {
    let all_good = inlier_ratio.clamp(1e-3, 1.0 - 1e-9).powi(settings.sample_size as i32);
    let needed = (1.0 - settings.confidence).ln() / (1.0 - all_good).ln();
    (needed.ceil() as usize).min(settings.max_hypotheses)
}

/// Different indices, in order of drawing.
fn draw(size: usize, num: usize, rng: &mut Rng) -> Vec<usize> {
    let mut sample = Vec::with_capacity(size);
    while sample.len() < size {
        let i = rng.random_range(0..num);
        if !sample.contains(&i) {
            sample.push(i);
        }
    }
    sample
}

fn count_inliers(pose: &CameraFromWorld, observations: &[PoseObservation], limit: f64) -> usize {
    observations.iter().filter(|observation| observation.chi2(pose) <= limit).count()
}

fn mark(pose: &CameraFromWorld, observations: &[PoseObservation], limit: f64) -> Vec<bool> {
    observations.iter().map(|observation| observation.chi2(pose) <= limit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lie::{exp, log};
    use visloc_base::{RngTree, gaussian};
    use visloc_geom::{Rigid3, World};

    const SETTINGS: RansacSettings = RansacSettings {
        is_enabled: true,
        sample_size: 5,
        confidence: 0.99,
        max_hypotheses: 100,
        inlier_chi2: 5.991,
        rescue_factor: 2.0,
    };

    fn scene(seed: u64, outliers: f64) -> (CameraFromWorld, Vec<PoseObservation>) {
        let mut rng = RngTree::new(seed).stream("scene", 0);
        let truth = exp::<World>(&Vector6::new(0.3, -0.2, 0.1, 0.1, -0.2, 0.05));
        let truth = Rigid3::new(nalgebra::Rotation3::from_matrix_unchecked(*truth.rotation()), *truth.translation());
        let observations = (0..120)
            .map(|i| {
                let mut draw = || rng.random_range(-1.0..1.0);
                let point = Point3::new(2.0 * draw(), 1.5 * draw(), 4.0 + draw());
                let seen = CameraFromWorld::transform(&truth, &point);
                let mut ray = seen.coords / seen.z;
                if f64::from(i) < 120.0 * outliers {
                    ray += Vector3::new(0.1 * draw(), 0.1 * draw(), 0.0);
                } else {
                    ray += Vector3::new(gaussian(&mut rng, 0.001), gaussian(&mut rng, 0.001), 0.0);
                }
                PoseObservation { point_in_world: point, ray, whitening: Matrix2::identity() * 1000.0 }
            })
            .collect();
        (truth, observations)
    }

    #[test]
    fn finds_the_pose_among_forty_percent_outliers() {
        for seed in 0..20 {
            let (truth, observations) = scene(seed, 0.4);
            let start = moved(&Vector6::new(0.03, 0.02, -0.03, 0.02, 0.01, 0.02), &truth);
            let mut rng = RngTree::new(seed).stream("ransac", 0);
            let found = robust_pose(&start, &observations, &SETTINGS, &mut rng);
            let error = log(&(found.camera_from_world * truth.inverse())).norm();
            assert!(error < 5e-3, "seed {seed}: {error}");
            assert!((60..=85).contains(&found.num_inliers), "{}", found.num_inliers);
        }
    }

    #[test]
    fn nothing_to_see_leaves_the_pose() {
        let (truth, _) = scene(1, 0.0);
        let mut rng = RngTree::new(1).stream("ransac", 0);
        let found = robust_pose(&truth, &[], &SETTINGS, &mut rng);
        assert_eq!(found.num_inliers, 0);
        assert!(log(&(found.camera_from_world * truth.inverse())).norm() < 1e-9);
    }
}
