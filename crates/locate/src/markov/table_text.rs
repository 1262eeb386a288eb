//! Tables with one line of numbers for each state.

use super::TableError;

/// The numbers of each state, in order, without the state's own; the first line is a header.
///
/// # Errors
/// If a line has not `count` numbers after the state's or states do not follow each other.
pub(super) fn rows(text: &str, count: usize, what: &str) -> Result<Vec<Vec<f64>>, TableError> {
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for (i, line) in text.lines().enumerate().skip(1) {
        let wrong = |expected: &str| TableError { line: i + 1, expected: expected.to_owned() };
        let numbers: Result<Vec<f64>, _> = line.split(',').map(str::parse).collect();
        let numbers = numbers.map_err(|_| wrong("numbers between commas"))?;
        let [state, values @ ..] = numbers.as_slice() else { return Err(wrong("a state")) };
        if values.len() != count || !values.iter().all(|value| value.is_finite()) {
            return Err(wrong(&format!("a state and {count} {what}")));
        }
        if *state != rows.len() as f64 {
            return Err(wrong(&format!("state {}", rows.len())));
        }
        rows.push(values.to_vec());
    }
    Ok(rows)
}
