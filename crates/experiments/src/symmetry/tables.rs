//! Tables: published and measured side by side.

use super::{
    contenders::{self, CONTROL, EXPLOITERS, EXPLORERS, FILTERS, PARTICLES},
    experiment::{LONG_MOVEMENTS, LONG_POSITIONS, POSITIONS},
    report::{Outcome, Summary},
    timing::{IterationTime, explorers},
};
use crate::{Table, number, positions::Movement, published};

const NONE: &str = "-";

/// All tables of the published part.
pub(super) fn published(summary: &Summary, times: &[IterationTime]) -> Vec<Table> {
    let tables = [
        static_filters(summary),
        moving_filters(summary),
        filter_times(times),
        evolutionary_successes(summary),
        evolutionary_iterations(summary),
        evolutionary_times(times),
    ];
    tables.into_iter().map(|table| published::beside(table, "symmetry")).collect()
}

/// Labels of the rows of particle filters, the null control last.
fn filter_labels() -> impl Iterator<Item = &'static str> {
    FILTERS.iter().map(|filter| filter.label).chain([CONTROL])
}

/// A name, and a cell for each number of positions.
fn row(name: String, cell: impl Fn(usize) -> String) -> impl Iterator<Item = String> {
    std::iter::once(name).chain(POSITIONS.map(cell))
}

/// A table with a column for each number of positions.
fn of_positions(name: &str, title: &str, first: &str) -> Table {
    Table::new(name, title, &[first, "2 positions", "3 positions", "4 positions"])
}

/// Static positions: successes of all filters.
fn static_filters(summary: &Summary) -> Table {
    let title = "Static positions, successes in % after 300 iterations: published | here (strict criterion)";
    let mut table = of_positions("static", title, "algorithm, particles");
    for label in filter_labels() {
        for num in PARTICLES {
            let cell = |positions| measured(summary.find(label, num, Movement::Static, positions));
            table.push(row(format!("{label}, {num}"), cell));
        }
    }
    table
}

/// Moving positions: successes with 1,000 particles and of the evolutionary algorithm.
fn moving_filters(summary: &Summary) -> Table {
    let title = "Positions that move 1 cm per iteration, successes in % after 300 iterations: published | here (strict)";
    let mut table = of_positions("moving", title, "algorithm, individuals");
    let evolutionary = contenders::evolutionary(20);
    let rows = filter_labels().map(|label| (label.to_owned(), 1000));
    for (label, num) in rows.chain([(evolutionary.label, evolutionary.num_individuals)]) {
        let cell = |positions| measured(summary.find(&label, num, Movement::Straight(0.01), positions));
        table.push(row(format!("{label}, {num}"), cell));
    }
    table
}

/// The evolutionary algorithm: successes.
fn evolutionary_successes(summary: &Summary) -> Table {
    let title = "Evolutionary, 4 races of 20 exploiters, static positions, successes in % after 300 iterations: \
                 published | here (strict)";
    let mut table = of_positions("evolutionary", title, "explorers");
    for num in EXPLORERS {
        table.push(row(num.to_string(), |positions| measured(summary.evolutionary(num, positions))));
    }
    table
}

/// The evolutionary algorithm: iterations until all positions are found.
fn evolutionary_iterations(summary: &Summary) -> Table {
    let title = "Evolutionary, mean iterations until all positions are found: published | here (difference)";
    let mut table = of_positions("evolutionary-iterations", title, "explorers");
    for num in EXPLORERS {
        let cell = |positions| {
            let mean = summary.evolutionary(num, positions).and_then(|outcome| outcome.mean_found_after);
            let difference = mean.and_then(|mean| Some((mean, iterations_difference(num, positions, mean)?)));
            difference
                .map_or_else(|| number(mean, 2), |(mean, percent)| format!("{mean:.2} ({percent:+.0} %)"))
        };
        table.push(row(num.to_string(), cell));
    }
    table
}

/// How much longer than published it took to find all positions, in percent.
pub(super) fn iterations_difference(num_explorers: usize, num_positions: usize, mean: f64) -> Option<f64> {
    let (row, column) = (num_explorers.to_string(), format!("{num_positions} positions"));
    let published = published::number("symmetry/evolutionary-iterations", &row, &column)?;
    Some(100.0 * (mean / published - 1.0))
}

/// Times of the filters.
fn filter_times(times: &[IterationTime]) -> Table {
    let title =
        "Particle filters, time of an iteration by the number of particles [ms]: published (Python) | here";
    let columns = PARTICLES.map(|num| num.to_string());
    let rows = FILTERS.map(|filter| filter.label.to_owned());
    time_table(("times", title, "algorithm"), &columns, &rows, times)
}

/// Times of the evolutionary algorithm.
fn evolutionary_times(times: &[IterationTime]) -> Table {
    let title = "Evolutionary with 4 races, time of an iteration [ms]: published (Python) | here";
    let name = ("evolutionary-times", title, "exploiters of a race");
    time_table(name, &EXPLORERS.map(explorers), &EXPLOITERS.map(|num| num.to_string()), times)
}

fn time_table(
    (name, title, first): (&str, &str, &str),
    columns: &[String],
    rows: &[String],
    times: &[IterationTime],
) -> Table {
    let header: Vec<&str> = std::iter::once(first).chain(columns.iter().map(String::as_str)).collect();
    let mut table = Table::new(name, title, &header);
    for row in rows {
        let cell = |column: &String| {
            let is_here = |time: &&IterationTime| {
                time.place.0 == name && time.place.1 == *row && time.place.2 == *column
            };
            number(times.iter().find(is_here).map(|time| time.mean_ms), 4)
        };
        table.push(std::iter::once(row.clone()).chain(columns.iter().map(cell)));
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
            let cell = |outcome: &Option<&Outcome>| {
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

fn measured(outcome: Option<&Outcome>) -> String {
    outcome.map_or_else(
        || NONE.to_owned(),
        |o| format!("{:.0} ({:.0})", o.percent(o.num_published), o.percent(o.num_strict)),
    )
}
