//! The two upright borders of something that may be a post: whether they are straight, alike, and go on as far as those of a post.

use nalgebra::{Point2, Vector2};

use super::view::GroundView;
use crate::vision::{BorderPixel, FeatureKind};

/// A post is looked at in so many heights.
pub(super) const HEIGHTS: usize = 24;
/// Where both have to be there, this share of both is seen, of each at least half: the bar at the foot of a net hides a part of one.
const MIN_SHARE_OF_BOTH: f64 = 0.75;
const MIN_SHARE_OF_EACH: f64 = 0.5;
/// Where one has to be there, this share of the better one.
const MIN_SHARE_ABOVE: f64 = 0.7;
/// Fewer heights than this tell nothing.
const MIN_SEEN: usize = 5;
/// How far a border may lie from a straight line: as a share of the width, and in pixels.
const MAX_BEND: f64 = 0.06;
const MAX_BEND_PX: f64 = 0.8;
/// Both borders run alike: the width at the top differs from that at the foot by at most this share.
const MAX_TAPER: f64 = 0.25;
/// An upright thing leans by at most this in the image, columns a row.
const MAX_SLOPE: f64 = 0.25;

/// What is seen of two upright borders.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct UprightBorders {
    /// Rows of the heights, pixels.
    pub rows: [f64; HEIGHTS],
    /// Columns of the left and the right border there.
    pub borders: [[Option<f64>; HEIGHTS]; 2],
    /// Where the wall behind is as bright as the post, so that the border cannot be seen.
    pub is_hidden: [[bool; HEIGHTS]; 2],
    /// How many heights were looked at.
    pub num: usize,
    /// Heights at which both borders, or one, have to be there.
    pub num_both: usize,
    pub num_one: usize,
    /// Column at row 0 and columns a row of both borders.
    lines: [(f64, f64); 2],
    /// How far a border may lie from its line, pixels.
    most_px: f64,
    /// Between both, in the middle of those heights where both have to be there.
    pub width_px: f64,
}

impl UprightBorders {
    /// Whether the borders are straight, alike, and go as high as they have to.
    pub fn judge(&mut self, foot_row: f64, width: f64, blur: f64) -> bool {
        if self.num_both < MIN_SEEN {
            return false;
        }
        let most = MAX_BEND * width + MAX_BEND_PX * blur;
        self.most_px = most;
        let (mut counts, mut visible) = ([[0; 2]; 2], [0; 2]);
        for (side, count) in counts.iter_mut().enumerate() {
            let Some(line) = self.straight(side, most) else { return false };
            self.lines[side] = line;
            let is_there = |i: &usize| self.is_on(side, *i, line, most);
            *count = [self.num_both, self.num_one].map(|num| (0..num).filter(is_there).count());
            visible[side] = (0..self.num_one).filter(|i| is_there(i) || !self.is_hidden[side][*i]).count();
        }
        let share = |count: usize, of: usize| count as f64 / of as f64;
        let width_at = |row: f64| self.column_of(1, row) - self.column_of(0, row);
        let (low, high) = (width_at(foot_row), width_at(self.rows[self.num_both - 1]));
        self.width_px = f64::midpoint(low, high);
        let [[left, left_above], [right, right_above]] = counts;
        share(left + right, 2 * self.num_both) >= MIN_SHARE_OF_BOTH
            && share(left.min(right), self.num_both) >= MIN_SHARE_OF_EACH
            && share(left_above, visible[0]).max(share(right_above, visible[1])) >= MIN_SHARE_ABOVE
            && (high - low).abs() <= MAX_TAPER * self.width_px + 1.0
    }

    /// The borders on their straight lines.
    pub fn add_borders(&self, view: &GroundView, out: &mut Vec<BorderPixel>) {
        for i in 0..self.num {
            for (side, inward) in [(0, Vector2::x()), (1, -Vector2::x())] {
                let on_line =
                    self.borders[side][i].filter(|_| self.is_on(side, i, self.lines[side], self.most_px));
                out.extend(on_line.map(|x| BorderPixel {
                    ideal_px: view.camera().ideal_px(&Point2::new(x, self.rows[i])),
                    inward,
                    kind: FeatureKind::WhiteGoal,
                }));
            }
        }
    }

    fn is_on(&self, side: usize, i: usize, (column, slope): (f64, f64), most: f64) -> bool {
        self.borders[side][i].is_some_and(|x| (x - column - slope * self.rows[i]).abs() <= most)
    }

    /// The straight line with the most columns of a border near it, of all through two of them; then the mean line of those.
    fn straight(&self, side: usize, most: f64) -> Option<(f64, f64)> {
        let mut best = (0, (0.0, 0.0));
        for i in 0..self.num_one {
            for j in i + 3..self.num_one {
                let Some((a, b)) = self.borders[side][i].zip(self.borders[side][j]) else { continue };
                let slope = (b - a) / (self.rows[j] - self.rows[i]);
                let line = (a - slope * self.rows[i], slope);
                let count = (0..self.num_one).filter(|k| self.is_on(side, *k, line, most)).count();
                if count > best.0 && slope.abs() < MAX_SLOPE {
                    best = (count, line);
                }
            }
        }
        if best.0 < 3 {
            return None;
        }
        let (mut n, mut x, mut y, mut xy, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for k in (0..self.num_one).filter(|k| self.is_on(side, *k, best.1, most)) {
            let (column, row) = (self.borders[side][k]?, self.rows[k]);
            n += 1.0;
            x += column;
            y += row;
            xy += column * row;
            yy += row * row;
        }
        let slope = (n * xy - x * y) / (n * yy - y * y);
        Some(((x - slope * y) / n, slope))
    }

    fn column_of(&self, side: usize, row: f64) -> f64 {
        self.lines[side].0 + self.lines[side].1 * row
    }

    /// Column of the axis, raw pixels.
    pub fn column_at(&self, row: f64) -> f64 {
        f64::midpoint(self.column_of(0, row), self.column_of(1, row))
    }
}
