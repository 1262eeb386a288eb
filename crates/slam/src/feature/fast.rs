//! FAST corners.

use visloc_core::GrayImage;

/// Radius of the circle, pixels; no corner lies closer to the border.
pub const FAST_RADIUS_PX: usize = 3;

/// The circle of 16 pixels, clockwise from the top.
const CIRCLE: [(isize, isize); 16] = [
    (0, -3),
    (1, -3),
    (2, -2),
    (3, -1),
    (3, 0),
    (3, 1),
    (2, 2),
    (1, 3),
    (0, 3),
    (-1, 3),
    (-2, 2),
    (-3, 1),
    (-3, 0),
    (-3, -1),
    (-2, -2),
    (-1, -3),
];

/// Pixels that are looked at together; the compiler turns the loops over them into vector instructions.
const BLOCK: usize = 16;

/// A corner, in the pixels of the image that was searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FastCorner {
    /// Column, pixels.
    pub x: u32,
    /// Row, pixels.
    pub y: u32,
}

/// Appends all corners of a row-ordered search: pixels with nine neighbors in a row on the circle that are all brighter
/// or all darker than the center by more than `threshold`. Without suppression of neighbors.
///
/// Source: Rosten and Drummond, "Machine learning for high-speed corner detection", 2006 (FAST-9).
pub fn detect_fast(image: &GrayImage, threshold: u8, corners: &mut Vec<FastCorner>) {
    for_each_block(image, |x, y, num_before| {
        let hits = block_hits(image, x, y, threshold);
        for i in (num_before..BLOCK).filter(|i| hits[*i] != 0) {
            corners.push(FastCorner { x: (x + i) as u32, y: y as u32 });
        }
    });
}

/// As [`detect_fast`], and whether each corner is one with a higher threshold, too.
pub fn detect_graded_fast(
    image: &GrayImage,
    (threshold, high_threshold): (u8, u8),
    corners: &mut Vec<(FastCorner, bool)>,
) {
    for_each_block(image, |x, y, num_before| {
        let hits = block_hits(image, x, y, threshold);
        if hits == [0; BLOCK] {
            return;
        }
        let clear = block_hits(image, x, y, high_threshold);
        for i in (num_before..BLOCK).filter(|i| hits[*i] != 0) {
            corners.push((FastCorner { x: (x + i) as u32, y: y as u32 }, clear[i] != 0));
        }
    });
}

/// Column and row of each block, and how many of its first pixels are those of the block before.
fn for_each_block(image: &GrayImage, mut take: impl FnMut(usize, usize, usize)) {
    let (width, height) = (image.width(), image.height());
    if width < 2 * FAST_RADIUS_PX + BLOCK || height <= 2 * FAST_RADIUS_PX {
        return;
    }
    for y in FAST_RADIUS_PX..height - FAST_RADIUS_PX {
        let end = width - FAST_RADIUS_PX;
        let mut x = FAST_RADIUS_PX;
        while x < end {
            // The last block overlaps the one before.
            let start = x.min(end - BLOCK);
            take(start, y, x - start);
            x = start + BLOCK;
        }
    }
}

/// How clear a corner is: the sum of the differences to the center that are above the threshold.
#[must_use]
pub fn fast_score(image: &GrayImage, corner: FastCorner, threshold: u8) -> u16 {
    let width = image.width() as isize;
    let middle = corner.y as isize * width + corner.x as isize;
    let center = image.data()[middle as usize];
    let difference = |(dx, dy): &(isize, isize)| {
        let value = image.data()[(middle + dy * width + dx) as usize];
        u16::from(value.abs_diff(center).saturating_sub(threshold))
    };
    CIRCLE.iter().map(difference).sum()
}

/// Nonzero where a pixel of the block is a corner.
#[inline]
fn block_hits(image: &GrayImage, x: usize, y: usize, threshold: u8) -> [u16; BLOCK] {
    let width = image.width() as isize;
    let origin = (y * image.width() + x) as isize;
    let block = |i: usize| -> [u8; BLOCK] {
        let (dx, dy) = CIRCLE[i];
        let start = (origin + dy * width + dx) as usize;
        let mut values = [0; BLOCK];
        values.copy_from_slice(&image.data()[start..start + BLOCK]);
        values
    };
    let mut center = [0_u8; BLOCK];
    center.copy_from_slice(&image.data()[origin as usize..origin as usize + BLOCK]);
    let high = center.map(|c| c.saturating_add(threshold));
    let low = center.map(|c| c.saturating_sub(threshold));
    // Nine in a row hold two neighbors of the four compass points.
    let compass = [block(0), block(4), block(8), block(12)];
    let mut candidates = 0_u8;
    for i in 0..BLOCK {
        let (mut brighter, mut darker) = (0_u8, 0_u8);
        for side in &compass {
            brighter += u8::from(side[i] > high[i]);
            darker += u8::from(side[i] < low[i]);
        }
        candidates |= u8::from(brighter >= 2) | u8::from(darker >= 2);
    }
    if candidates == 0 {
        return [0; BLOCK];
    }
    let (mut brighter, mut darker) = ([0_u16; BLOCK], [0_u16; BLOCK]);
    for bit in 0..16 {
        let side = block(bit);
        for i in 0..BLOCK {
            brighter[i] |= u16::from(side[i] > high[i]) << bit;
            darker[i] |= u16::from(side[i] < low[i]) << bit;
        }
    }
    let mut hits = [0; BLOCK];
    for i in 0..BLOCK {
        hits[i] = nine_in_a_row(brighter[i]) | nine_in_a_row(darker[i]);
    }
    hits
}

/// Nonzero if nine neighboring bits of the ring are set.
#[inline]
fn nine_in_a_row(ring: u16) -> u16 {
    let two = ring & ring.rotate_right(1);
    let four = two & two.rotate_right(2);
    let eight = four & four.rotate_right(4);
    eight & ring.rotate_right(8)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn is_corner_by_definition(image: &GrayImage, x: usize, y: usize, threshold: u8) -> bool {
        let center = i16::from(image.get(x, y));
        let ring: Vec<i16> = CIRCLE
            .iter()
            .map(|(dx, dy)| {
                let at = image.get((x as isize + dx) as usize, (y as isize + dy) as usize);
                i16::from(at) - center
            })
            .collect();
        let t = i16::from(threshold);
        (0..16).any(|s| (0..9).all(|i| ring[(s + i) % 16] > t) || (0..9).all(|i| ring[(s + i) % 16] < -t))
    }

    proptest! {
        #[test]
        fn finds_exactly_the_corners_of_the_definition(
            data in prop::collection::vec(prop::sample::select(vec![10_u8, 60, 70, 128, 250]), 41 * 15),
            threshold in 1_u8..80,
        ) {
            let image = GrayImage::from_raw(41, 15, data).unwrap();
            let mut corners = Vec::new();
            detect_fast(&image, threshold, &mut corners);
            let mut expected = Vec::new();
            for y in 3..12 {
                for x in 3..38 {
                    if is_corner_by_definition(&image, x, y, threshold) {
                        expected.push(FastCorner { x: x as u32, y: y as u32 });
                    }
                }
            }
            prop_assert_eq!(&corners, &expected);
            let mut graded = Vec::new();
            detect_graded_fast(&image, (threshold, threshold + 30), &mut graded);
            let (corners, is_clear): (Vec<FastCorner>, Vec<bool>) = graded.into_iter().unzip();
            prop_assert_eq!(&corners, &expected);
            for (corner, is_clear) in expected.iter().zip(is_clear) {
                let (x, y) = (corner.x as usize, corner.y as usize);
                prop_assert_eq!(is_clear, is_corner_by_definition(&image, x, y, threshold + 30));
            }
        }
    }

    #[test]
    fn tiny_images_have_no_corners() {
        let mut corners = Vec::new();
        detect_fast(&GrayImage::new(5, 5), 10, &mut corners);
        assert!(corners.is_empty());
    }
}
