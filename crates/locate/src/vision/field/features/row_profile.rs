//! The brightness along a part of an image row, and where it changes.

use nalgebra::Point2;

use super::view::GroundView;

/// Columns of a third of a post's width, pixels.
pub(super) fn third_of(width_px: f64) -> i64 {
    ((width_px / 3.0).round() as i64).max(1)
}

/// Sums of the brightness along a part of a row.
#[derive(Debug, Default)]
pub(super) struct RowProfile {
    first: i64,
    /// Of all columns from the first one on, before each.
    sums: Vec<f64>,
}

impl RowProfile {
    /// Reads the columns so far to both sides of a pixel, which must be in the image. Beyond the image it goes on as at its edge.
    pub fn read(&mut self, view: &GroundView, middle: &Point2<f64>, reach: f64) -> bool {
        let (from, to) = ((middle.x - reach).floor() as i64, (middle.x + reach).ceil() as i64);
        self.first = from;
        self.sums.clear();
        self.sums.push(0.0);
        let last = i64::from(view.width()) - 1;
        if !(0.0..=last as f64).contains(&middle.x) {
            return false;
        }
        let Some(luma) = view.lumas_around(middle.y) else { return false };
        let mut sum = 0.0;
        self.sums.extend((from..to + 1).map(|x| {
            sum += luma(x.clamp(0, last) as usize);
            sum
        }));
        true
    }

    /// Mean brightness of some columns.
    pub fn mean(&self, from: i64, num: i64) -> f64 {
        (self.sum_before(from + num) - self.sum_before(from)) / num as f64
    }

    /// By how much it is brighter from a column on than before it, so many columns each.
    #[inline]
    fn change(&self, x: i64, num: i64) -> f64 {
        let here = self.sum_before(x);
        (self.sum_before(x + num) - here) / num as f64 - (here - self.sum_before(x - num)) / num as f64
    }

    /// Sum of all columns before one.
    #[inline]
    fn sum_before(&self, x: i64) -> f64 {
        let last = self.sums.len() as i64 - 1;
        self.sums[(x - self.first).clamp(0, last) as usize]
    }

    /// Whether the brightness nowhere changes by so much from one column to another.
    pub fn is_even(&self, from: f64, to: f64, num: i64, most: f64) -> bool {
        let (from, to) = (from.min(to).round() as i64, from.max(to).round() as i64);
        (from..=to).all(|x| self.change(x, num).abs() < most)
    }

    /// Where the brightness changes most near a column, rising or falling if only one counts, if it changes by so much. What is compared
    /// is a third of the post's width on both sides, so that no cord of a net is a border.
    pub fn strongest_edge(&self, near: f64, width: f64, sign: Option<f64>, least: f64) -> Option<f64> {
        let num = third_of(width);
        let change = |x: i64| sign.map_or(self.change(x, num).abs(), |sign| sign * self.change(x, num));
        let reach = width / 3.0 + 1.0;
        let (from, to) = ((near - reach).round() as i64, (near + reach).round() as i64);
        let (most, x) = (from..=to).map(|x| (change(x), x)).max_by(|a, b| a.0.total_cmp(&b.0))?;
        if most < least {
            return None;
        }
        let (before, after) = (change(x - 1), change(x + 1));
        let bend = 2.0 * most - before - after;
        let shift = if bend > 1e-9 { (0.5 * (after - before) / bend).clamp(-0.5, 0.5) } else { 0.0 };
        // The change is between two columns.
        Some(x as f64 - 0.5 + shift)
    }
}
