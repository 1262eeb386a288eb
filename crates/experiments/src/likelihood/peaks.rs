//! The peaks of a likelihood.

use visloc_core::geom::{PlanarPose, angle};
use visloc_locate::ObservationModel;

use super::LikelihoodMap;

/// A pose that is more likely than those around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// The pose.
    pub pose: PlanarPose,
    /// Its likelihood, 0 to 1.
    pub likelihood: f64,
}

/// Peaks this far apart are told apart, meters.
pub const PEAK_DISTANCE_M: f64 = 0.4;

/// The local maxima of a map, the most likely first: cells that no neighbor exceeds, at least so far from a more likely
/// one, meters.
pub fn peaks(map: &LikelihoodMap, min_distance_m: f64) -> Vec<Peak> {
    let columns = map.num_columns;
    let rows = map.values.len() / columns;
    let is_local = |cell: &usize| {
        let (row, column) = (cell / columns, cell % columns);
        let (top, left) = (row.saturating_sub(1), column.saturating_sub(1));
        let around = (top..=(row + 1).min(rows - 1))
            .flat_map(|r| (left..=(column + 1).min(columns - 1)).map(move |c| r * columns + c));
        around.into_iter().all(|other| map.values[other] <= map.values[*cell])
    };
    let mut local: Vec<Peak> = (0..map.values.len())
        .filter(is_local)
        .map(|cell| Peak { pose: map.pose(cell), likelihood: map.values[cell] })
        .collect();
    local.sort_by(|a, b| b.likelihood.total_cmp(&a.likelihood));
    let mut kept: Vec<Peak> = Vec::new();
    for peak in local {
        if kept.iter().all(|other| other.pose.distance_m(&peak.pose) >= min_distance_m) {
            kept.push(peak);
        }
    }
    kept
}

/// First steps of a climb, meters and radians, and how often they are halved: down to about a millimeter.
const FIRST_STEP: (f64, f64) = (0.2, 0.15);
const NUM_HALVINGS: u32 = 8;

/// Walks from a pose uphill to a peak, by steps along x, y and heading and all their combinations.
/// Compass search after Hooke and Jeeves, 1961.
pub fn climb(model: &dyn ObservationModel, start: &PlanarPose) -> Peak {
    let mut best = Peak { pose: *start, likelihood: model.likelihood(start) };
    let (mut step_m, mut step_rad) = FIRST_STEP;
    for _ in 0..=NUM_HALVINGS {
        while let Some(better) = step(model, &best, step_m, step_rad) {
            best = better;
        }
        step_m /= 2.0;
        step_rad /= 2.0;
    }
    best
}

/// The best of the 26 neighbors, if it is better.
fn step(model: &dyn ObservationModel, from: &Peak, step_m: f64, step_rad: f64) -> Option<Peak> {
    let mut best: Option<Peak> = None;
    for dx in [-step_m, 0.0, step_m] {
        for dy in [-step_m, 0.0, step_m] {
            for turn in [-step_rad, 0.0, step_rad] {
                let pose = &from.pose;
                let yaw_rad = angle::wrap(pose.yaw_rad + turn);
                let pose = PlanarPose::new(pose.x_m + dx, pose.y_m + dy, yaw_rad);
                let likelihood = model.likelihood(&pose);
                let least = best.map_or(from.likelihood + 1e-9, |best| best.likelihood);
                if likelihood > least {
                    best = Some(Peak { pose, likelihood });
                }
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use visloc_locate::Region;

    use super::*;

    #[test]
    fn peaks_are_sorted_and_apart() {
        let mut values = vec![0.0; 100];
        values[11] = 0.5;
        values[88] = 0.9;
        values[77] = 0.8; // on the slope of the one before
        let region = Region { min_x_m: 0.0, max_x_m: 10.0, min_y_m: 0.0, max_y_m: 10.0 };
        let headings_rad = vec![0.0; 100];
        let map = LikelihoodMap { region, step_m: 1.0, num_columns: 10, values, headings_rad };
        let found = peaks(&map, 2.0);
        assert_eq!((found[0].likelihood, found[1].likelihood), (0.9, 0.5));
        assert_eq!((found[0].pose.x_m, found[0].pose.y_m), (8.5, 8.5));
        assert!((map.area_above_m2(0.5) - 3.0).abs() < 1e-12);
        assert_eq!(map.maximum().1, 0.9);
    }
}
