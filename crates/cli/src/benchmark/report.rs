//! The report: Markdown, CSV and HTML with pictures.

use std::{fmt::Write as _, path::Path};

use anyhow::{Context, Result};
use visloc_core::files;
use visloc_plot::escaped;

use super::{
    Claims, Row, Store,
    claims::Figure,
    compare::{Change, compare},
    pictures::{errors, way},
    table::{for_people, for_programs, for_screens, recording_by_recording},
};

/// What was done, beside the rows.
pub struct Account {
    /// What ran: program, runs, limits, machine.
    pub facts: Vec<String>,
    /// What looked like a recording and was not used.
    pub unused: Vec<String>,
    /// Runs that did not work: the command and the reason.
    pub failures: Vec<(String, String)>,
    /// The earlier benchmark, and what has changed since.
    pub changes: Option<(String, Vec<Change>)>,
}

impl Account {
    /// Lists below the table: titles and lines.
    pub fn lists(&self, rows: &[Row<'_>]) -> Vec<(String, Vec<String>)> {
        let mut lists = vec![("Recording by recording".to_owned(), recording_by_recording(rows))];
        if let Some((place, changes)) = &self.changes {
            let none =
                changes.is_empty().then(|| "nothing changed beyond the spread of the seeds".to_owned());
            let lines = none.into_iter().chain(changes.iter().map(ToString::to_string));
            lists.push((format!("Since {place}"), lines.collect()));
        }
        let failures = self.failures.iter().map(|(command, reason)| format!("visloc {command}: {reason}"));
        lists.push(("Runs that did not work".to_owned(), failures.collect()));
        lists.push(("Found, but not used".to_owned(), self.unused.clone()));
        lists.retain(|(_, lines)| !lines.is_empty());
        lists
    }

    /// The same with what readers of a file need.
    fn lists_with_notes(&self, claims: &Claims, rows: &[Row<'_>]) -> Vec<(String, Vec<String>)> {
        let mut sources: Vec<String> = claims.figures.iter().map(source_line).collect();
        sources.sort();
        sources.dedup();
        let mut lists = self.lists(rows);
        lists.push(("How to read it".to_owned(), NOTES.map(str::to_owned).to_vec()));
        lists.push(("Where the figures of others are from".to_owned(), sources));
        lists
    }
}

const NOTES: [&str; 5] = [
    "Median and range are over all runs of a row: recordings times seeds. \"3 of 5\" runs: the others have no such value; what they \
     lack shows in the share of frames with a pose.",
    "On a known map a place is claimed when the reliability is above 0.6; the share of frames is that of claimed ones. A claim is \
     wrong if it is more than 0.3 m from the truth.",
    "Without a map the estimate is aligned with the truth by rotation, translation and scale. *: fewer than 70 % of the frames have a \
     pose, so the error says little.",
    "Times and memory: the program itself, nothing else of the benchmark running, the first images of one recording of the class. \
     \"An image\" is tracking, or localization with image analysis; it holds while the machine has nothing else to do. The processor \
     time of the program has reading and decoding in it, and holds on a busy machine as well.",
    "Published figures are of the documents' own recordings; other programs ran on the same recordings with the default seed of the \
     scene, in whole.",
];

fn source_line(figure: &Figure) -> String {
    format!("{}, {}: {}", figure.by, figure.from.word(), figure.source)
}

/// Writes `report.md`, `report.csv` and `report.html`.
pub fn save(folder: &Path, claims: &Claims, rows: &[Row<'_>], account: &Account) -> Result<()> {
    let texts = [
        ("report.csv", for_programs(rows).csv()),
        ("report.md", markdown(claims, rows, account)),
        ("report.html", html(claims, rows, account)),
    ];
    texts.into_iter().try_for_each(|(name, text)| {
        let path = folder.join(name);
        files::write(&path, text).with_context(|| format!("{}: cannot write it", path.display()))
    })
}

/// The report of a folder with results as they are, compared with those of an earlier benchmark.
pub fn report_again(folder: &Path, baseline: &Path) -> Result<()> {
    let (claims, cells) = (Claims::built_in()?, Store::new(folder).all()?);
    let rows = Row::all(&claims, &cells);
    let changes = compare(&rows, &Store::new(baseline).all()?);
    let account = Account {
        facts: Vec::new(),
        unused: Vec::new(),
        failures: Vec::new(),
        changes: Some((baseline.display().to_string(), changes)),
    };
    save(folder, &claims, &rows, &account)
}

fn markdown(claims: &Claims, rows: &[Row<'_>], account: &Account) -> String {
    let glance = for_screens(rows);
    let mut text = format!(
        "# visloc benchmark\n\n{}\n\n## {}\n\n{}",
        account.facts.join("\n\n"),
        glance.title,
        glance.markdown()
    );
    for (title, lines) in account.lists_with_notes(claims, rows) {
        let _ = write!(text, "\n## {title}\n\n");
        lines.iter().for_each(|line| {
            let _ = writeln!(text, "* {}", line.replace('*', "\\*"));
        });
    }
    let all = for_people(rows);
    text + &format!("\n## {}\n\n{}", all.title, all.markdown())
}

const STYLE: &str = "body{font:14px/1.45 system-ui,sans-serif;margin:2em auto;max-width:1500px;padding:0 1em;color:#1b1b1b}\
    table{border-collapse:collapse;font-size:12.5px}th,td{text-align:left;padding:3px 8px;border-bottom:1px solid #e3e3e3;\
    vertical-align:top}th{position:sticky;top:0;background:#f6f6f6}td:first-child{font-weight:600}\
    td:nth-child(n+6){font-variant-numeric:tabular-nums;white-space:nowrap}.pictures{display:flex;flex-wrap:wrap;gap:1em;align-items:flex-start}\
    .pictures img{width:calc(60% - 0.5em);height:auto}\
    .pictures img+img{width:calc(40% - 0.5em)}li{overflow-wrap:anywhere}";

fn html(claims: &Claims, rows: &[Row<'_>], account: &Account) -> String {
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>visloc benchmark</title><style>{STYLE}</style></head>\
         <body>\n<h1>visloc benchmark</h1>\n"
    );
    account.facts.iter().for_each(|fact| {
        let _ = writeln!(text, "<p>{}</p>", escaped(fact));
    });
    let glance = for_screens(rows);
    let _ = writeln!(text, "<h2>{}</h2>\n{}", escaped(&glance.title), glance.html());
    for (title, lines) in account.lists_with_notes(claims, rows) {
        let lines: String = lines.iter().map(|line| format!("<li>{}</li>\n", escaped(line))).collect();
        let _ = writeln!(text, "<h2>{}</h2>\n<ul>\n{lines}</ul>", escaped(&title));
    }
    text += "<h2>Pictures</h2>\n";
    let mains: Vec<&Row<'_>> = rows.iter().filter(|row| row.is_main()).collect();
    for of_class in mains.chunk_by(|a, b| a.class == b.class) {
        let class = of_class[0].class;
        let way_of = of_class[0].runs.first().and_then(|cell| way(cell));
        let pictures: String =
            [errors(of_class), way_of].into_iter().flatten().map(|p| as_part(p.svg())).collect();
        if !pictures.is_empty() {
            let _ = writeln!(text, "<h3>{}</h3>\n<div class=\"pictures\">{pictures}</div>", escaped(class));
        }
    }
    let all = for_people(rows);
    text + &format!("<h2>{}</h2>\n{}</body></html>\n", escaped(&all.title), all.html())
}

/// A picture within a page; as an image of its own, since several pictures give the same names to their parts.
fn as_part(svg: &str) -> String {
    format!("<img alt=\"\" src=\"data:image/svg+xml;base64,{}\">", visloc_plot::base64(svg.as_bytes()))
}
