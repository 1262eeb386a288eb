//! What an import took and what it passed over.

use std::{collections::BTreeMap, fmt};

use serde::Serialize;

use crate::office::OfficePlan;

/// A plan from another format, and what became of the parts of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Import {
    /// The building.
    pub plan: OfficePlan,
    /// What was passed over, and what was taken for something that it does not say by itself.
    pub notes: Vec<ImportNote>,
}

/// Parts of a file that have the same fate.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct ImportNote {
    /// What they are, in the words of the format: `INSERT of block "DOOR90"`, `<text>`.
    pub what: String,
    /// Their layer, if the format has layers.
    pub layer: Option<String>,
    /// Whether they are in the plan, or were passed over.
    pub is_taken: bool,
    /// As what they were taken, or why they were passed over.
    pub reason: String,
    /// How many there are.
    pub count: usize,
    /// Line of the first one, from 1, if the format has lines.
    pub line: Option<usize>,
}

impl fmt::Display for ImportNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let times = if self.count > 1 { " x" } else { "" };
        write!(f, "{}{times} {}", self.count, self.what)?;
        if let Some(layer) = &self.layer {
            write!(f, " on layer {layer}")?;
        }
        if let Some(line) = self.line {
            let first = if self.count > 1 { "the first " } else { "" };
            write!(f, " ({first}in line {line})")?;
        }
        let fate = if self.is_taken { "taken" } else { "passed over," };
        write!(f, ": {fate} {}", self.reason)
    }
}

/// A part of a file, for notes.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Part {
    pub what: String,
    pub layer: Option<String>,
    pub line: Option<usize>,
}

type Key = (bool, String, Option<String>, String);

/// Counts parts by what they are and what became of them.
#[derive(Debug, Default)]
pub(super) struct Notes(BTreeMap<Key, (usize, Option<usize>)>);

impl Notes {
    pub fn passed_over(&mut self, part: &Part, reason: &str) {
        self.add(false, part, reason);
    }

    pub fn taken(&mut self, part: &Part, reason: &str) {
        self.add(true, part, reason);
    }

    /// Keys of a file, or of a part of it, that have no meaning there.
    pub fn unknown_keys<'a>(&mut self, keys: impl IntoIterator<Item = &'a String>, of: &str) {
        for key in keys {
            let part = Part { what: format!("key {key:?}"), ..Part::default() };
            self.passed_over(&part, &format!("not a part of {of}"));
        }
    }

    fn add(&mut self, is_taken: bool, part: &Part, reason: &str) {
        let key = (is_taken, part.what.clone(), part.layer.clone(), reason.to_owned());
        self.0.entry(key).or_insert((0, part.line)).0 += 1;
    }

    /// All notes, what was passed over first.
    pub fn into_vec(self) -> Vec<ImportNote> {
        let note = |((is_taken, what, layer, reason), (count, line))| ImportNote {
            what,
            layer,
            is_taken,
            reason,
            count,
            line,
        };
        self.0.into_iter().map(note).collect()
    }
}
