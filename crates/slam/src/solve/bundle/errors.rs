//! How far the cameras of a bundle may be off.

use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Matrix6, SMatrix, SVector, Vector2, Vector3};

use super::{
    Bundle,
    equations::{NormalEquations, linearize},
};
use crate::solve::SkylineFactor;

/// Smooth fields over the image: products of Legendre polynomials of both coordinates, of these degrees together. A constant one is a turn of the
/// camera; the fifth degree is that of the second radial coefficient of a lens.
const DEGREES: std::ops::RangeInclusive<usize> = 1..=5;
/// How many there are: 2 + 3 + 4 + 5 + 6.
const FIELDS: usize = 20;
/// Each shifts what is seen along two axes.
const SHIFTS: usize = 2 * FIELDS;
/// Share of what is known of all directions that is known of each: half of the digits of a number.
const LEAST: f64 = 1.5e-8;
/// A similarity moves all cameras alike.
const GAUGE: usize = 7;

/// How far the cameras of a bundle may be off.
///
/// Where the bundle lies, how it is turned and how large it is are no errors of it: errors are told against the similarity that brings all
/// cameras nearest to where they are. Source: Triggs et al., "Bundle adjustment: a modern synthesis", 1999, section 9.2 (inner constraints).
#[derive(Debug, Clone)]
pub struct BundleErrors {
    /// Covariance of the pose of each camera over a twist in its frame, translation first, if errors of observations were independent.
    pub cameras: Vec<Matrix6<f64>>,
    /// The same of the place of each point, if the cameras were not off.
    pub points: Vec<Matrix3<f64>>,
    /// Factor on variances since they are not: those of neighbors in the image and of one image after the other are alike and add up. At least 1.
    /// It is the mean square, in standard deviations, of smooth fields over the image by which residuals would be explained better, and none
    /// of which is there.
    /// Source: Kish, "Survey sampling", 1965, section 5.4 (design effect); Rao, "Large sample tests of statistical hypotheses", 1948 (score test).
    pub design_effect: f64,
}

impl Bundle {
    /// How far the cameras may be off where the bundle is. A camera of which nothing is seen is off by the prior, along each axis and about
    /// it. `None` if the equations have no solution.
    #[must_use]
    pub fn errors(&self, huber: f64, prior: (f64, f64)) -> Option<BundleErrors> {
        let equations = self.with_prior(huber, prior);
        let inverses = equations.point_inverses(LEAST);
        let reduced = equations.reduced(self, &inverses, 0.0);
        let factor = reduced.skyline().cholesky()?;
        let gauge = Gauge::of(self, prior, (&equations.slots, &factor))?;
        let camera = |(camera, slot): (usize, &Option<usize>)| {
            let own = slot.map_or_else(Matrix6::zeros, |slot| factor.inverse_block::<6>(6 * slot));
            gauge.in_middle(camera, *slot, own)
        };
        let cameras = equations.slots.iter().enumerate().map(camera).collect();
        let fields = Fields::of(self, huber, (&equations, &inverses));
        let design_effect = fields.mean_square(&factor, &reduced.vector).max(1.0);
        Some(BundleErrors { cameras, points: inverses, design_effect })
    }
}

impl Bundle {
    /// The equations of cameras that are off by the prior, along each axis and about it.
    fn with_prior(&self, huber: f64, prior: (f64, f64)) -> NormalEquations {
        let mut equations = NormalEquations::of(self, huber);
        for own in &mut equations.cameras {
            for i in 0..6 {
                own[(i, i)] += if i < 3 { prior.0 } else { prior.1 }.powi(-2);
            }
        }
        equations
    }

    /// Covariance of the parameters of the lens, if errors of observations were independent, with the same prior of the cameras as [`Bundle::errors`].
    #[must_use]
    pub fn lens_covariance(&self, huber: f64, prior: (f64, f64)) -> Option<DMatrix<f64>> {
        let equations = self.with_prior(huber, prior);
        let reduced = equations.reduced(self, &equations.point_inverses(LEAST), 0.0);
        let factor = reduced.skyline().cholesky()?;
        let (size, num) = (reduced.vector.len(), self.lens.len());
        let column = |i: usize| {
            let mut unit = DVector::zeros(size);
            unit[size - num + i] = 1.0;
            factor.solve(&unit)
        };
        let columns: Vec<DVector<f64>> = (0..num).map(column).collect();
        Some(DMatrix::from_fn(num, num, |i, j| columns[j][size - num + i]))
    }
}

/// Takes covariances from where one camera is held to where all of them are together.
struct Gauge {
    /// Twist of each camera by a similarity.
    by_similarity: Vec<SMatrix<f64, 6, GAUGE>>,
    /// What of a twist counts for the similarity, times the covariance where one camera is held; one for each free camera.
    correlations: DMatrix<f64>,
    /// The similarity by what counts for it.
    fit: SMatrix<f64, GAUGE, GAUGE>,
    /// Covariance of that.
    own: SMatrix<f64, GAUGE, GAUGE>,
}

impl Gauge {
    fn of(
        bundle: &Bundle,
        prior: (f64, f64),
        (slots, factor): (&[Option<usize>], &SkylineFactor),
    ) -> Option<Self> {
        let centers: Vec<Vector3<f64>> =
            bundle.cameras.iter().map(|pose| -(pose.rotation().transpose() * pose.translation())).collect();
        let middle = centers.iter().sum::<Vector3<f64>>() / centers.len().max(1) as f64;
        let twists = |(pose, center): (&_, &Vector3<f64>)| twists_by_similarity(pose, &(center - middle));
        let by_similarity: Vec<_> = bundle.cameras.iter().zip(&centers).map(twists).collect();
        // Lengths in units of the prior, so that places and turns count alike.
        let weights = SVector::<f64, 6>::from_fn(|i, _| if i < 3 { prior.0 } else { prior.1 }.powi(-2));
        let mut is_seeing = vec![false; bundle.cameras.len()];
        bundle.observations.iter().for_each(|observation| is_seeing[observation.camera] = true);
        let counts = |(twists, is_seeing): (&SMatrix<f64, 6, GAUGE>, &bool)| {
            // Where a camera is that sees nothing says nothing of the others.
            if *is_seeing { SMatrix::from_diagonal(&weights) * twists } else { SMatrix::zeros() }
        };
        let counting: Vec<SMatrix<f64, 6, GAUGE>> =
            by_similarity.iter().zip(&is_seeing).map(counts).collect();
        let num_free = slots.iter().flatten().count();
        let mut weighted = DMatrix::<f64>::zeros(6 * num_free, GAUGE);
        let mut fit = SMatrix::<f64, GAUGE, GAUGE>::zeros();
        for ((slot, counts), twists) in slots.iter().zip(&counting).zip(&by_similarity) {
            fit += counts.transpose() * twists;
            if let Some(slot) = slot {
                weighted.fixed_view_mut::<6, GAUGE>(6 * slot, 0).copy_from(counts);
            }
        }
        // Cameras at one place have no size.
        fit += SMatrix::identity() * (LEAST * fit.trace());
        let mut correlations = weighted.clone();
        for (column, mut solved) in weighted.column_iter().zip(correlations.column_iter_mut()) {
            solved.copy_from(&factor.solve(&column.into_owned()));
        }
        let own = SMatrix::from_fn(|i, j| weighted.column(i).dot(&correlations.column(j)));
        Some(Self { by_similarity, correlations, fit: fit.try_inverse()?, own })
    }

    /// Covariance of a camera whose covariance is given where another one is held.
    fn in_middle(&self, camera: usize, slot: Option<usize>, held: Matrix6<f64>) -> Matrix6<f64> {
        let moves = self.by_similarity[camera] * self.fit;
        let mut covariance = held + moves * self.own * moves.transpose();
        if let Some(slot) = slot {
            let cross = moves * self.correlations.fixed_view::<6, GAUGE>(6 * slot, 0).transpose();
            covariance -= cross + cross.transpose();
        }
        covariance
    }
}

/// Twists of a camera, whose center is given from the middle of all, by translation, rotation and growth of the world.
fn twists_by_similarity(pose: &crate::lie::CameraFromWorld, center: &Vector3<f64>) -> SMatrix<f64, 6, GAUGE> {
    let rotation = pose.rotation();
    let mut twists = SMatrix::<f64, 6, GAUGE>::zeros();
    // A center moves against the twist's translation.
    twists.fixed_view_mut::<3, 3>(0, 0).copy_from(&-rotation);
    twists.fixed_view_mut::<3, 3>(0, 3).copy_from(&(rotation * center.cross_matrix()));
    twists.fixed_view_mut::<3, 3>(3, 3).copy_from(&-rotation);
    twists.fixed_view_mut::<3, 1>(0, 6).copy_from(&-(rotation * center));
    twists
}

/// Equations of smooth fields over the image, with the points eliminated.
struct Fields {
    own: SMatrix<f64, SHIFTS, SHIFTS>,
    gradient: SVector<f64, SHIFTS>,
    by_camera: DMatrix<f64>,
}

impl Fields {
    fn of(bundle: &Bundle, huber: f64, (equations, inverses): (&NormalEquations, &[Matrix3<f64>])) -> Self {
        let most =
            bundle.observations.iter().fold(Vector2::zeros(), |most: Vector2<f64>, o| most.sup(&o.ray.abs()));
        let mut all = Self {
            own: SMatrix::zeros(),
            gradient: SVector::zeros(),
            by_camera: DMatrix::zeros(6 * equations.cameras.len(), SHIFTS),
        };
        equations.for_each_point(bundle, |start, group, free| {
            let mut by_point = SMatrix::<f64, 3, SHIFTS>::zeros();
            for (i, observation) in (start..).zip(group) {
                let Some(l) = linearize(bundle, i, observation, huber) else { continue };
                // Where it should be seen: where it is seen has the error that is asked for.
                let place = bundle.cameras[observation.camera].transform(&bundle.points[observation.point]);
                let place = Vector2::new(place.x / place.z, place.y / place.z);
                let shift = fields(&place.component_div(&most));
                let weighed = observation.whitening * l.weight;
                let point = l.by_point.transpose() * weighed;
                add_products::<3>(&point, &shift, |i, j, value| by_point[(i, j)] += value);
                all.add_own(&(observation.whitening.transpose() * weighed), &shift);
                let gradient = weighed.transpose() * l.error;
                (0..SHIFTS).for_each(|j| all.gradient[j] -= shift[j / 2] * gradient[j % 2]);
                if let Some(slot) = equations.slots[observation.camera] {
                    let camera = l.by_camera.transpose() * weighed;
                    let add = |i, j, value| all.by_camera[(6 * slot + i, j)] += value;
                    add_products::<6>(&camera, &shift, add);
                }
            }
            let point = group[0].point;
            let eliminated = inverses[point] * by_point;
            all.own -= by_point.transpose() * eliminated;
            all.gradient -= eliminated.transpose() * equations.point_gradient[point];
            for (slot, camera_by_point) in free {
                let mut own = all.by_camera.fixed_view_mut::<6, SHIFTS>(6 * slot, 0);
                own -= camera_by_point * eliminated;
            }
        });
        all
    }

    fn add_own(&mut self, information: &Matrix2<f64>, shift: &[f64; FIELDS]) {
        for (j, second) in shift.iter().enumerate() {
            for (i, first) in shift.iter().enumerate() {
                for (a, b) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    self.own[(2 * i + a, 2 * j + b)] += information[(a, b)] * first * second;
                }
            }
        }
    }

    /// Mean square of what the fields explain, standard deviations; 1 if they cannot be told apart.
    fn mean_square(&self, factor: &SkylineFactor, camera_gradient: &DVector<f64>) -> f64 {
        let mut solved = self.by_camera.clone();
        for (mut solved, column) in solved.column_iter_mut().zip(self.by_camera.column_iter()) {
            solved.copy_from(&factor.solve(&column.into_owned()));
        }
        let own = DMatrix::from_column_slice(SHIFTS, SHIFTS, self.own.as_slice())
            - self.by_camera.transpose() * &solved;
        let gradient =
            DVector::from_column_slice(self.gradient.as_slice()) - solved.transpose() * camera_gradient;
        own.cholesky().map_or(1.0, |own| gradient.dot(&own.solve(&gradient)) / SHIFTS as f64)
    }
}

/// Products of a matrix of two columns with all shifts, one after the other.
#[inline]
fn add_products<const N: usize>(
    matrix: &SMatrix<f64, N, 2>,
    shift: &[f64; FIELDS],
    mut add: impl FnMut(usize, usize, f64),
) {
    for (field, value) in shift.iter().enumerate() {
        for (axis, column) in matrix.column_iter().enumerate() {
            for (i, entry) in column.iter().enumerate() {
                add(i, 2 * field + axis, entry * value);
            }
        }
    }
}

/// The fields at a place of the image, from -1 to 1 on both axes.
fn fields(place: &Vector2<f64>) -> [f64; FIELDS] {
    let legendre = |x: f64| {
        let mut values = [1.0, x, 0.0, 0.0, 0.0, 0.0];
        for n in 2..values.len() {
            let m = n as f64;
            values[n] = ((2.0 * m - 1.0) * x * values[n - 1] - (m - 1.0) * values[n - 2]) / m;
        }
        values
    };
    let (along, down) = (legendre(place.x), legendre(place.y));
    let mut fields = [0.0; FIELDS];
    let of_degree = DEGREES.flat_map(|degree| (0..=degree).map(move |across| (across, degree - across)));
    for (field, (i, j)) in fields.iter_mut().zip(of_degree) {
        *field = along[i] * down[j];
    }
    fields
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Rotation3, Vector6};
    use rand::RngExt;
    use visloc_core::{RngTree, gaussian};

    use super::*;
    use crate::{
        lie::{CameraFromWorld, log},
        solve::{BundleObservation, BundleSettings},
    };

    const HUBER: f64 = 2.45;

    /// Cameras on an arc around points, and their truth. They look through a lens that nobody knows of.
    fn scene(seed: u64, lens: f64) -> (Bundle, Vec<CameraFromWorld>) {
        let mut rng = RngTree::new(seed).stream("errors", 0);
        let pose = |i: usize| {
            let angle = 0.1 * i as f64 - 0.45;
            let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), angle);
            CameraFromWorld::new(turn, Vector3::new(0.0, 0.0, 4.0))
        };
        let truth: Vec<CameraFromWorld> = (0..10).map(pose).collect();
        let mut bundle =
            Bundle { cameras: truth.clone(), is_free: (0..10).map(|i| i > 0).collect(), ..Bundle::default() };
        for point in 0..100 {
            let place = Point3::from(Vector3::from_fn(|_, _| rng.random_range(-1.2..1.2)));
            bundle.points.push(place);
            for (camera, pose) in truth.iter().enumerate() {
                let seen = pose.transform(&place);
                let mut ray = Vector2::new(seen.x / seen.z, seen.y / seen.z);
                ray *= 1.0 + lens * ray.norm_squared();
                ray += Vector2::from_fn(|_, _| gaussian(&mut rng, 0.001));
                let whitening = Matrix2::identity() * 1000.0;
                bundle.observations.push(BundleObservation { point, camera, ray, whitening });
            }
        }
        bundle.solve(&BundleSettings { max_iterations: 20, huber: HUBER });
        (bundle, truth)
    }

    /// Mean square of the errors of the cameras against the similarity that fits best, in standard deviations.
    fn mean_square(bundle: &Bundle, truth: &[CameraFromWorld], covariances: &[Matrix6<f64>]) -> f64 {
        let weights = Vector6::new(1.0 / 16.0, 1.0 / 16.0, 1.0 / 16.0, 1.0, 1.0, 1.0);
        let twist = |(found, truth): (&CameraFromWorld, &CameraFromWorld)| log(&(*found * truth.inverse()));
        let errors: Vec<Vector6<f64>> = bundle.cameras.iter().zip(truth).map(twist).collect();
        let center = |pose: &CameraFromWorld| *pose.inverse().translation();
        let middle = truth.iter().map(center).sum::<Vector3<f64>>() / truth.len() as f64;
        let moves: Vec<_> =
            truth.iter().map(|pose| twists_by_similarity(pose, &(center(pose) - middle))).collect();
        let (mut fit, mut all) = (SMatrix::<f64, GAUGE, GAUGE>::zeros(), SVector::<f64, GAUGE>::zeros());
        for (moves, error) in moves.iter().zip(&errors) {
            let counting = moves.transpose() * Matrix6::from_diagonal(&weights);
            fit += counting * moves;
            all += counting * error;
        }
        let similarity = fit.try_inverse().unwrap() * all;
        let of_one =
            |((error, moves), covariance): ((&Vector6<f64>, &SMatrix<f64, 6, GAUGE>), &Matrix6<f64>)| {
                let error = error - moves * similarity;
                error.dot(&(covariance.try_inverse().unwrap() * error)) / 6.0
            };
        errors.iter().zip(&moves).zip(covariances).map(of_one).sum::<f64>() / errors.len() as f64
    }

    #[test]
    fn cameras_are_off_as_far_as_is_said() {
        let (mut mean, seeds) = (0.0, 30);
        for seed in 0..seeds {
            let (bundle, truth) = scene(seed, 0.0);
            let errors = bundle.errors(HUBER, (4.0, 1.0)).unwrap();
            assert!(errors.design_effect < 2.5, "{}", errors.design_effect);
            mean += mean_square(&bundle, &truth, &errors.cameras) / seeds as f64;
        }
        assert!((0.8..1.25).contains(&mean), "{mean}");
    }

    #[test]
    fn errors_that_are_alike_in_all_images_add_up() {
        for seed in 0..10 {
            let (bundle, truth) = scene(seed, 0.3);
            let errors = bundle.errors(HUBER, (4.0, 1.0)).unwrap();
            let independent = mean_square(&bundle, &truth, &errors.cameras);
            let all = independent / errors.design_effect;
            assert!(independent > 2.0 && all < 2.0, "{independent} of {}", errors.design_effect);
        }
    }

    #[test]
    fn a_camera_that_sees_nothing_is_off_by_the_prior() {
        let (mut bundle, _) = scene(1, 0.0);
        bundle.observations.retain(|observation| observation.camera != 9);
        let errors = bundle.errors(HUBER, (4.0, 1.0)).unwrap();
        let unseen = errors.cameras[9].diagonal().map(f64::sqrt);
        assert!(unseen.rows(0, 3).iter().all(|sigma| (3.9..4.5).contains(sigma)), "{unseen}");
        assert!(errors.cameras[4].diagonal().map(f64::sqrt).amax() < 0.1);
    }
}
