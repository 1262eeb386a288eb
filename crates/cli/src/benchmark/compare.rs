//! What has changed since an earlier benchmark, beyond what the seeds differ by.

use std::fmt;

use visloc_eval::camera::Statistics;

use super::{Row, quantities::Quantity, store::Cell};

/// Where each side has one seed nothing is known about their spread; this share of the value stands for it.
const ASSUMED_SPREAD: f64 = 0.1;
/// The same for times, which depend on what else the machine does.
const ASSUMED_TIME_SPREAD: f64 = 0.25;

/// A change beyond the spread of the seeds.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The row.
    pub class: String,
    /// The settings.
    pub contender: String,
    /// What changed.
    pub quantity: Quantity,
    /// The recording; `None` for the mean over all of the row.
    pub recording: Option<String>,
    /// Medians over the seeds: before and now.
    pub values: (f64, f64),
    /// How far the seeds differ.
    pub spread: f64,
}

impl Change {
    /// Whether it is for the better.
    pub fn is_better(&self) -> bool {
        (self.values.1 > self.values.0) == self.quantity.is_better_high()
    }

    fn is_beyond_spread(&self) -> bool {
        (self.values.1 - self.values.0).abs() > self.spread.max(self.quantity.least_change())
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.is_better() { "better" } else { "worse" };
        let [before, now, spread] =
            [self.values.0, self.values.1, self.spread].map(|value| self.quantity.text(value));
        let recording = self.recording.as_ref().map(|name| format!(", {name}")).unwrap_or_default();
        let Self { class, contender, quantity, .. } = self;
        write!(
            f,
            "{word}: {class}{recording}; {contender}; {quantity}: {before} -> {now} (seeds differ by {spread})"
        )
    }
}

/// Changes row by row, and in rows with several recordings also one by one; the worse ones first. Recordings and excerpts that only
/// one side has are left out.
pub fn compare(rows: &[Row<'_>], baseline: &[Cell]) -> Vec<Change> {
    let mut changes: Vec<Change> = rows.iter().flat_map(|row| changes_of(row, baseline)).collect();
    changes.sort_by_key(Change::is_better);
    changes
}

#[allow(clippy::cast_precision_loss)]
fn changes_of(row: &Row<'_>, baseline: &[Cell]) -> Vec<Change> {
    let mut recordings: Vec<&str> = Vec::new();
    for cell in &row.runs {
        if !recordings.contains(&cell.key.recording.as_str()) {
            recordings.push(&cell.key.recording);
        }
    }
    let each: Vec<Change> =
        recordings.iter().filter_map(|recording| change_of(row, recording, baseline)).collect();
    let mean = |value: fn(&Change) -> f64| each.iter().map(value).sum::<f64>() / each.len() as f64;
    let whole = Change {
        class: row.class.to_owned(),
        contender: row.contender.to_owned(),
        quantity: row.quantity,
        recording: None,
        values: (mean(|change| change.values.0), mean(|change| change.values.1)),
        spread: mean(|change| change.spread),
    };
    let singles = if each.len() > 1 { each } else { Vec::new() };
    std::iter::once(whole).chain(singles).filter(Change::is_beyond_spread).collect()
}

/// The change on one recording, however small.
fn change_of(row: &Row<'_>, recording: &str, baseline: &[Cell]) -> Option<Change> {
    let now: Vec<&Cell> = row.runs.iter().copied().filter(|cell| cell.key.recording == recording).collect();
    let like = &now.first()?.key;
    let before = baseline.iter().filter(|cell| {
        let key = &cell.key;
        (key.recording == recording && key.contender == like.contender && key.is_timed == like.is_timed)
            && excerpt(&key.words) == excerpt(&like.words)
    });
    let statistics = |cells: &mut dyn Iterator<Item = &Cell>| {
        let values: Vec<f64> = cells.filter_map(|cell| cell.figures.get(&row.quantity).copied()).collect();
        Some((Statistics::of(&values)?, values.len()))
    };
    let (before, num_before) = statistics(&mut before.into_iter())?;
    let (now, num_now) = statistics(&mut now.into_iter())?;
    let is_time = matches!(row.quantity, Quantity::TimeMs | Quantity::ProgramMs);
    let assumed = before.median.abs() * if is_time { ASSUMED_TIME_SPREAD } else { ASSUMED_SPREAD };
    let is_known = num_before > 1 || num_now > 1;
    let spread = if is_known { (before.max - before.min).max(now.max - now.min) } else { assumed };
    Some(Change {
        class: row.class.to_owned(),
        contender: row.contender.to_owned(),
        quantity: row.quantity,
        recording: Some(recording.to_owned()),
        values: (before.median, now.median),
        spread,
    })
}

/// How many images of the recording were used, as the command says it.
fn excerpt(words: &[String]) -> Option<&String> {
    let option = words.iter().position(|word| word == "--frames" || word == "--end")?;
    words.get(option + 1)
}
