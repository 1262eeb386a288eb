//! Goal posts: upright runs of one color and of the width of a post at the distance of its foot.

use nalgebra::{Point2, Vector2};
use visloc_world::field::GoalColor;

use super::view::{GroundView, Seen};
use crate::vision::{
    GoalPost, PostSide,
    color::ColorClass,
    field::{
        FieldEnd,
        scan::{Run, ScanLine},
    },
    line_fit::LineFit,
};

/// Thinnest run of a post, pixels.
const MIN_RUN_PX: u32 = 3;
/// How far the borders of a post move from scan line to scan line, pixels a row, and at least.
const MAX_SLOPE: f64 = 0.2;
const MIN_MOVE_PX: f64 = 1.6;
/// A post covers so many scan lines and is so many times as high as wide.
const MIN_ROWS: usize = 4;
const MIN_ASPECT: f64 = 2.0;
/// Only a post that is this many times as high as wide is believed without a foot.
const MIN_ASPECT_WITHOUT_FOOT: f64 = 4.0;
/// The width of a post, as a share of what the distance of its foot demands. That distance is uncertain: a tilt that is off by a degree
/// makes 3.4 m of 4 m.
pub(super) const WIDTH_RANGE: std::ops::Range<f64> = 0.65..1.6;
/// Below a foot carpet comes within this many pixels.
const MAX_FOOT_GAP_PX: f64 = 9.0;
/// The goal line below a foot is at most so many widths of the post high in the image.
const MAX_LINE: f64 = 1.5;
/// The foot is looked for so many pixels, or widths of the post, below the last run: the bar of a goal's base makes the runs
/// beside the foot longer.
const MAX_FOOT_BELOW_PX: f64 = 30.0;
const MAX_FOOT_BELOW: f64 = 4.0;
/// A bar goes on at least this many widths of the post.
const MIN_BAR: f64 = 1.5;

/// Runs below each other.
#[derive(Debug, Clone, Copy)]
struct Column {
    class: ColorClass,
    fit: LineFit,
    num: usize,
    /// Last run and its row.
    start: f64,
    end: f64,
    row: u32,
    first_row: u32,
    sum_width: f64,
    white: u32,
    /// Whether the color goes on to the left or to the right above the first run.
    has_bar: [bool; 2],
}

#[derive(Debug, Default)]
pub(super) struct PostFinder {
    columns: Vec<Column>,
    /// Runs of the row before, with their class.
    last_row: Vec<(ColorClass, f64, f64)>,
    this_row: Vec<(ColorClass, f64, f64)>,
    last_spacing: u32,
}

impl PostFinder {
    pub fn clear(&mut self) {
        self.columns.clear();
        self.last_row.clear();
    }

    /// Adds the runs of the next horizontal scan line. `white` is the luma of white beside the carpet.
    pub fn add_row(&mut self, line: &ScanLine, runs: &[Run], white: u32) {
        self.this_row.clear();
        for run in runs {
            let is_post_color = matches!(run.class, ColorClass::Yellow | ColorClass::Blue);
            if is_post_color && run.end - run.start >= MIN_RUN_PX {
                let (start, end) = (f64::from(run.start), f64::from(run.end - 1));
                self.this_row.push((run.class, start, end));
                // What the border of the image cuts has no known width.
                if run.start > line.from && run.end < line.to {
                    self.add_run(run.class, start, end, line.fixed, white);
                }
            }
        }
        std::mem::swap(&mut self.last_row, &mut self.this_row);
        self.last_spacing = line.spacing;
    }

    fn add_run(&mut self, class: ColorClass, start: f64, end: f64, row: u32, white: u32) {
        let center = Point2::new(f64::midpoint(start, end), f64::from(row));
        let spacing = f64::from(self.last_spacing);
        let reach = MAX_SLOPE * spacing + MIN_MOVE_PX;
        let continued = self.columns.iter_mut().find(|column| {
            column.class == class
                && f64::from(row - column.row) <= spacing
                && row > column.row
                && (column.start - start).abs() <= reach
                && (column.end - end).abs() <= reach
        });
        if let Some(column) = continued {
            column.fit.add(&center);
            column.num += 1;
            (column.start, column.end, column.row) = (start, end, row);
            column.sum_width += end - start + 1.0;
            return;
        }
        let width = end - start + 1.0;
        let above = self.last_row.iter().filter(|(c, s, e)| *c == class && *s <= end && *e >= start);
        let has_bar = above.fold([false; 2], |[left, right], (_, s, e)| {
            [left || start - s > MIN_BAR * width, right || e - end > MIN_BAR * width]
        });
        let mut fit = LineFit::default();
        fit.add(&center);
        let (first_row, sum_width) = (row, width);
        self.columns.push(Column {
            class,
            fit,
            num: 1,
            start,
            end,
            row,
            first_row,
            sum_width,
            white,
            has_bar,
        });
    }

    /// Judges the columns. `is_goal` tells whether a pixel belongs to something that can be a colored goal.
    pub fn finish(
        &self,
        view: &GroundView,
        field_end: &FieldEnd,
        post_diameter_m: f64,
        is_goal: impl Fn(GoalColor, (u32, u32)) -> bool,
        out: &mut Vec<GoalPost>,
    ) {
        for column in &self.columns {
            let Some(post) = column.post(view, field_end, post_diameter_m) else { continue };
            let middle = (f64::midpoint(column.start, column.end) as u32, column.row);
            if is_goal(post.color, middle) {
                out.push(post);
            }
        }
    }
}

impl Column {
    fn post(&self, view: &GroundView, field_end: &FieldEnd, diameter_m: f64) -> Option<GoalPost> {
        let width_px = self.sum_width / self.num as f64;
        let height_px = f64::from(self.row - self.first_row);
        if self.num < MIN_ROWS || height_px < MIN_ASPECT * width_px {
            return None;
        }
        let color = if self.class == ColorClass::Yellow { GoalColor::Yellow } else { GoalColor::Blue };
        let axis = self.fit.line();
        // The raw pixels of the axis; a post is so short that a lens hardly bends it.
        let at_row = |row: f64| {
            let step = (row - axis.point.y) / if axis.along.y.abs() > 0.1 { axis.along.y } else { 1.0 };
            axis.at(step)
        };
        let foot_raw_px = self.foot(view, &at_row);
        let foot_px = view.camera().ideal_px(&foot_raw_px);
        let ray = view.ray(&foot_px);
        let ahead = ray.xy().try_normalize(1e-9)?;
        let mut post = GoalPost {
            color,
            bearing_rad: ahead.y.atan2(ahead.x),
            base_in_robot: None,
            foot_px,
            side: match self.has_bar {
                [true, false] => Some(PostSide::Right),
                [false, true] => Some(PostSide::Left),
                _ => None,
            },
        };
        if foot_raw_px.y + 3.0 >= f64::from(view.camera().size_px().1) {
            let is_high = height_px > MIN_ASPECT_WITHOUT_FOOT * width_px;
            return is_high.then_some(post);
        }
        if foot_raw_px.y < field_end.row_px(foot_raw_px.x) || !self.stands_on_carpet(view, &foot_px) {
            return None;
        }
        let front = view.ground(&foot_px)?;
        let distance_m = (front.coords - view.eye().xy()).norm().hypot(view.eye().z);
        let expected_px = view.focal_px() * diameter_m / distance_m;
        if !WIDTH_RANGE.contains(&(width_px / expected_px)) {
            return None;
        }
        post.base_in_robot = Some(front + ahead * (diameter_m / 2.0));
        Some(post)
    }

    /// Follows the color down the axis from the last run, in raw pixels.
    fn foot(&self, view: &GroundView, at_row: &impl Fn(f64) -> Point2<f64>) -> Point2<f64> {
        let mut row = f64::from(self.row);
        let limit = row + (MAX_FOOT_BELOW_PX * view.scale).max(MAX_FOOT_BELOW * (self.end - self.start));
        while row < limit && view.class_at_raw(&at_row(row + 1.0), self.white) == Some(self.class) {
            row += 1.0;
        }
        at_row(row + 0.5)
    }

    /// Carpet comes soon below the foot. The goal line may come first, below a post of another color; legs are longer.
    fn stands_on_carpet(&self, view: &GroundView, foot_px: &Point2<f64>) -> bool {
        let (mut below, mut other, mut white) = (1.0, 0.0, 0.0);
        while other <= MAX_FOOT_GAP_PX * view.scale && white <= MAX_LINE * (self.end - self.start) {
            match view.at_px(&(foot_px + Vector2::new(0.0, below)), self.white) {
                Seen::Carpet | Seen::Nothing => return true,
                Seen::White => white += 1.0,
                _ => other += 1.0,
            }
            below += 1.0;
        }
        false
    }
}
