//! Border pixels: the ends of the runs along a scan line.

use nalgebra::{Point2, Vector2};
use visloc_core::RgbImage;

use super::scan::{Direction, Run, ScanLine};
use crate::vision::{
    FeatureKind, blur_px,
    color::{ColorClass, luma},
};

/// The end of a run, before the filters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edge {
    /// Where the color changes, pixels, between pixel centers.
    pub px: Point2<f64>,
    /// The last pixel inside of the run.
    pub inside_px: (u32, u32),
    /// Whether the run begins here; otherwise it ends.
    pub is_start: bool,
    pub kind: FeatureKind,
    /// Brightness that is white near the run.
    pub white_luma: u32,
    /// For lines: whether there is carpet on both sides of the run. The border of the carpet and most things that are
    /// not lines have it on one side at most.
    pub is_beside_carpet: bool,
    /// Length of the run, pixels.
    pub run_px: u32,
    pub direction: Direction,
    /// For goals on a horizontal scan line: whether the border goes on upright on the next scan line.
    pub is_upright: bool,
}

impl Edge {
    /// Unit vector along the scan line, towards the inside of the run.
    pub fn inward(&self) -> Vector2<f64> {
        let sign = if self.is_start { 1.0 } else { -1.0 };
        match self.direction {
            Direction::Horizontal => Vector2::new(sign, 0.0),
            Direction::Vertical => Vector2::new(0.0, sign),
        }
    }
}

/// Most pixels of mixed color between a line and the carpet, in an image up to 640 px wide.
const MAX_BLEND_PX: u32 = 4;
/// Pixels of carpet that are looked at on each side of a line.
const CARPET_SAMPLES: i64 = 3;
/// Two patches of carpet differ by less than this in their share of green.
const MAX_CARPET_DIFFERENCE: f64 = 0.08;
/// Shortest run of a goal color, in such an image.
const MIN_GOAL_RUN_PX: u32 = 3;

/// Appends the ends of all runs of line and goal colors. Ends at the border of the scan line are no edges.
pub(super) fn edges_of_runs(image: &RgbImage, line: &ScanLine, runs: &[Run], edges: &mut Vec<Edge>) {
    let max_blend_px = MAX_BLEND_PX * blur_px(image.width());
    let min_goal_run_px = MIN_GOAL_RUN_PX * blur_px(image.width());
    for (i, run) in runs.iter().enumerate() {
        match run.class {
            ColorClass::White => {
                let before = carpet_beside(runs[..i].iter().rev(), max_blend_px);
                let after = carpet_beside(runs[i + 1..].iter(), max_blend_px);
                let is_beside_carpet = before
                    .zip(after)
                    .is_some_and(|(before, after)| is_same_carpet(image, line, run, before, after));
                let (Some(before), Some(after)) = (before, after) else {
                    push_ends(line, run, is_beside_carpet, edges);
                    continue;
                };
                let peak = (run.start..run.end).map(|p| luma_at(image, line, p)).max().unwrap_or(0);
                let level = f64::from(peak + run.green_luma) / 2.0;
                let rise = crossing(image, line, run.start.saturating_sub(before + 1), run.end, level);
                let fall = crossing_back(image, line, run.start, run.end + after, level);
                let rise = rise.unwrap_or(f64::from(run.start) - 0.5);
                let fall = fall.unwrap_or(f64::from(run.end) - 0.5);
                edges.push(edge(line, run, true, rise, is_beside_carpet));
                edges.push(edge(line, run, false, fall, is_beside_carpet));
            }
            ColorClass::Yellow | ColorClass::Blue if run.end - run.start >= min_goal_run_px => {
                push_ends(line, run, false, edges);
            }
            _ => {}
        }
    }
}

/// Appends the ends of a run to the nearest half pixel.
fn push_ends(line: &ScanLine, run: &Run, is_beside_carpet: bool, edges: &mut Vec<Edge>) {
    if run.start > line.from {
        edges.push(edge(line, run, true, f64::from(run.start) - 0.5, is_beside_carpet));
    }
    if run.end < line.to {
        edges.push(edge(line, run, false, f64::from(run.end) - 0.5, is_beside_carpet));
    }
}

fn edge(line: &ScanLine, run: &Run, is_start: bool, position: f64, is_beside_carpet: bool) -> Edge {
    let fixed = f64::from(line.fixed);
    Edge {
        px: match line.direction {
            Direction::Horizontal => Point2::new(position, fixed),
            Direction::Vertical => Point2::new(fixed, position),
        },
        inside_px: line.pixel(if is_start { run.start } else { run.end - 1 }),
        is_start,
        kind: match run.class {
            ColorClass::Yellow => FeatureKind::YellowGoal,
            ColorClass::Blue => FeatureKind::BlueGoal,
            _ => FeatureKind::FieldLine,
        },
        white_luma: run.white_luma,
        is_beside_carpet,
        run_px: run.end - run.start,
        direction: line.direction,
        is_upright: false,
    }
}

/// Pixels of mixed color until carpet comes; `None` if something else comes first.
fn carpet_beside<'a>(neighbors: impl Iterator<Item = &'a Run>, max_blend_px: u32) -> Option<u32> {
    let mut gap = 0;
    for run in neighbors {
        match run.class {
            ColorClass::Green => return Some(gap),
            ColorClass::Unknown | ColorClass::OtherGreen | ColorClass::Neutral => gap += run.end - run.start,
            _ => return None,
        }
        if gap > max_blend_px {
            return None;
        }
    }
    None
}

/// Whether the green before and after a run is the same carpet: of one hue, whatever the light. The gap between a carpet
/// and a green board is not a line.
fn is_same_carpet(image: &RgbImage, line: &ScanLine, run: &Run, before: u32, after: u32) -> bool {
    let first = i64::from(run.start) - i64::from(before) - 1;
    let last = i64::from(run.end) + i64::from(after);
    match (green_share(image, line, first, -1), green_share(image, line, last, 1)) {
        (Some(a), Some(b)) => (a - b).abs() < MAX_CARPET_DIFFERENCE,
        _ => true,
    }
}

/// Share of green in the color of the carpet from a position on; `None` if too little of the line is left to tell.
fn green_share(image: &RgbImage, line: &ScanLine, from: i64, step: i64) -> Option<f64> {
    let (mut green, mut all) = (0, 0);
    let step = step * i64::from(blur_px(image.width()));
    // The first pixel may still be mixed with the line.
    for i in 1..=CARPET_SAMPLES {
        let position = u32::try_from(from + step * i).ok().filter(|p| (line.from..line.to).contains(p))?;
        let (x, y) = line.pixel(position);
        let [r, g, b] = image.get(x, y).map(u32::from);
        green += g;
        all += r + g + b;
    }
    (all > 0).then(|| f64::from(green) / f64::from(all))
}

fn luma_at(image: &RgbImage, line: &ScanLine, position: u32) -> u32 {
    let (x, y) = line.pixel(position);
    luma(image.get(x, y))
}

/// Where the brightness first rises through `level` between two positions, in fractions of a pixel.
fn crossing(image: &RgbImage, line: &ScanLine, from: u32, to: u32, level: f64) -> Option<f64> {
    (from..to - 1).find_map(|p| {
        let (a, b) = (f64::from(luma_at(image, line, p)), f64::from(luma_at(image, line, p + 1)));
        (a < level && b >= level).then(|| f64::from(p) + (level - a) / (b - a))
    })
}

/// Where the brightness last falls through `level`, coming from the end.
fn crossing_back(image: &RgbImage, line: &ScanLine, from: u32, to: u32, level: f64) -> Option<f64> {
    let last = to.min(line.to - 1);
    (from..last).rev().find_map(|p| {
        let (a, b) = (f64::from(luma_at(image, line, p)), f64::from(luma_at(image, line, p + 1)));
        (a >= level && b < level).then(|| f64::from(p) + (a - level) / (a - b))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::{
        color::{ColorConfig, ColorTable, GoalColors},
        field::scan::scan_line,
    };

    /// One row of carpet with a white stripe between two real-valued borders, antialiased.
    fn stripe(left: f64, right: f64) -> RgbImage {
        let mut image = RgbImage::new(60, 1);
        for x in 0..60 {
            let (a, b) = (f64::from(x) - 0.5, f64::from(x) + 0.5);
            let cover = (b.min(right) - a.max(left)).clamp(0.0, 1.0);
            let mix = |green: f64, white: f64| (green + (white - green) * cover).round() as u8;
            image.set(x, 0, [mix(60.0, 230.0), mix(140.0, 232.0), mix(80.0, 228.0)]);
        }
        image
    }

    fn edges(image: &RgbImage) -> Vec<Edge> {
        let line = ScanLine { direction: Direction::Horizontal, fixed: 0, from: 0, to: 60, spacing: 1 };
        let (mut runs, mut edges) = (Vec::new(), Vec::new());
        scan_line(
            image,
            &ColorTable::new(&ColorConfig::default(), GoalColors::default()),
            &line,
            100,
            &mut runs,
        );
        edges_of_runs(image, &line, &runs, &mut edges);
        edges
    }

    #[test]
    fn borders_of_a_stripe_are_found_between_pixels() {
        for (left, right) in [(20.0, 27.0), (20.3, 27.6), (19.75, 25.1), (30.4, 44.9)] {
            let found = edges(&stripe(left, right));
            assert_eq!(found.len(), 2, "{left} {right}");
            assert!((found[0].px.x - left).abs() < 0.3, "left {left}, found {}", found[0].px.x);
            assert!((found[1].px.x - right).abs() < 0.3, "right {right}, found {}", found[1].px.x);
            assert!(found.iter().all(|edge| edge.is_beside_carpet && edge.kind == FeatureKind::FieldLine));
        }
    }

    #[test]
    fn white_beside_something_else_is_marked() {
        let mut image = stripe(20.0, 30.0);
        for x in 30..60 {
            image.set(x, 0, [150, 30, 30]);
        }
        let found = edges(&image);
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|edge| !edge.is_beside_carpet));
    }

    #[test]
    fn goal_runs_give_both_borders() {
        let mut image = stripe(100.0, 101.0);
        for x in 10..18 {
            image.set(x, 0, [30, 80, 175]);
        }
        let found = edges(&image);
        assert_eq!(found.iter().map(|edge| edge.px.x).collect::<Vec<_>>(), [9.5, 17.5]);
        assert!(found.iter().all(|edge| edge.kind == FeatureKind::BlueGoal));
    }
}
