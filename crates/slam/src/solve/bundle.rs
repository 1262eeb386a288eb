//! Bundle adjustment: cameras and points together.

use nalgebra::{
    DMatrix, DVector, Matrix2, Matrix2x3, Matrix2x6, Matrix3, Matrix3x6, Matrix6, Matrix6x3, Point3, Vector2,
    Vector3, Vector6,
};

use super::Skyline;
use crate::lie::{CameraFromWorld, image_by_twist, moved};

/// One measurement.
#[derive(Debug, Clone, Copy)]
pub struct BundleObservation {
    /// Index of the point.
    pub point: usize,
    /// Index of the camera.
    pub camera: usize,
    /// Where it is seen, on the plane z = 1 without distortion.
    pub ray: Vector2<f64>,
    /// Whitens a residual on that plane: square root of the inverse covariance.
    pub whitening: Matrix2<f64>,
}

/// Two cameras at the same place.
#[derive(Debug, Clone, Copy)]
pub struct BundleTie {
    /// Indices of the cameras.
    pub cameras: (usize, usize),
    /// Standard deviation of the distance of their centers along each axis, map units.
    pub sigma: f64,
}

/// How a bundle is solved.
#[derive(Debug, Clone, Copy)]
pub struct BundleSettings {
    /// Most Levenberg-Marquardt iterations.
    pub max_iterations: usize,
    /// Residual in standard deviations from which on Huber's cost is linear.
    pub huber: f64,
}

/// How it went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BundleReport {
    /// Iterations done.
    pub iterations: usize,
    /// Cost at the start: half the sum of Huber's function of the whitened residuals.
    pub first_cost: f64,
    /// Cost at the end.
    pub last_cost: f64,
}

/// Cameras, points and what the cameras see. Source: Triggs et al., "Bundle adjustment: a modern synthesis", 1999, section 6.1
/// (Schur complement).
#[derive(Debug, Clone, Default)]
pub struct Bundle {
    /// Poses of the cameras.
    pub cameras: Vec<CameraFromWorld>,
    /// Whether a camera may move; one entry for each camera.
    pub is_free: Vec<bool>,
    /// Places of the points.
    pub points: Vec<Point3<f64>>,
    /// Measurements, ordered by point.
    pub observations: Vec<BundleObservation>,
    /// Cameras that are known to be at the same place.
    pub ties: Vec<BundleTie>,
}

impl BundleTie {
    /// Distance of the centers in standard deviations.
    fn residual(&self, cameras: &[CameraFromWorld]) -> Vector3<f64> {
        let center = |camera: usize| {
            let pose = &cameras[camera];
            -(pose.rotation().transpose() * pose.translation())
        };
        (center(self.cameras.0) - center(self.cameras.1)) / self.sigma
    }
}

/// Normal equations with the points eliminated, and what is needed to get the points back.
struct Reduced {
    matrix: DMatrix<f64>,
    vector: DVector<f64>,
    point_inverse: Vec<Matrix3<f64>>,
    point_gradient: Vec<Vector3<f64>>,
    camera_by_point: Vec<Matrix6x3<f64>>,
}

/// A residual with its derivatives, weighted.
struct Linearized {
    error: Vector2<f64>,
    by_camera: Matrix2x6<f64>,
    by_point: Matrix2x3<f64>,
    weight: f64,
}

impl Bundle {
    /// Whitened residual of an observation; `None` behind the camera.
    #[inline]
    #[must_use]
    pub fn residual(&self, observation: &BundleObservation) -> Option<Vector2<f64>> {
        residual_of(&self.cameras[observation.camera], &self.points[observation.point], observation)
    }

    /// Minimizes Huber's cost of all residuals.
    pub fn solve(&mut self, settings: &BundleSettings) -> BundleReport {
        let slots = self.slots();
        let first_cost = self.cost(&self.cameras, &self.points, settings.huber);
        let mut report = BundleReport { iterations: 0, first_cost, last_cost: first_cost };
        let mut damping = 1e-4;
        while report.iterations < settings.max_iterations {
            report.iterations += 1;
            let reduced = self.reduce(&slots, damping, settings.huber);
            let Some(step) = solve_reduced(&reduced.matrix, &reduced.vector) else {
                damping *= 10.0;
                continue;
            };
            let (cameras, points) = self.stepped(&slots, &reduced, &step);
            let new_cost = self.cost(&cameras, &points, settings.huber);
            if new_cost.is_nan() || new_cost >= report.last_cost {
                damping *= 10.0;
                if damping > 1e6 {
                    break;
                }
                continue;
            }
            (self.cameras, self.points) = (cameras, points);
            let gain = (report.last_cost - new_cost) / report.last_cost;
            report.last_cost = new_cost;
            damping = (damping * 0.2).max(1e-9);
            if gain < 1e-4 {
                break;
            }
        }
        report
    }

    fn cost(&self, cameras: &[CameraFromWorld], points: &[Point3<f64>], huber: f64) -> f64 {
        let of_ties = self.ties.iter().map(|tie| 0.5 * tie.residual(cameras).norm_squared()).sum::<f64>();
        cost(cameras, points, &self.observations, huber) + of_ties
    }

    /// Adds the normal equations of the ties.
    fn add_ties(
        &self,
        slots: &[Option<usize>],
        diagonal: &mut [Matrix6<f64>],
        gradient: &mut [Vector6<f64>],
        blocks: &mut [Matrix6<f64>],
    ) {
        for tie in &self.ties {
            let error = tie.residual(&self.cameras);
            let (first, second) = tie.cameras;
            let jacobians = [(first, -1.0), (second, 1.0)].map(|(camera, sign)| {
                // The center moves against the twist's translation: c = -R' t.
                let mut jacobian = Matrix3x6::zeros();
                let by_translation = self.cameras[camera].rotation().transpose() * (sign / tie.sigma);
                jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&by_translation);
                (slots[camera], jacobian)
            });
            for (slot, jacobian) in &jacobians {
                let Some(slot) = *slot else { continue };
                diagonal[slot] += jacobian.transpose() * jacobian;
                gradient[slot] -= jacobian.transpose() * error;
            }
            if let [(Some(a), by_a), (Some(b), by_b)] = &jacobians {
                let block = by_a.transpose() * by_b;
                let (row, column) = ((*a).min(*b), (*a).max(*b));
                blocks[row * diagonal.len() + column] += if a < b { block } else { block.transpose() };
            }
        }
    }

    /// Position of each free camera among the unknowns.
    fn slots(&self) -> Vec<Option<usize>> {
        let mut next = 0;
        let mut slot = |is_free: &bool| {
            is_free.then(|| {
                next += 1;
                next - 1
            })
        };
        self.is_free.iter().map(&mut slot).collect()
    }

    fn linearize(&self, observation: &BundleObservation, huber: f64) -> Option<Linearized> {
        let camera = &self.cameras[observation.camera];
        let point = camera.transform(&self.points[observation.point]);
        let error = residual_of(camera, &self.points[observation.point], observation)?;
        let norm = error.norm();
        let weight = if norm > huber { huber / norm } else { 1.0 };
        let inv_z = 1.0 / point.z;
        let (x, y) = (point.x * inv_z, point.y * inv_z);
        let by_point_in_camera =
            observation.whitening * Matrix2x3::new(inv_z, 0.0, -x * inv_z, 0.0, inv_z, -y * inv_z);
        Some(Linearized {
            error,
            by_camera: image_by_twist(&by_point_in_camera, &point.coords),
            by_point: by_point_in_camera * camera.rotation(),
            weight,
        })
    }

    fn reduce(&self, slots: &[Option<usize>], damping: f64, huber: f64) -> Reduced {
        let num_free = slots.iter().flatten().count();
        let mut diagonal = vec![Matrix6::zeros(); num_free];
        let mut gradient = vec![Vector6::zeros(); num_free];
        let mut blocks = vec![Matrix6::zeros(); num_free * num_free];
        let mut reduced = Reduced {
            matrix: DMatrix::zeros(6 * num_free, 6 * num_free),
            vector: DVector::zeros(6 * num_free),
            point_inverse: vec![Matrix3::zeros(); self.points.len()],
            point_gradient: vec![Vector3::zeros(); self.points.len()],
            camera_by_point: vec![Matrix6x3::zeros(); self.observations.len()],
        };
        let mut start = 0;
        for group in self.observations.chunk_by(|a, b| a.point == b.point) {
            let point = group[0].point;
            let (mut hessian, mut point_gradient) = (Matrix3::zeros(), Vector3::zeros());
            for (i, observation) in group.iter().enumerate() {
                let Some(l) = self.linearize(observation, huber) else { continue };
                hessian += l.by_point.transpose() * l.by_point * l.weight;
                point_gradient -= l.by_point.transpose() * l.error * l.weight;
                if let Some(slot) = slots[observation.camera] {
                    diagonal[slot] += l.by_camera.transpose() * l.by_camera * l.weight;
                    gradient[slot] -= l.by_camera.transpose() * l.error * l.weight;
                    reduced.camera_by_point[start + i] = l.by_camera.transpose() * l.by_point * l.weight;
                }
            }
            for i in 0..3 {
                hessian[(i, i)] = hessian[(i, i)] * (1.0 + damping) + 1e-12;
            }
            let inverse = hessian.try_inverse().unwrap_or_else(Matrix3::zeros);
            for (i, first) in group.iter().enumerate() {
                let Some(slot) = slots[first.camera] else { continue };
                let product = reduced.camera_by_point[start + i] * inverse;
                gradient[slot] -= product * point_gradient;
                for (j, second) in group.iter().enumerate() {
                    let Some(other) = slots[second.camera].filter(|other| *other >= slot) else { continue };
                    blocks[slot * num_free + other] -=
                        product * reduced.camera_by_point[start + j].transpose();
                }
            }
            reduced.point_inverse[point] = inverse;
            reduced.point_gradient[point] = point_gradient;
            start += group.len();
        }
        self.add_ties(slots, &mut diagonal, &mut gradient, &mut blocks);
        assemble(&mut reduced, &diagonal, &gradient, &blocks, damping);
        reduced
    }

    fn stepped(
        &self,
        slots: &[Option<usize>],
        reduced: &Reduced,
        step: &DVector<f64>,
    ) -> (Vec<CameraFromWorld>, Vec<Point3<f64>>) {
        let twist = |slot: usize| Vector6::from_fn(|i, _| step[6 * slot + i]);
        let cameras = self.cameras.iter().zip(slots);
        let cameras =
            cameras.map(|(camera, slot)| slot.map_or(*camera, |slot| moved(&twist(slot), camera))).collect();
        let mut right = reduced.point_gradient.clone();
        for (observation, by_point) in self.observations.iter().zip(&reduced.camera_by_point) {
            if let Some(slot) = slots[observation.camera] {
                right[observation.point] -= by_point.transpose() * twist(slot);
            }
        }
        let steps = right.iter().zip(&reduced.point_inverse).map(|(right, inverse)| inverse * right);
        let points = self.points.iter().zip(steps).map(|(point, step)| point + step).collect();
        (cameras, points)
    }
}

/// Cameras from which on most of them share no point, so that most blocks are zero.
const MANY_CAMERAS: usize = 40;

fn solve_reduced(matrix: &DMatrix<f64>, vector: &DVector<f64>) -> Option<DVector<f64>> {
    if vector.len() > 6 * MANY_CAMERAS {
        return Skyline::of(matrix).solve(vector);
    }
    matrix.clone().cholesky().map(|c| c.solve(vector))
}

fn assemble(
    reduced: &mut Reduced,
    diagonal: &[Matrix6<f64>],
    gradient: &[Vector6<f64>],
    blocks: &[Matrix6<f64>],
    damping: f64,
) {
    let num_free = diagonal.len();
    for i in 0..num_free {
        reduced.vector.fixed_rows_mut::<6>(6 * i).copy_from(&gradient[i]);
        for j in i..num_free {
            let mut block = blocks[i * num_free + j];
            if i == j {
                let mut own = diagonal[i];
                for k in 0..6 {
                    own[(k, k)] = own[(k, k)] * (1.0 + damping) + 1e-9;
                }
                block += own;
            }
            reduced.matrix.fixed_view_mut::<6, 6>(6 * i, 6 * j).copy_from(&block);
            reduced.matrix.fixed_view_mut::<6, 6>(6 * j, 6 * i).copy_from(&block.transpose());
        }
    }
}

#[inline]
fn residual_of(
    camera: &CameraFromWorld,
    point: &Point3<f64>,
    observation: &BundleObservation,
) -> Option<Vector2<f64>> {
    let point = camera.transform(point);
    if point.z <= 1e-9 {
        return None;
    }
    let inv_z = 1.0 / point.z;
    Some(observation.whitening * (Vector2::new(point.x * inv_z, point.y * inv_z) - observation.ray))
}

fn cost(
    cameras: &[CameraFromWorld],
    points: &[Point3<f64>],
    observations: &[BundleObservation],
    huber: f64,
) -> f64 {
    let cost_of = |observation: &BundleObservation| {
        let camera = &cameras[observation.camera];
        // A point behind a camera costs as much as a gross outlier.
        let norm =
            residual_of(camera, &points[observation.point], observation).map_or(100.0 * huber, |e| e.norm());
        if norm > huber { huber * (norm - 0.5 * huber) } else { 0.5 * norm * norm }
    };
    observations.iter().map(cost_of).sum()
}

#[cfg(test)]
mod tests;
