//! Obstacles: broad upright patches of white, most of them other robots.

use nalgebra::Point2;

use super::{
    FieldAnalysisConfig, FieldEnd,
    scan::{Run, ScanLine},
};
use crate::vision::color::ColorClass;

/// A block of white that stands on the field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Obstacle {
    /// Left, top, right, bottom, pixels, inclusive.
    pub bounds_px: [u32; 4],
}

impl Obstacle {
    pub(super) fn contains(&self, px: (u32, u32), margin: u32) -> bool {
        let [left, top, right, bottom] = self.bounds_px;
        (left..=right + 2 * margin).contains(&(px.0 + margin))
            && (top..=bottom + 2 * margin).contains(&(px.1 + margin))
    }
}

#[derive(Debug, Clone, Copy)]
struct Segment {
    column: u32,
    spacing: u32,
    top: u32,
    bottom: u32,
    distance_m: f64,
}

#[derive(Debug, Clone, Copy)]
struct Block {
    bounds: [u32; 4],
    last: Segment,
    area_px: u32,
    distance_m: f64,
}

/// The foot of an obstacle is at least so many pixels below the end of the field, in an image up to 640 px wide.
const FOOT_BELOW_END_PX: f64 = 4.0;
/// Below this height, pixels of such an image, even a robot at the field's end is not seen.
const MIN_HEIGHT_PX: f64 = 6.0;

/// Collects upright white segments column by column from the left and joins them to blocks.
#[derive(Debug, Default)]
pub(super) struct ObstacleFinder {
    segments: Vec<Segment>,
    blocks: Vec<Block>,
    obstacles: Vec<Obstacle>,
}

impl ObstacleFinder {
    pub fn clear(&mut self) {
        self.segments.clear();
        self.blocks.clear();
        self.obstacles.clear();
    }

    /// Adds the white runs of a vertical scan line that are high enough for an obstacle, in an image of which so many pixels blur into one. `ground_distance_m` gives the
    /// distance of the ground seen at a pixel.
    pub fn add_column(
        &mut self,
        config: &FieldAnalysisConfig,
        line: &ScanLine,
        runs: &[Run],
        (focal_px, scale): (f64, f64),
        ground_distance_m: impl Fn(&Point2<f64>) -> Option<f64>,
    ) {
        for run in runs.iter().filter(|run| run.class == ColorClass::White) {
            let length_px = run.end - run.start;
            if f64::from(length_px) < MIN_HEIGHT_PX * scale {
                continue;
            }
            let foot = Point2::new(f64::from(line.fixed), f64::from(run.end - 1));
            let Some(distance_m) = ground_distance_m(&foot) else { continue };
            if f64::from(length_px) * distance_m / focal_px < config.min_obstacle_height_m {
                continue;
            }
            let (column, spacing) = (line.fixed, line.spacing);
            self.segments.push(Segment { column, spacing, top: run.start, bottom: run.end - 1, distance_m });
        }
    }

    /// Joins the segments to blocks; those that are broad enough for their distance are obstacles. Walls and whatever
    /// else stands beyond the end of the field are not.
    pub fn finish(
        &mut self,
        config: &FieldAnalysisConfig,
        (focal_px, scale): (f64, f64),
        field_end: &FieldEnd,
    ) {
        let stands_on_field = |segment: &Segment| {
            f64::from(segment.bottom)
                > field_end.row_px(f64::from(segment.column)) + FOOT_BELOW_END_PX * scale
        };
        self.segments.retain(stands_on_field);
        for segment in &self.segments {
            let joined = self.blocks.iter_mut().find(|block| {
                segment.column <= block.last.column + 2 * segment.spacing
                    && segment.top <= block.last.bottom
                    && block.last.top <= segment.bottom
            });
            let area_px = (segment.bottom - segment.top + 1) * segment.spacing;
            if let Some(block) = joined {
                let [left, top, right, bottom] = block.bounds;
                let is_new_column = segment.column > block.last.column;
                block.bounds =
                    [left, top.min(segment.top), right.max(segment.column), bottom.max(segment.bottom)];
                block.area_px += if is_new_column { area_px } else { 0 };
                block.distance_m = block.distance_m.min(segment.distance_m);
                block.last = *segment;
            } else {
                let bounds = [segment.column, segment.top, segment.column, segment.bottom];
                self.blocks.push(Block { bounds, last: *segment, area_px, distance_m: segment.distance_m });
            }
        }
        for block in &self.blocks {
            let [left, top, right, bottom] = block.bounds;
            let width_px = right - left + block.last.spacing;
            let width_m = f64::from(width_px) * block.distance_m / focal_px;
            // A line that runs away from the robot makes a long thin diagonal, which fills little of its bounds.
            let fill = f64::from(block.area_px) / f64::from(width_px * (bottom - top + 1));
            if width_m >= config.min_obstacle_width_m && fill >= 0.45 {
                // The border lies somewhere before the next scan line, and near the robot only every second one goes on.
                let reach = 2 * block.last.spacing;
                let bounds_px = [left.saturating_sub(reach), top, right + reach, bottom];
                self.obstacles.push(Obstacle { bounds_px });
            }
        }
    }

    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }
}
