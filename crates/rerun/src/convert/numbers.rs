//! All numbers of a moment as a table.

use serde_json::Value;
use visloc_studio::Message;

use super::read::{list, number, numbers, text};
use crate::{Entry, Shape};

const UNKNOWN: &str = "\u{2013}";

/// The table.
pub(super) fn entry(state: &Message) -> Entry {
    let facts: Vec<&Value> = list(state.header.get("facts")).collect();
    let text = if facts.is_empty() { contenders(state) } else { rows(&facts) };
    Entry::now("numbers", Shape::Markdown(text))
}

/// Rows of two texts.
fn rows(facts: &[&Value]) -> String {
    let mut out = "| | |\n|---|---|\n".to_owned();
    for fact in facts {
        let cells: Vec<&str> = list(Some(fact)).filter_map(Value::as_str).collect();
        out += &format!("| {} |\n", cells.join(" | "));
    }
    out
}

/// A column for each algorithm.
fn contenders(state: &Message) -> String {
    let all: Vec<&Value> = list(state.header.get("contenders")).collect();
    let row = |label: &str, cell: &dyn Fn(&Value) -> Option<String>| {
        let cells: Vec<String> =
            all.iter().map(|it| cell(it).unwrap_or_else(|| UNKNOWN.to_owned())).collect();
        format!("| {label} | {} |\n", cells.join(" | "))
    };
    let value = |key: &'static str, digits: usize| {
        move |it: &Value| number(it, key).map(|value| format!("{value:.digits$}"))
    };
    let mut out = row("", &|it| text(it, "name").map(str::to_owned));
    out += &format!("|---|{}\n", "---|".repeat(all.len()));
    out += &row("Place", &|it| {
        let [x, y, yaw] = numbers(it.get("pose"))?;
        Some(format!("{x:.2} m, {y:.2} m, {:.0}\u{b0}", f64::to_degrees(yaw)))
    });
    out += &row("Sigma", &|it| {
        let [x, y, yaw] = numbers(it.get("sigma"))?;
        Some(format!("{x:.3} m, {y:.3} m, {:.1}\u{b0}", f64::to_degrees(yaw)))
    });
    out += &row("Error", &|it| {
        let [meters, degrees] = numbers(it.get("error"))?;
        Some(format!("{meters:.3} m, {degrees:.1}\u{b0}"))
    });
    out += &row("Reliability", &value("reliability", 2));
    out += &row("... up to symmetry", &value("reliability_up_to_symmetry", 2));
    out += &row("Likelihood", &value("likelihood", 3));
    out += &row("Hypotheses", &|it| Some(list(it.get("hypotheses")).count().to_string()));
    out += &row("Individuals", &value("num_individuals", 0));
    out += &row("Image quality", &value("quality", 2));
    out += &row("Pixels kept", &value("num_kept", 0));
    out += &row("Pixels dropped", &value("num_dropped", 0));
    out += &row("Image, pose", &|it| {
        let ms = it.get("ms")?;
        Some(format!("{:.2} ms, {:.2} ms", number(ms, "image")?, number(ms, "pose")?))
    });
    out
}
