//! `visloc sources`: what frames can come from.

use anyhow::{Context, Result};
use serde::Serialize;
use visloc_io::sources::{KINDS, SourceKind, SourceOptions};

use crate::{args::SourcesArgs, say};

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct KindReport {
    name: &'static str,
    schemes: &'static [&'static str],
    form: &'static str,
    example: &'static str,
    summary: &'static str,
    live: bool,
    usable: bool,
    problem: Option<String>,
}

/// Runs the command.
pub fn execute(args: &SourcesArgs) -> Result<()> {
    let options = SourceOptions { ffmpeg: Some(args.ffmpeg.to_path_buf()), ..SourceOptions::default() };
    let kinds: Vec<KindReport> = KINDS.iter().map(|kind| report(kind, &options)).collect();
    if args.json {
        say::line!("{}", serde_json::to_string_pretty(&kinds).context("cannot write JSON")?);
        return Ok(());
    }
    let width = kinds.iter().map(|kind| kind.form.len()).max().unwrap_or(0);
    for kind in &kinds {
        let live = if kind.live { ", live" } else { "" };
        say::line!("{:<width$} {}{live}", kind.form, kind.name);
        say::line!("{:<width$} {}", "", kind.summary);
        say::line!("{:<width$} for instance: {}", "", kind.example);
        if let Some(problem) = &kind.problem {
            say::line!("{:<width$} not usable here: {problem}", "");
        }
    }
    Ok(())
}

fn report(kind: &SourceKind, options: &SourceOptions) -> KindReport {
    let SourceKind { name, schemes, form, example, summary, is_live, problem, .. } = *kind;
    let problem = problem(options);
    KindReport { name, schemes, form, example, summary, live: is_live, usable: problem.is_none(), problem }
}
