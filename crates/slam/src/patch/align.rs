//! Sub-pixel alignment of a patch.

use nalgebra::{Matrix2, Matrix4, Point2, Vector4};
use visloc_core::GrayImage;

use super::{BORDERED_PX, HALF_PX, PATCH_PX, Template};
use crate::image::sample_square;

const NUM: usize = PATCH_PX * PATCH_PX;

/// When an alignment ends and when it counts.
#[derive(Debug, Clone, Copy)]
pub struct AlignLimits {
    /// Most iterations.
    pub max_iterations: usize,
    /// Farthest that the patch may move from its start, pixels of the level.
    pub max_shift_px: f64,
    /// Largest share of the template's variance that may remain as residual, 0 to 1.
    pub max_unexplained: f32,
    /// Mean squared residual that is always accepted: sensor noise, squared gray levels.
    pub noise: f32,
}

/// An alignment that counts.
#[derive(Debug, Clone, Copy)]
pub struct Aligned {
    /// Center of the patch, pixels of the level.
    pub at: Point2<f64>,
    /// Mean squared residual after gain and offset, squared gray levels.
    pub residual: f32,
    /// Covariance of the place, squared pixels of the level. Long along an edge.
    pub covariance: Matrix2<f64>,
}

/// Gains between two images of the same thing that are believed: exposure and shadow.
const GAINS: std::ops::Range<f32> = 0.2..5.0;
/// Gains that an alignment starts with; a patch that is not yet in its place has another contrast.
const FIRST_GAINS: (f32, f32) = (0.5, 2.0);
/// Gray level from which on a pixel is saturated.
const SATURATED: f32 = 254.5;
/// Least error of an alignment, pixels: what interpolation and the flat patch leave.
const LEAST_SIGMA_PX: f64 = 0.15;
/// Error along a direction in which a patch has no structure, pixels.
const MOST_SIGMA_PX: f64 = 4.0;
/// Least mean squared residual that is believed, squared gray levels.
const LEAST_RESIDUAL: f64 = 4.0;

/// Moves a patch to where it fits the image best under any gain and offset. `start` is the center, in pixels of the image.
/// `None` if it leaves the image, does not converge to 0.03 px, or does not fit.
///
/// Source: Baker and Matthews, "Lucas-Kanade 20 years on", 2004, section 3.2 (inverse compositional), with linear
/// appearance variation: the unknowns are shift, gain and offset.
#[must_use]
pub fn align(
    template: &Template,
    image: &GrayImage,
    start: &Point2<f64>,
    limits: &AlignLimits,
) -> Option<Aligned> {
    let (mut x, mut y) = (start.x as f32, start.y as f32);
    let mut sampled = [0.0; NUM];
    sample(image, x, y, &mut sampled)?;
    let values = template.inner();
    let [light, image_light] = lights([&values, &sampled]);
    let problem = Problem::new(template, values, light)?;
    let (mut gain, mut offset) = light.to(image_light);
    for iteration in 0..limits.max_iterations {
        if iteration > 0 {
            sample(image, x, y, &mut sampled)?;
        }
        let step = problem.step(&sampled, gain, offset);
        // The image's gradients are those of the template times the gain.
        let (dx, dy) = (step[0] / gain, step[1] / gain);
        x -= dx;
        y -= dy;
        gain += step[2];
        offset += step[3];
        let shift2 = (f64::from(x) - start.x).powi(2) + (f64::from(y) - start.y).powi(2);
        // Written so that NaN ends the search.
        if !(shift2 <= limits.max_shift_px * limits.max_shift_px && GAINS.contains(&gain)) {
            return None;
        }
        if dx * dx + dy * dy < 0.03 * 0.03 {
            sample(image, x, y, &mut sampled)?;
            let residual = problem.residual(&sampled, gain, offset);
            let allowed = limits.noise.max(limits.max_unexplained * problem.variance * gain * gain);
            let at = Point2::new(f64::from(x), f64::from(y));
            let covariance = problem.covariance(residual / (gain * gain));
            return (residual <= allowed).then_some(Aligned { at, residual, covariance });
        }
    }
    None
}

/// The smaller one; unlike `f32::min` a single instruction.
#[inline]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The template with what does not change over the iterations.
struct Problem {
    values: [f32; NUM],
    /// Most that an image may differ: of a saturated pixel only a lower bound is known, so a brighter one does not differ.
    most: [f32; NUM],
    dx: [f32; NUM],
    dy: [f32; NUM],
    inverse_hessian: Matrix4<f32>,
    /// Structure tensor of the shift once gain and offset are eliminated, and noise is taken off.
    tensor: Matrix2<f64>,
    variance: f32,
}

impl Problem {
    fn new(template: &Template, values: [f32; NUM], light: Light) -> Option<Self> {
        let (mut dx, mut dy) = ([0.0; NUM], [0.0; NUM]);
        for row in 0..PATCH_PX {
            for column in 0..PATCH_PX {
                let at = (row + 1) * BORDERED_PX + column + 1;
                let t = &template.values;
                dx[row * PATCH_PX + column] = 0.5 * (t[at + 1] - t[at - 1]);
                dy[row * PATCH_PX + column] = 0.5 * (t[at + BORDERED_PX] - t[at - BORDERED_PX]);
            }
        }
        let most = values.map(|value| if value >= SATURATED { 0.0 } else { f32::INFINITY });
        let one = [1.0; NUM];
        let columns = [&dx, &dy, &values, &one];
        let mut hessian = Matrix4::zeros();
        for (i, j) in (0..4).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            hessian[(i, j)] = dot(columns[i], columns[j]);
        }
        let (inverse_hessian, tensor) = invert(&hessian, template.gradient_noise)?;
        Some(Self { values, most, dx, dy, inverse_hessian, tensor, variance: light.variance })
    }

    /// What the pixels of the image differ from the template under a gain and an offset.
    #[inline]
    fn differences(&self, sampled: &[f32; NUM], gain: f32, offset: f32) -> [f32; NUM] {
        let mut differences = [0.0; NUM];
        for i in 0..NUM {
            let expected = smaller(gain * self.values[i] + offset, 255.0);
            differences[i] = smaller(sampled[i] - expected, self.most[i]);
        }
        differences
    }

    /// Gauss-Newton step in shift, gain and offset.
    #[inline]
    fn step(&self, sampled: &[f32; NUM], gain: f32, offset: f32) -> Vector4<f32> {
        let errors = self.differences(sampled, gain, offset);
        let by = [&self.dx, &self.dy, &self.values, &[1.0; NUM]];
        self.inverse_hessian * Vector4::from(by.map(|column| dot(&errors, column)))
    }

    /// Covariance of the shift for a mean squared residual, squared pixels.
    fn covariance(&self, residual: f32) -> Matrix2<f64> {
        let residual = f64::from(residual).max(LEAST_RESIDUAL);
        // What holds for the error along each of the two main directions.
        let variance = |value: f64| {
            let variance = residual / value.max(1e-6);
            variance.min(MOST_SIGMA_PX * MOST_SIGMA_PX) + LEAST_SIGMA_PX * LEAST_SIGMA_PX
        };
        let (mean, reach) = eigenvalues(&self.tensor);
        let (along, across) = (variance(mean - reach), variance(mean + reach));
        let round = Matrix2::identity() * (0.5 * (along + across));
        let deviator = self.tensor - Matrix2::identity() * mean;
        if reach > 0.0 { round + deviator * (0.5 * (across - along) / reach) } else { round }
    }

    fn residual(&self, sampled: &[f32; NUM], gain: f32, offset: f32) -> f32 {
        let squares = self.differences(sampled, gain, offset).map(|difference| difference.powi(2));
        squares.iter().sum::<f32>() / NUM as f32
    }
}

/// Inverse of a structure tensor, of which the lower triangle is given, damped along directions without structure, and the tensor of
/// the shift without noise. `None` if the patch has structure in no direction.
fn invert(hessian: &Matrix4<f32>, gradient_noise: f32) -> Option<(Matrix4<f32>, Matrix2<f64>)> {
    // Single precision is too little for a nearly singular 4 x 4 matrix.
    let hessian = hessian.cast::<f64>();
    let block = |row: usize, column: usize| hessian.fixed_view::<2, 2>(row, column).into_owned();
    let whole = |lower: Matrix2<f64>| Matrix2::new(lower.m11, lower.m21, lower.m21, lower.m22);
    let (shift, light_by_shift, light) = (whole(block(0, 0)), block(2, 0), whole(block(2, 2)));
    let noise = f64::from(gradient_noise) * NUM as f64;
    // A shift of about two pixels is as likely as the noise: an edge stays where it is predicted along its direction.
    let damping = noise.max(NUM as f64 * 0.5) * 0.25;
    // Gain and offset are eliminated.
    let light_inverse = light.try_inverse().filter(|_| light.determinant() > 0.0)?;
    let by_shift = light_inverse * light_by_shift;
    let tensor = shift - light_by_shift.transpose() * by_shift;
    let shift_inverse = (tensor + Matrix2::identity() * damping).try_inverse()?;
    let mut inverse = Matrix4::zeros();
    inverse.fixed_view_mut::<2, 2>(0, 0).copy_from(&shift_inverse);
    let across = -by_shift * shift_inverse;
    inverse.fixed_view_mut::<2, 2>(2, 0).copy_from(&across);
    inverse.fixed_view_mut::<2, 2>(0, 2).copy_from(&across.transpose());
    inverse.fixed_view_mut::<2, 2>(2, 2).copy_from(&(light_inverse - across * by_shift.transpose()));
    let tensor = tensor - Matrix2::identity() * noise;
    let (mean, reach) = eigenvalues(&tensor);
    // Less than a gray level of gradient: nothing to hold on to.
    (mean + reach > NUM as f64).then(|| (inverse.cast::<f32>(), tensor))
}

/// Mean of the eigenvalues of a symmetric matrix, and how far they are from it.
fn eigenvalues(matrix: &Matrix2<f64>) -> (f64, f64) {
    (0.5 * matrix.trace(), (0.5 * (matrix.m11 - matrix.m22)).hypot(matrix.m21))
}

#[inline]
fn dot(a: &[f32; NUM], b: &[f32; NUM]) -> f32 {
    let mut lanes = [0.0_f32; 8];
    for row in 0..PATCH_PX {
        for lane in 0..8 {
            lanes[lane] += a[row * PATCH_PX + lane] * b[row * PATCH_PX + lane];
        }
    }
    lanes.iter().sum()
}

/// Mean and variance of a patch.
#[derive(Clone, Copy)]
struct Light {
    mean: f32,
    variance: f32,
}

impl Light {
    /// Gain and offset that make contrast and mean of a patch those of the image, before it is aligned.
    fn to(self, image: Self) -> (f32, f32) {
        let gain = (image.variance / self.variance.max(1.0)).sqrt().clamp(FIRST_GAINS.0, FIRST_GAINS.1);
        (gain, image.mean - gain * self.mean)
    }
}

/// Of two patches side by side: sums in order take as long for two as for one.
fn lights(patches: [&[f32; NUM]; 2]) -> [Light; 2] {
    let mut sums = [0.0_f32; 2];
    for i in 0..NUM {
        for (sum, patch) in sums.iter_mut().zip(patches) {
            *sum += patch[i];
        }
    }
    let means = sums.map(|sum| sum / NUM as f32);
    let mut squares = [0.0_f32; 2];
    for i in 0..NUM {
        for ((sum, patch), mean) in squares.iter_mut().zip(patches).zip(means) {
            *sum += (patch[i] - mean) * (patch[i] - mean);
        }
    }
    [0, 1].map(|patch| Light { mean: means[patch], variance: squares[patch] / NUM as f32 })
}

/// Samples the 8 x 8 px around a position; `None` if they are not all inside.
#[inline]
fn sample(image: &GrayImage, x: f32, y: f32, out: &mut [f32; NUM]) -> Option<()> {
    sample_square::<PATCH_PX>(image, x - HALF_PX as f32, y - HALF_PX as f32, out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(shift_x: f64, shift_y: f64, gain: f64, offset: f64) -> GrayImage {
        let mut image = GrayImage::new(64, 64);
        for y in 0..64 {
            for x in 0..64 {
                let (u, v) = (x as f64 - shift_x, y as f64 - shift_y);
                let value = 110.0 + 40.0 * (u * 0.35).sin() * (v * 0.3).cos() + 25.0 * ((u + v) * 0.2).sin();
                image.data_mut()[y * 64 + x] = (value * gain + offset).round().clamp(0.0, 255.0) as u8;
            }
        }
        image
    }

    const LIMITS: AlignLimits =
        AlignLimits { max_iterations: 15, max_shift_px: 4.0, max_unexplained: 0.3, noise: 4.0 };

    #[test]
    fn finds_shifts_under_gain_and_offset() {
        let reference = image(0.0, 0.0, 1.0, 0.0);
        for (dx, dy) in [(0.3, -0.4), (1.6, 1.2), (-2.1, 0.7)] {
            let current = image(dx, dy, 1.2, -20.0);
            let start = Point2::new(30.0, 31.0);
            let template = Template::from_image(&reference, &start, 0.0).unwrap();
            let found = align(&template, &current, &start, &LIMITS).unwrap();
            let error = (found.at - Point2::new(30.0 + dx, 31.0 + dy)).norm();
            assert!(error < 0.05, "{dx} {dy}: {error}");
        }
    }

    #[test]
    fn the_closed_forms_agree_with_decompositions() {
        let reference = image(0.0, 0.0, 1.0, 0.0);
        for (x, y) in [(30.0, 31.0), (25.3, 40.2), (41.0, 22.7)] {
            let template = Template::from_image(&reference, &Point2::new(x, y), 2.0).unwrap();
            let values = template.inner();
            let [light, _] = lights([&values, &values]);
            let problem = Problem::new(&template, values, light).unwrap();
            let columns = [&problem.dx, &problem.dy, &values, &[1.0; NUM]];
            let mut damped = Matrix4::from_fn(|i, j| dot(columns[i], columns[j])).cast::<f64>();
            (0..2).for_each(|i| damped[(i, i)] += 0.25 * 2.0 * NUM as f64);
            let product = problem.inverse_hessian.cast::<f64>() * damped;
            assert!((product - Matrix4::identity()).norm() < 1e-2, "{product}");
            let eigen = problem.tensor.symmetric_eigen();
            let variance = eigen
                .eigenvalues
                .map(|value| (9.0 / value.max(1e-6)).min(MOST_SIGMA_PX.powi(2)) + LEAST_SIGMA_PX.powi(2));
            let expected =
                eigen.eigenvectors * Matrix2::from_diagonal(&variance) * eigen.eigenvectors.transpose();
            let error = (problem.covariance(9.0) - expected).norm();
            assert!(error < 1e-9 * expected.norm(), "{error}");
        }
    }

    #[test]
    fn light_that_doubles_is_no_obstacle() {
        let reference = image(0.0, 0.0, 0.6, 0.0);
        let start = Point2::new(30.0, 31.0);
        let template = Template::from_image(&reference, &start, 0.0).unwrap();
        for (gain, offset) in [(1.3, 0.0), (0.3, 10.0), (1.2, 60.0)] {
            let current = image(1.1, -0.8, gain, offset);
            let found = align(&template, &current, &start, &LIMITS).unwrap();
            let error = (found.at - Point2::new(31.1, 30.2)).norm();
            assert!(error < 0.1, "{gain} {offset}: {error}");
        }
    }

    #[test]
    fn saturated_pixels_do_not_pull() {
        // About a third of the patch is brighter than the image can tell.
        let reference = image(0.0, 0.0, 1.0, 0.0);
        let current = image(0.6, 0.4, 1.9, -10.0);
        let start = Point2::new(30.0, 31.0);
        for (from, to, sign) in [(&reference, &current, 1.0), (&current, &reference, -1.0)] {
            let template = Template::from_image(from, &start, 0.0).unwrap();
            let found = align(&template, to, &start, &LIMITS).unwrap();
            let error = (found.at - Point2::new(30.0 + 0.6 * sign, 31.0 + 0.4 * sign)).norm();
            assert!(error < 0.15, "{error}");
        }
    }

    #[test]
    fn an_edge_is_known_across_and_not_along() {
        let mut reference = GrayImage::new(64, 64);
        for y in 0..64 {
            for x in 0..64 {
                let noise = ((x * 7919 + y * 104_729) % 7) as u8;
                reference.data_mut()[y * 64 + x] = if x + y < 62 { 60 + noise } else { 150 + noise };
            }
        }
        let start = Point2::new(30.0, 31.0);
        let template = Template::from_image(&reference, &start, 4.0).unwrap();
        let found = align(&template, &reference, &start, &LIMITS).unwrap();
        let along = nalgebra::Vector2::new(1.0, -1.0).normalize();
        let across = nalgebra::Vector2::new(1.0, 1.0).normalize();
        let sigma = |v: &nalgebra::Vector2<f64>| v.dot(&(found.covariance * v)).sqrt();
        assert!(sigma(&along) > 0.5 && sigma(&across) < 0.2, "{} {}", sigma(&along), sigma(&across));
    }

    #[test]
    fn flat_patches_and_borders_are_refused() {
        let reference = image(0.0, 0.0, 1.0, 0.0);
        let flat = GrayImage::new(64, 64);
        let start = Point2::new(30.0, 31.0);
        let template = Template::from_image(&reference, &start, 0.0).unwrap();
        assert!(align(&template, &flat, &start, &LIMITS).is_none());
        let flat_template = Template::from_image(&flat, &start, 0.0).unwrap();
        assert!(align(&flat_template, &reference, &start, &LIMITS).is_none());
        assert!(align(&template, &reference, &Point2::new(2.0, 30.0), &LIMITS).is_none());
        assert!(align(&template, &reference, &Point2::new(f64::NAN, 30.0), &LIMITS).is_none());
    }
}
