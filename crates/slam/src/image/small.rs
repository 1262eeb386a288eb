//! A tiny blurred copy of an image, to compare whole views.

use visloc_core::GrayImage;

use super::Pyramid;

/// Width of a small image, pixels.
const WIDTH: usize = 40;
/// Height of a small image, pixels.
const HEIGHT: usize = 30;

/// An image of 40 x 30 px, blurred, with mean 0 and standard deviation 1. Source: Klein and Murray, "Improving the
/// agility of keyframe-based SLAM", 2008.
#[derive(Debug, Clone, PartialEq)]
pub struct SmallImage {
    values: Vec<f32>,
}

impl SmallImage {
    /// From the coarsest level that is not smaller.
    #[must_use]
    pub fn new(pyramid: &Pyramid) -> Self {
        let fits = |level: &usize| {
            let image = pyramid.level(*level);
            image.width() >= WIDTH && image.height() >= HEIGHT
        };
        let level = (0..pyramid.num_levels()).rev().find(fits).unwrap_or(0);
        let mut values = blurred(&blurred(&resampled(pyramid.level(level))));
        let n = values.len() as f32;
        let mean = values.iter().sum::<f32>() / n;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f32>() / n;
        let scale = 1.0 / variance.sqrt().max(1.0);
        values.iter_mut().for_each(|v| *v = (*v - mean) * scale);
        Self { values }
    }

    /// Correlation with another image, in [-1, 1]; 1 for the same view under any gain and offset.
    #[must_use]
    pub fn similarity(&self, other: &Self) -> f32 {
        let sum: f32 = self.values.iter().zip(&other.values).map(|(a, b)| a * b).sum();
        sum / self.values.len() as f32
    }
}

/// Means of blocks.
fn resampled(image: &GrayImage) -> Vec<f32> {
    let range = |i: usize, parts: usize, size: usize| {
        let start = i * size / parts;
        start..((i + 1) * size / parts).max(start + 1).min(size.max(1))
    };
    let mut values = Vec::with_capacity(WIDTH * HEIGHT);
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            let (mut sum, mut count) = (0_u32, 0_u32);
            for row in range(y, HEIGHT, image.height()) {
                for column in range(x, WIDTH, image.width()) {
                    sum += u32::from(image.get(column, row));
                    count += 1;
                }
            }
            values.push(sum as f32 / count.max(1) as f32);
        }
    }
    values
}

/// One pass of the kernel 1 2 1 in both directions.
fn blurred(values: &[f32]) -> Vec<f32> {
    let at = |x: usize, y: usize| values[y * WIDTH + x];
    let mut out = Vec::with_capacity(values.len());
    for y in 0..HEIGHT {
        let (up, down) = (y.saturating_sub(1), (y + 1).min(HEIGHT - 1));
        for x in 0..WIDTH {
            let (left, right) = (x.saturating_sub(1), (x + 1).min(WIDTH - 1));
            let row = |y: usize| at(left, y) + 2.0 * at(x, y) + at(right, y);
            out.push((row(up) + 2.0 * row(y) + row(down)) / 16.0);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(gain: f64, shift: usize) -> Pyramid {
        let mut image = GrayImage::new(160, 120);
        for y in 0..120 {
            for x in 0..160 {
                let value = 100.0 + 60.0 * ((x + shift) as f64 / 17.0).sin() * (y as f64 / 13.0).cos();
                image.data_mut()[y * 160 + x] = (value * gain) as u8;
            }
        }
        Pyramid::new(image, 3)
    }

    #[test]
    fn brightness_does_not_matter_but_the_view_does() {
        let reference = SmallImage::new(&image(1.0, 0));
        assert!(reference.similarity(&SmallImage::new(&image(0.5, 0))) > 0.99);
        assert!(reference.similarity(&SmallImage::new(&image(1.0, 40))) < 0.5);
    }
}
