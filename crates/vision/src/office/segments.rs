//! Straight edges by linking ridges of the gradient.
//!
//! After LSD (Grompone von Gioi et al. 2010) and `EDLines` (Akinlar and Topal 2011): a pixel is on an edge where the
//! gradient is largest across it; neighbors whose gradients point the same way belong to one edge; a line is fitted to
//! their positions between the pixels.

use nalgebra::{Point2, Vector2};
use visloc_base::RgbImage;

use super::{EdgeSegment, gray::GrayImage, segment::Moments};

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
        for y in first_row + 1..height - 1 {
            let [above, here, below] = [y - 1, y, y + 1].map(|y| self.gray.row(y));
            let row = y * width + 1..(y + 1) * width - 1;
            let gx = &mut self.gx[row.clone()];
            let gy = &mut self.gy[row.clone()];
            let strength = &mut self.strength[row];
            let v = |value: u8| i16::from(value);
            for x in 0..width - 2 {
                let dx = v(above[x + 2]) - v(above[x]) + 2 * (v(here[x + 2]) - v(here[x])) + v(below[x + 2])
                    - v(below[x]);
                let dy =
                    v(below[x]) - v(above[x]) + 2 * (v(below[x + 1]) - v(above[x + 1])) + v(below[x + 2])
                        - v(above[x + 2]);
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
            for x in 2..width - 2 {
                let i = y * width + x;
                let here = self.strength[i];
                if here < min_strength {
                    continue;
                }
                let across = if self.gx[i].unsigned_abs() >= self.gy[i].unsigned_abs() { 1 } else { width };
                if here >= self.strength[i - across] && here > self.strength[i + across] {
                    self.is_open[i] = true;
                    self.ridge.push(i as u32);
                }
            }
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
        let mut moments = Moments::default();
        points.iter().for_each(|point| moments.add(*point));
        let (middle, along, residual2) = moments.line();
        let place = |point: &Point2<f64>| (point - middle).dot(&along);
        if residual2 <= MAX_RESIDUAL_PX * MAX_RESIDUAL_PX {
            let first = points.iter().copied().min_by(|a, b| place(a).total_cmp(&place(b)));
            let last = points.iter().copied().max_by(|a, b| place(a).total_cmp(&place(b)));
            let (Some(first), Some(last)) = (first, last) else { return };
            let segment = EdgeSegment::fitted(moments, [first, last]);
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
        let chord = (last - first).try_normalize(1e-9).unwrap_or(along);
        let off = |point: &Point2<f64>| chord.perp(&(point - first)).abs();
        let bend = (0..points.len()).max_by(|a, b| off(&points[*a]).total_cmp(&off(&points[*b])));
        let cut = from + bend.unwrap_or(points.len() / 2).clamp(1, points.len() - 1);
        self.fit(from, cut, min_length_px, out, depth + 1);
        self.fit(cut, to, min_length_px, out, depth + 1);
    }
}
