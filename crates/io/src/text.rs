//! Numbers and times in text files.

use visloc_core::Timestamp;

/// A finite number, or what was expected and found.
pub(crate) fn parse_number(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok();
    number
        .filter(|number| number.is_finite())
        .ok_or_else(|| format!("expected a finite number, found '{text}'"))
}

/// Seconds to nanoseconds without the rounding of a float, where they are written plainly.
pub(crate) fn parse_secs(text: &str) -> Result<Timestamp, String> {
    let secs = parse_number(text)?;
    if secs.abs() > 9e9 {
        return Err(format!("expected a time in seconds, found '{text}'"));
    }
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let is_plain = fraction.len() <= 9 && fraction.bytes().all(|byte| byte.is_ascii_digit());
    let nanos: Option<i64> = format!("{fraction:0<9}").parse().ok();
    match (whole.parse::<i64>(), nanos) {
        (Ok(whole), Some(nanos)) if is_plain => {
            let nanos = if text.starts_with('-') { -nanos } else { nanos };
            Ok(Timestamp::from_nanos(whole * 1_000_000_000 + nanos))
        }
        _ => Ok(Timestamp::from_secs(secs)),
    }
}

/// Whole nanoseconds, as EuRoC writes them.
pub(crate) fn parse_nanos(text: &str) -> Result<Timestamp, String> {
    let nanos: Option<i64> = text.parse().ok();
    nanos
        .map(Timestamp::from_nanos)
        .ok_or_else(|| format!("expected a time in whole nanoseconds, found '{text}'"))
}

/// Lines with data and their numbers, from 1: without comments, empty lines and spaces around.
pub(crate) fn data_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_data = |line: &(usize, &str)| !line.1.is_empty() && !line.1.starts_with('#');
    text.lines().map(str::trim).enumerate().map(|(i, line)| (i + 1, line)).filter(is_data)
}
/// What is wrong with a YAML text, and where, without the lines around it that its parser draws below.
pub(crate) fn yaml_reason(error: &serde_saphyr::Error) -> String {
    let text = error.to_string();
    text.lines().next().unwrap_or_default().trim().trim_start_matches("error: ").to_owned()
}
