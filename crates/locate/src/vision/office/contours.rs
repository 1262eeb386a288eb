//! Straight edges from contours: the method of the documents.
//!
//! Source: 2017 section 5.3.1, after Solis et al. 2009: the image is normalized and smoothed, contours are followed where
//! the Laplacian changes its sign by more than a threshold, and cut into straight pieces.

use nalgebra::Point2;
use visloc_core::RgbImage;

use super::{
    EdgeSegment,
    gray::{GrayImage, append_marked},
};
use crate::vision::line_fit::LineFit;

/// A contour is cut where it lies farther from the straight way between its ends, pixels.
const MAX_OFF_PX: f64 = 1.2;

/// Finds straight edges. Keeps its memory from image to image.
#[derive(Debug, Clone, Default)]
pub struct ContourDetector {
    gray: GrayImage,
    rows: Vec<u16>,
    smooth: Vec<u16>,
    laplacian: Vec<i32>,
    /// Whether a pixel is on a contour that has not been followed yet.
    is_edge: Vec<bool>,
    edges: Vec<u32>,
    chain: Vec<Point2<f64>>,
    tail: Vec<Point2<f64>>,
}

impl ContourDetector {
    /// As [`super::GradientDetector::detect`].
    pub fn detect(
        &mut self,
        image: &RgbImage,
        first_row: usize,
        min_step: f64,
        min_length_px: f64,
        out: &mut Vec<EdgeSegment>,
    ) {
        let first_row = first_row.min(image.height() as usize);
        if image.width() < 9 || image.height() as usize - first_row < 9 {
            return;
        }
        self.gray.fill(image, first_row);
        self.normalize(first_row);
        self.blur(first_row);
        self.differentiate(first_row);
        self.find_contours(first_row, min_step);
        for i in 0..self.edges.len() {
            let seed = self.edges[i] as usize;
            if self.is_edge[seed] {
                self.follow(seed);
                cut(&self.chain, min_length_px, out);
            }
        }
    }

    /// Stretches the brightness so that a hundredth of the pixels is black and a hundredth white.
    fn normalize(&mut self, first_row: usize) {
        let values = &mut self.gray.values[first_row * self.gray.width..];
        let counts = histogram(values);
        let share = values.len() / 100;
        let quantile = |limit: usize| {
            let mut sum = 0;
            counts.iter().position(|count| {
                sum += count;
                sum > limit
            })
        };
        let low = quantile(share).unwrap_or(0);
        let high = quantile(values.len() - 1 - share).unwrap_or(255).max(low + 1);
        let stretched: [u8; 256] =
            std::array::from_fn(|value| ((value.saturating_sub(low) * 255) / (high - low)).min(255) as u8);
        for value in values {
            *value = stretched[usize::from(*value)];
        }
    }

    /// Gaussian of five pixels (1, 4, 6, 4, 1) along both axes; 256 times as large, so that 16 bits just hold it. The
    /// outermost two pixels keep what they had.
    fn blur(&mut self, first_row: usize) {
        let (width, height) = (self.gray.width, self.gray.height);
        self.rows.resize(width * height, 0);
        self.smooth.resize(width * height, 0);
        for y in first_row..height {
            let gray = self.gray.row(y);
            let five: [&[u8]; 5] = std::array::from_fn(|i| &gray[i..i + width - 4]);
            let sums = &mut self.rows[y * width + 2..(y + 1) * width - 2];
            for (x, sum) in sums.iter_mut().enumerate() {
                *sum = weighted(five.map(|column| u16::from(column[x])));
            }
        }
        for y in first_row + 2..height - 2 {
            let row = |y: usize| &self.rows[y * width + 2..(y + 1) * width - 2];
            let five = [row(y - 2), row(y - 1), row(y), row(y + 1), row(y + 2)];
            let sums = &mut self.smooth[y * width + 2..(y + 1) * width - 2];
            for (x, sum) in sums.iter_mut().enumerate() {
                *sum = weighted(five.map(|row| row[x]));
            }
        }
    }

    /// The Laplacian, 256 times as large. The outermost three pixels keep what they had.
    fn differentiate(&mut self, first_row: usize) {
        let (width, height) = (self.gray.width, self.gray.height);
        self.laplacian.resize(width * height, 0);
        for y in first_row + 3..height - 3 {
            let cross = Cross::new(&self.smooth, y, width, 3);
            let sums = &mut self.laplacian[y * width + 3..(y + 1) * width - 3];
            for (x, sum) in sums.iter_mut().enumerate() {
                let [here, left, right, above, below] = cross.at(x).map(i32::from);
                *sum = left + right + above + below - 4 * here;
            }
        }
    }

    /// Marks where the Laplacian changes its sign, strongly enough.
    fn find_contours(&mut self, first_row: usize, min_step: f64) {
        let (width, height) = (self.gray.width, self.gray.height);
        self.is_edge.clear();
        self.is_edge.resize(width * height, false);
        self.edges.clear();
        // The smoothed step's Laplacian swings by about a fifth of the step on both sides.
        let min_swing = (min_step * 256.0 * 0.35) as i32;
        for y in first_row + 4..height - 4 {
            let cross = Cross::new(&self.laplacian, y, width, 4);
            let inner = y * width + 4..(y + 1) * width - 4;
            let is_edge = &mut self.is_edge[inner.clone()];
            for (x, is_edge) in is_edge.iter_mut().enumerate() {
                let [here, left, right, above, below] = cross.at(x);
                let lowest = left.min(right).min(above).min(below);
                // Without shortcuts, so that this becomes vector instructions.
                *is_edge = (here > 0) & (lowest <= 0) & (here - lowest >= min_swing);
            }
            append_marked(is_edge, inner.start, &mut self.edges);
        }
    }

    /// Follows a contour from a pixel to both sides and takes its pixels away.
    fn follow(&mut self, seed: usize) {
        let mut chain = std::mem::take(&mut self.chain);
        let mut tail = std::mem::take(&mut self.tail);
        chain.clear();
        tail.clear();
        self.is_edge[seed] = false;
        self.walk(seed, &mut tail);
        self.walk(seed, &mut chain);
        chain.reverse();
        chain.push(self.zero(seed));
        chain.extend_from_slice(&tail);
        (self.chain, self.tail) = (chain, tail);
    }

    fn walk(&mut self, seed: usize, out: &mut Vec<Point2<f64>>) {
        let width = self.gray.width;
        let mut i = seed;
        loop {
            // Straight neighbors first, so that corners are not skipped.
            let around = [
                i - 1,
                i + 1,
                i - width,
                i + width,
                i - width - 1,
                i - width + 1,
                i + width - 1,
                i + width + 1,
            ];
            let Some(next) = around.into_iter().find(|j| self.is_edge[*j]) else { return };
            self.is_edge[next] = false;
            out.push(self.zero(next));
            i = next;
        }
    }

    /// Where the Laplacian is zero beside a pixel, in the direction in which it falls most.
    fn zero(&self, i: usize) -> Point2<f64> {
        let width = self.gray.width;
        let here = self.laplacian[i];
        let neighbors = [(1_isize, 0_isize), (-1, 0), (0, 1), (0, -1)];
        let value =
            |(dx, dy): (isize, isize)| self.laplacian[i.wrapping_add_signed(dx + dy * width as isize)];
        let steepest = neighbors.into_iter().min_by_key(|step| value(*step)).unwrap_or((0, 0));
        let fall = f64::from(here - value(steepest)).max(1.0);
        let part = (f64::from(here) / fall).clamp(0.0, 1.0);
        let (x, y) = ((i % width) as f64, (i / width) as f64);
        Point2::new(x + part * steepest.0 as f64, y + part * steepest.1 as f64)
    }
}

/// How often each value is there. Counted in four parts: neighbors are often equal, and a count that was just written is
/// slow to read.
fn histogram(values: &[u8]) -> [usize; 256] {
    let mut parts = [[0_u32; 256]; 4];
    let (fours, rest) = values.as_chunks::<4>();
    for four in fours {
        for (part, value) in parts.iter_mut().zip(four) {
            part[usize::from(*value)] += 1;
        }
    }
    rest.iter().for_each(|value| parts[0][usize::from(*value)] += 1);
    std::array::from_fn(|value| parts.iter().map(|part| part[value] as usize).sum())
}

/// Five values in a row by the weights 1, 4, 6, 4, 1.
#[inline]
fn weighted(five: [u16; 5]) -> u16 {
    five[0] + five[4] + 4 * (five[1] + five[3]) + 6 * five[2]
}

/// A row of an image, as far as `margin` pixels from its ends, with the neighbors of each of its pixels.
struct Cross<'a, T> {
    rows: [&'a [T]; 5],
}

impl<'a, T: Copy> Cross<'a, T> {
    fn new(values: &'a [T], y: usize, width: usize, margin: usize) -> Self {
        let (from, count) = (y * width + margin, width - 2 * margin);
        Self { rows: [from, from - 1, from + 1, from - width, from + width].map(|i| &values[i..i + count]) }
    }

    /// A pixel, counted from the margin, and what is left of it, right, above and below.
    #[inline]
    fn at(&self, x: usize) -> [T; 5] {
        self.rows.map(|row| row[x])
    }
}

/// Cuts a chain of points into straight pieces (Ramer, Douglas and Peucker).
fn cut(chain: &[Point2<f64>], min_length_px: f64, out: &mut Vec<EdgeSegment>) {
    let [first, .., last] = chain else { return };
    if (chain.len() as f64) < 0.7 * min_length_px {
        return;
    }
    let chord = last - first;
    let along = chord.try_normalize(1e-9);
    let off = |point: &Point2<f64>| match along {
        Some(along) => along.perp(&(point - first)).abs(),
        None => (point - first).norm(),
    };
    let (mut farthest, mut farthest_px) = (0, 0.0);
    for (i, point) in chain.iter().enumerate() {
        let off_px = off(point);
        if off_px >= farthest_px {
            (farthest, farthest_px) = (i, off_px);
        }
    }
    if farthest_px > MAX_OFF_PX && farthest > 0 && farthest < chain.len() - 1 {
        cut(&chain[..=farthest], min_length_px, out);
        cut(&chain[farthest..], min_length_px, out);
        return;
    }
    if chord.norm() < min_length_px {
        return;
    }
    let mut fit = LineFit::default();
    chain.iter().for_each(|point| fit.add(point));
    out.push(EdgeSegment::fitted(fit, [*first, *last]));
}

#[cfg(test)]
mod tests {
    use visloc_core::RngTree;

    use super::*;
    use crate::vision::office::gray::tests::patches;

    /// What the detector does to a whole row at once, pixel by pixel as it is written in the documents.
    #[test]
    fn contours_are_those_of_the_plain_formulas() {
        let rng = &mut RngTree::new(8).stream("contours", 0);
        let mut detector = ContourDetector::default();
        // One detector for images of several sizes: nothing of an image may be left in the next one.
        for (width, height, first_row) in [(64, 48, 7), (37, 29, 0), (9, 9, 0), (90, 41, 20)] {
            let image = patches(width, height, rng);
            detector.detect(&image, first_row, 9.0, 7.0, &mut Vec::new());
            let expected = plain_contours(&image, first_row, 9.0);
            assert_eq!(detector.edges, expected, "{width} x {height} from row {first_row}");
            assert!(width < 20 || !expected.is_empty());
        }
    }

    fn plain_contours(image: &RgbImage, first_row: usize, min_step: f64) -> Vec<u32> {
        let mut gray = GrayImage::default();
        gray.fill(image, first_row);
        let (width, height) = (gray.width, gray.height);
        let mut sorted: Vec<i32> = gray.values[first_row * width..].iter().map(|v| i32::from(*v)).collect();
        sorted.sort_unstable();
        let share = sorted.len() / 100;
        let (low, high) = (sorted[share], sorted[sorted.len() - 1 - share]);
        let bright = |x: usize, y: usize| {
            ((i32::from(gray.row(y)[x]) - low) * 255 / (high - low).max(1)).clamp(0, 255)
        };
        let weights = [1, 4, 6, 4, 1];
        let smooth = |x: usize, y: usize| -> i32 {
            let row = |y: usize| (0..5).map(|i| weights[i] * bright(x + i - 2, y)).sum::<i32>();
            (0..5).map(|i| weights[i] * row(y + i - 2)).sum()
        };
        let laplacian = |x: usize, y: usize| {
            smooth(x - 1, y) + smooth(x + 1, y) + smooth(x, y - 1) + smooth(x, y + 1) - 4 * smooth(x, y)
        };
        let min_swing = (min_step * 256.0 * 0.35) as i32;
        let mut edges = Vec::new();
        for y in first_row + 4..height - 4 {
            for x in 4..width - 4 {
                let here = laplacian(x, y);
                let others =
                    [laplacian(x - 1, y), laplacian(x + 1, y), laplacian(x, y - 1), laplacian(x, y + 1)];
                let crosses = |other: &i32| (here > 0) != (*other > 0) && (here - other).abs() >= min_swing;
                if here > 0 && others.iter().any(crosses) {
                    edges.push((y * width + x) as u32);
                }
            }
        }
        edges
    }
}
