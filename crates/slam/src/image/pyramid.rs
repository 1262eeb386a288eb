//! The image pyramid.

use std::sync::OnceLock;

use nalgebra::Point2;
use visloc_core::GrayImage;

use crate::orb::{NoOrbMatch, OrbCorners, OrbDescriptor, OrbMatch, OrbSearch};

/// An image and its halvings. Level 0 is the image itself. Its ORB corners are found when they are first asked for, and kept.
#[derive(Debug, Clone)]
pub struct Pyramid {
    levels: Vec<GrayImage>,
    orb: OnceLock<OrbCorners>,
}

/// Levels that have ORB corners. Program: 3.
const ORB_LEVELS: usize = 3;

impl Pyramid {
    /// Builds `num_levels` levels (at least one); stops early where a side would fall below 16 px.
    #[must_use]
    pub fn new(image: GrayImage, num_levels: usize) -> Self {
        let mut levels = vec![image];
        while levels.len() < num_levels {
            let last = &levels[levels.len() - 1];
            if last.width() < 32 || last.height() < 32 {
                break;
            }
            let next = halved(last);
            levels.push(next);
        }
        Self { levels, orb: OnceLock::new() }
    }

    /// One level.
    ///
    /// # Panics
    /// If there is no such level.
    #[inline]
    #[must_use]
    pub fn level(&self, level: usize) -> &GrayImage {
        &self.levels[level]
    }

    /// The ORB corners. The threshold of the first call counts.
    #[must_use]
    pub fn orb(&self, threshold: u8) -> &OrbCorners {
        self.orb.get_or_init(|| OrbCorners::new(&self.levels[..self.levels.len().min(ORB_LEVELS)], threshold))
    }

    /// The ORB descriptor of a pixel of level 0 on a level; `None` near the border.
    #[must_use]
    pub fn describe(&self, level: usize, px: &Point2<f64>, search: &OrbSearch) -> Option<OrbDescriptor> {
        self.orb(search.threshold).describe(self.levels.get(level)?, level, px)
    }

    /// The ORB corner most like a descriptor around a line; see [`OrbCorners::best_near`].
    ///
    /// # Errors
    /// If no corner near the line is alike.
    pub fn best_near(
        &self,
        descriptor: &OrbDescriptor,
        line: (&[Point2<f64>], usize),
        search: &OrbSearch,
    ) -> Result<OrbMatch, NoOrbMatch> {
        self.orb(search.threshold).best_near(&self.levels, descriptor, line, search)
    }

    /// How many levels there are.
    #[inline]
    #[must_use]
    pub fn num_levels(&self) -> usize {
        self.levels.len()
    }
}

/// Each pixel is the rounded mean of a 2 x 2 block; an odd last row or column is left out.
pub(crate) fn halved(image: &GrayImage) -> GrayImage {
    let (width, height) = (image.width() / 2, image.height() / 2);
    let mut out = GrayImage::new(width, height);
    for y in 0..height {
        let (top, _) = image.row(2 * y)[..2 * width].as_chunks();
        let (bottom, _) = image.row(2 * y + 1)[..2 * width].as_chunks();
        let target = &mut out.data_mut()[y * width..(y + 1) * width];
        for ((t, a), b) in target.iter_mut().zip(top).zip(bottom) {
            *t = ((sum_of_pair(*a) + sum_of_pair(*b) + 2) >> 2) as u8;
        }
    }
    out
}

/// The image at twice its size, linear between its pixels: halved, it is itself again but for its finest structure.
pub(crate) fn doubled(image: &GrayImage) -> GrayImage {
    let (width, height) = (image.width(), image.height());
    // A pixel lies between the two nearest ones, at a quarter of the way.
    let between = |near: f32, far: f32| 0.5 * (near + 0.5 * (near + far));
    let neighbors = |at: usize, end: usize| [at.saturating_sub(1), (at + 1).min(end - 1)];
    let mut out = GrayImage::new(2 * width, 2 * height);
    let mut rows = out.data_mut().chunks_exact_mut((2 * width).max(1));
    for y in 0..height {
        for other in neighbors(y, height) {
            let pixels = image.row(y).iter().zip(image.row(other));
            let row: Vec<f32> =
                pixels.map(|(near, far)| between(f32::from(*near), f32::from(*far))).collect();
            let Some(target) = rows.next() else { break };
            for (x, pair) in target.as_chunks_mut::<2>().0.iter_mut().enumerate() {
                *pair = neighbors(x, width).map(|other| (between(row[x], row[other]) + 0.5) as u8);
            }
        }
    }
    out
}

/// Both as one number: so the compiler makes vector instructions of the loop, ten times as fast as of single bytes.
#[inline]
fn sum_of_pair(pixels: [u8; 2]) -> u16 {
    let pair = u16::from_le_bytes(pixels);
    (pair & 0xff) + (pair >> 8)
}

/// Position on a level of a pixel of level 0. Pixel centers are at integers on every level, so a pixel of level 1 lies
/// between two pixels of level 0.
#[inline]
#[must_use]
pub fn level_from_px(px: &Point2<f64>, level: usize) -> Point2<f64> {
    let scale = 1.0 / (1_u32 << level) as f64;
    Point2::new((px.x + 0.5) * scale - 0.5, (px.y + 0.5) * scale - 0.5)
}

/// Position on level 0 of a pixel of a level.
#[inline]
#[must_use]
pub fn px_from_level(at: &Point2<f64>, level: usize) -> Point2<f64> {
    let scale = (1_u32 << level) as f64;
    Point2::new((at.x + 0.5) * scale - 0.5, (at.y + 0.5) * scale - 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_stays_a_ramp_at_the_mapped_place() {
        let mut image = GrayImage::new(128, 64);
        for y in 0..64 {
            for x in 0..128 {
                image.data_mut()[y * 128 + x] = (x + y) as u8;
            }
        }
        let pyramid = Pyramid::new(image, 2);
        assert_eq!(pyramid.num_levels(), 2);
        let px = px_from_level(&Point2::new(10.0, 5.0), 1);
        assert_eq!(px, Point2::new(20.5, 10.5));
        assert_eq!(pyramid.level(1).get(10, 5), 31);
        assert_eq!(level_from_px(&px, 1), Point2::new(10.0, 5.0));
    }

    #[test]
    fn an_image_that_is_doubled_and_halved_is_itself() {
        let mut image = GrayImage::new(32, 16);
        for (i, value) in image.data_mut().iter_mut().enumerate() {
            *value = (5 * (i % 32) + 3 * (i / 32)) as u8;
        }
        let large = doubled(&image);
        assert_eq!((large.width(), large.height()), (64, 32));
        let again = halved(&large);
        let inside = |it: &GrayImage, x, y| i32::from(it.get(x, y));
        for (x, y) in (1..31).flat_map(|x| (1..15).map(move |y| (x, y))) {
            assert!((inside(&again, x, y) - inside(&image, x, y)).abs() <= 1, "{x}, {y}");
        }
        // A place is where it was: between two pixels.
        assert_eq!(
            i32::from(large.get(21, 10)),
            5 * 10 + 3 * 5 + 1,
            "a quarter of a step of 5 on, of 3 back"
        );
        assert_eq!(doubled(&GrayImage::new(0, 0)).width(), 0);
    }

    #[test]
    fn small_images_have_fewer_levels() {
        assert_eq!(Pyramid::new(GrayImage::new(40, 100), 5).num_levels(), 2);
        assert_eq!(Pyramid::new(GrayImage::new(1, 1), 5).num_levels(), 1);
    }
}
