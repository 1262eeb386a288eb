//! Checks of values, with errors that name the place in the file.

use std::{fmt, ops::RangeInclusive};

use toml::de::{DeTable, DeValue};

use super::load::ScenarioError;

/// Checks values of one scenario.
pub(super) struct Check<'a> {
    pub(super) name: &'a str,
    pub(super) text: &'a str,
}

impl Check<'_> {
    /// An error about a key unless the condition holds.
    pub(super) fn that(
        &self,
        holds: bool,
        key: &str,
        expected: &str,
        found: impl fmt::Display,
    ) -> Result<(), ScenarioError> {
        if holds {
            return Ok(());
        }
        Err(ScenarioError::Value {
            name: self.name.to_owned(),
            line: line_of(self.text, key),
            key: key.to_owned(),
            expected: expected.to_owned(),
            found: found.to_string(),
        })
    }

    /// An error unless the value lies in the range; not-a-number never does.
    pub(super) fn range(
        &self,
        key: &str,
        value: f64,
        range: RangeInclusive<f64>,
    ) -> Result<(), ScenarioError> {
        let expected = format!("a number from {} to {}", range.start(), range.end());
        // Debug writes 1e300 in short.
        let found = if value.abs() < 1e7 { value.to_string() } else { format!("{value:?}") };
        self.that(range.contains(&value), key, &expected, found)
    }
}

/// The line, from 1, on which a key like `motion[2].walk.speed_m_per_s` stands, or its last parent that is written.
fn line_of(text: &str, key: &str) -> Option<usize> {
    let root = DeTable::parse(text).ok()?;
    let mut table = Some(root.get_ref());
    let mut offset = None;
    for part in key.split('.') {
        let (name, index) = match part.split_once('[') {
            Some((name, index)) => (name, index.trim_end_matches(']').parse::<usize>().ok()),
            None => (part, None),
        };
        let Some((found_key, found)) = table.and_then(|t| t.iter().find(|(k, _)| k.get_ref() == name)) else {
            break;
        };
        offset = Some(found_key.span().start);
        let mut value = found.get_ref();
        if let (Some(index), DeValue::Array(items)) = (index, value) {
            let Some(item) = items.get(index) else { break };
            offset = Some(item.span().start);
            value = item.get_ref();
        }
        table = match value {
            DeValue::Table(inner) => Some(inner),
            _ => None,
        };
    }
    Some(text[..offset?].matches('\n').count() + 1)
}
