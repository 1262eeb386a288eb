//! Blobs of goal colors: connected runs of neighboring scan rows.

use visloc_base::RgbImage;

use super::{
    FieldAnalysisConfig,
    scan::{Run, ScanLine},
};
use crate::{
    FeatureKind,
    color::{ColorClass, ColorTable},
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
    /// Whether a pixel is inside, with a margin.
    pub(super) fn contains(&self, px: (u32, u32), margin: u32) -> bool {
        let [left, top, right, bottom] = self.bounds_px;
        (left..=right + 2 * margin).contains(&(px.0 + margin))
            && (top..=bottom + 2 * margin).contains(&(px.1 + margin))
    }

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
    blobs: Vec<GoalBlob>,
    /// Lowest run of each blob: where its foot is.
    feet: Vec<(u32, u32)>,
    blob_of_root: Vec<Option<usize>>,
}

/// Shortest run that is joined to a blob.
const MIN_RUN_PX: u32 = 2;

impl BlobFinder {
    pub fn clear(&mut self) {
        self.runs.clear();
        self.previous_row = 0..0;
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
        self.previous_row = first..self.runs.len();
    }

    fn root(&self, mut run: usize) -> usize {
        while self.runs[run].parent != run {
            run = self.runs[run].parent;
        }
        run
    }

    /// Joins what was added to blobs and judges them.
    pub fn finish(
        &mut self,
        config: &FieldAnalysisConfig,
        image: &RgbImage,
        table: &ColorTable,
        white: u32,
    ) -> &[GoalBlob] {
        self.blobs.clear();
        self.feet.clear();
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
                self.blobs.len() - 1
            });
            let blob = &mut self.blobs[index];
            let [left, top, right, bottom] = blob.bounds_px;
            let last_row = (run.row + run.spacing.max(1) - 1).min(image.height() - 1);
            blob.bounds_px =
                [left.min(run.start), top.min(run.row), right.max(run.end - 1), bottom.max(last_row)];
            blob.area_px += (run.end - run.start) * run.spacing.max(1);
            self.feet[index] = (u32::midpoint(run.start, run.end), last_row);
        }
        for (blob, foot) in self.blobs.iter_mut().zip(&self.feet) {
            blob.is_valid = is_goal_shaped(config, blob) && stands_on_carpet(image, table, *foot, white);
        }
        &self.blobs
    }

    pub fn blobs(&self) -> &[GoalBlob] {
        &self.blobs
    }
}

/// A goal is high enough, and either upright (a post) or hollow (two posts and a bar).
fn is_goal_shaped(config: &FieldAnalysisConfig, blob: &GoalBlob) -> bool {
    let aspect = f64::from(blob.width()) / f64::from(blob.height());
    let fill = f64::from(blob.area_px) / f64::from(blob.width() * blob.height());
    blob.height() >= config.min_blob_height_px && (aspect <= config.max_filled_blob_aspect || fill < 0.5)
}

/// Below the foot of a goal comes carpet or its line; below a board or a shirt comes something else. A foot below the
/// image's border cannot be judged and is accepted.
fn stands_on_carpet(image: &RgbImage, table: &ColorTable, foot: (u32, u32), white: u32) -> bool {
    let (x, y) = foot;
    let (from, to) = (y + 2, y + 14);
    if to >= image.height() {
        return true;
    }
    let carpet = (from..to)
        .filter(|row| {
            let class = table.class_beside_carpet(image.get(x.min(image.width() - 1), *row), white);
            matches!(class, ColorClass::Green | ColorClass::White)
        })
        .count();
    carpet * 10 >= 6 * (to - from) as usize
}
