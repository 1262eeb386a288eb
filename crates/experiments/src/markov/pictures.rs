//! Pictures of beliefs and errors.

use visloc_core::geom::PlanarPose;
use visloc_plot::{
    Color, Grid as CellGrid, HeatMap, Histogram, HistogramSeries, Picture, PoseMark, heat_map, histogram,
};

use super::{
    experiment::{MarkovExperiment, MarkovRecord, Reading, Task},
    goalkeeper::Keeper,
};
use crate::Results;

/// Instants of which the source shows the belief.
const SYNTHETIC_INSTANTS: [usize; 3] = [0, 6, 11];
const IMAGE_INSTANTS: [usize; 4] = [0, 1, 4, 11];

pub(super) fn all(experiment: &MarkovExperiment, results: &Results<MarkovRecord>) -> Vec<(String, Picture)> {
    let mut pictures = Vec::new();
    for (name, task, instants) in [
        ("synthetic", Task::Synthetic, &SYNTHETIC_INSTANTS[..]),
        ("images", Task::Images(Reading::Published), &IMAGE_INSTANTS[..]),
        ("densities", Task::Images(Reading::Densities), &IMAGE_INSTANTS[..]),
    ] {
        let walks = experiment.walks(results, task);
        let Some(first) = walks.first() else { continue };
        for &t in instants {
            let Some(belief) = first.beliefs.get(t) else { continue };
            pictures.push((format!("belief-{name}-t{t:02}"), belief_map(experiment, belief, name, t)));
        }
    }
    pictures.push(("goalkeeper-errors".to_owned(), keeper_errors(experiment, results)));
    pictures
}

/// The belief of each tile, all headings together, on the field; arrows for the truth and the best state.
fn belief_map(experiment: &MarkovExperiment, belief: &[f64], name: &str, t: usize) -> Picture {
    let grid = &experiment.stage.grid;
    let (columns, rows) = (grid.num_columns(), grid.num_rows());
    // The picture's cells run along +x and +y, the grid's tiles from the blue goal's far corner.
    let mut values = vec![0.0; columns * rows];
    for (index, probability) in belief.iter().enumerate() {
        let state = grid.state(index);
        values[(rows - 1 - state.row) * columns + (columns - 1 - state.column)] += probability;
    }
    let (best, probability) =
        belief.iter().enumerate().fold((0, 0.0), |best, (i, p)| if *p > best.1 { (i, *p) } else { best });
    let mark = |label: &str, color, pose: PlanarPose| PoseMark { label: label.to_owned(), color, pose };
    // One arrow, if both would lie on each other.
    let truth = 32 * t;
    let marks = if best == truth {
        vec![mark("robot, best", Color::BLUISH_GREEN, grid.pose(best))]
    } else {
        vec![
            mark("robot", Color::BLUISH_GREEN, grid.pose(truth)),
            mark("best", Color::VERMILION, grid.pose(best)),
        ]
    };
    let answer = if probability > 0.5 { "localized" } else { "not localized" };
    let half_m = [columns, rows].map(|count| count as f64 * grid.tile_m() / 2.0);
    let input = HeatMap {
        title: format!("Belief at t = {t}, walk along the right edge ({name})"),
        subtitle: format!(
            "state {best} has {:.0} %: {answer}; the robot is in state {}",
            100.0 * probability,
            32 * t
        ),
        value_label: "belief of the tile, all headings".to_owned(),
        grid: CellGrid {
            origin_m: [-half_m[0], -half_m[1]],
            cell_m: grid.tile_m(),
            num_columns: columns,
            values,
        },
        range: Some((0.0, 1.0)),
        marks,
    };
    heat_map(&input, Some((&experiment.stage.field).into()))
}

fn keeper_errors(experiment: &MarkovExperiment, results: &Results<MarkovRecord>) -> Picture {
    let series = [
        ("published filter", Color::BLUE, Keeper::Published),
        ("corrected way", Color::VERMILION, Keeper::Corrected),
    ];
    let series = series.map(|(label, color, keeper)| HistogramSeries {
        label: label.to_owned(),
        color,
        values: experiment.keepers(results, keeper).iter().map(|record| record.error_m * 1000.0).collect(),
    });
    histogram(&Histogram {
        title: "Goalkeeper: distance from the middle of the target tile at the end".to_owned(),
        subtitle: "published: 150 to 350 mm on the robot".to_owned(),
        value_label: "error [mm]".to_owned(),
        num_bins: 20,
        range: Some((0.0, 1000.0)),
        series: series.to_vec(),
    })
}
