//! How a patch of a keyframe looks from another place.

use nalgebra::{Matrix2, Point2, Vector3};
use visloc_core::{
    GrayImage,
    geom::{Camera, CameraFrame, Rigid3},
};

use super::{BORDERED_PX, HALF_PX, PATCH_PX};
use crate::image::{Pyramid, level_from_px};

/// Pixels of a patch with its border, as gray levels; rows of 10.
#[derive(Debug, Clone)]
pub struct Template {
    /// Gray levels, 10 x 10, row by row.
    pub values: [f32; NUM],
    /// Mean squared gradient that noise alone has, (gray levels per pixel)^2. Structure below it is not to be believed.
    pub gradient_noise: f32,
}

/// What decides how a patch looks: where it was seen and from where it is looked at now.
#[derive(Debug, Clone, Copy)]
pub struct WarpGeometry<'a> {
    /// The camera of the current image.
    pub camera: &'a Camera,
    /// The camera of the reference image.
    pub reference_camera: &'a Camera,
    /// Center of the patch in the reference image, pixels of level 0.
    pub reference_px: Point2<f64>,
    /// The same on the plane z = 1 of the reference camera.
    pub reference_ray: Vector3<f64>,
    /// Level on which the patch was found.
    pub reference_level: usize,
    /// Depth along z in the reference camera, map units.
    pub reference_depth: f64,
    /// Motion between the two views.
    pub current_from_reference: Rigid3<CameraFrame, CameraFrame>,
}

/// A linear warp between two views and the levels that fit it.
#[derive(Debug, Clone, Copy)]
pub struct PatchWarp {
    /// Pixels of the reference's level per pixel of the current level.
    reference_by_current: Matrix2<f64>,
    /// Level of the reference image that is sampled.
    reference_level: usize,
    /// Level of the current image to search.
    pub current_level: usize,
}

impl PatchWarp {
    /// The warp of a plane patch that faces the reference camera. `None` if the patch is not visible, is turned away or
    /// is seen more than about six times larger or smaller.
    #[must_use]
    pub fn new(geometry: &WarpGeometry<'_>, num_levels: usize) -> Option<Self> {
        Self::from_matrix(&current_by_reference(geometry)?, geometry.reference_level, num_levels)
    }

    /// The warp whose linear part is known: pixels of the current image per pixel of the reference image, both on level 0. `None` if
    /// the patch is turned away or is seen more than about six times larger or smaller.
    #[must_use]
    pub fn from_matrix(
        current_by_reference: &Matrix2<f64>,
        reference_level: usize,
        num_levels: usize,
    ) -> Option<Self> {
        let determinant = current_by_reference.determinant();
        if !(1.0 / 40.0..40.0).contains(&determinant) {
            return None;
        }
        // Sides of a current pixel in reference pixels, as a power of two.
        let octaves = 0.5 * determinant.log2();
        let highest = num_levels as f64 - 1.0;
        let current_level = (reference_level as f64 + octaves).round().clamp(0.0, highest);
        let reference_level = (current_level - octaves).round().clamp(0.0, highest);
        let scale = (current_level - reference_level).exp2();
        let reference_by_current = current_by_reference.try_inverse()? * scale;
        Some(Self {
            reference_by_current,
            reference_level: reference_level as usize,
            current_level: current_level as usize,
        })
    }

    /// The same warp for a coarser level of the current image.
    #[must_use]
    pub fn coarser(&self, num_levels: usize) -> Option<Self> {
        if self.current_level + 1 >= num_levels {
            return None;
        }
        let (reference_level, factor) = if self.reference_level + 1 < num_levels {
            (self.reference_level + 1, 1.0)
        } else {
            (self.reference_level, 2.0)
        };
        Some(Self {
            reference_by_current: self.reference_by_current * factor,
            reference_level,
            current_level: self.current_level + 1,
        })
    }

    /// Takes the patch out of the reference image, whose gradient noise on each level is given. `None` if it reaches over the border.
    #[must_use]
    pub fn take(&self, reference: &Pyramid, center_px: &Point2<f64>, noise: &[f32]) -> Option<Template> {
        let level = self.reference_level.min(reference.num_levels() - 1);
        let image = reference.level(level);
        let center = level_from_px(center_px, level);
        let m = self.reference_by_current.cast::<f32>();
        let reach = HALF_PX as f32 + 1.0;
        let reach_x = (m[(0, 0)].abs() + m[(0, 1)].abs()) * reach;
        let reach_y = (m[(1, 0)].abs() + m[(1, 1)].abs()) * reach;
        let (cx, cy) = (center.x as f32, center.y as f32);
        let is_inside = cx - reach_x >= 0.0
            && cy - reach_y >= 0.0
            && cx + reach_x < image.width() as f32 - 1.0
            && cy + reach_y < image.height() as f32 - 1.0;
        if !is_inside {
            return None;
        }
        let mut places = Places::default();
        for row in 0..BORDERED_PX {
            let v = row as f32 - reach;
            let (mut x, mut y) =
                (cx + m[(0, 1)] * v - m[(0, 0)] * reach, cy + m[(1, 1)] * v - m[(1, 0)] * reach);
            for i in row * BORDERED_PX..(row + 1) * BORDERED_PX {
                (places.x[i], places.y[i]) = (x, y);
                x += m[(0, 0)];
                y += m[(1, 0)];
            }
        }
        let values = places.sample(image);
        Some(Template { values, gradient_noise: noise.get(level).copied().unwrap_or(0.0) })
    }
}

/// Pixels of the current image per pixel of the reference image, both on level 0.
fn current_by_reference(geometry: &WarpGeometry<'_>) -> Option<Matrix2<f64>> {
    let step_px = f64::from(1_u32 << geometry.reference_level) * HALF_PX as f64;
    let current_px = |ray: Vector3<f64>| {
        let point = geometry.current_from_reference.transform(&(ray * geometry.reference_depth).into());
        geometry.camera.project(&point).ok()
    };
    let moved_ray = |dx: f64, dy: f64| {
        let px = Point2::new(geometry.reference_px.x + dx, geometry.reference_px.y + dy);
        geometry.reference_camera.bearing(&px)
    };
    let center = current_px(geometry.reference_ray)?;
    let right = current_px(moved_ray(step_px, 0.0))?;
    let down = current_px(moved_ray(0.0, step_px))?;
    Some(Matrix2::from_columns(&[(right - center) / step_px, (down - center) / step_px]))
}

/// Pixels of a patch with its border.
const NUM: usize = BORDERED_PX * BORDERED_PX;

/// Places between the pixels of an image, for each pixel of a patch; the caller keeps them inside.
struct Places {
    x: [f32; NUM],
    y: [f32; NUM],
}

impl Default for Places {
    fn default() -> Self {
        Self { x: [0.0; NUM], y: [0.0; NUM] }
    }
}

impl Places {
    /// The values there (bilinear). Step by step for all places, so that the compiler makes vector instructions of what is computed, and
    /// the processor fetches many pixels at a time: a keyframe's image is hardly ever in its cache.
    fn sample(mut self, image: &GrayImage) -> [f32; NUM] {
        let width = image.width();
        let mut starts = [0_u32; NUM];
        for ((start, x), y) in starts.iter_mut().zip(&mut self.x).zip(&mut self.y) {
            let ((left, column), (top, row)) = (floor(*x), floor(*y));
            *x -= left;
            *y -= top;
            *start = row * width as u32 + column;
        }
        let (upper, lower) = (image.data(), &image.data()[width..]);
        let pair_at = |pixels: &[u8], start: usize| -> u16 {
            let pair = &pixels[start..start + 2];
            u16::from_le_bytes([pair[0], pair[1]])
        };
        let (mut above, mut below) = ([0_u16; NUM], [0_u16; NUM]);
        for (i, start) in starts.iter().enumerate() {
            (above[i], below[i]) = (pair_at(upper, *start as usize), pair_at(lower, *start as usize));
        }
        let both = |pair: u16| pair.to_le_bytes().map(f32::from);
        let mut values = [0.0; NUM];
        for (i, value) in values.iter_mut().enumerate() {
            let ([a, b], [c, d]) = (both(above[i]), both(below[i]));
            let (above, below) = (a + self.x[i] * (b - a), c + self.x[i] * (d - c));
            *value = above + self.y[i] * (below - above);
        }
        values
    }
}

/// The whole number below a coordinate, up to 2^22: exactly, without the instructions that a conversion takes for numbers that do not
/// fit. 0 where rounding has brought a place a little over the border.
#[inline]
fn floor(v: f32) -> (f32, u32) {
    // From 2^23 on single precision has whole numbers only, one for each pattern of bits.
    const WHOLE: f32 = 8_388_608.0;
    let nearest = (v + WHOLE) - WHOLE;
    let below = nearest - if nearest > v { 1.0 } else { 0.0 };
    let below = if below > 0.0 { below } else { 0.0 };
    (below, (below + WHOLE).to_bits() - WHOLE.to_bits())
}

impl Template {
    /// The patch around a position of one image, without a warp. `None` if it reaches over the border.
    #[must_use]
    pub fn from_image(image: &GrayImage, center: &Point2<f64>, gradient_noise: f32) -> Option<Self> {
        let reach = HALF_PX as f32 + 1.0;
        let (left, top) = (center.x as f32 - reach, center.y as f32 - reach);
        let side = BORDERED_PX as f32;
        if left < 0.0
            || top < 0.0
            || left + side >= image.width() as f32
            || top + side >= image.height() as f32
        {
            return None;
        }
        let mut places = Places::default();
        for i in 0..NUM {
            (places.x[i], places.y[i]) = (left + (i % BORDERED_PX) as f32, top + (i / BORDERED_PX) as f32);
        }
        Some(Self { values: places.sample(image), gradient_noise })
    }

    /// The inner 8 x 8 pixels, row by row.
    #[must_use]
    pub fn inner(&self) -> [f32; PATCH_PX * PATCH_PX] {
        let mut inner = [0.0; PATCH_PX * PATCH_PX];
        for (row, line) in inner.chunks_exact_mut(PATCH_PX).enumerate() {
            let start = (row + 1) * BORDERED_PX + 1;
            line.copy_from_slice(&self.values[start..start + PATCH_PX]);
        }
        inner
    }
}
