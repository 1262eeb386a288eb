//! Images in memory.

use thiserror::Error;

/// Pixel data whose length does not fit the size.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("image of {width} x {height} px: expected {expected} bytes, found {found}")]
pub struct ImageSizeError {
    width: usize,
    height: usize,
    expected: usize,
    found: usize,
}

impl ImageSizeError {
    pub(crate) fn new(width: usize, height: usize, expected: usize, found: usize) -> Self {
        Self { width, height, expected, found }
    }
}

/// An 8-bit color image, rows from top to bottom, three bytes (red, green, blue) a pixel.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RgbImage {
    width: u32,
    height: u32,
    data: Vec<u8>,
}

impl RgbImage {
    /// A black image.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, data: vec![0; width as usize * height as usize * 3] }
    }

    /// From bytes, row by row.
    ///
    /// # Errors
    /// If there are not exactly `width * height * 3` bytes.
    pub fn from_raw(width: u32, height: u32, data: Vec<u8>) -> Result<Self, ImageSizeError> {
        let expected = (width as usize).saturating_mul(height as usize).saturating_mul(3);
        if data.len() != expected {
            return Err(ImageSizeError::new(width as usize, height as usize, expected, data.len()));
        }
        Ok(Self { width, height, data })
    }

    /// Width, pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height, pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All bytes, row by row.
    pub fn data(&self) -> &[u8] {
        &self.data
    }

    /// All bytes, row by row.
    pub fn data_mut(&mut self) -> &mut [u8] {
        &mut self.data
    }

    /// All pixels, row by row.
    #[inline]
    pub fn pixels(&self) -> &[[u8; 3]] {
        self.data.as_chunks().0
    }

    /// The bytes, without a copy.
    pub fn into_raw(self) -> Vec<u8> {
        self.data
    }

    /// One pixel.
    ///
    /// # Panics
    /// If the pixel is outside the image.
    #[inline]
    pub fn get(&self, x: u32, y: u32) -> [u8; 3] {
        let i = (y as usize * self.width as usize + x as usize) * 3;
        // One check of the bounds.
        let px = &self.data[i..i + 3];
        [px[0], px[1], px[2]]
    }

    /// Sets one pixel.
    ///
    /// # Panics
    /// If the pixel is outside the image.
    #[inline]
    pub fn set(&mut self, x: u32, y: u32, rgb: [u8; 3]) {
        let i = (y as usize * self.width as usize + x as usize) * 3;
        self.data[i..i + 3].copy_from_slice(&rgb);
    }

    /// One row of pixels.
    ///
    /// # Panics
    /// If the row is outside the image.
    #[inline]
    pub fn row(&self, y: u32) -> &[u8] {
        let stride = self.width as usize * 3;
        &self.data[y as usize * stride..(y as usize + 1) * stride]
    }
}

/// Hue in degrees [0, 360), saturation 0 to 1 and brightness 0 to 255 of a color (HSV).
#[inline]
pub fn hue_saturation_brightness(rgb: [u8; 3]) -> (f64, f64, f64) {
    let [r, g, b] = rgb.map(f64::from);
    let (max, min) = (r.max(g).max(b), r.min(g).min(b));
    let chroma = max - min;
    if chroma == 0.0 {
        return (0.0, 0.0, max);
    }
    let sextant = if max == r {
        ((g - b) / chroma).rem_euclid(6.0)
    } else if max == g {
        (b - r) / chroma + 2.0
    } else {
        (r - g) / chroma + 4.0
    };
    (sextant * 60.0, chroma / max, max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_that_no_memory_holds_are_not_expected() {
        assert!(RgbImage::from_raw(u32::MAX, u32::MAX, Vec::new()).is_err());
        assert!(crate::GrayImage::from_raw(usize::MAX / 2 + 1, 2, Vec::new()).is_err());
    }

    #[test]
    fn pixels_are_row_major() {
        let mut image = RgbImage::new(3, 2);
        image.set(2, 1, [1, 2, 3]);
        assert_eq!(&image.data()[15..], &[1, 2, 3]);
        assert_eq!(image.get(2, 1), [1, 2, 3]);
        assert_eq!(&image.row(1)[6..], &[1, 2, 3]);
        assert_eq!(image.pixels()[4..], [[0; 3], [1, 2, 3]]);
    }

    #[test]
    fn wrong_length_is_refused() {
        let error = RgbImage::from_raw(2, 2, vec![0; 11]).unwrap_err();
        assert_eq!(error.to_string(), "image of 2 x 2 px: expected 12 bytes, found 11");
    }

    #[test]
    fn hue_of_pure_colors() {
        for (rgb, hue) in [
            ([255, 0, 0], 0.0),
            ([255, 255, 0], 60.0),
            ([0, 255, 0], 120.0),
            ([0, 0, 200], 240.0),
            ([255, 0, 255], 300.0),
        ] {
            let (h, s, _) = hue_saturation_brightness(rgb);
            assert!((h - hue).abs() < 1e-9 && (s - 1.0).abs() < 1e-9, "{rgb:?}");
        }
    }
}
