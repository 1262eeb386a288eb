//! Normal equations of a bundle.

use nalgebra::{
    DMatrix, DVector, Matrix2x3, Matrix2x6, Matrix3, Matrix3x6, Matrix6, Matrix6x3, SMatrix, SVector,
    Vector2, Vector3, Vector6,
};

use super::{Bundle, BundleLens, BundleObservation, residual_of};
use crate::{
    lie::{adjoint, image_by_twist},
    solve::Skyline,
};

/// The equations at one state, without damping. Steps of any damping can be had from them.
pub struct NormalEquations {
    /// Position of each free camera among the unknowns.
    pub(super) slots: Vec<Option<usize>>,
    pub(super) cameras: Vec<Matrix6<f64>>,
    pub(super) camera_gradient: Vec<Vector6<f64>>,
    /// Blocks of two different cameras, from the ties: row, column and block, row first.
    between: Vec<(usize, usize, Matrix6<f64>)>,
    points: Vec<Matrix3<f64>>,
    pub(super) point_gradient: Vec<Vector3<f64>>,
    /// One for each observation of a free camera, in order, if there are not too many cameras: those of a whole map are worked out when
    /// they are asked for, since they would take as much memory as the map.
    camera_by_point: Option<Vec<Matrix6x3<f64>>>,
    huber: f64,
    lens: Vec<LensEquations>,
}

/// What a parameter of the lens adds.
#[derive(Clone)]
struct LensEquations {
    /// With itself and with the parameters before it.
    own: Vec<f64>,
    gradient: f64,
    by_camera: Vec<Vector6<f64>>,
    by_point: Vec<Vector3<f64>>,
}

/// A step of all unknowns.
pub struct Step {
    /// Twist of each camera; `None` for one that may not move.
    pub cameras: Vec<Option<Vector6<f64>>>,
    /// Step of each point.
    pub points: Vec<Vector3<f64>>,
    /// Change of each parameter of the lens.
    pub lens: Vec<f64>,
}

/// A residual with its derivatives, weighted.
pub struct Linearized {
    pub(super) error: Vector2<f64>,
    pub by_camera: Matrix2x6<f64>,
    pub by_point: Matrix2x3<f64>,
    /// The residual on the plane z = 1, not whitened.
    off: Vector2<f64>,
    pub(super) weight: f64,
}

/// Cameras from which on most of them share no point, so that most blocks are zero.
const MANY_CAMERAS: usize = 40;

/// The equations of cameras and lens, with the points eliminated.
pub struct Reduced {
    num_free: usize,
    /// Those on and above the diagonal, row by row.
    blocks: Vec<Matrix6<f64>>,
    /// Of each parameter of the lens the blocks with the cameras, and with the parameters up to itself.
    lens: Vec<LensEquations>,
    /// The right side.
    pub(super) vector: DVector<f64>,
}

impl Reduced {
    /// Where the block of two cameras is, the lower one first.
    #[inline]
    fn at(num_free: usize, row: usize, column: usize) -> usize {
        row * num_free - row * (row + 1) / 2 + column
    }

    /// An entry of the lower triangle, the only one that decompositions read.
    #[inline]
    fn entry(&self, row: usize, column: usize) -> f64 {
        // Parameters of the lens come last.
        let num_of_cameras = self.vector.len() - self.lens.len();
        let parameters = [row, column].map(|at| at.checked_sub(num_of_cameras));
        let [(row, below), (column, right)] = [row, column].map(|at| (at / 6, at % 6));
        match parameters {
            [Some(row), Some(column)] => self.lens[row].own[column],
            [Some(row), None] => self.lens[row].by_camera[column][right],
            _ => self.blocks[Self::at(self.num_free, column, row)][(right, below)],
        }
    }

    /// The matrix without the zeros before the first entry of each row.
    pub(super) fn skyline(&self) -> Skyline {
        Skyline::of(self.vector.len(), |row, column| self.entry(row, column))
    }

    fn solve(self) -> Option<DVector<f64>> {
        let size = self.vector.len();
        if self.num_free > MANY_CAMERAS {
            let skyline = self.skyline();
            let Self { vector, .. } = self;
            return skyline.solve(&vector);
        }
        let mut matrix = DMatrix::zeros(size, size);
        for column in 0..size {
            (column..size).for_each(|row| matrix[(row, column)] = self.entry(row, column));
        }
        Some(matrix.cholesky()?.solve(&self.vector))
    }
}

impl NormalEquations {
    /// Of a bundle that is linearized later, see [`NormalEquations::set`].
    pub fn empty(bundle: &Bundle) -> Self {
        Self {
            slots: slots(&bundle.is_free),
            cameras: Vec::new(),
            camera_gradient: Vec::new(),
            between: Vec::new(),
            points: Vec::new(),
            point_gradient: Vec::new(),
            camera_by_point: None,
            huber: 0.0,
            lens: Vec::new(),
        }
    }

    /// Linearizes all residuals.
    pub fn of(bundle: &Bundle, huber: f64) -> Self {
        let mut equations = Self::empty(bundle);
        equations.set(bundle, huber);
        equations
    }

    /// Linearizes all residuals of the bundle that this one was made for, each time in the same memory.
    pub fn set(&mut self, bundle: &Bundle, huber: f64) {
        let num_free = self.slots.iter().flatten().count();
        let num_points = bundle.points.len();
        let of_lens = |(i, lens): (usize, &BundleLens)| {
            let information = 1.0 / (lens.sigma * lens.sigma);
            let mut own = vec![0.0; i + 1];
            own[i] = information;
            LensEquations {
                own,
                gradient: (lens.expected - lens.change) * information,
                by_camera: vec![Vector6::zeros(); num_free],
                by_point: vec![Vector3::zeros(); num_points],
            }
        };
        self.lens = bundle.lens.iter().enumerate().map(of_lens).collect();
        self.between.clear();
        set_zeros(&mut self.cameras, num_free);
        set_zeros(&mut self.camera_gradient, num_free);
        set_zeros(&mut self.points, num_points);
        set_zeros(&mut self.point_gradient, num_points);
        self.huber = huber;
        let mut kept = self.camera_by_point.take().unwrap_or_default();
        kept.clear();
        let are_kept = num_free <= MANY_CAMERAS;
        for (i, observation) in bundle.observations.iter().enumerate() {
            let linearized = linearize(bundle, i, observation, huber);
            if let Some(linearized) = &linearized {
                self.add(observation, linearized);
                self.add_lens(&bundle.lens, i, observation, linearized);
            }
            if are_kept && self.slots[observation.camera].is_some() {
                kept.push(linearized.map_or_else(Matrix6x3::zeros, |l| l.camera_by_point()));
            }
        }
        self.camera_by_point = are_kept.then_some(kept);
        self.add_ties(bundle);
        self.add_motions(bundle);
    }

    #[inline]
    fn add(&mut self, observation: &BundleObservation, l: &Linearized) {
        let point = observation.point;
        let by_point = rows_of(&l.by_point);
        add_square(&mut self.points[point], &by_point, l.weight);
        subtract_gradient(&mut self.point_gradient[point], &by_point, l);
        let slot = self.slots[observation.camera];
        if let Some(slot) = slot {
            let by_camera = rows_of(&l.by_camera);
            add_symmetric(&mut self.cameras[slot], &by_camera, l.weight);
            subtract_gradient(&mut self.camera_gradient[slot], &by_camera, l);
        }
    }

    #[inline]
    fn add_lens(&mut self, lens: &[BundleLens], i: usize, observation: &BundleObservation, l: &Linearized) {
        let by_lens = |lens: &BundleLens| {
            let of_size = lens.size_by_change.get(i).map_or_else(Vector2::zeros, |size| size * l.off);
            -observation.whitening * (lens.ray_by_change[i] + of_size)
        };
        let slot = self.slots[observation.camera];
        for (equations, parameter) in self.lens.iter_mut().zip(lens) {
            let by_parameter = by_lens(parameter);
            for (own, other) in equations.own.iter_mut().zip(lens) {
                *own += by_parameter.dot(&by_lens(other)) * l.weight;
            }
            equations.gradient -= by_parameter.dot(&l.error) * l.weight;
            equations.by_point[observation.point] += l.by_point.transpose() * by_parameter * l.weight;
            if let Some(slot) = slot {
                equations.by_camera[slot] += l.by_camera.transpose() * by_parameter * l.weight;
            }
        }
    }

    fn add_ties(&mut self, bundle: &Bundle) {
        for tie in &bundle.ties {
            let error = tie.residual(&bundle.cameras);
            let (first, second) = tie.cameras;
            let jacobians = [(first, -1.0), (second, 1.0)].map(|(camera, sign)| {
                // The center moves against the twist's translation: c = -R' t.
                let mut jacobian = Matrix3x6::zeros();
                let by_translation = bundle.cameras[camera].rotation().transpose() * (sign / tie.sigma);
                jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&by_translation);
                (self.slots[camera], jacobian)
            });
            self.add_pair(&jacobians, &error);
        }
    }

    fn add_motions(&mut self, bundle: &Bundle) {
        for motion in &bundle.motions {
            let (first, second) = motion.cameras;
            let weights = Matrix6::from_diagonal(&motion.weights());
            // A twist of the first camera moves the second one against it, seen from there.
            let by_first = -(weights * adjoint(&motion.between(&bundle.cameras)));
            let jacobians = [(self.slots[first], by_first), (self.slots[second], weights)];
            self.add_pair(&jacobians, &motion.residual(&bundle.cameras));
        }
    }

    /// Adds a residual of two cameras, with its derivative by the twist of each.
    fn add_pair<const N: usize>(
        &mut self,
        jacobians: &[(Option<usize>, SMatrix<f64, N, 6>); 2],
        error: &SVector<f64, N>,
    ) {
        for (slot, jacobian) in jacobians {
            let Some(slot) = *slot else { continue };
            self.cameras[slot] += jacobian.transpose() * jacobian;
            self.camera_gradient[slot] -= jacobian.transpose() * error;
        }
        if let [(Some(a), by_a), (Some(b), by_b)] = jacobians {
            let block = by_a.transpose() * by_b;
            let block = if a < b { block } else { block.transpose() };
            self.between.push(((*a).min(*b), (*a).max(*b), block));
        }
    }

    /// The step with a damping, share of the diagonal. `None` if the equations have no solution.
    pub fn solve(&self, bundle: &Bundle, damping: f64) -> Option<Step> {
        let inverses = self.point_inverses(damping);
        let solution = self.reduced(bundle, &inverses, damping).solve()?;
        let num_free = self.cameras.len();
        let twist = |slot: usize| Vector6::from_fn(|i, _| solution[6 * slot + i]);
        let mut right = self.point_gradient.clone();
        self.for_each_point(bundle, |_, group, free| {
            for (slot, by_point) in free {
                right[group[0].point] -= by_point.transpose() * twist(*slot);
            }
        });
        let lens: Vec<f64> = solution.iter().skip(6 * num_free).copied().collect();
        for (equations, change) in self.lens.iter().zip(&lens) {
            for (right, by_point) in right.iter_mut().zip(&equations.by_point) {
                *right -= by_point * *change;
            }
        }
        Some(Step {
            cameras: self.slots.iter().map(|slot| slot.map(twist)).collect(),
            points: right.iter().zip(&inverses).map(|(right, inverse)| inverse * right).collect(),
            lens,
        })
    }

    /// Inverse of the damped equations of each point.
    pub(super) fn point_inverses(&self, damping: f64) -> Vec<Matrix3<f64>> {
        self.points.iter().map(|hessian| damped_inverse(hessian, damping)).collect()
    }

    /// Goes through the points with the number of their first observation, all of their observations, and of each free camera that sees them
    /// the slot and the block of camera and point.
    pub(super) fn for_each_point(
        &self,
        bundle: &Bundle,
        mut take: impl FnMut(usize, &[BundleObservation], &[(usize, Matrix6x3<f64>)]),
    ) {
        let (mut start, mut free) = (0, Vec::new());
        let mut kept = self.camera_by_point.as_ref().map(|kept| kept.iter());
        for group in bundle.observations.chunk_by(|a, b| a.point == b.point) {
            free.clear();
            for (i, observation) in (start..).zip(group) {
                let Some(slot) = self.slots[observation.camera] else { continue };
                let by_point = match &mut kept {
                    Some(kept) => kept.next().copied(),
                    None => linearize(bundle, i, observation, self.huber).map(|l| l.camera_by_point()),
                };
                free.push((slot, by_point.unwrap_or_else(Matrix6x3::zeros)));
            }
            take(start, group, &free);
            start += group.len();
        }
    }

    /// The equations with the points eliminated.
    pub(super) fn reduced(&self, bundle: &Bundle, inverses: &[Matrix3<f64>], damping: f64) -> Reduced {
        let num_free = self.cameras.len();
        let at = |row: usize, column: usize| Reduced::at(num_free, row, column);
        let mut blocks = vec![Matrix6::zeros(); num_free * (num_free + 1) / 2];
        let mut gradient = self.camera_gradient.clone();
        for (slot, own) in self.cameras.iter().enumerate() {
            blocks[at(slot, slot)] = damped(own, damping);
        }
        for (row, column, block) in &self.between {
            blocks[at(*row, *column)] += block;
        }
        self.for_each_point(bundle, |_, group, free| {
            let point = group[0].point;
            for (slot, by_point) in free {
                let product = by_point * inverses[point];
                gradient[*slot] -= product * self.point_gradient[point];
                for (other, other_by_point) in free.iter().filter(|(other, _)| other > slot) {
                    subtract_product(&mut blocks[at(*slot, *other)], &product, other_by_point);
                }
                subtract_symmetric(&mut blocks[at(*slot, *slot)], &product, by_point);
            }
        });
        let num_of_cameras = 6 * num_free;
        let mut vector = DVector::zeros(num_of_cameras + self.lens.len());
        for (slot, gradient) in gradient.iter().enumerate() {
            vector.fixed_rows_mut::<6>(6 * slot).copy_from(gradient);
        }
        let lens = self.reduced_lens(bundle, inverses);
        for (i, lens) in lens.iter().enumerate() {
            vector[num_of_cameras + i] = lens.gradient;
        }
        Reduced { num_free, blocks, lens, vector }
    }

    /// The equations of the lens with the points eliminated.
    fn reduced_lens(&self, bundle: &Bundle, inverses: &[Matrix3<f64>]) -> Vec<LensEquations> {
        let mut reduced = self.lens.clone();
        for (equations, reduced) in self.lens.iter().zip(&mut reduced) {
            let products: Vec<Vector3<f64>> = equations
                .by_point
                .iter()
                .zip(inverses)
                .map(|(by_point, inverse)| inverse * by_point)
                .collect();
            for (own, other) in reduced.own.iter_mut().zip(&self.lens) {
                *own -= products
                    .iter()
                    .zip(&other.by_point)
                    .map(|(product, other)| product.dot(other))
                    .sum::<f64>();
            }
            reduced.gradient -= products
                .iter()
                .zip(&self.point_gradient)
                .map(|(product, gradient)| product.dot(gradient))
                .sum::<f64>();
            self.for_each_point(bundle, |_, group, free| {
                for (slot, by_point) in free {
                    reduced.by_camera[*slot] -= by_point * products[group[0].point];
                }
            });
        }
        reduced
    }
}

/// Position of each free camera among the unknowns.
fn slots(is_free: &[bool]) -> Vec<Option<usize>> {
    let mut next = 0;
    let mut slot = |is_free: &bool| {
        is_free.then(|| {
            next += 1;
            next - 1
        })
    };
    is_free.iter().map(&mut slot).collect()
}

fn set_zeros<const R: usize, const C: usize>(blocks: &mut Vec<SMatrix<f64, R, C>>, num: usize) {
    blocks.clear();
    blocks.resize(num, SMatrix::zeros());
}

impl Linearized {
    /// Second derivative by camera and point.
    #[inline]
    fn camera_by_point(&self) -> Matrix6x3<f64> {
        let [first, second] = rows_of(&self.by_camera);
        let by_point = rows_of(&self.by_point);
        Matrix6x3::from_fn(|row, column| {
            (first[row] * by_point[0][column] + second[row] * by_point[1][column]) * self.weight
        })
    }
}

/// The rows of a derivative of two lines side by side, in order in memory.
#[inline]
fn rows_of<const N: usize>(jacobian: &SMatrix<f64, 2, N>) -> [[f64; N]; 2] {
    [0, 1].map(|row| std::array::from_fn(|column| jacobian[(row, column)]))
}

/// Adds a derivative times itself. nalgebra calls its loop over matrices of any size for this, too.
#[inline]
fn add_square<const N: usize>(sum: &mut SMatrix<f64, N, N>, [first, second]: &[[f64; N]; 2], weight: f64) {
    for column in 0..N {
        for row in 0..N {
            sum[(row, column)] += (first[row] * first[column] + second[row] * second[column]) * weight;
        }
    }
}

/// As [`add_square`], for a matrix whose entries below the diagonal nobody reads.
#[inline]
fn add_symmetric(sum: &mut Matrix6<f64>, [first, second]: &[[f64; 6]; 2], weight: f64) {
    for column in 0..6 {
        // Two rows are one instruction.
        for row in 0..=column | 1 {
            sum[(row, column)] += (first[row] * first[column] + second[row] * second[column]) * weight;
        }
    }
}

/// Subtracts a derivative times the error.
#[inline]
fn subtract_gradient<const N: usize>(sum: &mut SVector<f64, N>, rows: &[[f64; N]; 2], l: &Linearized) {
    for row in 0..N {
        sum[row] -= (rows[0][row] * l.error.x + rows[1][row] * l.error.y) * l.weight;
    }
}

/// Subtracts `left * right'` from a block. Most of a solution's time goes into this product, for which nalgebra calls its loop over
/// matrices of any size.
#[inline]
fn subtract_product(block: &mut Matrix6<f64>, left: &Matrix6x3<f64>, right: &Matrix6x3<f64>) {
    for column in 0..6 {
        let [a, b, c] = [right[(column, 0)], right[(column, 1)], right[(column, 2)]];
        for row in 0..6 {
            block[(row, column)] -= left[(row, 0)] * a + left[(row, 1)] * b + left[(row, 2)] * c;
        }
    }
}

/// As [`subtract_product`], for a block on the diagonal, whose entries below the diagonal nobody reads.
#[inline]
fn subtract_symmetric(block: &mut Matrix6<f64>, left: &Matrix6x3<f64>, right: &Matrix6x3<f64>) {
    for column in 0..6 {
        let [a, b, c] = [right[(column, 0)], right[(column, 1)], right[(column, 2)]];
        // Two rows are one instruction.
        for row in 0..=column | 1 {
            block[(row, column)] -= left[(row, 0)] * a + left[(row, 1)] * b + left[(row, 2)] * c;
        }
    }
}

fn damped(hessian: &Matrix6<f64>, damping: f64) -> Matrix6<f64> {
    let mut damped = *hessian;
    for i in 0..6 {
        damped[(i, i)] = damped[(i, i)] * (1.0 + damping) + 1e-9;
    }
    damped
}

fn damped_inverse(hessian: &Matrix3<f64>, damping: f64) -> Matrix3<f64> {
    let mut damped = *hessian;
    for i in 0..3 {
        damped[(i, i)] = damped[(i, i)] * (1.0 + damping) + 1e-12;
    }
    damped.try_inverse().unwrap_or_else(Matrix3::zeros)
}

/// Residual and derivatives of the observation of a number; `None` behind the camera.
#[inline]
pub fn linearize(
    bundle: &Bundle,
    i: usize,
    observation: &BundleObservation,
    huber: f64,
) -> Option<Linearized> {
    let camera = &bundle.cameras[observation.camera];
    let observation = bundle.seen(i, observation, bundle.lens.iter().map(|lens| lens.change));
    let error = residual_of(camera, &bundle.points[observation.point], &observation)?;
    let point = camera.transform(&bundle.points[observation.point]);
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
        off: Vector2::new(x, y) - observation.ray,
        weight,
    })
}
