//! Straight edges from contours: the method of the documents.
//!
//! Source: 2017 section 5.3.1, after Solis et al. 2009: the image is normalized and smoothed, contours are followed where
//! the Laplacian changes its sign by more than a threshold, and cut into straight pieces.

use nalgebra::Point2;
use visloc_base::RgbImage;

use super::{EdgeSegment, gray::GrayImage, segment::Moments};

/// A contour is cut where it lies farther from the straight way between its ends, pixels.
const MAX_OFF_PX: f64 = 1.2;

/// Finds straight edges. Keeps its memory from image to image.
#[derive(Debug, Clone, Default)]
pub struct ContourDetector {
    gray: GrayImage,
    rows: Vec<i32>,
    smooth: Vec<i32>,
    laplacian: Vec<i32>,
    is_edge: Vec<bool>,
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
        self.find_contours(first_row, min_step);
        let (width, height) = (self.gray.width, self.gray.height);
        for y in first_row..height {
            for x in 0..width {
                if self.is_edge[y * width + x] {
                    self.follow(y * width + x);
                    cut(&self.chain, min_length_px, out);
                }
            }
        }
    }

    /// Stretches the brightness so that a hundredth of the pixels is black and a hundredth white.
    fn normalize(&mut self, first_row: usize) {
        let values = &mut self.gray.values[first_row * self.gray.width..];
        let mut counts = [0_usize; 256];
        values.iter().for_each(|value| counts[usize::from(*value)] += 1);
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
        for value in values {
            *value = ((usize::from(*value).saturating_sub(low) * 255) / (high - low)).min(255) as u8;
        }
    }

    /// Gaussian of five pixels (1, 4, 6, 4, 1) along both axes; 256 times as large.
    fn blur(&mut self, first_row: usize) {
        let (width, height) = (self.gray.width, self.gray.height);
        for buffer in [&mut self.rows, &mut self.smooth, &mut self.laplacian] {
            buffer.clear();
            buffer.resize(width * height, 0);
        }
        for y in first_row..height {
            let gray = self.gray.row(y);
            let row = &mut self.rows[y * width..(y + 1) * width];
            for (sum, five) in row[2..].iter_mut().zip(gray.windows(5)) {
                let v = |i: usize| i32::from(five[i]);
                *sum = v(0) + 4 * v(1) + 6 * v(2) + 4 * v(3) + v(4);
            }
        }
        for y in first_row + 2..height - 2 {
            for x in 2..width - 2 {
                let v = |dy: usize| self.rows[(y + dy - 2) * width + x];
                self.smooth[y * width + x] = v(0) + 4 * v(1) + 6 * v(2) + 4 * v(3) + v(4);
            }
        }
    }

    /// Marks where the Laplacian changes its sign, strongly enough.
    fn find_contours(&mut self, first_row: usize, min_step: f64) {
        let (width, height) = (self.gray.width, self.gray.height);
        for y in first_row + 3..height - 3 {
            for x in 3..width - 3 {
                let i = y * width + x;
                let s = &self.smooth;
                self.laplacian[i] = s[i - 1] + s[i + 1] + s[i - width] + s[i + width] - 4 * s[i];
            }
        }
        self.is_edge.clear();
        self.is_edge.resize(width * height, false);
        // The smoothed step's Laplacian swings by about a fifth of the step on both sides.
        let min_swing = (min_step * 256.0 * 0.35) as i32;
        for y in first_row + 4..height - 4 {
            for x in 4..width - 4 {
                let i = y * width + x;
                let here = self.laplacian[i];
                let crosses = |other: i32| (here > 0) != (other > 0) && (here - other).abs() >= min_swing;
                self.is_edge[i] = here > 0
                    && [1, width]
                        .iter()
                        .any(|step| crosses(self.laplacian[i + step]) || crosses(self.laplacian[i - step]));
            }
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

/// Cuts a chain of points into straight pieces (Ramer, Douglas and Peucker).
fn cut(chain: &[Point2<f64>], min_length_px: f64, out: &mut Vec<EdgeSegment>) {
    let [first, .., last] = chain else { return };
    if (chain.len() as f64) < 0.7 * min_length_px {
        return;
    }
    let chord = last - first;
    let off = |point: &Point2<f64>| match chord.try_normalize(1e-9) {
        Some(along) => along.perp(&(point - first)).abs(),
        None => (point - first).norm(),
    };
    let farthest = (0..chain.len()).max_by(|a, b| off(&chain[*a]).total_cmp(&off(&chain[*b]))).unwrap_or(0);
    if off(&chain[farthest]) > MAX_OFF_PX && farthest > 0 && farthest < chain.len() - 1 {
        cut(&chain[..=farthest], min_length_px, out);
        cut(&chain[farthest..], min_length_px, out);
        return;
    }
    if chord.norm() < min_length_px {
        return;
    }
    let mut moments = Moments::default();
    chain.iter().for_each(|point| moments.add(*point));
    out.push(EdgeSegment::fitted(moments, [*first, *last]));
}
