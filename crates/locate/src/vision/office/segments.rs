//! Straight edges by linking ridges of the gradient.
//!
//! After LSD (Grompone von Gioi et al. 2010) and `EDLines` (Akinlar and Topal 2011): a pixel is on an edge where the
//! gradient is largest across it; neighbors whose gradients point the same way belong to one edge; a line is fitted to
//! their positions between the pixels.

use nalgebra::{Point2, Vector2};
use visloc_core::RgbImage;

use super::{
    EdgeSegment,
    gray::{GrayImage, append_marked},
};
use crate::vision::line_fit::LineFit;

/// Sobel's sum of weights: a step of 1 between two flat areas gives this.
const SOBEL_GAIN: f64 = 4.0;
/// Directions of one edge differ by less than this: cosine squared of 20 degrees.
const SAME_DIRECTION_COS2: f64 = 0.883;
/// Largest root mean square distance of an edge's points from its line, pixels.
const MAX_RESIDUAL_PX: f64 = 0.7;

/// Finds straight edges. Keeps its memory from image to image.
#[derive(Debug, Clone, Default)]
pub struct GradientDetector {
    gray: GrayImage,
    gx: Vec<i16>,
    gy: Vec<i16>,
    strength: Vec<u16>,
    /// Whether a pixel is on a ridge that no edge has taken yet.
    is_open: Vec<bool>,
    ridge: Vec<u32>,
    stack: Vec<u32>,
    region: Vec<Point2<f64>>,
}

impl GradientDetector {
    /// Appends all straight edges of an image from a row on. `min_step` is the least step of brightness across an edge,
    /// `min_length_px` the least length.
    pub fn detect(
        &mut self,
        image: &RgbImage,
        first_row: usize,
        min_step: f64,
        min_length_px: f64,
        out: &mut Vec<EdgeSegment>,
    ) {
        let first_row = first_row.min(image.height() as usize);
        if image.width() < 5 || image.height() as usize - first_row < 5 {
            return;
        }
        self.gray.fill(image, first_row);
        self.differentiate(first_row);
        self.find_ridges(first_row, (min_step * SOBEL_GAIN) as u16);
        for i in 0..self.ridge.len() {
            let seed = self.ridge[i] as usize;
            if self.is_open[seed] {
                self.grow(seed);
                self.fit(0, self.region.len(), min_length_px, out, 0);
            }
        }
    }

    /// Sobel gradients of all inner pixels from a row on.
    fn differentiate(&mut self, first_row: usize) {
        let (width, height) = (self.gray.width, self.gray.height);
        for buffer in [&mut self.gx, &mut self.gy] {
            buffer.resize(width * height, 0);
        }
        self.strength.resize(width * height, 0);
        let count = width - 2;
        for y in first_row + 1..height - 1 {
            let [above, here, below] = [y - 1, y, y + 1].map(|y| {
                let row = self.gray.row(y);
                [&row[..count], &row[1..=count], &row[2..]]
            });
            let row = y * width + 1..(y + 1) * width - 1;
            let gx = &mut self.gx[row.clone()][..count];
            let gy = &mut self.gy[row.clone()][..count];
            let strength = &mut self.strength[row][..count];
            for x in 0..count {
                let v = |row: &[&[u8]; 3], i: usize| i16::from(row[i][x]);
                let dx = v(&above, 2) - v(&above, 0) + 2 * (v(&here, 2) - v(&here, 0)) + v(&below, 2)
                    - v(&below, 0);
                let dy = v(&below, 0) - v(&above, 0) + 2 * (v(&below, 1) - v(&above, 1)) + v(&below, 2)
                    - v(&above, 2);
                gx[x] = dx;
                gy[x] = dy;
                strength[x] = dx.unsigned_abs() + dy.unsigned_abs();
            }
        }
    }

    /// Pixels whose gradient is strong enough and the largest across the edge.
    fn find_ridges(&mut self, first_row: usize, min_strength: u16) {
        let (width, height) = (self.gray.width, self.gray.height);
        self.is_open.clear();
        self.is_open.resize(width * height, false);
        self.ridge.clear();
        for y in first_row + 2..height - 2 {
            let (from, count) = (y * width + 2, width - 4);
            let strength = |i: usize| &self.strength[i..i + count];
            let [left, here, right] = [from - 1, from, from + 1].map(strength);
            let [above, below] = [from - width, from + width].map(strength);
            let (gx, gy) = (&self.gx[from..from + count], &self.gy[from..from + count]);
            let is_open = &mut self.is_open[from..from + count];
            for x in 0..count {
                // Both directions and without shortcuts, so that this becomes vector instructions.
                let is_upright = gx[x].unsigned_abs() >= gy[x].unsigned_abs();
                let is_top_along_x = (here[x] >= left[x]) & (here[x] > right[x]);
                let is_top_along_y = (here[x] >= above[x]) & (here[x] > below[x]);
                let is_top = (is_upright & is_top_along_x) | (!is_upright & is_top_along_y);
                is_open[x] = is_top & (here[x] >= min_strength);
            }
            append_marked(is_open, from, &mut self.ridge);
        }
    }

    /// Takes all ridge pixels that hang together with the seed and whose gradients point the same way, in the order in
    /// which they lie along the edge from one end to the other.
    fn grow(&mut self, seed: usize) {
        self.region.clear();
        self.stack.clear();
        self.stack.push(seed as u32);
        self.is_open[seed] = false;
        let mut mean = Vector2::new(f64::from(self.gx[seed]), f64::from(self.gy[seed]));
        let width = self.gray.width;
        while let Some(i) = self.stack.pop() {
            let i = i as usize;
            self.region.push(self.between_pixels(i));
            for j in [
                i - width - 1,
                i - width,
                i - width + 1,
                i - 1,
                i + 1,
                i + width - 1,
                i + width,
                i + width + 1,
            ] {
                if !self.is_open[j] {
                    continue;
                }
                let gradient = Vector2::new(f64::from(self.gx[j]), f64::from(self.gy[j]));
                let along = gradient.dot(&mean);
                if along > 0.0
                    && along * along >= SAME_DIRECTION_COS2 * gradient.norm_squared() * mean.norm_squared()
                {
                    self.is_open[j] = false;
                    self.stack.push(j as u32);
                    mean += gradient;
                }
            }
        }
    }

    /// Where exactly the gradient is largest across the edge: the top of a parabola through three pixels.
    fn between_pixels(&self, i: usize) -> Point2<f64> {
        let width = self.gray.width;
        let is_upright = self.gx[i].unsigned_abs() >= self.gy[i].unsigned_abs();
        let across = if is_upright { 1 } else { width };
        let [before, here, after] = [i - across, i, i + across].map(|i| f64::from(self.strength[i]));
        let bend = before - 2.0 * here + after;
        let off = if bend < 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
        let (x, y) = ((i % width) as f64, (i / width) as f64);
        if is_upright { Point2::new(x + off, y) } else { Point2::new(x, y + off) }
    }

    /// Fits a line to a part of the region. A part that is not straight is cut in two.
    fn fit(&mut self, from: usize, to: usize, min_length_px: f64, out: &mut Vec<EdgeSegment>, depth: usize) {
        const MAX_DEPTH: usize = 4;
        let points = &mut self.region[from..to];
        if (points.len() as f64) < 0.7 * min_length_px {
            return;
        }
        let mut fit = LineFit::default();
        points.iter().for_each(|point| fit.add(point));
        let line = fit.line();
        let place = |point: &Point2<f64>| line.position(point);
        if line.rms_px <= MAX_RESIDUAL_PX {
            let first = points.iter().copied().min_by(|a, b| place(a).total_cmp(&place(b)));
            let last = points.iter().copied().max_by(|a, b| place(a).total_cmp(&place(b)));
            let (Some(first), Some(last)) = (first, last) else { return };
            let segment = EdgeSegment::fitted(fit, [first, last]);
            if segment.length_px() >= min_length_px {
                out.push(segment);
            }
            return;
        }
        if depth == MAX_DEPTH {
            return;
        }
        // Cut where the region bends most.
        points.sort_by(|a, b| place(a).total_cmp(&place(b)));
        let (first, last) = (points[0], points[points.len() - 1]);
        let chord = (last - first).try_normalize(1e-9).unwrap_or(line.along);
        let off = |point: &Point2<f64>| chord.perp(&(point - first)).abs();
        let bend = (0..points.len()).max_by(|a, b| off(&points[*a]).total_cmp(&off(&points[*b])));
        let cut = from + bend.unwrap_or(points.len() / 2).clamp(1, points.len() - 1);
        self.fit(from, cut, min_length_px, out, depth + 1);
        self.fit(cut, to, min_length_px, out, depth + 1);
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::RngTree;

    use super::*;
    use crate::vision::office::gray::tests::patches;

    /// What the detector does to a whole row at once, pixel by pixel.
    #[test]
    fn ridges_are_those_of_the_plain_formulas() {
        let rng = &mut RngTree::new(9).stream("ridges", 0);
        let mut detector = GradientDetector::default();
        for (width, height, first_row) in [(64, 48, 7), (37, 29, 0), (5, 5, 0), (90, 41, 20)] {
            let image = patches(width, height, rng);
            detector.detect(&image, first_row, 9.0, 7.0, &mut Vec::new());
            let expected = plain_ridges(&image, first_row, 9.0 * SOBEL_GAIN);
            assert_eq!(detector.ridge, expected, "{width} x {height} from row {first_row}");
            assert!(width < 20 || !expected.is_empty());
        }
    }

    fn plain_ridges(image: &RgbImage, first_row: usize, min_strength: f64) -> Vec<u32> {
        let mut gray = GrayImage::default();
        gray.fill(image, first_row);
        let v = |x: usize, y: usize| i32::from(gray.row(y)[x]);
        let gradient = |x: usize, y: usize| {
            let column = |x: usize| v(x, y - 1) + 2 * v(x, y) + v(x, y + 1);
            let row = |y: usize| v(x - 1, y) + 2 * v(x, y) + v(x + 1, y);
            [column(x + 1) - column(x - 1), row(y + 1) - row(y - 1)]
        };
        let strength = |x: usize, y: usize| gradient(x, y).map(i32::abs).iter().sum::<i32>();
        let mut ridges = Vec::new();
        for y in first_row + 2..gray.height - 2 {
            for x in 2..gray.width - 2 {
                let [dx, dy] = gradient(x, y).map(i32::abs);
                let (before, after) = if dx >= dy {
                    (strength(x - 1, y), strength(x + 1, y))
                } else {
                    (strength(x, y - 1), strength(x, y + 1))
                };
                let here = strength(x, y);
                if f64::from(here) >= min_strength && here >= before && here > after {
                    ridges.push((y * gray.width + x) as u32);
                }
            }
        }
        ridges
    }
}
