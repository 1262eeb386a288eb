//! Gray images in memory.

use crate::{ImageSizeError, RgbImage};

/// An 8-bit gray image, rows from top to bottom.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct GrayImage {
    width: usize,
    height: usize,
    data: Vec<u8>,
}

impl GrayImage {
    /// A black image.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, data: vec![0; width * height] }
    }

    /// From bytes, row by row.
    ///
    /// # Errors
    /// If there are not exactly `width * height` bytes.
    pub fn from_raw(width: usize, height: usize, data: Vec<u8>) -> Result<Self, ImageSizeError> {
        let expected = width.saturating_mul(height);
        if data.len() != expected {
            return Err(ImageSizeError::new(width, height, expected, data.len()));
        }
        Ok(Self { width, height, data })
    }

    /// Luma of a color image with the weights of ITU-R BT.601, rounded.
    pub fn from_rgb(image: &RgbImage) -> Self {
        let luma = |rgb: &[u8]| {
            let [r, g, b] = [u32::from(rgb[0]), u32::from(rgb[1]), u32::from(rgb[2])];
            // Weights in 1/65536; they sum to one, so that gray stays gray.
            ((r * 19_595 + g * 38_470 + b * 7_471 + 32_768) >> 16) as u8
        };
        let data = image.data().chunks_exact(3).map(luma).collect();
        Self { width: image.width() as usize, height: image.height() as usize, data }
    }

    /// A gray image in color: three equal channels.
    pub fn to_rgb(&self) -> RgbImage {
        let side = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
        let data = self.data.iter().flat_map(|gray| [*gray; 3]).collect();
        RgbImage::from_raw(side(self.width), side(self.height), data).unwrap_or_default()
    }

    /// The image at a whole fraction of its size: each pixel is the rounded mean of a square of `factor` pixels (at least 1) a side. What
    /// does not fill a square at the right and at the bottom is left out.
    #[must_use]
    pub fn shrunk(&self, factor: usize) -> Self {
        let factor = factor.max(1);
        let mut out = Self::new(self.width / factor, self.height / factor);
        let area = (factor * factor) as u32;
        let mut sums = vec![0_u32; out.width];
        for (y, target) in out.data.chunks_exact_mut(out.width.max(1)).enumerate() {
            sums.fill(0);
            for row in y * factor..(y + 1) * factor {
                for (sum, square) in sums.iter_mut().zip(self.row(row).chunks_exact(factor)) {
                    *sum += square.iter().map(|pixel| u32::from(*pixel)).sum::<u32>();
                }
            }
            for (pixel, sum) in target.iter_mut().zip(&sums) {
                *pixel = ((sum + area / 2) / area) as u8;
            }
        }
        out
    }

    /// Width, pixels.
    #[inline]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height, pixels.
    #[inline]
    pub fn height(&self) -> usize {
        self.height
    }

    /// All bytes, row by row.
    #[inline]
    pub fn data(&self) -> &[u8] {
        &self.data
    }

    /// All bytes, row by row.
    #[inline]
    pub fn data_mut(&mut self) -> &mut [u8] {
        &mut self.data
    }

    /// One pixel.
    ///
    /// # Panics
    /// If the pixel is outside the image.
    #[inline]
    pub fn get(&self, x: usize, y: usize) -> u8 {
        self.data[y * self.width + x]
    }

    /// One row of pixels.
    ///
    /// # Panics
    /// If the row is outside the image.
    #[inline]
    pub fn row(&self, y: usize) -> &[u8] {
        &self.data[y * self.width..(y + 1) * self.width]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gray_stays_gray_and_green_is_brightest() {
        let image = RgbImage::from_raw(3, 1, vec![200, 200, 200, 0, 255, 0, 0, 0, 255]).unwrap();
        assert_eq!(GrayImage::from_rgb(&image).data(), &[200, 150, 29]);
    }

    #[test]
    fn shrinking_takes_the_mean_of_squares() {
        let rows = [[10, 20, 30, 40, 99], [20, 30, 50, 60, 99], [0, 0, 0, 1, 99]];
        let image = GrayImage::from_raw(5, 3, rows.concat()).unwrap();
        assert_eq!(image.shrunk(2), GrayImage::from_raw(2, 1, vec![20, 45]).unwrap());
        assert_eq!(image.shrunk(1), image);
        assert_eq!(image.shrunk(7).data(), &[0; 0]);
    }

    #[test]
    fn wrong_length_is_refused() {
        assert!(GrayImage::from_raw(3, 2, vec![0; 5]).is_err());
        assert_eq!(GrayImage::from_raw(3, 2, vec![7; 6]).unwrap().row(1), &[7; 3]);
    }
}
