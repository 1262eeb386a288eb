//! Tables: published and measured side by side.

use super::{
    contenders::{self, CONTROL, FILTERS},
    experiment::{LONG_MOVEMENTS, LONG_POSITIONS},
    published::{self, EXPLORERS, PARTICLES, POSITIONS},
    report::Summary,
};
use crate::{Table, positions::Movement};

const NONE: &str = "-";

/// Labels of the rows of particle filters, the null control last.
fn filter_labels() -> impl Iterator<Item = &'static str> {
    FILTERS.iter().map(|filter| filter.label).chain([CONTROL])
}

/// Static positions: successes of all filters.
pub(super) fn static_filters(summary: &Summary) -> Table {
    let title = "Static positions, successes in % after 300 iterations: published | here (strict criterion)";
    let mut table =
        Table::new("static", title, &["algorithm", "particles", "2 positions", "3 positions", "4 positions"]);
    for label in filter_labels() {
        let all_published = published::static_successes(label);
        for (i, num_particles) in PARTICLES.into_iter().enumerate() {
            let mut row = vec![label.to_owned(), num_particles.to_string()];
            for (j, num_positions) in POSITIONS.into_iter().enumerate() {
                let published = all_published.map(|table| table[i][j]);
                let found = summary.find(label, num_particles, Movement::Static, num_positions);
                row.push(published_and_measured(published, found));
            }
            table.push(row);
        }
    }
    table
}

/// Moving positions: successes with 1,000 particles and of the evolutionary algorithm.
pub(super) fn moving_filters(summary: &Summary) -> Table {
    let title = "Positions that move 1 cm per iteration, successes in % after 300 iterations: published | here (strict)";
    let header = ["algorithm", "individuals", "2 positions", "3 positions", "4 positions"];
    let mut table = Table::new("moving", title, &header);
    let evolutionary = contenders::evolutionary(20);
    let rows = filter_labels().map(|label| (label.to_owned(), 1000));
    for (label, num) in rows.chain([(evolutionary.label, evolutionary.num_individuals)]) {
        let mut row = vec![label.clone(), num.to_string()];
        for (j, num_positions) in POSITIONS.into_iter().enumerate() {
            let published = published::moving_successes(&label).map(|row| row[j]);
            let found = summary.find(&label, num, Movement::Straight(0.01), num_positions);
            row.push(published_and_measured(published, found));
        }
        table.push(row);
    }
    table
}

/// The evolutionary algorithm: successes.
pub(super) fn evolutionary_successes(summary: &Summary) -> Table {
    let title = "Evolutionary, 4 races of 20 exploiters, static positions, successes in % after 300 iterations: \
                 published | here (strict)";
    let mut table = Table::new(
        "evolutionary",
        title,
        &["explorers", "individuals", "2 positions", "3 positions", "4 positions"],
    );
    for (i, num_explorers) in EXPLORERS.into_iter().enumerate() {
        let contender = contenders::evolutionary(num_explorers);
        let mut row = vec![num_explorers.to_string(), contender.num_individuals.to_string()];
        for (j, num_positions) in POSITIONS.into_iter().enumerate() {
            let found =
                summary.find(&contender.label, contender.num_individuals, Movement::Static, num_positions);
            row.push(published_and_measured(Some(published::EVOLUTIONARY_SUCCESSES[i][j]), found));
        }
        table.push(row);
    }
    table
}

/// The evolutionary algorithm: iterations until all positions are found.
pub(super) fn evolutionary_iterations(summary: &Summary) -> Table {
    let title = "Evolutionary, mean iterations until all positions are found: published | here (difference)";
    let header = ["explorers", "2 positions", "3 positions", "4 positions"];
    let mut table = Table::new("evolutionary-iterations", title, &header);
    for (i, num_explorers) in EXPLORERS.into_iter().enumerate() {
        let contender = contenders::evolutionary(num_explorers);
        let mut row = vec![num_explorers.to_string()];
        for (j, num_positions) in POSITIONS.into_iter().enumerate() {
            let published = published::EVOLUTIONARY_ITERATIONS[i][j];
            let found =
                summary.find(&contender.label, contender.num_individuals, Movement::Static, num_positions);
            let mean = found.and_then(|outcome| outcome.mean_found_after);
            row.push(mean.map_or_else(
                || format!("{published:.2} | {NONE}"),
                |mean| format!("{published:.2} | {mean:.2} ({:+.0} %)", 100.0 * (mean / published - 1.0)),
            ));
        }
        table.push(row);
    }
    table
}

/// The long part: runs that held all positions.
pub(super) fn long(summary: &Summary) -> Table {
    let title = "3,000 iterations, at most 120 individuals, runs in which all positions were held: published criterion \
                 at the end | strict criterion at the end | strict criterion in every iteration after the 300th";
    let labels = LONG_POSITIONS.map(|num| format!("{num} positions"));
    let mut header = vec!["algorithm", "movement", "runs"];
    header.extend(labels.iter().map(String::as_str));
    let mut table = Table::new("long", title, &header);
    for contender in [contenders::evolutionary_long(), contenders::control(120)] {
        for movement in LONG_MOVEMENTS {
            let name = match movement {
                Movement::Static => "static".to_owned(),
                Movement::Straight(step_m) | Movement::Wandering(step_m) => {
                    format!("{:.0} cm per iteration", 100.0 * step_m)
                }
            };
            let outcomes = LONG_POSITIONS.map(|num| summary.find(&contender.label, 120, movement, num));
            let num_runs = outcomes.iter().flatten().map(|outcome| outcome.num_runs).max().unwrap_or(0);
            let cell = |outcome: &Option<&super::report::Outcome>| {
                outcome.map_or_else(
                    || NONE.to_owned(),
                    |o| format!("{} | {} | {}", o.num_published, o.num_strict, o.num_never_lost),
                )
            };
            let first = [contender.label.clone(), name, num_runs.to_string()];
            table.push(first.into_iter().chain(outcomes.iter().map(cell)));
        }
    }
    table
}

fn published_and_measured(published: Option<u32>, outcome: Option<&super::report::Outcome>) -> String {
    let published = published.map_or_else(|| NONE.to_owned(), |value| value.to_string());
    let measured = outcome.map_or_else(
        || NONE.to_owned(),
        |o| format!("{:.0} ({:.0})", o.percent(o.num_published), o.percent(o.num_strict)),
    );
    format!("{published:>3} | {measured:>9}")
}
