//! Numbers as they are typed, each within the range in which it makes sense.

use std::ops::{Bound, RangeBounds};

/// Parser of a number within limits; not-a-number never is.
pub(super) fn within(
    least: f64,
    most: f64,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number: Option<f64> = text.trim().parse().ok();
        number
            .filter(|number| (least..=most).contains(number))
            .ok_or_else(|| format!("expected a number from {least} to {most}"))
    }
}

/// Numbers with commas between them.
pub(super) fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    const MOST: f64 = 1e4;
    let wrong = || format!("expected {N} numbers with commas between them, found {text:?}");
    let parts: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    let numbers: [f64; N] = parts.map_err(|_| wrong())?.try_into().map_err(|_| wrong())?;
    if numbers.iter().all(|number| number.abs() <= MOST) {
        Ok(numbers)
    } else {
        Err(format!("expected numbers from -{MOST} to {MOST}, found {text:?}"))
    }
}

/// Any number but infinity and not-a-number: the range is checked where it is known.
pub(super) fn number(text: &str) -> Result<f64, String> {
    text.trim()
        .parse()
        .ok()
        .filter(|number: &f64| number.is_finite())
        .ok_or_else(|| "expected a number".to_owned())
}

/// Degrees, once around in both directions.
pub(super) fn degrees(text: &str) -> Result<f64, String> {
    within(-180.0, 180.0)(text)
}

/// A time from the start, seconds.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    within(0.0, 1e6)(text)
}

/// Side of a square or tag of a board, meters.
pub(super) fn board_side(text: &str) -> Result<f64, String> {
    within(0.0001, 10.0)(text)
}

/// Parser of a whole number within a range, which may be open.
pub(super) fn whole<T>(
    range: impl RangeBounds<u64>,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: TryFrom<u64>,
{
    let least = match range.start_bound() {
        Bound::Included(least) => *least,
        _ => 0,
    };
    let most = match range.end_bound() {
        Bound::Included(most) => Some(*most),
        Bound::Excluded(above) => Some(above - 1),
        // What the type holds.
        Bound::Unbounded => {
            let all = [u64::from(u8::MAX), u64::from(u16::MAX), u64::from(u32::MAX)];
            all.into_iter().find(|most| T::try_from(most + 1).is_err())
        }
    };
    move |text| {
        let number =
            text.trim().parse().ok().filter(|number| (least..=most.unwrap_or(u64::MAX)).contains(number));
        number.and_then(|number| T::try_from(number).ok()).ok_or_else(|| match most {
            Some(most) => format!("expected a whole number from {least} to {most}"),
            None => format!("expected a whole number from {least} on"),
        })
    }
}
