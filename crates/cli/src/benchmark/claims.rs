//! What is claimed, and the figures of others.

use anyhow::{Context, Result};
use serde::Deserialize;

use super::quantities::Quantity;

const TEXT: &str = include_str!("claims.toml");

/// The file of claims; see its head.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claims {
    /// Settings.
    pub contenders: Vec<Contender>,
    /// Recordings of one kind, in the order of the report.
    pub classes: Vec<Class>,
    /// Figures of others.
    pub figures: Vec<Figure>,
}

/// Whether a robot knows its map, or a camera has none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// `visloc localize`.
    Map,
    /// `visloc slam`.
    Slam,
}

impl Kind {
    /// The command that does the run.
    pub fn command(self) -> &'static str {
        match self {
            Self::Map => "localize",
            Self::Slam => "slam",
        }
    }
}

/// Settings that are claimed.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contender {
    /// In tables.
    pub name: String,
    /// What it runs on.
    pub kind: Kind,
    /// Options of the command.
    pub words: Vec<String>,
    /// Runs on each recording.
    pub seeds: u64,
    /// Whether a quick benchmark runs it.
    pub quick: bool,
}

/// Recordings of one kind.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Class {
    /// In tables.
    pub name: String,
    /// What runs on them.
    pub kind: Kind,
    /// Their names or those of their sequences.
    pub recordings: Vec<String>,
}

/// A figure of others.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// Where it belongs.
    pub classes: Vec<String>,
    /// Settings that it stands beside; all if there are none.
    #[serde(default)]
    pub contenders: Vec<String>,
    /// What it measures.
    pub quantity: Quantity,
    /// Where it comes from.
    pub from: From,
    /// In the quantity's unit.
    pub value: f64,
    /// Share of the images with a pose, where it is known.
    pub coverage: Option<f64>,
    /// Algorithm or program.
    pub by: String,
    /// Document and section, or who measured it when.
    pub source: String,
}

/// Where a figure comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum From {
    /// A document, on recordings of its own.
    Published,
    /// Another program on the same recordings.
    Same,
}

impl From {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::Same => "same recording",
        }
    }
}

impl Claims {
    /// The claims that are part of the program.
    pub fn built_in() -> Result<Self> {
        toml::from_str(TEXT).context("claims.toml")
    }

    /// The class of a recording, by its name or that of its sequence.
    pub fn class_of(&self, kind: Kind, name: &str) -> Option<&str> {
        let is_named =
            |class: &&Class| class.kind == kind && class.recordings.iter().any(|known| known == name);
        self.classes.iter().find(is_named).map(|class| class.name.as_str())
    }

    /// The figure that stands beside a row.
    pub fn figure(&self, class: &str, contender: &str, quantity: Quantity, from: From) -> Option<&Figure> {
        self.figures.iter().find(|figure| {
            figure.from == from
                && figure.quantity == quantity
                && figure.classes.iter().any(|name| name == class)
                && (figure.contenders.is_empty() || figure.contenders.iter().any(|name| name == contender))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_stands_beside_a_row() {
        let claims = Claims::built_in().unwrap();
        for figure in &claims.figures {
            for name in &figure.classes {
                let class = claims.classes.iter().find(|class| class.name == *name);
                let kind = class.unwrap_or_else(|| panic!("no class {name:?}")).kind;
                let is_of_both = figure.quantity == Quantity::Coverage || figure.quantity.is_cost();
                let is_of_slam = figure.quantity == Quantity::AteM;
                assert!(is_of_both || is_of_slam == (kind == Kind::Slam), "{name}: {:?}", figure.quantity);
                let is_known =
                    |name: &String| claims.contenders.iter().any(|c| c.name == *name && c.kind == kind);
                assert!(figure.contenders.iter().all(is_known), "{name}: {:?}", figure.contenders);
            }
            assert!(figure.value.is_finite() && !figure.source.is_empty() && !figure.by.is_empty());
        }
        let first = |kind| claims.contenders.iter().find(|contender| contender.kind == kind);
        assert!([Kind::Map, Kind::Slam].into_iter().all(|kind| first(kind).is_some_and(|first| first.quick)));
    }
}
