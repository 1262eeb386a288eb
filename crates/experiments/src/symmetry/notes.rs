//! What the tables mean, and where they differ from the published ones.

use super::{
    contenders::{EXPLORERS, FILTERS, PARTICLES},
    experiment::POSITIONS,
    report::Summary,
    tables::iterations_difference,
};
use crate::{positions::Movement, published};

/// Largest differences to the published figures, in words.
pub(super) fn published(summary: &Summary) -> Vec<String> {
    let mut notes = vec![
        "Criterion of the document: somebody within 2 m of every position. Strict: near every position a quarter of its \
         fair share of all individuals, explorers included. The null control shows what the first one is worth."
            .to_owned(),
        "When due: survivors are drawn only in iterations in which the effective sample size is below half of the \
         particles; until then particles keep their weights."
            .to_owned(),
        "Noise: 0.1 m for MC, MCA and systematic, 0.15 m for MCE and MCAe, whose elite has none. The document does not \
         say it. Positions are at least 0.5 m from the border, so that no cloud is cut in half there, and 4 m from each \
         other; the document does not say how they are placed."
            .to_owned(),
    ];
    for filter in &FILTERS {
        let largest =
            deviations(summary, filter.label).into_iter().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        if let Some((difference, place)) = largest {
            notes.push(format!(
                "{}: largest difference to the published successes {difference:+.0} points ({place}).",
                filter.label
            ));
        }
    }
    notes.extend(iterations(summary));
    notes
}

/// Differences in points, with their places.
fn deviations(summary: &Summary, label: &str) -> Vec<(f64, String)> {
    let mut differences = Vec::new();
    for (table, movement) in [("static", Movement::Static), ("moving", Movement::Straight(0.01))] {
        for (num_particles, num_positions) in
            PARTICLES.into_iter().flat_map(|n| POSITIONS.map(|positions| (n, positions)))
        {
            let (row, column) = (format!("{label}, {num_particles}"), format!("{num_positions} positions"));
            let figure = published::number(&format!("symmetry/{table}"), &row, &column);
            let outcome = summary.find(label, num_particles, movement, num_positions);
            if let (Some(figure), Some(outcome)) = (figure, outcome) {
                let difference = outcome.percent(outcome.num_published) - figure;
                differences.push((
                    difference,
                    format!("{num_particles} particles, {num_positions} {table} positions"),
                ));
            }
        }
    }
    differences
}

fn iterations(summary: &Summary) -> Option<String> {
    let of = |num_explorers: usize, num_positions: usize| {
        let mean = summary.evolutionary(num_explorers, num_positions)?.mean_found_after?;
        iterations_difference(num_explorers, num_positions, mean)
    };
    let ratios = EXPLORERS.into_iter().flat_map(|num| POSITIONS.into_iter().filter_map(move |p| of(num, p)));
    let largest = ratios.max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    Some(format!(
        "Evolutionary: largest difference to the published iterations until found {largest:+.0} %. An explorer founds a \
         race from a likelihood of 0.25 on, and races nearer than 2 m are one; the document says neither."
    ))
}

/// What the table of the long part means.
pub(super) fn long() -> Vec<String> {
    vec![
        "Positions that move turn at random where the way ahead leaves the square or comes within 4 m of another position."
            .to_owned(),
        "Evolutionary: at most 8 races share 96 exploiters equally; 24 explorers in each iteration; the fair share counts \
         all 120."
            .to_owned(),
        "With 8 positions a quarter of the fair share is what chance puts within 2 m of a place far from the border, so the \
         null control can meet the strict criterion for a moment, but not for long."
            .to_owned(),
    ]
}
