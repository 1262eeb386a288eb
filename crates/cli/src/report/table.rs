//! Tables for people.

use visloc_core::eval::{ErrorSummary, KidnapRecovery};

use super::EvaluationReport;

/// One column of a comparison.
pub struct Column<'a> {
    /// At its head.
    pub title: &'a str,
    /// Its numbers.
    pub report: &'a EvaluationReport,
}

/// All numbers of one or more reports below each other.
pub fn comparison_table(columns: &[Column<'_>]) -> String {
    let row = |label: &str, value: &dyn Fn(&EvaluationReport) -> String| -> Vec<String> {
        let values = columns.iter().map(|column| value(column.report));
        std::iter::once(label.to_owned()).chain(values).collect()
    };
    let pair = |[first, second]: [Option<f64>; 2], unit: &str, decimals: usize| {
        format!("{} / {}", measure(first, "", decimals), measure(second, unit, decimals))
    };
    let usual = |errors: Option<ErrorSummary>| errors.map_or([None; 2], |e| [e.mean, e.median]);
    let worst = |errors: Option<ErrorSummary>| errors.map_or([None; 2], |e| [e.p95, e.max]);
    let titles = columns.iter().map(|column| column.title.to_owned());
    let mut rows: Vec<Vec<String>> = vec![std::iter::once(String::new()).chain(titles).collect()];
    rows.push(row("position error, mean / median", &|r| pair(usual(r.position_error_m), " m", 2)));
    rows.push(row("position error, 95 % / max", &|r| pair(worst(r.position_error_m), " m", 2)));
    rows.push(row("heading error, mean / median", &|r| pair(usual(r.heading_error_deg), " deg", 1)));
    rows.push(row("heading error, 95 % / max", &|r| pair(worst(r.heading_error_deg), " deg", 1)));
    rows.push(row("says that it is localized", &|r| percent(r.localized_share)));
    rows.push(row("says so first after", &|r| measure(r.time_to_localize_s, " s", 1)));
    rows.push(row("position error while it says so", &|r| {
        measure(r.tracking_position_error_m.and_then(|errors| errors.mean), " m", 2)
    }));
    for (i, time_s) in kidnap_times(columns).into_iter().enumerate() {
        let label = format!("kidnap {} at {time_s:.1} s: found after", i + 1);
        rows.push(row(&label, &|r| recovery(r.kidnaps.as_ref().and_then(|kidnaps| kidnaps.get(i)))));
    }
    if columns.iter().any(|column| column.report.iteration_ms.is_some()) {
        rows.push(row("time per frame, mean / 99 %", &|r| {
            pair(r.iteration_ms.map_or([None; 2], |timing| [timing.mean, timing.p99]), " ms", 2)
        }));
    }
    align(&rows)
}

fn kidnap_times(columns: &[Column<'_>]) -> Vec<f64> {
    let kidnaps = columns.iter().filter_map(|column| column.report.kidnaps.as_ref());
    kidnaps
        .max_by_key(|kidnaps| kidnaps.len())
        .map_or_else(Vec::new, |kidnaps| kidnaps.iter().map(|kidnap| kidnap.time_s).collect())
}

fn recovery(kidnap: Option<&KidnapRecovery>) -> String {
    match kidnap {
        Some(kidnap) if kidnap.recovered => measure(kidnap.recovery_s, " s", 1),
        Some(_) => "not found".to_owned(),
        None => "-".to_owned(),
    }
}

/// A number with its unit, or a dash.
pub fn measure(value: Option<f64>, unit: &str, decimals: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}{unit}"))
}

/// A share as percentage, or a dash.
pub fn percent(share: Option<f64>) -> String {
    measure(share.map(|share| 100.0 * share), " %", 0)
}

/// First column to the left, the others to the right.
fn align(rows: &[Vec<String>]) -> String {
    let num_columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |i: usize| rows.iter().filter_map(|row| row.get(i)).map(|cell| cell.chars().count()).max();
    let widths: Vec<usize> = (0..num_columns).filter_map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate();
        let cells = cells.map(|(i, (cell, width))| match i {
            0 => format!("{cell:<width$}"),
            _ => format!("{cell:>width$}"),
        });
        cells.collect::<Vec<_>>().join("   ").trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_numbers_are_dashes_and_columns_are_aligned() {
        let known = EvaluationReport {
            localized_share: Some(0.876),
            kidnaps: Some(vec![KidnapRecovery {
                time_s: 26.0,
                recovered: true,
                recovery_s: Some(1.25),
                position_error_m: Some(0.1),
            }]),
            ..EvaluationReport::default()
        };
        let unknown = EvaluationReport::default();
        let table = comparison_table(&[
            Column { title: "one", report: &known },
            Column { title: "two", report: &unknown },
        ]);
        let line = |start: &str| table.lines().find(|line| line.starts_with(start)).unwrap().to_owned();
        assert!(line("says that it is localized").contains("88 %"), "{table}");
        assert!(line("kidnap 1 at 26.0 s").contains("1.2 s"), "{table}");
        let ends: Vec<usize> = table.lines().map(|line| line.chars().count()).collect();
        assert!(ends.windows(2).all(|pair| pair[0] == pair[1]), "{table}");
    }
}
