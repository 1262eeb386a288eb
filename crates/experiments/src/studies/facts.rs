//! What the likelihood map of one view says.

use serde_json::{Value, json};
use visloc_core::{RngTree, geom::PlanarPose};
use visloc_locate::PipelineConfig;
use visloc_plot::Picture;

use super::StudyOutcome;
use crate::{
    ExperimentError,
    likelihood::{
        Eye, HeadingChoice, LikelihoodMap, LikelihoodPictures, Peak, SimulatedView, View, map_csv, peaks,
    },
};

/// Side of a cell, meters.
const STEP_M: f64 = 0.05;
/// Places that reach this share of the maximum could be the right one.
const HIGH_SHARE: f64 = 0.95;

/// One view with its likelihood over all places, each with its best heading.
pub(super) struct ViewFacts {
    /// In tables and titles.
    pub label: String,
    /// Where the robot is.
    pub truth: PlanarPose,
    pub image: SimulatedView,
    pub eye: Eye,
    pub map: LikelihoodMap,
    /// Likelihood at the true pose.
    pub at_truth: f64,
}

impl ViewFacts {
    pub(super) fn new(label: &str, view: &View, seed: u64) -> Result<Self, ExperimentError> {
        let image = SimulatedView::take(view, seed)?;
        let rng = RngTree::new(seed).subtree("study", 0);
        let mut eye = Eye::new(&image.map, &PipelineConfig::with_color_table(), rng)?;
        eye.look(&image.source.frame)?;
        let map = LikelihoodMap::new(eye.model(), HeadingChoice::Best, STEP_M);
        let truth = view.world_from_robot;
        let at_truth = eye.model().likelihood(&truth);
        Ok(Self { label: label.to_owned(), truth, image, eye, map, at_truth })
    }

    /// Line pixels and goal pixels that are weighed.
    pub(super) fn num_pixels(&self) -> (usize, usize) {
        let pixels = &self.eye.percept().pixels;
        let num_goals = pixels.iter().filter(|pixel| pixel.kind.is_goal()).count();
        (pixels.len() - num_goals, num_goals)
    }

    /// Distance of the most likely place from the true one, meters.
    pub(super) fn maximum_error_m(&self) -> f64 {
        self.map.maximum().0.distance_m(&self.truth)
    }

    /// Peaks that could be the right place, the most likely first.
    pub(super) fn high_peaks(&self) -> Vec<Peak> {
        let least = HIGH_SHARE * self.map.maximum().1;
        let found = peaks(&self.map, crate::likelihood::PEAK_DISTANCE_M);
        found.into_iter().filter(|peak| peak.likelihood >= least).collect()
    }

    /// All peaks.
    pub(super) fn num_peaks(&self) -> usize {
        peaks(&self.map, crate::likelihood::PEAK_DISTANCE_M).len()
    }

    /// Area of the places that could be the right one, square meters.
    pub(super) fn high_area_m2(&self) -> f64 {
        self.map.area_above_m2(HIGH_SHARE * self.map.maximum().1)
    }

    /// The columns that all studies share: pixels, likelihood at the truth, maximum and its distance, places that could be
    /// right.
    pub(super) const HEADER: [&'static str; 8] = [
        "view",
        "line + goal pixels",
        "likelihood at the truth",
        "maximum",
        "its distance [m]",
        "peaks from 95 %",
        "area from 95 % [m2]",
        "document",
    ];

    /// The cells of these columns; `document` is what the document says.
    pub(super) fn row(&self, document: &str) -> [String; 8] {
        let (lines, goals) = self.num_pixels();
        [
            self.label.clone(),
            format!("{lines} + {goals}"),
            format!("{:.3}", self.at_truth),
            format!("{:.3}", self.map.maximum().1),
            format!("{:.2}", self.maximum_error_m()),
            self.high_peaks().len().to_string(),
            format!("{:.2}", self.high_area_m2()),
            document.to_owned(),
        ]
    }

    pub(super) fn json(&self) -> Value {
        let (lines, goals) = self.num_pixels();
        let (maximum, likelihood) = self.map.maximum();
        json!({
            "view": self.label,
            "line_pixels": lines,
            "goal_pixels": goals,
            "likelihood_at_truth": self.at_truth,
            "maximum": {
                "likelihood": likelihood, "x_m": maximum.x_m, "y_m": maximum.y_m,
                "heading_deg": maximum.yaw_rad.to_degrees(), "error_m": self.maximum_error_m(),
            },
            "peaks_from_95_percent": self.high_peaks().len(),
            "area_from_95_percent_m2": self.high_area_m2(),
        })
    }

    pub(super) fn pictures(&self) -> LikelihoodPictures<'_> {
        let (lines, goals) = self.num_pixels();
        LikelihoodPictures {
            title: self.label.clone(),
            subtitle: format!("{lines} line pixels and {goals} goal pixels; best heading at each place"),
            field: self.eye.field(),
            truth: Some(self.truth),
        }
    }

    /// Adds map, surface, image and the table of all places to an outcome, under a name.
    pub(super) fn add_to(&self, outcome: &mut StudyOutcome, name: &str) {
        let pictures = self.pictures();
        let mut add = |kind: &str, picture: Picture| {
            outcome.report.pictures.push((format!("{name}-{kind}"), picture));
        };
        add("map", pictures.heat(&self.map));
        add("surface", pictures.surface(&self.map));
        add("image", pictures.image(&self.image.source.frame, self.eye.percept()));
        outcome.files.push((format!("{name}-map.csv"), map_csv(&self.map)));
    }
}

/// A pose in meters and degrees.
pub(super) fn pose(x_m: f64, y_m: f64, yaw_deg: f64) -> PlanarPose {
    PlanarPose::new(x_m, y_m, yaw_deg.to_radians())
}

/// The map of the documents.
pub(super) const MAP_2010: &str = "robocup-spl-2010";
