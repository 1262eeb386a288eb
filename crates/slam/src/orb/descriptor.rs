//! The descriptor of one place.

use visloc_core::GrayImage;

use super::pattern::{NUM_BITS, NUM_TURNS, PATTERN, REACH_PX, SIDE};

/// Pixels around a place that its descriptor needs.
pub const ORB_MARGIN_PX: usize = 16;
/// Radius of the disc whose centroid gives the direction, pixels. Source: Rublee et al., 2011, section 3.2 (patch of 31 px).
const DISC_RADIUS_PX: i32 = 15;
/// Half the side of the boxes whose means are compared, pixels. Source: Rublee et al., 2011, section 4.1 (5 x 5 px).
const BOX_RADIUS_PX: usize = 2;
/// Side of a box, pixels.
const BOX_PX: usize = 2 * BOX_RADIUS_PX + 1;
/// Rows that the boxes need.
const ROWS: usize = SIDE + 2 * BOX_RADIUS_PX;
/// Columns of the disc, and one more so that they are a multiple of eight.
const DISC_COLUMNS: usize = 2 * DISC_RADIUS_PX as usize + 2;
/// Rows of the disc.
const DISC_ROWS: usize = DISC_COLUMNS - 1;
/// 1 inside of the disc, row by row.
const DISC: [[i16; DISC_COLUMNS]; DISC_ROWS] = disc();

const fn disc() -> [[i16; DISC_COLUMNS]; DISC_ROWS] {
    let mut disc = [[0; DISC_COLUMNS]; DISC_ROWS];
    let mut row = 0;
    while row < DISC_ROWS {
        let mut column = 0;
        while column < DISC_COLUMNS {
            let (dx, dy) = (column as i32 - DISC_RADIUS_PX, row as i32 - DISC_RADIUS_PX);
            disc[row][column] = (dx * dx + dy * dy <= DISC_RADIUS_PX * DISC_RADIUS_PX) as i16;
            column += 1;
        }
        row += 1;
    }
    disc
}

/// 256 comparisons of brightness around a corner, turned with the corner.
///
/// Source: Rublee, Rabaud, Konolige and Bradski, "ORB: an efficient alternative to SIFT or SURF", 2011. Deviation: the pairs
/// that are compared are drawn, not learned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OrbDescriptor {
    words: [u64; NUM_BITS / 64],
}

impl OrbDescriptor {
    /// The descriptor of a pixel. `None` nearer to the border than [`ORB_MARGIN_PX`].
    #[must_use]
    pub fn new(image: &GrayImage, x: usize, y: usize) -> Option<Self> {
        is_inside(image, x, y).then(|| Self::of_sums(&box_sums(image, x, y), turn(image, x, y)))
    }

    /// The descriptor of a pixel of an image of which many are described, see [`OrbDescriptor::new`].
    #[must_use]
    pub fn with_sums(image: &GrayImage, sums: &BoxSums, x: usize, y: usize) -> Option<Self> {
        is_inside(image, x, y).then(|| Self::of_sums(&sums.around(x, y), turn(image, x, y)))
    }

    fn of_sums(sums: &[u16; SIDE * SIDE], turn: usize) -> Self {
        let mut words = [0; NUM_BITS / 64];
        for (word, pairs) in words.iter_mut().zip(PATTERN[turn].chunks_exact(64)) {
            for (bit, [a, b]) in pairs.iter().enumerate() {
                *word |= u64::from(sums[usize::from(*a)] < sums[usize::from(*b)]) << bit;
            }
        }
        Self { words }
    }

    #[cfg(test)]
    pub(crate) fn from_words(words: [u64; NUM_BITS / 64]) -> Self {
        Self { words }
    }

    /// As bytes.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; NUM_BITS / 8] {
        std::array::from_fn(|i| self.words[i / 8].to_le_bytes()[i % 8])
    }

    /// From bytes.
    #[must_use]
    pub fn from_bytes(bytes: &[u8; NUM_BITS / 8]) -> Self {
        let byte = |i: usize, shift: usize| u64::from(bytes[8 * i + shift]) << (8 * shift);
        Self { words: std::array::from_fn(|i| (0..8).map(|shift| byte(i, shift)).sum()) }
    }

    /// The descriptor with these bits turned over.
    #[cfg(test)]
    pub(crate) fn with_wrong(&self, bits: [u64; NUM_BITS / 64]) -> Self {
        Self { words: std::array::from_fn(|i| self.words[i] ^ bits[i]) }
    }

    /// A descriptor without a place.
    pub(super) fn none() -> Self {
        Self { words: [0; NUM_BITS / 64] }
    }

    /// Number of different bits, 0 to 256; about 128 for places that have nothing to do with each other.
    #[inline]
    #[must_use]
    pub fn distance(&self, other: &Self) -> u32 {
        self.words.iter().zip(&other.words).map(|(a, b)| (a ^ b).count_ones()).sum()
    }

    /// The first 64 bits.
    #[inline]
    #[must_use]
    pub fn first_word(&self) -> u64 {
        self.words[0]
    }

    /// Up to 32 bits from one on.
    #[inline]
    #[must_use]
    pub fn bits(&self, first: usize, num: usize) -> u32 {
        let (word, shift) = (first / 64, first % 64);
        let low = self.words[word] >> shift;
        let high = self.words.get(word + 1).map_or(0, |next| next.unbounded_shl(64 - shift as u32));
        ((low | high) & ((1 << num) - 1)) as u32
    }

    /// One of the 256 bits.
    #[must_use]
    pub fn bit(&self, bit: usize) -> bool {
        self.words[bit / 64] >> (bit % 64) & 1 == 1
    }
}

/// Whether a pixel has all around it that its descriptor needs.
fn is_inside(image: &GrayImage, x: usize, y: usize) -> bool {
    x >= ORB_MARGIN_PX
        && y >= ORB_MARGIN_PX
        && x + ORB_MARGIN_PX < image.width()
        && y + ORB_MARGIN_PX < image.height()
}

/// Direction from a pixel to the centroid of brightness around it, in steps of the pattern.
fn turn(image: &GrayImage, x: usize, y: usize) -> usize {
    let reach = DISC_RADIUS_PX as usize;
    let (mut by_x, mut by_y) = (0_i32, 0_i32);
    for (row, inside) in DISC.iter().enumerate() {
        let pixels = &image.row(y + row - reach)[x - reach..][..DISC_COLUMNS];
        let (mut sum, mut moment) = (0_i32, 0_i32);
        for (column, (pixel, inside)) in pixels.iter().zip(inside).enumerate() {
            let value = i16::from(*pixel) * inside;
            sum += i32::from(value);
            moment += i32::from(value) * (column as i32 - DISC_RADIUS_PX);
        }
        by_x += moment;
        by_y += (row as i32 - DISC_RADIUS_PX) * sum;
    }
    let turns = f64::from(by_y).atan2(f64::from(by_x)) / std::f64::consts::TAU;
    (turns * NUM_TURNS as f64).round().rem_euclid(NUM_TURNS as f64) as usize % NUM_TURNS
}

/// Sums over the box around each pixel of an image, to describe many of its pixels.
#[derive(Debug, Clone)]
pub struct BoxSums {
    width: usize,
    /// Row by row; 0 where the box reaches over the border.
    sums: Vec<u16>,
}

impl BoxSums {
    /// Of all pixels of an image.
    #[must_use]
    pub fn new(image: &GrayImage) -> Self {
        let (width, height) = (image.width(), image.height());
        let mut sums = vec![0; width * height];
        if width < BOX_PX || height < BOX_PX {
            return Self { width, sums };
        }
        let boxes = width - BOX_PX + 1;
        let mut lines = vec![0_u16; boxes * height];
        for (line, y) in lines.chunks_exact_mut(boxes).zip(0..) {
            let row = image.row(y);
            for shift in 0..BOX_PX {
                for (sum, value) in line.iter_mut().zip(&row[shift..]) {
                    *sum += u16::from(*value);
                }
            }
        }
        for y in BOX_RADIUS_PX..height - BOX_RADIUS_PX {
            let start = y * width + BOX_RADIUS_PX;
            let target = &mut sums[start..start + boxes];
            for line in lines[(y - BOX_RADIUS_PX) * boxes..].chunks_exact(boxes).take(BOX_PX) {
                for (sum, value) in target.iter_mut().zip(line) {
                    *sum += value;
                }
            }
        }
        Self { width, sums }
    }

    /// Those of the square that the pattern covers, row by row.
    fn around(&self, x: usize, y: usize) -> [u16; SIDE * SIDE] {
        let reach = REACH_PX as usize;
        let mut square = [0; SIDE * SIDE];
        for (line, y) in square.chunks_exact_mut(SIDE).zip(y - reach..) {
            line.copy_from_slice(&self.sums[y * self.width + x - reach..][..SIDE]);
        }
        square
    }
}

/// Sums over the box around each pixel of the square that the pattern covers, row by row.
fn box_sums(image: &GrayImage, x: usize, y: usize) -> [u16; SIDE * SIDE] {
    let reach = REACH_PX as usize + BOX_RADIUS_PX;
    let mut rows = [[0_u16; SIDE]; ROWS];
    for (i, sums) in rows.iter_mut().enumerate() {
        let pixels = &image.row(y + i - reach)[x - reach..=x + reach];
        for (j, sum) in sums.iter_mut().enumerate() {
            *sum = pixels[j..j + BOX_PX].iter().map(|value| u16::from(*value)).sum();
        }
    }
    let mut boxes = [0; SIDE * SIDE];
    for (i, line) in boxes.chunks_exact_mut(SIDE).enumerate() {
        for row in &rows[i..i + BOX_PX] {
            for (sum, value) in line.iter_mut().zip(row) {
                *sum += value;
            }
        }
    }
    boxes
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use rand::RngExt;
    use visloc_core::RngTree;

    use super::*;

    const SIZE: usize = 400;

    /// Smooth noise that can be looked up anywhere: a sum of waves of random direction and length.
    struct Texture(Vec<(f64, f64, f64)>);

    impl Texture {
        fn new(seed: u64) -> Self {
            let mut rng = RngTree::new(seed).stream("texture", 0);
            let wave = |_| {
                let (direction, length): (f64, f64) =
                    (rng.random_range(0.0..TAU), rng.random_range(7.0..40.0));
                let (kx, ky) = (direction.cos() * TAU / length, direction.sin() * TAU / length);
                (kx, ky, rng.random_range(0.0..TAU))
            };
            Self((0..60).map(wave).collect())
        }

        fn at(&self, x: f64, y: f64) -> u8 {
            let sum: f64 = self.0.iter().map(|(kx, ky, phase)| (kx * x + ky * y + phase).sin()).sum();
            (128.0 + 9.0 * sum).clamp(0.0, 255.0) as u8
        }

        /// An image turned about its center and brightened.
        fn image(&self, angle: f64, gain: f64, offset: f64) -> GrayImage {
            let mut image = GrayImage::new(SIZE, SIZE);
            let (sin, cos) = angle.sin_cos();
            let half = SIZE as f64 / 2.0;
            for row in 0..SIZE {
                for column in 0..SIZE {
                    let (x, y) = (column as f64 - half, row as f64 - half);
                    let value = f64::from(self.at(cos * x + sin * y, cos * y - sin * x));
                    image.data_mut()[row * SIZE + column] = (gain * value + offset) as u8;
                }
            }
            image
        }
    }

    /// Places of the unturned image, in pixels from its center.
    fn places() -> impl Iterator<Item = (i32, i32)> {
        (-3..=3).flat_map(|row| (-3..=3).map(move |column| (35 * column, 35 * row)))
    }

    fn describe(image: &GrayImage, x: f64, y: f64) -> OrbDescriptor {
        let half = SIZE as f64 / 2.0;
        OrbDescriptor::new(image, (half + x).round() as usize, (half + y).round() as usize).unwrap()
    }

    #[test]
    fn turning_the_image_hardly_changes_a_descriptor() {
        for seed in 0..3 {
            let texture = Texture::new(seed);
            let upright = texture.image(0.0, 1.0, 0.0);
            for degrees in [17.0_f64, 45.0, 90.0, 143.0, 270.0] {
                let angle = degrees.to_radians();
                let image = texture.image(angle, 0.7, 20.0);
                let (sin, cos) = angle.sin_cos();
                let mut distances: Vec<u32> = places()
                    .map(|(x, y)| {
                        let (x, y) = (f64::from(x), f64::from(y));
                        let there = describe(&image, cos * x - sin * y, sin * x + cos * y);
                        describe(&upright, x, y).distance(&there)
                    })
                    .collect();
                distances.sort_unstable();
                // A few places have no clear direction.
                assert!(distances[distances.len() / 2] < 40, "{degrees}: {distances:?}");
                assert!(distances[distances.len() * 4 / 5] < 80, "{degrees}: {distances:?}");
            }
        }
    }

    #[test]
    fn different_places_differ_in_half_of_the_bits() {
        let texture = Texture::new(5);
        let image = texture.image(0.0, 1.0, 0.0);
        let all: Vec<OrbDescriptor> =
            places().map(|(x, y)| describe(&image, f64::from(x), f64::from(y))).collect();
        let mut distances = Vec::new();
        for (i, a) in all.iter().enumerate() {
            assert_eq!(a.distance(a), 0);
            for b in &all[..i] {
                assert_eq!(a.distance(b), b.distance(a));
                distances.push(f64::from(a.distance(b)));
            }
        }
        let mean = distances.iter().sum::<f64>() / distances.len() as f64;
        assert!((105.0..146.0).contains(&mean), "mean {mean}");
        let num_near = distances.iter().filter(|distance| **distance < 64.0).count();
        assert!(num_near * 20 < distances.len(), "{num_near} of {}", distances.len());
    }

    #[test]
    fn a_descriptor_is_the_same_whether_its_sums_are_shared_or_not() {
        let image = Texture::new(7).image(0.3, 1.1, 4.0);
        let sums = BoxSums::new(&image);
        for (x, y) in (0..image.height()).step_by(5).flat_map(|y| (0..image.width()).map(move |x| (x, y))) {
            assert_eq!(OrbDescriptor::with_sums(&image, &sums, x, y), OrbDescriptor::new(&image, x, y));
        }
        assert!(OrbDescriptor::with_sums(&image, &sums, usize::MAX - 20, 20).is_none());
        let tiny = GrayImage::new(3, 40);
        assert!(OrbDescriptor::with_sums(&tiny, &BoxSums::new(&tiny), 1, 20).is_none());
    }

    #[test]
    fn pieces_of_a_descriptor_are_its_bits() {
        let words = [0x0123_4567_89ab_cdef, 0xfedc_ba98_7654_3210, 0x5555_aaaa_3333_cccc, u64::MAX];
        let descriptor = OrbDescriptor::from_words(words);
        for (first, num) in [(0, 10), (60, 10), (64, 1), (120, 32), (246, 10)] {
            let expected = (0..num).map(|i| u32::from(descriptor.bit(first + i)) << i).sum::<u32>();
            assert_eq!(descriptor.bits(first, num), expected, "{first}, {num}");
        }
    }

    #[test]
    fn no_descriptor_at_the_border() {
        let image = GrayImage::new(64, 48);
        assert!(OrbDescriptor::new(&image, 15, 20).is_none() && OrbDescriptor::new(&image, 16, 32).is_none());
        assert!(OrbDescriptor::new(&image, 16, 31).is_some() && OrbDescriptor::new(&image, 47, 16).is_some());
        assert!(OrbDescriptor::new(&image, usize::MAX - 20, 20).is_none());
    }
}
