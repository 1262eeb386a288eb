//! FAST corners.

use std::ops::Range;

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
    let all = 0..image.width();
    for_each_corner(image, threshold, |_| std::slice::from_ref(&all), |corner, _| corners.push(corner));
}

/// As [`detect_fast`] within some columns of each row (from left to right), and whether each corner is one with a higher threshold, too.
pub fn detect_graded_fast<'a>(
    image: &GrayImage,
    (threshold, high_threshold): (u8, u8),
    columns: impl Fn(usize) -> &'a [Range<usize>],
    mut take: impl FnMut(FastCorner, bool),
) {
    for_each_corner(image, threshold, columns, |corner, strength| take(corner, strength > high_threshold));
}

/// Each corner with its strength: the highest threshold up to which it is one, and one more.
fn for_each_corner<'a>(
    image: &GrayImage,
    threshold: u8,
    columns: impl Fn(usize) -> &'a [Range<usize>],
    mut take: impl FnMut(FastCorner, u8),
) {
    let (width, height) = (image.width(), image.height());
    if width < 2 * FAST_RADIUS_PX + BLOCK || height <= 2 * FAST_RADIUS_PX {
        return;
    }
    let end = width - FAST_RADIUS_PX;
    for y in FAST_RADIUS_PX..height - FAST_RADIUS_PX {
        for range in columns(y) {
            let mut x = range.start.max(FAST_RADIUS_PX);
            while x < range.end.min(end) {
                // The last block of a row overlaps the one before.
                let start = x.min(end - BLOCK);
                let past = (start + BLOCK).min(range.end);
                let strengths = block_strengths(image, start, y, threshold);
                for (strength, x) in strengths.iter().flat_map(|s| &s[x - start..past - start]).zip(x..) {
                    if *strength > threshold {
                        take(FastCorner { x: x as u32, y: y as u32 }, *strength);
                    }
                }
                x = past;
            }
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

/// Of each pixel of the block the least difference to the center of the nine neighbors in a row on the circle, all brighter or all darker,
/// that differ most. `None` if certainly none is above the threshold.
#[inline]
fn block_strengths(image: &GrayImage, x: usize, y: usize, threshold: u8) -> Option<[u8; BLOCK]> {
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
    // Nine in a row hold two neighbors of the four compass points: one of each two that face each other.
    let (top, right, bottom, left) = (block(0), block(4), block(8), block(12));
    let mut candidates = 0_u8;
    for i in 0..BLOCK {
        let is_brighter = |side: &[u8; BLOCK]| u8::from(side[i] > high[i]);
        let is_darker = |side: &[u8; BLOCK]| u8::from(side[i] < low[i]);
        candidates |= (is_brighter(&top) | is_brighter(&bottom)) & (is_brighter(&left) | is_brighter(&right));
        candidates |= (is_darker(&top) | is_darker(&bottom)) & (is_darker(&left) | is_darker(&right));
    }
    if candidates == 0 {
        return None;
    }
    let (mut brighter, mut darker) = ([0_u8; WOUND], [0_u8; WOUND]);
    let lines = brighter.chunks_exact_mut(BLOCK).zip(darker.chunks_exact_mut(BLOCK));
    for (i, (brighter, darker)) in lines.enumerate() {
        let side = block(i % CIRCLE.len());
        for lane in 0..BLOCK {
            brighter[lane] = side[lane].saturating_sub(center[lane]);
            darker[lane] = center[lane].saturating_sub(side[lane]);
        }
    }
    let (brighter, darker) = (strongest_nine(&brighter), strongest_nine(&darker));
    let mut strengths = [0; BLOCK];
    for lane in 0..BLOCK {
        strengths[lane] = brighter[lane].max(darker[lane]);
    }
    Some(strengths)
}

/// Values of a block around its circle one and a half times, so that each row of nine lies in one piece.
const WOUND: usize = (CIRCLE.len() + 8) * BLOCK;

/// Of nine neighbors in a row on the circle the least, and of all such rows the greatest.
#[inline]
fn strongest_nine(ring: &[u8; WOUND]) -> [u8; BLOCK] {
    let (mut least, mut of_nine) = (*ring, [0; CIRCLE.len() * BLOCK]);
    // Least of two neighbors, of four, of eight.
    for reach in [1, 2, 4] {
        for i in 0..WOUND - 8 * BLOCK + (8 - 2 * reach) * BLOCK {
            least[i] = least[i].min(least[i + reach * BLOCK]);
        }
    }
    for (i, of_nine) in of_nine.iter_mut().enumerate() {
        *of_nine = least[i].min(ring[i + 8 * BLOCK]);
    }
    let mut strongest = [0; BLOCK];
    for line in of_nine.chunks_exact(BLOCK) {
        for lane in 0..BLOCK {
            strongest[lane] = strongest[lane].max(line[lane]);
        }
    }
    strongest
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
            let columns = [0..9, 12..13, 20..41];
            let mut graded = Vec::new();
            let take = |corner, is_clear| graded.push((corner, is_clear));
            detect_graded_fast(&image, (threshold, threshold + 30), |_| &columns, take);
            let (corners, is_clear): (Vec<FastCorner>, Vec<bool>) = graded.into_iter().unzip();
            expected.retain(|corner| columns.iter().any(|range| range.contains(&(corner.x as usize))));
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
