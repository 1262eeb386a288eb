//! From runs to rows: one for each class, setting and quantity.

use visloc_eval::camera::Statistics;
use visloc_experiments::Table;

use super::{
    Claims, Kind,
    claims::{Figure, From},
    quantities::{Quantity, percent},
    store::Cell,
};

/// The column that says what is measured.
const WHAT: usize = 2;
/// Below this share of frames with a pose an error says little; such errors get a star.
const FULL_COVERAGE: f64 = 0.7;

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
                let of: Vec<&Cell> = cells.iter().filter(is_of).collect();
                if !of.is_empty() {
                    rows.extend(rows_of(claims, class, &contender.name, contender.kind, &of));
                }
            }
        }
        rows
    }

    /// The values of the runs that have one.
    pub fn values(&self) -> Vec<f64> {
        self.runs.iter().filter_map(|cell| cell.figures.get(&self.quantity).copied()).collect()
    }

    /// Whether it is the error that stands first.
    pub fn is_main(&self) -> bool {
        [Kind::Map, Kind::Slam].into_iter().any(|kind| self.quantity == Quantity::main_of(kind))
    }

    /// Median, with a star if few frames have a pose; and range.
    fn here(&self) -> [String; 2] {
        let Some(found) = Statistics::of(&self.values()) else { return ["-".to_owned(), "-".to_owned()] };
        let is_partial = self.coverage.is_some_and(|coverage| coverage.median < FULL_COVERAGE);
        let star = if self.quantity == Quantity::AteM && is_partial { "*" } else { "" };
        let [median, min, max] = [found.median, found.min, found.max].map(|value| self.quantity.text(value));
        let range = if min == max { min } else { format!("{min} to {max}") };
        [median + star, range]
    }

    fn num_runs(&self) -> String {
        let num_values = self.values().len();
        if num_values == self.runs.len() {
            num_values.to_string()
        } else {
            format!("{num_values} of {}", self.runs.len())
        }
    }

    fn coverage(&self) -> String {
        let Some(coverage) = self.coverage else { return "-".to_owned() };
        let [median, min] = [coverage.median, coverage.min].map(percent);
        if median == min { median } else { format!("{median} (least {min})") }
    }
}

fn rows_of<'a>(
    claims: &'a Claims,
    class: &'a str,
    contender: &'a str,
    kind: Kind,
    cells: &[&'a Cell],
) -> Vec<Row<'a>> {
    let of = |is_timed: bool| {
        cells.iter().copied().filter(move |cell| cell.key.is_timed == is_timed).collect::<Vec<_>>()
    };
    let [accuracy, times] = [false, true].map(of);
    let shares: Vec<f64> =
        accuracy.iter().filter_map(|cell| cell.figures.get(&Quantity::Coverage).copied()).collect();
    let cost = |quantity| times.iter().find_map(|cell| cell.figures.get(&quantity).copied());
    let row = |quantity: Quantity| Row {
        class,
        contender,
        quantity,
        runs: if quantity.is_cost() { times.clone() } else { accuracy.clone() },
        published: claims.figure(class, contender, quantity, From::Published),
        peer: claims.figure(class, contender, quantity, From::Same),
        coverage: Statistics::of(&shares),
        time_ms: cost(Quantity::TimeMs),
        memory_mb: cost(Quantity::MemoryMb),
    };
    let is_shown = |row: &Row<'_>| {
        !row.values().is_empty() || (row.quantity == Quantity::main_of(kind) && !row.runs.is_empty())
    };
    Quantity::ALL.into_iter().map(row).filter(is_shown).collect()
}

/// The table for people. What is the same as in the row above is left empty.
pub fn for_people<'a>(rows: impl Iterator<Item = &'a Row<'a>>) -> Table {
    let header = [
        "recordings",
        "settings",
        "what",
        "published",
        "best other program",
        "here, median",
        "least to largest",
        "runs",
        "frames with a pose",
        "ms an image",
        "MB",
    ];
    let mut table = Table::new("claims", "What is claimed", &header);
    let mut above = ("", "");
    for row in rows {
        let is_new_class = above.0 != row.class;
        let is_new = is_new_class || above.1 != row.contender;
        above = (row.class, row.contender);
        let once = |text: String, is_wanted: bool| if is_wanted { text } else { String::new() };
        let cost = |quantity: Quantity, value: Option<f64>| {
            value.map_or_else(|| "-".to_owned(), |v| quantity.text(v))
        };
        let [median, range] = row.here();
        table.push([
            once(row.class.to_owned(), is_new_class),
            once(row.contender.to_owned(), is_new),
            row.quantity.title().to_owned(),
            row.published.map_or_else(|| "-".to_owned(), figure_text),
            row.peer.map_or_else(|| "-".to_owned(), figure_text),
            median,
            range,
            row.num_runs(),
            once(row.coverage(), is_new),
            once(cost(Quantity::TimeMs, row.time_ms), is_new),
            once(cost(Quantity::MemoryMb, row.memory_mb), is_new),
        ]);
    }
    table
}

/// The errors that stand first, for a screen: what they are stands above.
pub fn for_screens(rows: &[Row<'_>]) -> Table {
    let mut table = for_people(rows.iter().filter(|row| row.is_main()));
    "Position error: mean on a known map, without one ATE RMSE after alignment with scale [m]"
        .clone_into(&mut table.title);
    for row in std::iter::once(&mut table.header).chain(&mut table.rows) {
        row.remove(WHAT);
    }
    table
}

/// A figure of others with its origin.
fn figure_text(figure: &Figure) -> String {
    let coverage =
        figure.coverage.map(|share| format!(", {} of the frames", percent(share))).unwrap_or_default();
    format!("{} ({}{coverage})", figure.quantity.text(figure.value), figure.by)
}

/// The table for programs.
pub fn for_programs(rows: &[Row<'_>]) -> Table {
    let header = [
        "class",
        "settings",
        "quantity",
        "published",
        "published_by",
        "published_in",
        "peer",
        "peer_coverage",
        "peer_program",
        "peer_source",
        "median",
        "least",
        "largest",
        "runs",
        "runs_with_value",
        "coverage_median",
        "coverage_least",
        "ms_an_image",
        "memory_mb",
    ];
    let mut table = Table::new("report", "", &header);
    let number = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    for row in rows {
        let key = serde_json::to_value(row.quantity).ok();
        let found = Statistics::of(&row.values());
        let (published, peer) = (row.published, row.peer);
        let text = |figure: Option<&Figure>, text: fn(&Figure) -> &str| {
            figure.map(|f| text(f).to_owned()).unwrap_or_default()
        };
        table.push([
            row.class.to_owned(),
            row.contender.to_owned(),
            key.and_then(|key| key.as_str().map(str::to_owned)).unwrap_or_default(),
            number(published.map(|figure| figure.value)),
            text(published, |figure| &figure.by),
            text(published, |figure| &figure.source),
            number(peer.map(|figure| figure.value)),
            number(peer.and_then(|figure| figure.coverage)),
            text(peer, |figure| &figure.by),
            text(peer, |figure| &figure.source),
            number(found.map(|found| found.median)),
            number(found.map(|found| found.min)),
            number(found.map(|found| found.max)),
            row.runs.len().to_string(),
            row.values().len().to_string(),
            number(row.coverage.map(|coverage| coverage.median)),
            number(row.coverage.map(|coverage| coverage.min)),
            number(row.time_ms),
            number(row.memory_mb),
        ]);
    }
    table
}
