//! All detectors, with the buffers that they keep from image to image.

use nalgebra::Point2;
use visloc_world::field::GoalColor;

use super::{
    chains::Chains,
    circle::CircleFinder,
    config::FeatureDetectionConfig,
    crossings::Crossings,
    junctions, marks,
    posts::PostFinder,
    segments::{self, Segment},
    view::GroundView,
    white_posts::{PostSize, WhitePostFinder},
};
use crate::vision::{
    BorderPixel, FieldFeatures,
    field::{
        FieldAnalysisConfig, FieldEnd,
        edges::Edge,
        scan::{Run, ScanLine},
    },
};

/// Finds composite features from what the scan and the filters of the analysis pass on.
#[derive(Debug, Default)]
pub(in crate::vision::field) struct FeatureDetector {
    crossings: Crossings,
    chains: Chains,
    segments: Vec<Segment>,
    circle: CircleFinder,
    posts: PostFinder,
    white_posts: WhitePostFinder,
}

impl FeatureDetector {
    /// Begins an image.
    pub fn clear(&mut self) {
        self.crossings.clear();
        self.posts.clear();
        self.white_posts.clear();
    }

    /// Takes the runs of a horizontal scan line; they come from top to bottom. `white` is the luma of white beside the carpet.
    pub fn add_row(&mut self, line: &ScanLine, runs: &[Run], white: u32, config: &FeatureDetectionConfig) {
        self.posts.add_row(line, runs, white);
        if config.has_white_goals {
            self.white_posts.add_row(line, runs);
        }
    }

    /// Takes a border of a line that passed the filters; they come in the order of the scan lines.
    pub fn add_border(&mut self, view: &GroundView, edge: &Edge, ideal_px: Point2<f64>, white: u32) {
        self.crossings.add(view, edge, ideal_px, white);
    }

    /// The sides of the white posts that were found in this image.
    pub fn post_borders(&self) -> &[BorderPixel] {
        self.white_posts.borders()
    }

    /// Finds everything. `is_goal` tells whether a pixel belongs to something that can be a colored goal.
    pub fn finish(
        &mut self,
        view: &GroundView,
        config: &FieldAnalysisConfig,
        field_end: &FieldEnd,
        is_goal: impl Fn(GoalColor, (u32, u32)) -> bool,
        out: &mut FieldFeatures,
    ) {
        out.clear();
        let (field, line_width_m) = (&config.composite, config.line_width_m);
        let crossings = &self.crossings.all;
        self.chains.build(crossings, view, line_width_m);
        segments::find(&self.chains, crossings, view, line_width_m, &mut self.segments);
        let lengths = (field.circle_radius_m, line_width_m);
        out.circle = self.circle.find(crossings, &self.chains, view, lengths, &mut self.segments);
        junctions::find(&self.segments, view, line_width_m, &mut out.junctions);
        marks::find(crossings, &self.segments, view, field.mark_size_m, &mut out.marks);
        self.posts.finish(view, field_end, field.post_diameter_m, is_goal, &mut out.posts);
        let size = PostSize {
            diameter_m: field.post_diameter_m,
            height_m: config.goal_height_m,
            range_m: config.max_line_distance_m,
        };
        self.white_posts.finish(view, &size, &mut out.posts);
        out.lines.extend(self.segments.iter().map(Segment::perceived));
    }
}
