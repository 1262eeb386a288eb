//! The likelihood of all places and of all headings.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;
use visloc_core::geom::{PlanarPose, angle};
use visloc_locate::{ObservationModel, Region};
use visloc_plot::Grid;

/// With which heading each place is weighed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HeadingChoice {
    /// The same everywhere, radians.
    Fixed(f64),
    /// At each place the one that explains the image best.
    Best,
}

/// Headings that are tried first, and how often the step is halved around the best of them: from 3 to 0.1 degrees.
const NUM_HEADINGS: u32 = 120;
const NUM_HALVINGS: usize = 5;
/// So many of the first headings are looked at more closely.
const NUM_REFINED: usize = 3;

/// The likelihood over a grid of places.
#[derive(Debug, Clone, PartialEq)]
pub struct LikelihoodMap {
    /// What the cells cover.
    pub region: Region,
    /// Side of a cell, meters.
    pub step_m: f64,
    /// Cells along x.
    pub num_columns: usize,
    /// Likelihood at the middle of each cell, rows along x, the first at the least y.
    pub values: Vec<f64>,
    /// Heading with which each cell was weighed, radians.
    pub headings_rad: Vec<f64>,
}

impl LikelihoodMap {
    /// Weighs the middles of all cells with a conditioned model, in parallel. The number of threads changes nothing.
    pub fn new(model: &dyn ObservationModel, heading: HeadingChoice, step_m: f64) -> Self {
        let region = model.region();
        let count = |length_m: f64| ((length_m / step_m).round() as usize).max(1);
        let num_columns = count(region.max_x_m - region.min_x_m);
        let num_rows = count(region.max_y_m - region.min_y_m);
        let at = |i: usize| place(&region, step_m, num_columns, i);
        let cell = |i: usize| {
            let (x_m, y_m) = at(i);
            match heading {
                HeadingChoice::Fixed(yaw_rad) => {
                    (model.likelihood(&PlanarPose::new(x_m, y_m, yaw_rad)), yaw_rad)
                }
                HeadingChoice::Best => best_heading(model, x_m, y_m),
            }
        };
        let (values, headings_rad) = (0..num_columns * num_rows).into_par_iter().map(cell).unzip();
        Self { region, step_m, num_columns, values, headings_rad }
    }

    /// The pose of a cell.
    pub fn pose(&self, cell: usize) -> PlanarPose {
        let (x_m, y_m) = place(&self.region, self.step_m, self.num_columns, cell);
        PlanarPose::new(x_m, y_m, self.headings_rad[cell])
    }

    /// The most likely cell, the first of equal ones, with its likelihood.
    pub fn maximum(&self) -> (PlanarPose, f64) {
        let best = (0..self.values.len())
            .fold(0, |best, cell| if self.values[cell] > self.values[best] { cell } else { best });
        (self.pose(best), self.values[best])
    }

    /// Area of the cells that are at least so likely, square meters.
    pub fn area_above_m2(&self, likelihood: f64) -> f64 {
        let count = self.values.iter().filter(|value| **value >= likelihood).count();
        count as f64 * self.step_m * self.step_m
    }

    /// Mean over the cells whose distance from a place lies between two limits; `None` if there are none.
    pub fn mean_around(&self, center: &PlanarPose, from_m: f64, to_m: f64) -> Option<f64> {
        let is_between = |cell: &usize| (from_m..to_m).contains(&self.pose(*cell).distance_m(center));
        let values: Vec<f64> =
            (0..self.values.len()).filter(is_between).map(|cell| self.values[cell]).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    }

    /// For pictures.
    pub fn grid(&self) -> Grid {
        Grid {
            origin_m: [self.region.min_x_m, self.region.min_y_m],
            cell_m: self.step_m,
            num_columns: self.num_columns,
            values: self.values.clone(),
        }
    }
}

fn place(region: &Region, step_m: f64, num_columns: usize, cell: usize) -> (f64, f64) {
    let (column, row) = (cell % num_columns, cell / num_columns);
    (region.min_x_m + (column as f64 + 0.5) * step_m, region.min_y_m + (row as f64 + 0.5) * step_m)
}

/// Likelihood and heading of the best heading at a place.
fn best_heading(model: &dyn ObservationModel, x_m: f64, y_m: f64) -> (f64, f64) {
    let at = |yaw_rad: f64| model.likelihood(&PlanarPose::new(x_m, y_m, yaw_rad));
    let step_rad = TAU / f64::from(NUM_HEADINGS);
    let mut first: Vec<(f64, f64)> = (0..NUM_HEADINGS)
        .map(|i| -PI + step_rad * f64::from(i))
        .map(|yaw_rad| (at(yaw_rad), yaw_rad))
        .collect();
    first.sort_by(|a, b| b.0.total_cmp(&a.0));
    let refine = |&start: &(f64, f64)| {
        let (mut best, mut step_rad) = (start, step_rad);
        for _ in 0..NUM_HALVINGS {
            step_rad /= 2.0;
            let around = [best.1 - step_rad, best.1 + step_rad].map(|yaw_rad| (at(yaw_rad), yaw_rad));
            best = around.into_iter().fold(best, |best, other| if other.0 > best.0 { other } else { best });
        }
        best
    };
    let refined = first.iter().take(NUM_REFINED).map(refine);
    let (value, yaw_rad) =
        refined.reduce(|best, other| if other.0 > best.0 { other } else { best }).unwrap_or((0.0, 0.0));
    (value, angle::wrap(yaw_rad))
}

/// Likelihood of the headings at a place, every half degree from -pi to pi: heading (radians) and likelihood.
pub fn heading_profile(model: &dyn ObservationModel, x_m: f64, y_m: f64) -> Vec<(f64, f64)> {
    const COUNT: u32 = 720;
    let heading = |i: u32| -PI + TAU * f64::from(i) / f64::from(COUNT);
    let weighed = |yaw_rad: f64| (yaw_rad, model.likelihood(&PlanarPose::new(x_m, y_m, yaw_rad)));
    (0..=COUNT).map(heading).map(weighed).collect()
}
