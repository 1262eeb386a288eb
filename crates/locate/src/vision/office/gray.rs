//! Brightness of an image, row by row.

use visloc_core::RgbImage;

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
        let (threes, rest) = image.data()[3 * from..].as_chunks::<9>();
        let (values, last_values) = self.values[from..].as_chunks_mut::<3>();
        for (values, three) in values.iter_mut().zip(threes) {
            *values = brightness_of_three(three);
        }
        for (value, rgb) in last_values.iter_mut().zip(rest.as_chunks::<3>().0) {
            *value = brightness(*rgb);
        }
    }

    pub fn row(&self, y: usize) -> &[u8] {
        &self.values[y * self.width..(y + 1) * self.width]
    }
}

const WEIGHTS: [u64; 3] = [77, 150, 29];

fn brightness(rgb: [u8; 3]) -> u8 {
    let sum: u64 = WEIGHTS.iter().zip(rgb).map(|(weight, value)| weight * u64::from(value)).sum();
    (sum >> 8) as u8
}

/// [`brightness`] of three pixels in a row. They are summed in one word, each in 24 bits, which its sum does not fill.
#[inline]
fn brightness_of_three(rgb: &[u8; 9]) -> [u8; 3] {
    const FIRST_OF_EACH: u64 = 0xff_0000_ff00_00ff;
    let ([first @ .., _], [_, second @ ..]) = (rgb, rgb);
    let (from_first, from_second) = (u64::from_le_bytes(*first), u64::from_le_bytes(*second));
    let red = from_first & FIRST_OF_EACH;
    let green = from_second & FIRST_OF_EACH;
    let blue = (from_second >> 8) & FIRST_OF_EACH;
    let sum = WEIGHTS[0] * red + WEIGHTS[1] * green + WEIGHTS[2] * blue;
    [8, 32, 56].map(|shift| (sum >> shift) as u8)
}

/// Appends the indices of all marked pixels; the first one of `is_marked` has the index `first`. Most are not marked, so
/// they are looked at eight at a time.
pub(super) fn append_marked(is_marked: &[bool], first: usize, out: &mut Vec<u32>) {
    let (eights, rest) = is_marked.as_chunks::<8>();
    let mut from = first as u32;
    for eight in eights {
        // A byte of each; the lowest one is the first pixel.
        let mut bits = u64::from_le_bytes(eight.map(u8::from));
        while bits != 0 {
            out.push(from + bits.trailing_zeros() / 8);
            bits &= bits - 1;
        }
        from += 8;
    }
    out.extend((from..).zip(rest).filter(|(_, mark)| **mark).map(|(i, _)| i));
}

#[cfg(test)]
pub(super) mod tests {
    use rand::RngExt;
    use visloc_core::{Rng, RngTree};

    use super::*;

    /// Patches of random colors with noise: edges of every strength, flat areas, and values at both ends of the range.
    pub fn patches(width: usize, height: usize, rng: &mut Rng) -> RgbImage {
        let colors: Vec<[i32; 3]> =
            (0..16).map(|_| std::array::from_fn(|_| rng.random_range(-40..300))).collect();
        let mut image = RgbImage::new(width as u32, height as u32);
        for y in 0..height {
            for x in 0..width {
                let color = colors[(x / 11 + 5 * (y / 7)) % colors.len()];
                let noise = rng.random_range(-4..=4);
                image.set(x as u32, y as u32, color.map(|value| (value + noise).clamp(0, 255) as u8));
            }
        }
        image
    }

    #[test]
    fn three_pixels_at_once_have_the_brightness_of_each() {
        let rng = &mut RngTree::new(3).stream("gray", 0);
        for (width, height) in [(1, 1), (5, 2), (7, 7), (64, 9)] {
            let image = patches(width, height, rng);
            let mut gray = GrayImage::default();
            gray.fill(&image, 0);
            for y in 0..height {
                for x in 0..width {
                    let rgb = image.get(x as u32, y as u32).map(u32::from);
                    let expected = (77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2]) >> 8;
                    assert_eq!(u32::from(gray.row(y)[x]), expected, "{x}, {y} of {width}");
                }
            }
        }
    }

    #[test]
    fn marked_pixels_are_found_in_order() {
        let rng = &mut RngTree::new(4).stream("marked", 0);
        for len in [0, 1, 7, 8, 9, 16, 100, 313] {
            let is_marked: Vec<bool> = (0..len).map(|_| rng.random_bool(0.2)).collect();
            let mut found = vec![3];
            append_marked(&is_marked, 1000, &mut found);
            let expected: Vec<u32> =
                (1000..).zip(&is_marked).filter(|(_, mark)| **mark).map(|(i, _)| i).collect();
            assert_eq!(found[0], 3);
            assert_eq!(found[1..], expected);
        }
    }
}
