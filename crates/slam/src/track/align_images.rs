//! Sparse image alignment: the motion between two images from the pixels around known points.

use nalgebra::{SMatrix, SVector, Vector3, Vector6};
use visloc_core::{
    GrayImage,
    geom::{Camera, CameraFrame, Rigid3},
};

use crate::{
    image::{Pyramid, level_from_px, sample_square},
    lie::{exp, image_by_twist},
};

/// Side of a patch, pixels.
const SIDE: usize = 4;
const NUM: usize = SIDE * SIDE;

/// Gains between two images that an alignment starts with.
const FIRST_GAINS: (f32, f32) = (0.4, 2.5);

/// A point of the reference image.
#[derive(Debug, Clone, Copy)]
pub struct AlignFeature {
    /// Pixel of level 0 in the reference image.
    pub px: nalgebra::Point2<f64>,
    /// The point in the reference camera, map units.
    pub point: Vector3<f64>,
}

/// What an alignment found.
#[derive(Debug, Clone, Copy)]
pub struct ImageAlignment {
    /// Motion between the images.
    pub current_from_reference: Rigid3<CameraFrame, CameraFrame>,
    /// Features inside both images on the last level.
    pub num_features: usize,
    level: usize,
    light: Light,
}

/// Gain and offset of the current image against the reference.
#[derive(Debug, Clone, Copy)]
struct Light {
    gain: f32,
    offset: f32,
}

/// The patch of one feature on one level, with what does not change over the iterations.
#[derive(Debug)]
struct Patch {
    values: [f32; NUM],
    dx: [f32; NUM],
    dy: [f32; NUM],
    /// Derivatives of the pixel's coordinates by the twist.
    by_twist_x: [f64; 6],
    by_twist_y: [f64; 6],
    point: Vector3<f64>,
}

/// Normal equations in twist, gain and offset.
struct Normal {
    hessian: SMatrix<f64, 8, 8>,
    gradient: SVector<f64, 8>,
    cost: f64,
    num_features: usize,
}

/// The reference image around its points, to which images are aligned from several starts.
#[derive(Debug)]
pub struct AlignReference<'a> {
    camera: &'a Camera,
    pyramid: &'a Pyramid,
    features: &'a [AlignFeature],
    /// The patches of each level that was asked for.
    patches: Vec<Option<Vec<Patch>>>,
}

impl<'a> AlignReference<'a> {
    /// Of an image and the points that are seen in it.
    #[must_use]
    pub fn new(camera: &'a Camera, pyramid: &'a Pyramid, features: &'a [AlignFeature]) -> Self {
        let patches = (0..pyramid.num_levels()).map(|_| None).collect();
        Self { camera, pyramid, features, patches }
    }

    /// Aligns from the coarsest level to the finest. Minimizes the differences of the
    /// pixels of 4 x 4 patches under a common gain and offset, with robust weights.
    ///
    /// Source: Forster, Pizzoli and Scaramuzza, "SVO", 2014, section IV-A (inverse compositional); gain and offset as in Engel,
    /// Koltun and Cremers, "Direct sparse odometry", 2016.
    #[must_use]
    pub fn align(
        &mut self,
        current: &Pyramid,
        start: &Rigid3<CameraFrame, CameraFrame>,
        levels: (usize, usize),
        max_iterations: usize,
    ) -> ImageAlignment {
        let (camera, pyramid, features) = (self.camera, self.pyramid, self.features);
        let mut motion = *start;
        let light = Light { gain: 1.0, offset: 0.0 };
        let mut result = ImageAlignment { current_from_reference: *start, num_features: 0, level: 0, light };
        let coarsest = levels.0.min(pyramid.num_levels() - 1).min(current.num_levels() - 1);
        for level in (levels.1.min(coarsest)..=coarsest).rev() {
            let patches = self.patches[level].get_or_insert_with(|| {
                features.iter().filter_map(|feature| Patch::new(camera, pyramid, feature, level)).collect()
            });
            let problem = Level { camera, image: current.level(level), level, patches };
            let aligned = problem.align(&motion, max_iterations);
            if aligned.num_features >= 4 {
                motion = aligned.current_from_reference;
                result = aligned;
            }
        }
        result
    }

    /// Median absolute residual of an alignment on its last level, gray levels; `f32::MAX` if there is none.
    #[must_use]
    pub fn median_residual(&self, current: &Pyramid, alignment: &ImageAlignment) -> f32 {
        let ImageAlignment { current_from_reference, level, light, .. } = alignment;
        match self.patches.get(*level) {
            Some(Some(patches)) if alignment.num_features > 0 => {
                let problem =
                    Level { camera: self.camera, image: current.level(*level), level: *level, patches };
                median(&mut problem.residuals(current_from_reference, light))
            }
            _ => f32::MAX,
        }
    }
}

struct Level<'a> {
    camera: &'a Camera,
    image: &'a GrayImage,
    level: usize,
    patches: &'a [Patch],
}

impl Level<'_> {
    fn align(&self, start: &Rigid3<CameraFrame, CameraFrame>, max_iterations: usize) -> ImageAlignment {
        let (Light { mut gain, mut offset }, scale) = self.robust_start(start);
        let mut motion = *start;
        let mut accepted = (motion, gain, offset);
        let mut last_cost = f64::INFINITY;
        let mut num_features = 0;
        for _ in 0..max_iterations {
            let normal = self.accumulate(&motion, gain, offset, scale);
            if normal.num_features < 4 || normal.cost >= last_cost {
                break;
            }
            num_features = normal.num_features;
            accepted = (motion, gain, offset);
            last_cost = normal.cost;
            let mut hessian = normal.hessian;
            for i in 0..8 {
                hessian[(i, i)] = hessian[(i, i)] * (1.0 + 1e-5) + 1e-9;
            }
            let Some(step) = hessian.cholesky().map(|c| c.solve(&normal.gradient)) else { break };
            if !step.iter().all(|v| v.is_finite()) {
                break;
            }
            // The image's gradients are those of the reference times the gain.
            let twist = Vector6::from_fn(|i, _| step[i]) / f64::from(gain);
            motion = motion * exp::<CameraFrame>(&twist).inverse();
            gain += step[6] as f32;
            offset += step[7] as f32;
            if !(0.2..5.0).contains(&gain) {
                break;
            }
            // A few hundredths of a pixel of the level.
            if twist.amax() < 2e-5 * f64::from(1_u32 << self.level) {
                accepted = (motion, gain, offset);
                break;
            }
        }
        let (current_from_reference, gain, offset) = accepted;
        let light = Light { gain, offset };
        ImageAlignment { current_from_reference, num_features, level: self.level, light }
    }

    /// Gain and offset from the medians, and the scale of the robust weights.
    fn robust_start(&self, motion: &Rigid3<CameraFrame, CameraFrame>) -> (Light, f32) {
        let num = self.patches.len() * NUM;
        let (mut before, mut now) = (Vec::with_capacity(num), Vec::with_capacity(num));
        let mut sampled = [0.0; NUM];
        for patch in self.patches {
            if self.sample(patch, motion, &mut sampled).is_some() {
                before.extend(patch.values);
                now.extend(sampled);
            }
        }
        let (mut ordered_before, mut ordered_now) = (before.clone(), now.clone());
        let (center_before, spread_before) = center_and_spread(&mut ordered_before);
        let (center_now, spread_now) = center_and_spread(&mut ordered_now);
        let gain = (spread_now / spread_before.max(1.0)).clamp(FIRST_GAINS.0, FIRST_GAINS.1);
        let offset = center_now - gain * center_before;
        let residual = |(now, before): (&f32, &f32)| (now - gain * before - offset).abs();
        let mut residuals: Vec<f32> = now.iter().zip(&before).map(residual).collect();
        (Light { gain, offset }, (1.4826 * median(&mut residuals)).clamp(3.0, 40.0))
    }

    fn residuals(&self, motion: &Rigid3<CameraFrame, CameraFrame>, light: &Light) -> Vec<f32> {
        let mut residuals = Vec::with_capacity(self.patches.len() * NUM);
        let mut sampled = [0.0; NUM];
        for patch in self.patches {
            if self.sample(patch, motion, &mut sampled).is_some() {
                let residual = |(s, t): (&f32, &f32)| (s - light.gain * t - light.offset).abs();
                residuals.extend(sampled.iter().zip(&patch.values).map(residual));
            }
        }
        residuals
    }

    #[inline]
    fn sample(
        &self,
        patch: &Patch,
        motion: &Rigid3<CameraFrame, CameraFrame>,
        out: &mut [f32; NUM],
    ) -> Option<()> {
        let px = self.camera.project(&motion.transform(&patch.point.into())).ok()?;
        let at = level_from_px(&px, self.level);
        sample(self.image, at.x as f32, at.y as f32, out)
    }

    fn accumulate(
        &self,
        motion: &Rigid3<CameraFrame, CameraFrame>,
        gain: f32,
        offset: f32,
        scale: f32,
    ) -> Normal {
        let mut normal =
            Normal { hessian: SMatrix::zeros(), gradient: SVector::zeros(), cost: 0.0, num_features: 0 };
        let mut sampled = [0.0; NUM];
        let cutoff2 = (3.0 * scale) * (3.0 * scale);
        let (mut cost, mut num_pixels) = (0.0_f64, 0_u32);
        for patch in self.patches {
            if self.sample(patch, motion, &mut sampled).is_none() {
                continue;
            }
            normal.num_features += 1;
            num_pixels += NUM as u32;
            let s = Sums::of(patch, &sampled, gain, offset, cutoff2);
            cost += f64::from(s.cost);
            s.add_to(patch, &mut normal);
        }
        // Per pixel, so that features that leave the image do not lower the cost.
        normal.cost = cost / f64::from(num_pixels.max(1));
        normal.hessian.fill_lower_triangle_with_upper_triangle();
        normal
    }
}

/// Weighted sums over the pixels of a patch, of products of gradient, value and residual.
#[derive(Default)]
struct Sums {
    xx: f32,
    xy: f32,
    yy: f32,
    xt: f32,
    yt: f32,
    x1: f32,
    y1: f32,
    tt: f32,
    t1: f32,
    n: f32,
    xr: f32,
    yr: f32,
    tr: f32,
    r: f32,
    cost: f32,
}

impl Sums {
    #[inline]
    fn of(patch: &Patch, sampled: &[f32; NUM], gain: f32, offset: f32, cutoff2: f32) -> Self {
        let mut s = Self::default();
        for (i, value) in sampled.iter().enumerate() {
            let (x, y, t) = (patch.dx[i], patch.dy[i], patch.values[i]);
            let r = value - gain * t - offset;
            // Tukey's biweight.
            let rest = (1.0 - r * r / cutoff2).max(0.0);
            let w = rest * rest;
            s.cost += 1.0 - w * rest;
            s.xx += w * x * x;
            s.xy += w * x * y;
            s.yy += w * y * y;
            s.xt += w * x * t;
            s.yt += w * y * t;
            s.x1 += w * x;
            s.y1 += w * y;
            s.tt += w * t * t;
            s.t1 += w * t;
            s.n += w;
            s.xr += w * x * r;
            s.yr += w * y * r;
            s.tr += w * t * r;
            s.r += w * r;
        }
        s
    }

    /// Adds to the upper triangle of the Hessian and to the gradient.
    #[inline]
    fn add_to(&self, patch: &Patch, normal: &mut Normal) {
        let d = f64::from;
        let (by_x, by_y) = (&patch.by_twist_x, &patch.by_twist_y);
        let (xx, xy, yy) = (d(self.xx), d(self.xy), d(self.yy));
        let Normal { hessian, gradient, .. } = normal;
        for column in 0..6 {
            let (x, y) = (xx * by_x[column] + xy * by_y[column], xy * by_x[column] + yy * by_y[column]);
            for row in 0..=column {
                hessian[(row, column)] += by_x[row] * x + by_y[row] * y;
            }
        }
        let (xt, yt, x1, y1) = (d(self.xt), d(self.yt), d(self.x1), d(self.y1));
        let (xr, yr) = (d(self.xr), d(self.yr));
        for row in 0..6 {
            hessian[(row, 6)] += by_x[row] * xt + by_y[row] * yt;
            hessian[(row, 7)] += by_x[row] * x1 + by_y[row] * y1;
            gradient[row] += by_x[row] * xr + by_y[row] * yr;
        }
        hessian[(6, 6)] += d(self.tt);
        hessian[(6, 7)] += d(self.t1);
        hessian[(7, 7)] += d(self.n);
        gradient[6] += d(self.tr);
        gradient[7] += d(self.r);
    }
}

impl Patch {
    fn new(camera: &Camera, reference: &Pyramid, feature: &AlignFeature, level: usize) -> Option<Self> {
        const WIDE: usize = SIDE + 2;
        let image = reference.level(level);
        let at = level_from_px(&feature.px, level);
        let mut wide = [0.0_f32; WIDE * WIDE];
        sample_wide(image, at.x as f32, at.y as f32, &mut wide)?;
        let (mut values, mut dx, mut dy) = ([0.0; NUM], [0.0; NUM], [0.0; NUM]);
        for row in 0..SIDE {
            for column in 0..SIDE {
                let at = (row + 1) * WIDE + column + 1;
                let i = row * SIDE + column;
                values[i] = wide[at];
                dx[i] = 0.5 * (wide[at + 1] - wide[at - 1]);
                dy[i] = 0.5 * (wide[at + WIDE] - wide[at - WIDE]);
            }
        }
        let (_, by_point) = camera.project_with_jacobian(&feature.point.into()).ok()?;
        let by_twist = image_by_twist(&by_point, &feature.point) / f64::from(1_u32 << level);
        let row = |row| std::array::from_fn(|column| by_twist[(row, column)]);
        Some(Self { values, dx, dy, by_twist_x: row(0), by_twist_y: row(1), point: feature.point })
    }
}

/// Samples 4 x 4 px around a position (one pixel more to the top left); `None` if they are not all inside.
#[inline]
fn sample(image: &GrayImage, x: f32, y: f32, out: &mut [f32; NUM]) -> Option<()> {
    sample_square::<SIDE>(image, x - 2.0, y - 2.0, out)
}

fn sample_wide(image: &GrayImage, x: f32, y: f32, out: &mut [f32]) -> Option<()> {
    sample_square::<{ SIDE + 2 }>(image, x - 3.0, y - 3.0, out)
}

/// Median of gray levels and median deviation from it; 0 without any.
fn center_and_spread(values: &mut [f32]) -> (f32, f32) {
    if values.is_empty() {
        return (0.0, 0.0);
    }
    let center = median(values);
    values.iter_mut().for_each(|value| *value = (*value - center).abs());
    (center, median(values))
}

/// Median of values that are not below 0, which have the order of their bits.
fn median(values: &mut [f32]) -> f32 {
    if values.is_empty() {
        return f32::MAX;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by_key(middle, |value| value.to_bits()).1
}
