//! How well every place explains the image.
//!
//! Source: 2010 section 4.4. Each cell has the best of some headings, so that the map is one of places.

use std::f64::consts::TAU;

use visloc_core::geom::PlanarPose;
use visloc_locate::{
    ObservationModel, PipelineConfig,
    observation::{field::FieldObservationModel, office::OfficeObservationModel},
    vision::Percept,
};
use visloc_world::Map;

use crate::StudioError;

/// Most cells.
const MAX_CELLS: f64 = 900.0;
/// Smallest cells, meters.
const MIN_PITCH_M: f64 = 0.2;
/// Headings that are tried in each cell.
const NUM_HEADINGS: u32 = 16;

/// Likelihoods over a grid.
pub(super) struct LikelihoodMap {
    model: Box<dyn ObservationModel>,
}

impl LikelihoodMap {
    /// For a map.
    pub fn new(map: &Map, config: &PipelineConfig) -> Result<Self, StudioError> {
        let model: Box<dyn ObservationModel> = match map {
            Map::Field(field) => Box::new(FieldObservationModel::new(field, &config.observation)?),
            Map::Office(office) => Box::new(OfficeObservationModel::new(office, &config.office.observation)?),
            other => return Err(StudioError::command("likelihood", "a field or a building", other.name())),
        };
        Ok(Self { model })
    }

    /// Least x and y, pitch, columns and rows, then the likelihoods row by row.
    pub fn values(&mut self, percept: &Percept) -> Vec<f64> {
        self.model.condition_on(percept);
        let region = self.model.region();
        let (width_m, depth_m) = (region.max_x_m - region.min_x_m, region.max_y_m - region.min_y_m);
        let pitch_m = (width_m * depth_m / MAX_CELLS).sqrt().max(MIN_PITCH_M);
        let [columns, rows] = [width_m, depth_m].map(|side| (side / pitch_m).ceil());
        let mut out = vec![region.min_x_m, region.min_y_m, pitch_m, columns, rows];
        let mut y = 0.5;
        while y < rows {
            let mut x = 0.5;
            while x < columns {
                out.push(self.best(region.min_x_m + x * pitch_m, region.min_y_m + y * pitch_m));
                x += 1.0;
            }
            y += 1.0;
        }
        out
    }

    fn best(&self, x_m: f64, y_m: f64) -> f64 {
        let heading = |i: u32| f64::from(i) * TAU / f64::from(NUM_HEADINGS);
        let likelihood = |i| self.model.likelihood(&PlanarPose::new(x_m, y_m, heading(i)));
        (0..NUM_HEADINGS).map(likelihood).fold(0.0, f64::max)
    }
}
