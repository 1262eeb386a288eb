//! Blobs of goal colors: connected runs of neighboring scan rows.

use nalgebra::Point2;
use visloc_core::Frame;

use super::{
    FieldAnalysisConfig, FieldEnd,
    edges::Edge,
    scan::{Run, ScanLine},
};
use crate::vision::{
    FeatureKind, PerceivedBlob,
    color::{ColorClass, ColorTable},
    ground_distance_m, px_in,
};

/// A connected patch of a goal's color.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GoalBlob {
    /// Which goal's color.
    pub kind: FeatureKind,
    /// Left, top, right, bottom, pixels, inclusive.
    pub bounds_px: [u32; 4],
    /// Pixels of the color, counted on scan rows and scaled to all rows.
    pub area_px: u32,
    /// Whether size, shape and foot fit a goal.
    pub is_valid: bool,
}

impl GoalBlob {
    fn width(&self) -> u32 {
        self.bounds_px[2] - self.bounds_px[0] + 1
    }

    fn height(&self) -> u32 {
        self.bounds_px[3] - self.bounds_px[1] + 1
    }
}

#[derive(Debug, Clone, Copy)]
struct BlobRun {
    class: ColorClass,
    start: u32,
    end: u32,
    row: u32,
    spacing: u32,
    parent: usize,
}

/// Collects runs row by row from the top and joins them to blobs.
#[derive(Debug, Default)]
pub(super) struct BlobFinder {
    runs: Vec<BlobRun>,
    previous_row: std::ops::Range<usize>,
    /// The row before the last added one.
    row_before: std::ops::Range<usize>,
    max_spacing: u32,
    blobs: Vec<GoalBlob>,
    /// Lowest run of each blob: where its foot is.
    feet: Vec<(u32, u32)>,
    /// Sums of (x, y) over the counted pixels of each blob.
    moments: Vec<(f64, f64)>,
    /// The widest run on each row of each blob, with the blob.
    row_widths: Vec<(usize, u32)>,
    /// Row and width of what was added to `row_widths` last for each blob.
    open_rows: Vec<(u32, u32)>,
    blob_of_root: Vec<Option<usize>>,
}

/// Where feet of goals are judged.
pub(super) struct Feet<'a> {
    pub frame: &'a Frame,
    pub table: &'a ColorTable,
    /// Of a post.
    pub diameter_m: f64,
}

impl Feet<'_> {
    /// Whether there is carpet below a pixel, within so many pixels.
    fn is_carpet_below(&self, (x, y): (u32, u32), reach: u32) -> bool {
        let image = &self.frame.image;
        // A foot at the lower border of the image cannot be judged.
        y + reach >= image.height()
            || (y..=y + reach).any(|y| {
                let [r, g, b] = image.get(x, y);
                self.table.class(r, g, b) == ColorClass::Green
            })
    }

    /// How wide a post is that stands at a pixel; `None` if no ground is seen there.
    fn post_width_px(&self, (x, y): (u32, u32)) -> Option<f64> {
        let distance_m = ground_distance_m(self.frame, &Point2::new(f64::from(x), f64::from(y)))?;
        let slant_m = distance_m.hypot(self.frame.robot_from_camera.translation().z);
        Some(self.frame.camera.focal_px().0 * self.diameter_m / slant_m)
    }
}

/// A goal stands on the goal line: carpet comes within so many pixels below its foot at least, in an image 320 px wide.
const MIN_FOOT_REACH_PX: u32 = 8;
/// Shortest run that is joined to a blob.
const MIN_RUN_PX: u32 = 2;
/// Width of a post, as a share of what the distance of its foot demands. That distance is uncertain: a tilt that is off by a degree
/// makes 4 m of 5 m.
const POST_WIDTH: std::ops::RangeInclusive<f64> = 0.45..=2.2;
/// Least height of a goal, as a share of what its posts' width demands: its top may be hidden.
const MIN_POST_HEIGHT: f64 = 0.5;

impl BlobFinder {
    pub fn clear(&mut self) {
        self.runs.clear();
        self.previous_row = 0..0;
        self.row_before = 0..0;
        self.max_spacing = 0;
    }

    /// Adds the runs of the next horizontal scan line.
    pub fn add_row(&mut self, line: &ScanLine, runs: &[Run]) {
        let first = self.runs.len();
        for run in runs {
            let is_goal = matches!(run.class, ColorClass::Yellow | ColorClass::Blue);
            if is_goal && run.end - run.start >= MIN_RUN_PX {
                let parent = self.runs.len();
                let (class, start, end) = (run.class, run.start, run.end);
                self.runs.push(BlobRun { class, start, end, row: line.fixed, spacing: line.spacing, parent });
            }
        }
        for above in self.previous_row.clone() {
            for below in first..self.runs.len() {
                let (a, b) = (self.runs[above], self.runs[below]);
                if a.class == b.class && a.start < b.end && b.start < a.end {
                    let (root_a, root_b) = (self.root(above), self.root(below));
                    self.runs[root_a.max(root_b)].parent = root_a.min(root_b);
                }
            }
        }
        self.row_before = std::mem::replace(&mut self.previous_row, first..self.runs.len());
        self.max_spacing = self.max_spacing.max(line.spacing);
    }

    fn root(&self, mut run: usize) -> usize {
        while self.runs[run].parent != run {
            run = self.runs[run].parent;
        }
        run
    }

    /// Joins what was added to blobs and judges them: a goal stands on the carpet and consists of posts.
    pub fn finish(
        &mut self,
        config: &FieldAnalysisConfig,
        size_px: (u32, u32),
        field_end: &FieldEnd,
        feet: &Feet<'_>,
    ) {
        self.join(size_px);
        self.measure_rows();
        let (min_reach, min_height) =
            (px_in(size_px.0, MIN_FOOT_REACH_PX), px_in(size_px.0, config.min_blob_height_px));
        let mut rows = self.row_widths.chunk_by(|a, b| a.0 == b.0);
        for (blob, foot) in self.blobs.iter_mut().zip(&self.feet) {
            let rows = rows.next().unwrap_or_default();
            let Some((_, width_px)) = rows.get(rows.len() / 2) else { continue };
            let reach = blob.width().clamp(min_reach, blob.height() / 2 + min_reach);
            blob.is_valid = blob.height() >= min_height
                && is_goal_shaped(config, blob)
                && f64::from(foot.1) >= field_end.row_px(f64::from(foot.0))
                && has_posts(config, blob, f64::from(*width_px), feet.post_width_px(*foot), size_px)
                && feet.is_carpet_below(*foot, reach);
        }
    }

    /// Joins connected runs to blobs.
    fn join(&mut self, size_px: (u32, u32)) {
        self.blobs.clear();
        self.feet.clear();
        self.moments.clear();
        self.blob_of_root.clear();
        self.blob_of_root.resize(self.runs.len(), None);
        for i in 0..self.runs.len() {
            let run = self.runs[i];
            let root = self.root(i);
            let index = *self.blob_of_root[root].get_or_insert_with(|| {
                let kind = if run.class == ColorClass::Yellow {
                    FeatureKind::YellowGoal
                } else {
                    FeatureKind::BlueGoal
                };
                let bounds_px = [run.start, run.row, run.end - 1, run.row];
                self.blobs.push(GoalBlob { kind, bounds_px, area_px: 0, is_valid: false });
                self.feet.push((0, 0));
                self.moments.push((0.0, 0.0));
                self.blobs.len() - 1
            });
            let blob = &mut self.blobs[index];
            let [left, top, right, bottom] = blob.bounds_px;
            let last_row = (run.row + run.spacing.max(1) - 1).min(size_px.1 - 1);
            blob.bounds_px =
                [left.min(run.start), top.min(run.row), right.max(run.end - 1), bottom.max(last_row)];
            let run_area_px = (run.end - run.start) * run.spacing.max(1);
            blob.area_px += run_area_px;
            let moment = &mut self.moments[index];
            moment.0 += f64::from(run_area_px) * f64::from(run.start + run.end - 1) / 2.0;
            moment.1 += f64::from(run_area_px) * f64::midpoint(f64::from(run.row), f64::from(last_row));
            self.feet[index] = (u32::midpoint(run.start, run.end), last_row);
        }
    }

    /// The widest run on each row of each blob, ordered by blob and width.
    fn measure_rows(&mut self) {
        self.row_widths.clear();
        self.open_rows.clear();
        self.open_rows.resize(self.blobs.len(), (0, 0));
        for i in 0..self.runs.len() {
            let run = self.runs[i];
            let Some(blob) = self.blob_of_root[self.root(i)] else { continue };
            let (row, width) = &mut self.open_rows[blob];
            if *row != run.row && *width > 0 {
                self.row_widths.push((blob, *width));
                *width = 0;
            }
            *row = run.row;
            *width = (*width).max(run.end - run.start);
        }
        self.row_widths.extend(self.open_rows.iter().enumerate().map(|(blob, (_, width))| (blob, *width)));
        self.row_widths.sort_unstable();
    }

    pub fn blobs(&self) -> &[GoalBlob] {
        &self.blobs
    }

    /// The valid blobs as wholes.
    pub fn perceived(&self, out: &mut Vec<PerceivedBlob>) {
        out.clear();
        for (blob, (x, y)) in self.blobs.iter().zip(&self.moments).filter(|(blob, _)| blob.is_valid) {
            let area_px = f64::from(blob.area_px);
            let centroid_px = Point2::new(x / area_px, y / area_px);
            out.push(PerceivedBlob { kind: blob.kind, area_px, centroid_px });
        }
    }

    /// Whether a pixel belongs to a valid blob of its kind: a run of the blob on a nearby scan row covers its column.
    pub fn is_in_valid_blob(&self, kind: FeatureKind, px: (u32, u32), margin: u32) -> bool {
        let class = if kind == FeatureKind::YellowGoal { ColorClass::Yellow } else { ColorClass::Blue };
        let reach = self.max_spacing + margin;
        let first = self.runs.partition_point(|run| run.row + reach < px.1);
        self.runs[first..].iter().take_while(|run| run.row <= px.1 + reach).any(|run| {
            run.class == class
                && run.start <= px.0 + margin
                && px.0 < run.end + margin
                && self.blob_of_root[self.root(run.parent)].is_some_and(|blob| self.blobs[blob].is_valid)
        })
    }

    /// Marks the borders of goal colors on the last added row that go on upright from the row before, as well as blurred borders tell.
    pub fn mark_upright(&self, edges: &mut [Edge], max_slope: f64, blur_px: u32) {
        for edge in edges.iter_mut().filter(|edge| edge.kind.is_goal()) {
            let class =
                if edge.kind == FeatureKind::YellowGoal { ColorClass::Yellow } else { ColorClass::Blue };
            let is_start = edge.px.x < f64::from(edge.inside_px.0);
            edge.is_upright = self.row_before.clone().any(|i| {
                let run = &self.runs[i];
                let border = if is_start { run.start } else { run.end - 1 };
                let reach = max_slope * f64::from(run.spacing) + f64::from(blur_px);
                run.class == class && f64::from(border.abs_diff(edge.inside_px.0)) <= reach
            });
        }
    }
}

/// Whether most rows of a blob are as wide as a post that stands at its foot, and the blob as high as such a post. Of what the image's
/// border cuts only what is seen is judged.
fn has_posts(
    config: &FieldAnalysisConfig,
    blob: &GoalBlob,
    width_px: f64,
    expected_px: Option<f64>,
    size_px: (u32, u32),
) -> bool {
    let Some(expected_px) = expected_px else { return false };
    let [left, top, right, bottom] = blob.bounds_px;
    let (is_beside, is_below) = (left == 0 || right + 1 >= size_px.0, bottom + 1 >= size_px.1);
    // One pixel may be mixed with what is behind.
    let ratios = [width_px, width_px + 1.0].map(|width_px| width_px / expected_px);
    let is_wide_enough = ratios[1] >= *POST_WIDTH.start() || is_beside;
    // A foot below the image is nearer than the lowest row.
    let is_narrow_enough = ratios[0] <= *POST_WIDTH.end() || is_below;
    let aspect = config.goal_height_m / config.composite.post_diameter_m;
    let is_high_enough =
        f64::from(blob.height()) >= MIN_POST_HEIGHT * aspect * width_px || top == 0 || is_below;
    is_wide_enough && is_narrow_enough && is_high_enough
}

/// A goal is either upright (a post) or hollow (two posts and a bar).
fn is_goal_shaped(config: &FieldAnalysisConfig, blob: &GoalBlob) -> bool {
    let aspect = f64::from(blob.width()) / f64::from(blob.height());
    let fill = f64::from(blob.area_px) / f64::from(blob.width() * blob.height());
    aspect <= config.max_filled_blob_aspect || fill < 0.5
}
