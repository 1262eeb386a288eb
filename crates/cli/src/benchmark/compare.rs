//! What has changed since an earlier benchmark, beyond what the seeds differ by.

use std::fmt;

use visloc_core::eval::camera::Statistics;

use super::{Row, quantities::Quantity, store::Cell};

/// Where each side has one seed nothing is known about their spread; this share of the value stands for it.
const ASSUMED_SPREAD: f64 = 0.1;
/// The same for times, which depend on what else the machine does.
const ASSUMED_TIME_SPREAD: f64 = 0.25;

/// A change beyond the spread of the seeds.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Class, recording if it is about one of several, settings, and quantity.
    pub what: String,
    /// What changed.
    pub quantity: Quantity,
    /// Before and now: medians over the seeds, or the mean of these over the recordings of a row.
    pub values: [f64; 2],
    /// How far the seeds differ.
    pub spread: f64,
}

impl Change {
    /// Whether it is for the better.
    pub fn is_better(&self) -> bool {
        (self.values[1] > self.values[0]) == self.quantity.is_better_high()
    }

    fn is_beyond_spread(&self) -> bool {
        (self.values[1] - self.values[0]).abs() > self.spread.max(self.quantity.least_change())
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.is_better() { "better" } else { "worse" };
        let [before, now] = self.values.map(|value| self.quantity.text(value));
        let spread = self.quantity.text(self.spread);
        write!(f, "{word}: {}: {before} -> {now} (seeds differ by {spread})", self.what)
    }
}

/// Changes row by row, and in rows with several recordings also one by one; the worse ones first. Recordings and excerpts that only
/// one side has are left out.
pub fn compare(rows: &[Row<'_>], baseline: &[Cell]) -> Vec<Change> {
    let mut changes: Vec<Change> = rows.iter().flat_map(|row| changes_of(row, baseline)).collect();
    changes.sort_by_key(Change::is_better);
    changes
}

fn changes_of(row: &Row<'_>, baseline: &[Cell]) -> Vec<Change> {
    let names = row.recordings();
    let mut changes: Vec<Change> =
        names.iter().filter_map(|recording| change_of(row, recording, baseline)).collect();
    let num = changes.len() as f64;
    let mean = |value: fn(&Change) -> f64| changes.iter().map(value).sum::<f64>() / num;
    let whole = Change {
        what: format!("{}; {}; {}", row.class, row.contender, row.quantity),
        quantity: row.quantity,
        values: [mean(|change| change.values[0]), mean(|change| change.values[1])],
        spread: mean(|change| change.spread),
    };
    if changes.len() == 1 {
        changes.clear();
    }
    changes.insert(0, whole);
    changes.retain(Change::is_beyond_spread);
    changes
}

/// The change on one recording, however small.
fn change_of(row: &Row<'_>, recording: &str, baseline: &[Cell]) -> Option<Change> {
    let like = &row.runs.iter().find(|cell| cell.key.recording == recording)?.key;
    let is_like = |cell: &&Cell| {
        let key = &cell.key;
        (&key.recording, &key.contender, key.is_timed) == (&like.recording, &like.contender, like.is_timed)
            && excerpt(&key.words) == excerpt(&like.words)
    };
    let before = baseline.iter().filter(is_like).filter_map(|cell| cell.figures.get(&row.quantity).copied());
    let (before, now) = (before.collect::<Vec<_>>(), row.values_on(recording));
    let is_spread_known = before.len() > 1 || now.len() > 1;
    let (before, now) = (Statistics::of(&before)?, Statistics::of(&now)?);
    let is_time = matches!(row.quantity, Quantity::TimeMs | Quantity::ProgramMs);
    let assumed = before.median.abs() * if is_time { ASSUMED_TIME_SPREAD } else { ASSUMED_SPREAD };
    Some(Change {
        what: format!("{}, {recording}; {}; {}", row.class, row.contender, row.quantity),
        quantity: row.quantity,
        values: [before.median, now.median],
        spread: if is_spread_known { (before.max - before.min).max(now.max - now.min) } else { assumed },
    })
}

/// How many images of the recording were used, as the command says it.
fn excerpt(words: &[String]) -> Option<&String> {
    let option = words.iter().position(|word| word == "--frames" || word == "--end")?;
    words.get(option + 1)
}
