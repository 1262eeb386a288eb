//! Numbers as they are typed, each within the range in which it makes sense.

/// A number within limits; not-a-number never is.
pub(super) fn number_in(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let number: Option<f64> = text.trim().parse().ok();
    number
        .filter(|number| (least..=most).contains(number))
        .ok_or_else(|| format!("expected a number from {least} to {most}"))
}

/// Degrees, once around in both directions.
pub(super) fn degrees(text: &str) -> Result<f64, String> {
    number_in(text, -180.0, 180.0)
}

/// A time from the start, seconds.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    number_in(text, 0.0, 1e6)
}

/// Side of a square or tag of a board, meters.
pub(super) fn board_side(text: &str) -> Result<f64, String> {
    number_in(text, 0.0001, 10.0)
}
