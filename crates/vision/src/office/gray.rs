//! Brightness of an image, row by row.

use visloc_base::RgbImage;

/// Brightness of every pixel, 0 to 255. Keeps its memory from image to image.
#[derive(Debug, Clone, Default)]
pub(super) struct GrayImage {
    pub width: usize,
    pub height: usize,
    pub values: Vec<u8>,
}

impl GrayImage {
    /// Takes the brightness of an image from `first_row` on; rows above keep what they had.
    pub fn fill(&mut self, image: &RgbImage, first_row: usize) {
        (self.width, self.height) = (image.width() as usize, image.height() as usize);
        self.values.resize(self.width * self.height, 0);
        let from = first_row.min(self.height) * self.width;
        let rgb = image.data()[3 * from..].chunks_exact(3);
        for (value, rgb) in self.values[from..].iter_mut().zip(rgb) {
            let sum = 77 * u16::from(rgb[0]) + 150 * u16::from(rgb[1]) + 29 * u16::from(rgb[2]);
            *value = (sum >> 8) as u8;
        }
    }

    pub fn row(&self, y: usize) -> &[u8] {
        &self.values[y * self.width..(y + 1) * self.width]
    }
}
