//! Lists of what there is.

use anyhow::{Context, Result};
use serde::Serialize;

use crate::{args::ListArgs, say};

/// One thing of a list.
#[derive(Debug, Serialize)]
pub struct Listed {
    name: &'static str,
    summary: String,
}

impl Listed {
    /// By its name, and in a few words.
    pub fn new(name: &'static str, summary: impl Into<String>) -> Self {
        Self { name, summary: summary.into() }
    }
}

/// Prints a list.
pub fn print_list(all: &[Listed], args: &ListArgs) -> Result<()> {
    if args.json {
        say::line!("{}", serde_json::to_string_pretty(all).context("cannot write JSON")?);
        return Ok(());
    }
    let width = all.iter().map(|one| one.name.len()).max().unwrap_or(0);
    all.iter().for_each(|Listed { name, summary }| say::line!("{name:<width$}  {summary}"));
    Ok(())
}
