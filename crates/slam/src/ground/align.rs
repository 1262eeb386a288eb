//! Alignment of two images of the ground by their brightness.

use nalgebra::{
    Matrix2, Matrix2x3, Matrix3x2, Matrix5, Point2, Point3, Rotation3, SMatrix, Vector3, Vector5,
};
use visloc_core::{
    Frame, GrayImage, Timestamp,
    geom::{Camera, CameraFrame, PlanarPose, Rigid3, Robot},
};

use crate::image::{Pyramid, px_from_level, sample_square};

/// Levels of the pyramid: on the coarsest a pixel is eight, and a turn of a degree in an image of 320 pixels shifts it by less than one.
const LEVELS: usize = 4;
/// Most points of a level: neighboring pixels say the same.
const MAX_POINTS: usize = 1000;
/// With fewer points in both images a level says nothing.
const MIN_POINTS: usize = 40;
/// Ground farther away than this is not used, in heights of the camera: there, an error of half a degree in the camera's direction
/// changes a distance by more than 7 %.
const MAX_RANGE: f64 = 8.0;
/// Iterations of each level; most need three.
const MAX_ITERATIONS: usize = 10;
/// A smaller step ends the iterations, meters and radians.
const SMALL_STEP: f64 = 1e-5;
/// Errors of neighboring pixels are alike: all of an image count as at most so many. By trial on one rendered tour, of 1,000 points.
const MAX_INDEPENDENT: f64 = 300.0;
/// A robot changes its speed by so much, meters per squared second.
const ACCELERATION_M_PER_S2: f64 = 9.0;
/// And its turning, radians per squared second.
const TURN_ACCELERATION_RAD_PER_S2: f64 = 45.0;
/// Error of the camera's direction that changes from one image to the next, radians, about the axes to the right and ahead.
const TILT_NOISE_RAD: f64 = 0.004;
/// Residuals beyond this, in standard deviations, count less (Huber), and beyond that not at all: they are no ground.
const HUBER: f64 = 1.345;
const OUTLIER: f64 = 5.0;
/// Quantization of brightness, gray levels.
const LEAST_NOISE: f32 = 0.3;

/// What a robot sees of the ground at one time.
#[derive(Debug, Clone)]
pub(super) struct View {
    pub at: Timestamp,
    pyramid: Pyramid,
    camera: Camera,
    robot_from_camera: Rigid3<Robot, CameraFrame>,
}

impl View {
    pub fn new(frame: &Frame) -> Self {
        Self {
            at: frame.at,
            pyramid: Pyramid::new(GrayImage::from_rgb(&frame.image), LEVELS),
            camera: frame.camera,
            robot_from_camera: frame.robot_from_camera,
        }
    }

    /// Points of the ground on a level, spread evenly over the image.
    fn collect(&self, level: usize, out: &mut Vec<GroundPoint>) {
        out.clear();
        let image = self.pyramid.level(level);
        let eye = self.robot_from_camera.translation();
        let step = (image.width() * image.height()).div_ceil(MAX_POINTS).isqrt().max(1);
        for y in (step / 2..image.height()).step_by(step) {
            for x in (step / 2..image.width()).step_by(step) {
                #[allow(clippy::cast_precision_loss)]
                let px = px_from_level(&Point2::new(x as f64, y as f64), level);
                let ray = self.robot_from_camera.rotate(&self.camera.bearing(&px));
                if eye.z <= 0.0 || -ray.z * MAX_RANGE < ray.xy().norm() {
                    continue;
                }
                let at = eye - ray * (eye.z / ray.z);
                out.push(GroundPoint { at: at.xy().into(), gray: f32::from(image.row(y)[x]) });
            }
        }
    }
}

/// A point of the ground.
#[derive(Debug, Clone, Copy)]
struct GroundPoint {
    /// Seen from the robot, meters.
    at: Point2<f64>,
    gray: f32,
}

/// How the robot moved from one view to another.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    /// The robot in the second view, seen from where it was in the first.
    pub motion: PlanarPose,
    /// Standard deviation of the position, the larger axis, meters.
    pub spread_m: f64,
    /// Standard deviation of the heading, radians.
    pub spread_rad: f64,
    /// Standard deviation of the brightness of the ground between both, gray levels.
    pub noise: f64,
    /// Distance from the guess, in standard deviations of what a robot changes its motion by in the time between both.
    pub surprise: f64,
}

/// Aligns views; keeps its buffers.
#[derive(Debug, Clone, Default)]
pub(super) struct Aligner {
    points: Vec<GroundPoint>,
    rows: Vec<Row>,
    sorted: Vec<f32>,
}

/// Residual of a point and its derivatives by motion and tilt.
#[derive(Debug, Clone, Copy)]
struct Row {
    residual: f32,
    /// Squared slope of the brightness, mean of both axes, squared gray levels per squared pixel of the level.
    squared_slope: f32,
    jacobian: Vector5<f64>,
}

impl Aligner {
    /// The motion that makes the ground look alike in both views, near a guess: planar motion and a small tilt of the camera, by
    /// Gauss-Newton from coarse to fine. `None` if too little ground is in both.
    pub fn align(&mut self, from: &View, to: &View, guess: &PlanarPose) -> Option<Fit> {
        let secs = to.at.secs_since(from.at);
        let spread = [
            ACCELERATION_M_PER_S2 * secs * secs,
            ACCELERATION_M_PER_S2 * secs * secs,
            TURN_ACCELERATION_RAD_PER_S2 * secs * secs,
            TILT_NOISE_RAD,
            TILT_NOISE_RAD,
        ];
        let prior = Matrix5::from_diagonal(&Vector5::from(spread).map(|sigma| sigma.powi(-2)));
        let start = Vector5::new(guess.x_m, guess.y_m, guess.yaw_rad, 0.0, 0.0);
        let (mut state, mut fit) = (start, None);
        for level in (0..from.pyramid.num_levels().min(to.pyramid.num_levels())).rev() {
            from.collect(level, &mut self.points);
            for _ in 0..MAX_ITERATIONS {
                self.linearize(to, level, &state);
                if self.rows.len() < MIN_POINTS {
                    break;
                }
                let noise = self.center();
                let (hessian, gradient) = self.normal_equations(noise);
                let hessian = hessian + prior;
                let Some(cholesky) = hessian.cholesky() else { break };
                let step = cholesky.solve(&(gradient + prior * (state - start)));
                state -= step;
                let covariance = cholesky.inverse();
                fit = Some((level, covariance, noise));
                if step.amax() < SMALL_STEP {
                    break;
                }
            }
        }
        // Coarse levels alone leave several pixels open.
        let (_, covariance, noise) = fit.filter(|(level, ..)| *level == 0)?;
        let change = (state - start).fixed_rows::<3>(0).into_owned();
        let surprise = (prior.fixed_view::<3, 3>(0, 0) * change).dot(&change).sqrt();
        Some(Fit {
            motion: PlanarPose::new(state[0], state[1], state[2]),
            spread_m: covariance[(0, 0)].max(covariance[(1, 1)]).sqrt(),
            spread_rad: covariance[(2, 2)].sqrt(),
            noise: f64::from(noise),
            surprise,
        })
    }

    /// Residuals of all points that are in the second view, and their derivatives.
    fn linearize(&mut self, to: &View, level: usize, state: &Vector5<f64>) {
        self.rows.clear();
        let image = to.pyramid.level(level);
        let scale = 1.0 / f64::from(1_u32 << level);
        let (sin, cos) = state[2].sin_cos();
        let turn = Matrix2::new(cos, sin, -sin, cos);
        let tilt = Rotation3::from_scaled_axis(Vector3::new(state[3], 0.0, state[4]));
        let camera_from_robot = tilt.matrix() * to.robot_from_camera.rotation().transpose();
        let on_ground: Matrix3x2<f64> = camera_from_robot.fixed_columns::<2>(0).into();
        let eye = to.robot_from_camera.translation();
        let mut around = [0.0_f32; 9];
        for point in &self.points {
            let from_robot = point.at.coords - state.fixed_rows::<2>(0);
            let seen = turn * from_robot;
            let in_camera = camera_from_robot * (Vector3::new(seen.x, seen.y, 0.0) - eye);
            let Ok((px, by_point)) = to.camera.project_with_jacobian(&Point3::from(in_camera)) else {
                continue;
            };
            #[allow(clippy::cast_possible_truncation)]
            let (left, top) = (((px.x + 0.5) * scale - 1.5) as f32, ((px.y + 0.5) * scale - 1.5) as f32);
            if sample_square::<3>(image, left, top, &mut around).is_none() {
                continue;
            }
            let (across, down) = (0.5 * (around[5] - around[3]), 0.5 * (around[7] - around[1]));
            let slope = SMatrix::<f64, 1, 2>::new(f64::from(across) * scale, f64::from(down) * scale);
            let by_point: Matrix2x3<f64> = by_point;
            let by_camera = slope * by_point;
            let by_ground = by_camera * on_ground;
            // The point moves against the robot, and turns against it.
            let by_position = -(by_ground * turn);
            let by_turn = by_ground * nalgebra::Vector2::new(seen.y, -seen.x);
            let right = by_camera * Vector3::new(0.0, -in_camera.z, in_camera.y);
            let ahead = by_camera * Vector3::new(-in_camera.y, in_camera.x, 0.0);
            let jacobian = Vector5::new(by_position[0], by_position[1], by_turn[0], right[0], ahead[0]);
            let squared_slope = 0.5 * (across * across + down * down);
            self.rows.push(Row { residual: around[4] - point.gray, squared_slope, jacobian });
        }
    }

    /// Takes the median from all residuals, since the light may change; returns their robust standard deviation.
    fn center(&mut self) -> f32 {
        self.sorted.clear();
        self.sorted.extend(self.rows.iter().map(|row| row.residual));
        let middle = self.sorted.len() / 2;
        let median = *self.sorted.select_nth_unstable_by(middle, f32::total_cmp).1;
        self.rows.iter_mut().for_each(|row| row.residual -= median);
        self.sorted.iter_mut().for_each(|residual| *residual = (*residual - median).abs());
        let deviation = *self.sorted.select_nth_unstable_by(middle, f32::total_cmp).1;
        1.4826 * deviation + LEAST_NOISE
    }

    fn normal_equations(&self, noise: f32) -> (Matrix5<f64>, Vector5<f64>) {
        let (mut hessian, mut gradient) = (Matrix5::zeros(), Vector5::zeros());
        let noise = f64::from(noise);
        let mut squared_slopes = 0.0;
        for Row { residual, squared_slope, jacobian } in &self.rows {
            squared_slopes += f64::from(*squared_slope);
            let residual = f64::from(*residual);
            let size = residual.abs() / noise;
            if size > OUTLIER {
                continue;
            }
            let weight = if size > HUBER { HUBER / size } else { 1.0 };
            hessian.syger(weight, jacobian, jacobian, 1.0);
            gradient.axpy(weight * residual, jacobian, 1.0);
        }
        hessian.fill_upper_triangle_with_lower_triangle();
        #[allow(clippy::cast_precision_loss)]
        let num_points = self.rows.len() as f64;
        // The residuals have the noise of two images, the slopes that of half of one: so much slope is there without any texture, and
        // tells nothing.
        let of_texture = 1.0 - 0.25 * noise * noise * num_points / squared_slopes.max(1e-9);
        let share = of_texture.max(0.0) * (MAX_INDEPENDENT / num_points).min(1.0) / (noise * noise);
        (hessian * share, gradient * share)
    }
}
