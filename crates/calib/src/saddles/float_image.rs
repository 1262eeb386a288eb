//! Images as floating-point numbers.

use nalgebra::Point2;
use visloc_core::GrayImage;

/// A gray image of `f32`, 0 to 255, rows from top to bottom.
#[derive(Debug, Clone, PartialEq)]
pub struct FloatImage {
    width: usize,
    height: usize,
    data: Vec<f32>,
}

impl FloatImage {
    /// The same image.
    pub fn from_gray(image: &GrayImage) -> Self {
        let data = image.data().iter().map(|v| f32::from(*v)).collect();
        Self { width: image.width(), height: image.height(), data }
    }

    /// From values row by row; missing ones are 0.
    pub(crate) fn from_raw(width: usize, height: usize, mut data: Vec<f32>) -> Self {
        data.resize(width * height, 0.0);
        Self { width, height, data }
    }

    /// Width, pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height, pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// One row.
    pub fn row(&self, y: usize) -> &[f32] {
        &self.data[y * self.width..(y + 1) * self.width]
    }

    /// Brightness at a place, linear between pixels; outside of the image that of the border.
    #[inline]
    pub fn sample(&self, px: &Point2<f64>) -> f64 {
        let x = px.x.clamp(0.0, (self.width - 1) as f64);
        let y = px.y.clamp(0.0, (self.height - 1) as f64);
        let (i, j) =
            ((x as usize).min(self.width.saturating_sub(2)), (y as usize).min(self.height.saturating_sub(2)));
        let (u, v) = (x - i as f64, y - j as f64);
        let at = |dx: usize, dy: usize| {
            let (x, y) = ((i + dx).min(self.width - 1), (j + dy).min(self.height - 1));
            f64::from(self.data[y * self.width + x])
        };
        (at(0, 0) * (1.0 - u) + at(1, 0) * u) * (1.0 - v) + (at(0, 1) * (1.0 - u) + at(1, 1) * u) * v
    }

    /// Half the size: means of 2 x 2 pixels. Pixel (x, y) of the result covers (2 x + 0.5, 2 y + 0.5).
    #[must_use]
    pub fn half(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let mut data = Vec::with_capacity(width * height);
        for y in 0..height {
            let (a, b) = (self.row(2 * y), self.row(2 * y + 1));
            data.extend((0..width).map(|x| (a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1]) / 4.0));
        }
        Self { width, height, data }
    }

    /// Smoothed by a Gaussian, pixels.
    #[must_use]
    pub fn blurred(&self, sigma_px: f32) -> Self {
        let radius = (3.0 * sigma_px).ceil() as usize;
        let kernel: Vec<f32> = (0..=2 * radius)
            .map(|i| (-0.5 * ((i as f32 - radius as f32) / sigma_px).powi(2)).exp())
            .collect();
        let total: f32 = kernel.iter().sum();
        let kernel: Vec<f32> = kernel.iter().map(|k| k / total).collect();
        let mut across = Vec::with_capacity(self.data.len());
        let mut padded = vec![0.0_f32; self.width + 2 * radius];
        for y in 0..self.height {
            let row = self.row(y);
            padded[radius..radius + self.width].copy_from_slice(row);
            padded[..radius].fill(row[0]);
            padded[radius + self.width..].fill(row[self.width - 1]);
            across.extend(
                padded.windows(kernel.len()).map(|w| w.iter().zip(&kernel).map(|(a, k)| a * k).sum::<f32>()),
            );
        }
        let mut data = vec![0.0_f32; self.data.len()];
        for y in 0..self.height {
            let out = &mut data[y * self.width..(y + 1) * self.width];
            for (i, k) in kernel.iter().enumerate() {
                let from = (y + i).saturating_sub(radius).min(self.height - 1);
                let row = &across[from * self.width..(from + 1) * self.width];
                out.iter_mut().zip(row).for_each(|(o, v)| *o += k * v);
            }
        }
        Self { width: self.width, height: self.height, data }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sampling_blurring_and_halving_keep_a_ramp() {
        let data = (0..20 * 16).map(|i| (i % 20 * 5) as u8).collect();
        let image = FloatImage::from_gray(&GrayImage::from_raw(20, 16, data).unwrap());
        assert!((image.sample(&Point2::new(3.25, 7.5)) - 16.25).abs() < 1e-5);
        assert!((image.blurred(1.5).sample(&Point2::new(9.0, 7.0)) - 45.0).abs() < 1e-3);
        assert!((image.half().sample(&Point2::new(3.0, 2.0)) - 32.5).abs() < 1e-5);
        assert!(image.sample(&Point2::new(-5.0, 99.0)).abs() < 1e-9);
    }
}
