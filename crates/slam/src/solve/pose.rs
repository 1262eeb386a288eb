//! The pose of one camera from points that it sees.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Matrix6, Point3, SMatrix, SVector, Vector2, Vector3, Vector6};
use rand::RngExt;
use visloc_core::Rng;

use super::normal::{add_residual, solve_damped};
use crate::lie::{CameraFromWorld, log, moved, skew};

/// One landmark and where the camera sees it.
///
/// A landmark is the point `anchor + direction / inverse_depth`. Of a known point, `direction` is zero and the anchor is the
/// point. Of a candidate, the anchor is the center of its host and its inverse depth is only known up to a factor that all
/// candidates have in common: were their errors taken for independent, many of them together would feign to know the scale.
#[derive(Debug, Clone, Copy)]
pub struct PoseObservation {
    /// The point, or the center of the candidate's host; map units.
    pub anchor_in_world: Point3<f64>,
    /// The candidate's ray (z = 1 in its host) in the world.
    pub direction_in_world: Vector3<f64>,
    /// Inverse depth of a candidate, 1 / map unit; `None` for a known point.
    pub inverse_depth: Option<f64>,
    /// Where it is seen, on the plane z = 1 without distortion.
    pub ray: Vector3<f64>,
    /// Whitens a residual on that plane: square root of the inverse covariance.
    pub whitening: Matrix2<f64>,
}

impl PoseObservation {
    /// Of a known point.
    #[must_use]
    pub fn of_point(point_in_world: Point3<f64>, ray: Vector3<f64>, whitening: Matrix2<f64>) -> Self {
        Self {
            anchor_in_world: point_in_world,
            direction_in_world: Vector3::zeros(),
            inverse_depth: None,
            ray,
            whitening,
        }
    }

    /// The landmark in the camera, up to its depth, and the anchor in the camera.
    #[inline]
    fn in_camera(&self, state: &State) -> (Vector3<f64>, Vector3<f64>, f64) {
        let anchor = state.pose.transform(&self.anchor_in_world).coords;
        match self.inverse_depth {
            None => (anchor, anchor, 1.0),
            Some(inverse_depth) => {
                let weight = inverse_depth * state.log_scale.exp();
                (state.pose.rotate(&self.direction_in_world) + anchor * weight, anchor, weight)
            }
        }
    }

    /// Whitened residual; `None` behind the camera.
    #[inline]
    fn residual(&self, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        if point.z <= 1e-9 {
            return None;
        }
        let error = Vector2::new(point.x / point.z - self.ray.x, point.y / point.z - self.ray.y);
        Some(self.whitening * error)
    }

    /// Whitened residual with its derivatives by the twist and by the logarithm of the candidates' scale.
    #[inline]
    fn linearize(&self, state: &State) -> Option<(Vector2<f64>, SMatrix<f64, 2, 7>)> {
        let (point, anchor, weight) = self.in_camera(state);
        let error = self.residual(&point)?;
        let inv_z = 1.0 / point.z;
        let (x, y) = (point.x * inv_z, point.y * inv_z);
        let by_point = self.whitening * Matrix2x3::new(inv_z, 0.0, -x * inv_z, 0.0, inv_z, -y * inv_z);
        let mut jacobian = SMatrix::<f64, 2, 7>::zeros();
        jacobian.fixed_view_mut::<2, 3>(0, 0).copy_from(&(by_point * weight));
        jacobian.fixed_view_mut::<2, 3>(0, 3).copy_from(&(-by_point * skew(&point)));
        if self.inverse_depth.is_some() {
            jacobian.fixed_view_mut::<2, 1>(0, 6).copy_from(&(by_point * anchor * weight));
        }
        Some((error, jacobian))
    }

    /// Squared length of the whitened residual; infinite behind the camera.
    #[inline]
    #[must_use]
    pub fn chi2(&self, state: &State) -> f64 {
        let (point, _, _) = self.in_camera(state);
        self.residual(&point).map_or(f64::INFINITY, |error| error.norm_squared())
    }
}

/// What is estimated: the pose, and the factor that the inverse depths of all candidates have in common.
#[derive(Debug, Clone, Copy)]
pub struct State {
    /// The pose.
    pub pose: CameraFromWorld,
    /// Logarithm of the factor on inverse depths.
    pub log_scale: f64,
}

impl State {
    /// A pose, and candidates as they are.
    #[must_use]
    pub fn new(pose: &CameraFromWorld) -> Self {
        Self { pose: *pose, log_scale: 0.0 }
    }
}

/// Covariance of a pose over the twist that [`moved`] applies: translation first, map units and radians, in the frame of the camera. It
/// grows where the observations disagree more than their own covariances say. `None` if they do not fix the pose.
#[must_use]
pub fn pose_covariance(pose: &CameraFromWorld, observations: &[PoseObservation]) -> Option<Matrix6<f64>> {
    let state = State::new(pose);
    let (mut information, mut chi2, mut num) = (Matrix6::zeros(), 0.0, 0_u32);
    for (error, jacobian) in observations.iter().filter_map(|observation| observation.linearize(&state)) {
        let by_twist = jacobian.fixed_view::<2, 6>(0, 0);
        information += by_twist.transpose() * by_twist;
        chi2 += error.norm_squared();
        num += 1;
    }
    let freedoms = (2.0 * f64::from(num) - 6.0).max(1.0);
    let covariance = information.cholesky()?.inverse() * (chi2 / freedoms).max(1.0);
    covariance.iter().all(|value| value.is_finite()).then_some(covariance)
}

/// As [`pose_covariance`], where the points are off, too: each by a covariance of its own, in the world. The pose was found as if they were not.
#[must_use]
pub fn pose_covariance_among(
    pose: &CameraFromWorld,
    observations: &[(PoseObservation, Matrix3<f64>)],
) -> Option<Matrix6<f64>> {
    let state = State::new(pose);
    let (mut information, mut by_points) = (Matrix6::zeros(), Matrix6::zeros());
    for (observation, of_point) in observations {
        let Some((_, jacobian)) = observation.linearize(&state) else { continue };
        let by_twist = jacobian.fixed_view::<2, 6>(0, 0);
        let by_point = jacobian.fixed_view::<2, 3>(0, 0) * pose.rotation();
        let in_image = by_point * of_point * by_point.transpose();
        information += by_twist.transpose() * by_twist;
        by_points += by_twist.transpose() * in_image * by_twist;
    }
    let of_pixels = information.cholesky()?.inverse();
    let known: Vec<PoseObservation> = observations.iter().map(|(observation, _)| *observation).collect();
    let covariance = pose_covariance(pose, &known)? + of_pixels * by_points * of_pixels;
    covariance.iter().all(|value| value.is_finite()).then_some(covariance)
}

/// Standard deviation of the logarithm of the candidates' common scale before anything is seen.
const SCALE_SIGMA: f64 = 0.7;

/// What is known of a pose before anything is seen.
#[derive(Debug, Clone, Copy)]
pub struct PosePrior {
    expected_from_world: CameraFromWorld,
    /// Inverse variances along and about each axis.
    information: [f64; 2],
}

impl PosePrior {
    /// An expected pose with standard deviations, map units along each axis of the camera and radians about it.
    #[must_use]
    pub fn new(expected_from_world: CameraFromWorld, (length, angle_rad): (f64, f64)) -> Self {
        Self { expected_from_world, information: [length.powi(-2), angle_rad.powi(-2)] }
    }

    /// Adds its normal equations.
    fn add(&self, state: &State, hessian: &mut SMatrix<f64, 7, 7>, gradient: &mut SVector<f64, 7>) {
        let error = log(&(state.pose * self.expected_from_world.inverse()));
        for i in 0..6 {
            let information = self.information[i / 3];
            hessian[(i, i)] += information;
            gradient[i] -= information * error[i];
        }
    }
}

/// Size of a sample.
const SAMPLE_SIZE: usize = 5;
/// Probability of one sample without outliers.
const CONFIDENCE: f64 = 0.99;
/// Largest squared whitened residual of an inlier: three standard deviations.
const INLIER_CHI2: f64 = 9.0;
/// Factor on the residual (not squared) within which outliers get a second chance.
const RESCUE_FACTOR: f64 = 2.0;

/// How outliers are found. With neither nothing is rejected.
#[derive(Debug, Clone, Copy)]
pub struct Rejection {
    /// Most hypotheses that are drawn, if any are.
    pub max_hypotheses: Option<usize>,
    /// Whether observations are weighed by how well they fit.
    pub has_robust_weights: bool,
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

/// Gauss-Newton on the reprojection error over the selected observations and the prior, with Tukey's biweight (cut off at `cutoff` whitened
/// units) or, with an infinite cutoff, plain least squares.
#[must_use]
pub fn refine_pose(
    start: &State,
    prior: Option<&PosePrior>,
    observations: &[PoseObservation],
    is_used: impl Fn(usize) -> bool,
    cutoff: f64,
    max_iterations: usize,
) -> State {
    let mut state = *start;
    for _ in 0..max_iterations {
        let (mut hessian, mut gradient) = (SMatrix::<f64, 7, 7>::zeros(), SVector::<f64, 7>::zeros());
        for (_, observation) in observations.iter().enumerate().filter(|(i, _)| is_used(*i)) {
            let Some((error, jacobian)) = observation.linearize(&state) else { continue };
            let ratio2 = error.norm_squared() / (cutoff * cutoff);
            if ratio2 >= 1.0 {
                continue;
            }
            let weight = (1.0 - ratio2).powi(2);
            add_residual((&mut hessian, &mut gradient), &error, &jacobian, weight);
        }
        if let Some(prior) = prior {
            prior.add(&state, &mut hessian, &mut gradient);
        }
        hessian[(6, 6)] += 1.0 / (SCALE_SIGMA * SCALE_SIGMA);
        gradient[6] -= state.log_scale / (SCALE_SIGMA * SCALE_SIGMA);
        let Some(step) = solve_damped(hessian, &gradient, 1e-6) else { break };
        let twist = Vector6::from_fn(|i, _| step[i]);
        state.pose = moved(&twist, &state.pose);
        state.log_scale = (state.log_scale + step[6]).clamp(-3.0, 3.0);
        if twist.amax() < 1e-7 {
            break;
        }
    }
    state
}

/// As [`refine_pose`], but the camera only turns: its center stays where the start has it.
#[must_use]
pub fn refine_turn(
    start: &CameraFromWorld,
    observations: &[PoseObservation],
    is_used: impl Fn(usize) -> bool,
    cutoff: f64,
    max_iterations: usize,
) -> CameraFromWorld {
    let mut state = State::new(start);
    for _ in 0..max_iterations {
        let (mut hessian, mut gradient) = (Matrix3::zeros(), Vector3::zeros());
        for (_, observation) in observations.iter().enumerate().filter(|(i, _)| is_used(*i)) {
            let Some((error, jacobian)) = observation.linearize(&state) else { continue };
            let ratio2 = error.norm_squared() / (cutoff * cutoff);
            if ratio2 >= 1.0 {
                continue;
            }
            // A rotation in front of the pose leaves the center alone.
            let by_turn = jacobian.fixed_view::<2, 3>(0, 3);
            let weight = (1.0 - ratio2).powi(2);
            hessian += by_turn.transpose() * by_turn * weight;
            gradient -= by_turn.transpose() * error * weight;
        }
        hessian += Matrix3::identity() * 1e-9;
        let Some(turn) = hessian.cholesky().map(|c| c.solve(&gradient)) else { break };
        if !turn.iter().all(|v| v.is_finite()) {
            break;
        }
        state.pose = moved(&Vector6::new(0.0, 0.0, 0.0, turn.x, turn.y, turn.z), &state.pose);
        if turn.amax() < 1e-7 {
            break;
        }
    }
    state.pose
}

/// Pose with outliers rejected: hypotheses from small samples, least squares over the inliers of the best, rescue of outliers
/// within a larger threshold, least squares again. The start pose is the first hypothesis.
///
/// Source: Fischler and Bolles, "Random sample consensus", 1981, for the number of hypotheses.
#[must_use]
pub fn robust_pose(
    start: &CameraFromWorld,
    prior: Option<&PosePrior>,
    (observations, rejection): (&[PoseObservation], Rejection),
    rng: &mut Rng,
) -> RobustPose {
    let start = &State::new(start);
    let Rejection { max_hypotheses, has_robust_weights } = rejection;
    if max_hypotheses.is_none() && !has_robust_weights {
        let pose = refine_pose(start, prior, observations, |_| true, f64::INFINITY, 10).pose;
        let num_inliers = observations.len();
        return RobustPose { camera_from_world: pose, is_inlier: vec![true; num_inliers], num_inliers };
    }
    let limit = INLIER_CHI2;
    let cutoff = if has_robust_weights { 2.0 * limit.sqrt() } else { f64::INFINITY };
    // Wide first: the start may be off by several pixels.
    let wide = refine_pose(start, prior, observations, |_| true, 4.0 * cutoff, 5);
    let mut best = refine_pose(&wide, prior, observations, |_| true, cutoff, 5);
    let mut best_count = count_inliers(&best, observations, limit);
    let at_start = refine_pose(start, prior, observations, |_| true, cutoff, 5);
    let start_count = count_inliers(&at_start, observations, limit);
    if start_count > best_count {
        (best, best_count) = (at_start, start_count);
    }
    if let Some(most) = max_hypotheses.filter(|_| observations.len() >= 2 * SAMPLE_SIZE) {
        let mut drawn = 0;
        while drawn < needed_hypotheses(best_count as f64 / observations.len() as f64).min(most) {
            drawn += 1;
            let sample = draw(SAMPLE_SIZE, observations.len(), rng);
            let pose = refine_pose(start, prior, observations, |i| sample.contains(&i), f64::INFINITY, 5);
            let count = count_inliers(&pose, observations, limit);
            if count > best_count {
                (best, best_count) = (pose, count);
            }
        }
    }
    let is_inlier = mark(&best, observations, limit);
    let pose = refine_pose(&best, prior, observations, |i| is_inlier[i], cutoff, 5);
    let is_rescued = mark(&pose, observations, limit * RESCUE_FACTOR.powi(2));
    let pose = refine_pose(&pose, prior, observations, |i| is_rescued[i], cutoff, 10);
    let is_inlier = mark(&pose, observations, limit);
    let num_inliers = is_inlier.iter().filter(|is_inlier| **is_inlier).count();
    RobustPose { camera_from_world: pose.pose, is_inlier, num_inliers }
}

fn needed_hypotheses(inlier_ratio: f64) -> usize {
    let all_good = inlier_ratio.clamp(1e-3, 1.0 - 1e-9).powi(SAMPLE_SIZE as i32);
    let needed = (1.0 - CONFIDENCE).ln() / (1.0 - all_good).ln();
    needed.ceil() as usize
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

fn count_inliers(pose: &State, observations: &[PoseObservation], limit: f64) -> usize {
    observations.iter().filter(|observation| observation.chi2(pose) <= limit).count()
}

fn mark(pose: &State, observations: &[PoseObservation], limit: f64) -> Vec<bool> {
    observations.iter().map(|observation| observation.chi2(pose) <= limit).collect()
}

#[cfg(test)]
mod tests {
    use visloc_core::{
        RngTree, gaussian,
        geom::{Rigid3, World},
    };

    use super::*;
    use crate::lie::{exp, log};

    const REJECTION: Rejection = Rejection { max_hypotheses: Some(100), has_robust_weights: true };

    fn scene(seed: u64, outliers: f64) -> (CameraFromWorld, Vec<PoseObservation>) {
        let mut rng = RngTree::new(seed).stream("scene", 0);
        let truth = exp::<World>(&Vector6::new(0.3, -0.2, 0.1, 0.1, -0.2, 0.05));
        let truth =
            Rigid3::new(nalgebra::Rotation3::from_matrix_unchecked(*truth.rotation()), *truth.translation());
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
                PoseObservation::of_point(point, ray, Matrix2::identity() * 1000.0)
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
            let found = robust_pose(&start, None, (&observations, REJECTION), &mut rng);
            let error = log(&(found.camera_from_world * truth.inverse())).norm();
            assert!(error < 0.01, "seed {seed}: {error}");
            assert!((60..=85).contains(&found.num_inliers), "{}", found.num_inliers);
        }
    }

    #[test]
    fn without_samples_and_weights_every_outlier_counts() {
        let (truth, observations) = scene(3, 0.4);
        let find = |max_hypotheses, has_robust_weights| {
            let rejection = Rejection { max_hypotheses, has_robust_weights };
            let found = robust_pose(
                &truth,
                None,
                (&observations, rejection),
                &mut RngTree::new(3).stream("ransac", 0),
            );
            (log(&(found.camera_from_world * truth.inverse())).norm(), found.num_inliers)
        };
        let (error, num_inliers) = find(None, false);
        assert!(error > 0.01 && num_inliers == observations.len(), "{error} {num_inliers}");
        assert!(find(Some(100), false).0 < 0.01 && find(None, true).0 < 0.01);
    }

    #[test]
    fn jacobians_are_the_numeric_ones() {
        let (truth, observations) = scene(2, 0.0);
        let mut candidate = observations[3];
        candidate.direction_in_world = Vector3::new(0.1, 0.2, 1.0);
        candidate.anchor_in_world = Point3::new(0.3, -0.2, 0.1);
        candidate.inverse_depth = Some(0.3);
        for observation in [observations[0], observations[50], candidate] {
            let state = State { pose: truth, log_scale: 0.2 };
            let (_, analytic) = observation.linearize(&state).unwrap();
            for i in 0..7 {
                let shifted = |step: f64| {
                    let mut other = state;
                    if i < 6 {
                        let mut twist = Vector6::zeros();
                        twist[i] = step;
                        other.pose = moved(&twist, &state.pose);
                    } else {
                        other.log_scale += step;
                    }
                    observation.linearize(&other).unwrap().0
                };
                let numeric = (shifted(1e-6) - shifted(-1e-6)) / 2e-6;
                assert!((numeric - analytic.column(i)).norm() < 1e-3, "{i}: {numeric} {analytic}");
            }
        }
    }

    #[test]
    fn a_turn_is_found_and_the_center_stays() {
        for seed in 0..5 {
            let (truth, observations) = scene(seed, 0.1);
            let start = moved(&Vector6::new(0.0, 0.0, 0.0, 0.03, -0.02, 0.04), &truth);
            let found = refine_turn(&start, &observations, |_| true, 30.0, 10);
            let error = log(&(found * truth.inverse()));
            assert!(error.norm() < 1e-3, "seed {seed}: {error}");
            assert!((found.inverse().translation() - truth.inverse().translation()).norm() < 1e-9);
        }
    }

    #[test]
    fn a_few_known_points_set_the_scale_among_many_candidates() {
        let (truth, mut observations) = scene(5, 0.0);
        // Candidates made at the origin, all believed to be twice as near as they are.
        for observation in observations.iter_mut().skip(8) {
            let point = observation.anchor_in_world;
            observation.direction_in_world = point.coords / point.z;
            observation.anchor_in_world = Point3::origin();
            observation.inverse_depth = Some(2.0 / point.z);
        }
        let start = moved(&Vector6::new(0.01, -0.01, 0.01, 0.002, 0.002, 0.0), &truth);
        let mut rng = RngTree::new(5).stream("ransac", 0);
        let found = robust_pose(&start, None, (&observations, REJECTION), &mut rng);
        let error = (found.camera_from_world.translation() - truth.translation()).norm();
        assert!(error < 0.04, "{error}");
    }

    #[test]
    fn nothing_to_see_leaves_the_pose() {
        let (truth, _) = scene(1, 0.0);
        let mut rng = RngTree::new(1).stream("ransac", 0);
        let found = robust_pose(&truth, None, (&[], REJECTION), &mut rng);
        assert_eq!(found.num_inliers, 0);
        assert!(log(&(found.camera_from_world * truth.inverse())).norm() < 1e-9);
    }
}
