//! Comparison of a patch with many places of an image.

use visloc_core::GrayImage;

use super::{HALF_PX, PATCH_PX, Template};

/// A patch made ready for [`SearchPatch::zmssd`].
#[derive(Debug, Clone)]
pub struct SearchPatch {
    values: [i16; PATCH_PX * PATCH_PX],
    sum: i32,
    sum_of_squares: i32,
}

impl SearchPatch {
    /// From the inner pixels of a template, rounded to gray levels.
    #[must_use]
    pub fn new(template: &Template) -> Self {
        let values = template.inner().map(|v| v.round() as i16);
        let sum = values.iter().map(|v| i32::from(*v)).sum();
        let sum_of_squares = values.iter().map(|v| i32::from(*v) * i32::from(*v)).sum();
        Self { values, sum, sum_of_squares }
    }

    /// Variance of the patch, squared gray levels.
    #[must_use]
    pub fn variance(&self) -> f32 {
        let n = (PATCH_PX * PATCH_PX) as i32;
        (self.sum_of_squares - self.sum * self.sum / n) as f32 / n as f32
    }

    /// Mean squared difference to the patch around a pixel once both have mean 0, squared gray levels. `None` if that patch
    /// is not inside the image.
    #[inline]
    #[must_use]
    pub fn zmssd(&self, image: &GrayImage, x: usize, y: usize) -> Option<f32> {
        // Places far outside must not overflow.
        let (right, bottom) =
            ((image.width() + 1).saturating_sub(HALF_PX), (image.height() + 1).saturating_sub(HALF_PX));
        if x < HALF_PX || y < HALF_PX || x >= right || y >= bottom {
            return None;
        }
        // Sums of neighbors, for the instruction that multiplies pairs and adds them.
        let (mut sum, mut squares, mut products) = ([0_i16; PATCH_PX], [0_i32; HALF_PX], [0_i32; HALF_PX]);
        for (row, line) in self.values.chunks_exact(PATCH_PX).enumerate() {
            let start = (y - HALF_PX + row) * image.width() + x - HALF_PX;
            let pixels: &[u8; PATCH_PX] = image.data()[start..start + PATCH_PX].try_into().ok()?;
            let pixels = pixels.map(i16::from);
            for lane in 0..PATCH_PX {
                sum[lane] += pixels[lane];
            }
            let product = |a: i16, b: i16| i32::from(a) * i32::from(b);
            for lane in 0..HALF_PX {
                let (left, right) = (pixels[2 * lane], pixels[2 * lane + 1]);
                squares[lane] += product(left, left) + product(right, right);
                products[lane] += product(left, line[2 * lane]) + product(right, line[2 * lane + 1]);
            }
        }
        let total = |lanes: &[i32; HALF_PX]| lanes.iter().sum::<i32>();
        let difference = self.sum - sum.iter().map(|sum| i32::from(*sum)).sum::<i32>();
        let n = (PATCH_PX * PATCH_PX) as i32;
        let ssd = self.sum_of_squares - 2 * total(&products) + total(&squares) - difference * difference / n;
        Some(ssd.max(0) as f32 / n as f32)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;

    #[test]
    fn zero_at_the_same_place_under_an_offset() {
        let mut image = GrayImage::new(32, 32);
        image.data_mut().iter_mut().enumerate().for_each(|(i, v)| *v = (i * i / 7 % 180) as u8);
        let mut brighter = image.clone();
        brighter.data_mut().iter_mut().for_each(|v| *v += 40);
        let template = Template::from_image(&image, &Point2::new(15.0, 14.0), 0.0).unwrap();
        let patch = SearchPatch::new(&template);
        assert_eq!(patch.zmssd(&brighter, 15, 14), Some(0.0));
        assert!(patch.zmssd(&brighter, 17, 14).unwrap() > 100.0);
        assert!(patch.zmssd(&image, 3, 14).is_none() && patch.zmssd(&image, 4, 29).is_none());
        assert!(patch.zmssd(&image, usize::MAX, 10).is_none() && patch.zmssd(&image, 28, 28).is_some());
    }
}
