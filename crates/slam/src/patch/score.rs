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
        // Rounded; nothing is negative here.
        let values = template.inner().map(|v| (v + 0.5) as i16);
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
    // Never as a part of the caller, where the compiler does not turn the loops into vector instructions.
    #[inline(never)]
    #[must_use]
    pub fn zmssd(&self, image: &GrayImage, x: usize, y: usize) -> Option<f32> {
        // Places far outside must not overflow.
        let (right, bottom) =
            ((image.width() + 1).saturating_sub(HALF_PX), (image.height() + 1).saturating_sub(HALF_PX));
        if x < HALF_PX || y < HALF_PX || x >= right || y >= bottom {
            return None;
        }
        // All differences at first: loops over them become the instruction that multiplies pairs and adds them. Sums of columns fit sixteen bits.
        let (mut differences, mut sums) = ([0_i16; PATCH_PX * PATCH_PX], [0_i16; PATCH_PX]);
        let start = (y - HALF_PX) * image.width() + x - HALF_PX;
        for row in 0..PATCH_PX {
            let pixels = &image.data()[start + row * image.width()..][..PATCH_PX];
            for column in 0..PATCH_PX {
                let difference = self.values[row * PATCH_PX + column] - i16::from(pixels[column]);
                differences[row * PATCH_PX + column] = difference;
                sums[column] += difference;
            }
        }
        let sum: i32 = sums.iter().map(|sum| i32::from(*sum)).sum();
        let n = (PATCH_PX * PATCH_PX) as i32;
        let ssd = sum_of_products(&differences, &differences) - sum * sum / n;
        Some(ssd.max(0) as f32 / n as f32)
    }
}

#[inline]
fn sum_of_products(a: &[i16; PATCH_PX * PATCH_PX], b: &[i16; PATCH_PX * PATCH_PX]) -> i32 {
    a.iter().zip(b).map(|(a, b)| i32::from(*a) * i32::from(*b)).sum()
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
