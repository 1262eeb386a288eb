//! From runs to rows: one for each class, setting and quantity.

use visloc_core::eval::camera::Statistics;
use visloc_plot::Table;

use super::{
    Claims, Kind,
    claims::{Contender, Figure, From},
    quantities::{Quantity, percent},
    store::Cell,
};

/// Below this share of frames with a pose an error says little; such errors get a star.
const FULL_COVERAGE: f64 = 0.7;

/// Columns for people and for programs.
const HEADER: &str = "recordings, settings, what, published, best other program, median here, least to largest, runs, \
    frames with a pose, ms an image, MB";
const HEADER_FOR_PROGRAMS: &str = "class settings quantity published published_by published_in peer peer_by peer_in \
    peer_coverage median least largest recordings runs runs_with_value";

/// A quantity of a setting on a class of recordings.
pub struct Row<'a> {
    /// The class.
    pub class: &'a str,
    /// The settings.
    pub contender: &'a str,
    /// What is measured.
    pub quantity: Quantity,
    /// All runs, with and without a value.
    pub runs: Vec<&'a Cell>,
    /// The figure of a document.
    pub published: Option<&'a Figure>,
    /// The figure of another program on the same recordings.
    pub peer: Option<&'a Figure>,
    coverage: Option<Statistics>,
    time_ms: Option<f64>,
    memory_mb: Option<f64>,
}

impl<'a> Row<'a> {
    /// All rows of some runs.
    pub fn all(claims: &'a Claims, cells: &'a [Cell]) -> Vec<Self> {
        let mut classes: Vec<&str> = claims.classes.iter().map(|class| class.name.as_str()).collect();
        for cell in cells {
            if !classes.contains(&cell.key.class.as_str()) {
                classes.push(&cell.key.class);
            }
        }
        let mut rows = Vec::new();
        for class in classes {
            for contender in &claims.contenders {
                let is_of = |cell: &&Cell| cell.key.class == class && cell.key.contender == contender.name;
                rows.extend(rows_of(
                    claims,
                    class,
                    contender,
                    &cells.iter().filter(is_of).collect::<Vec<_>>(),
                ));
            }
        }
        rows
    }

    /// The values of the runs that have one.
    pub fn values(&self) -> Vec<f64> {
        values(self.quantity, &self.runs)
    }

    /// The values on one recording.
    pub fn values_on(&self, recording: &str) -> Vec<f64> {
        let runs = self.runs.iter().copied().filter(|cell| cell.key.recording == recording);
        values(self.quantity, &runs.collect::<Vec<_>>())
    }

    /// The recordings of its runs, each once.
    pub fn recordings(&self) -> Vec<&'a str> {
        let mut names: Vec<&str> = Vec::new();
        for cell in &self.runs {
            if !names.contains(&cell.key.recording.as_str()) {
                names.push(&cell.key.recording);
            }
        }
        names
    }

    /// Whether it is the error that stands first.
    pub fn is_main(&self) -> bool {
        [Kind::Map, Kind::Slam].into_iter().any(|kind| self.quantity == Quantity::main_of(kind))
    }

    /// Median and range of some of its values.
    fn median_and_range(&self, values: &[f64]) -> [String; 2] {
        let Some(found) = Statistics::of(values) else { return ["-", "-"].map(str::to_owned) };
        let [median, min, max] = [found.median, found.min, found.max].map(|value| self.quantity.text(value));
        let range = if min == max { min } else { format!("{min} to {max}") };
        [median, range]
    }

    /// How many runs have a value, and on how many recordings.
    fn num_runs(&self) -> String {
        let (num_values, num_runs, num_recordings) =
            (self.values().len(), self.runs.len(), self.recordings().len());
        let of = if num_values == num_runs { String::new() } else { format!(" of {num_runs}") };
        let on = if num_recordings == 1 { String::new() } else { format!(" on {num_recordings} recordings") };
        format!("{num_values}{of}{on}")
    }

    fn coverage(&self) -> String {
        let Some(coverage) = self.coverage else { return "-".to_owned() };
        let [median, min] = [coverage.median, coverage.min].map(percent);
        if median == min { median } else { format!("{median} (least {min})") }
    }
}

fn values(quantity: Quantity, cells: &[&Cell]) -> Vec<f64> {
    cells.iter().filter_map(|cell| cell.figures.get(&quantity).copied()).collect()
}

fn rows_of<'a>(
    claims: &'a Claims,
    class: &'a str,
    contender: &'a Contender,
    cells: &[&'a Cell],
) -> Vec<Row<'a>> {
    let (times, accuracy): (Vec<&Cell>, Vec<&Cell>) = cells.iter().partition(|cell| cell.key.is_timed);
    let cost = |quantity| values(quantity, &times).first().copied();
    let row = |quantity: Quantity| Row {
        class,
        contender: &contender.name,
        quantity,
        runs: if quantity.is_cost() { times.clone() } else { accuracy.clone() },
        published: claims.figure(class, &contender.name, quantity, From::Published),
        peer: claims.figure(class, &contender.name, quantity, From::Same),
        coverage: Statistics::of(&values(Quantity::Coverage, &accuracy)),
        time_ms: cost(Quantity::TimeMs),
        memory_mb: cost(Quantity::MemoryMb),
    };
    let is_shown = |row: &Row<'_>| {
        !row.values().is_empty()
            || (row.quantity == Quantity::main_of(contender.kind) && !row.runs.is_empty())
    };
    Quantity::all().map(row).filter(is_shown).collect()
}

/// The table for people. What is the same as in the row above is left empty.
pub fn for_people(rows: &[Row<'_>]) -> Table {
    table(rows.iter(), true)
}

/// The errors that stand first, for a screen: what they are stands above.
pub fn for_screens(rows: &[Row<'_>]) -> Table {
    table(rows.iter().filter(|row| row.is_main()), false)
}

fn table<'a>(rows: impl Iterator<Item = &'a Row<'a>>, has_quantities: bool) -> Table {
    let header: Vec<&str> = HEADER.split(", ").collect();
    let title = match has_quantities {
        true => "What is claimed",
        false => "Position error: mean on a known map, without one ATE RMSE after alignment with scale [m]",
    };
    let chosen = |column: &usize| has_quantities || header[*column] != "what";
    let columns: Vec<usize> = (0..header.len()).filter(chosen).collect();
    let mut table = Table::new("claims", title, &columns.iter().map(|&i| header[i]).collect::<Vec<_>>());
    let mut above = ("", "");
    for row in rows {
        let is_new_class = above.0 != row.class;
        let is_new = is_new_class || above.1 != row.contender;
        above = (row.class, row.contender);
        let once = |text: String, is_wanted: bool| if is_wanted { text } else { String::new() };
        let cost = |quantity: Quantity, value: Option<f64>| {
            once(value.map_or_else(|| "-".to_owned(), |value| quantity.text(value)), is_new)
        };
        let is_partial = row.coverage.is_some_and(|coverage| coverage.median < FULL_COVERAGE);
        let star = if row.quantity == Quantity::AteM && is_partial { "*" } else { "" };
        let [median, range] = row.median_and_range(&row.values());
        let cells = [
            once(row.class.to_owned(), is_new_class),
            once(row.contender.to_owned(), is_new),
            row.quantity.title().to_owned(),
            figure_text(row.published),
            figure_text(row.peer),
            median + star,
            range,
            row.num_runs(),
            once(row.coverage(), is_new),
            cost(Quantity::TimeMs, row.time_ms),
            cost(Quantity::MemoryMb, row.memory_mb),
        ];
        table.push(columns.iter().map(|&i| cells[i].clone()));
    }
    table
}

/// A figure of others with its origin.
fn figure_text(figure: Option<&Figure>) -> String {
    let Some(figure) = figure else { return "-".to_owned() };
    let coverage =
        figure.coverage.map(|share| format!(", {} of the frames", percent(share))).unwrap_or_default();
    format!("{} ({}{coverage})", figure.quantity.text(figure.value), figure.by)
}

/// The first errors of classes with several recordings, recording by recording.
pub fn recording_by_recording(rows: &[Row<'_>]) -> Vec<String> {
    let several = rows.iter().filter(|row| row.is_main() && row.recordings().len() > 1);
    several
        .map(|row| {
            let each = row.recordings().into_iter().map(|recording| {
                let [median, range] = row.median_and_range(&row.values_on(recording));
                format!("{recording} {median} ({range})")
            });
            format!("{}; {}: {}", row.class, row.contender, each.collect::<Vec<_>>().join(", "))
        })
        .collect()
}

/// The table for programs.
pub fn for_programs(rows: &[Row<'_>]) -> Table {
    let mut table = Table::new("report", "", &HEADER_FOR_PROGRAMS.split(' ').collect::<Vec<_>>());
    for row in rows {
        let key = serde_json::to_value(row.quantity).unwrap_or_default();
        let found = Statistics::of(&row.values());
        let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
        let of_others = |figure: Option<&Figure>| {
            let text = |part: fn(&Figure) -> &str| figure.map(part).unwrap_or_default().to_owned();
            [number(figure.map(|f| f.value)), text(|f| &f.by), text(|f| &f.source)]
        };
        let mut cells = vec![row.class.to_owned(), row.contender.to_owned()];
        cells.push(key.as_str().unwrap_or_default().to_owned());
        cells.extend(of_others(row.published).into_iter().chain(of_others(row.peer)));
        cells.push(number(row.peer.and_then(|figure| figure.coverage)));
        cells.extend([found.map(|f| f.median), found.map(|f| f.min), found.map(|f| f.max)].map(number));
        cells.extend([row.recordings().len(), row.runs.len(), row.values().len()].map(|n| n.to_string()));
        table.push(cells);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmark::store::CellKey;

    fn cell(recording: &str, seed: u64, error_m: f64) -> Cell {
        let key = CellKey {
            class: "S4 floor, abrupt turns".to_owned(),
            recording: recording.to_owned(),
            contender: "sdvl".to_owned(),
            seed,
            ..CellKey::default()
        };
        let figures = [(Quantity::AteM, error_m), (Quantity::Coverage, 1.0)];
        Cell { key, figures: figures.into(), truth: Vec::new(), estimate: Vec::new() }
    }

    #[test]
    fn scenes_of_a_kind_share_a_row_and_are_listed_one_by_one() {
        let claims = Claims::built_in().unwrap();
        let cells = [cell("S4", 101, 0.01), cell("S4", 102, 0.03), cell("S4s404", 101, 0.5)];
        let rows = Row::all(&claims, &cells);
        let table = for_screens(&rows);
        assert_eq!(table.rows.len(), 1);
        assert_eq!(table.rows[0][4..7], ["0.0300", "0.0100 to 0.500", "3 on 2 recordings"]);
        let lines = recording_by_recording(&rows);
        assert_eq!(
            lines,
            ["S4 floor, abrupt turns; sdvl: S4 0.0200 (0.0100 to 0.0300), S4s404 0.500 (0.500)"]
        );
    }
}
