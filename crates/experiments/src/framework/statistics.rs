//! Numbers that describe many values, and how they are written.

pub(crate) use visloc_core::mean;

/// Smallest of the sorted values that at least this share of them, 0 to 1, does not exceed.
pub(crate) fn quantile<T: Copy>(sorted: &[T], share: f64) -> Option<T> {
    let rank = ((sorted.len() as f64 * share).ceil() as usize).max(1);
    sorted.get(rank - 1).copied()
}

/// From the smallest to the largest.
pub(crate) fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Part of a whole; `None` of nothing.
pub(crate) fn ratio(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// A share as percent; `-` for what is not there.
pub(crate) fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| "-".to_owned(), |share| format!("{:.1} %", 100.0 * share))
}

/// With so many decimals; `-` for what is not there or not finite.
pub(crate) fn number(value: Option<f64>, decimals: usize) -> String {
    match value.filter(|value| value.is_finite()) {
        None => "-".to_owned(),
        Some(value) if value.abs() >= 1e4 => format!("{value:.0e}"),
        Some(value) => format!("{value:.decimals$}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let values: Vec<u32> = (1..=10).collect();
        assert_eq!((quantile(&values, 0.5), quantile(&values, 0.9)), (Some(5), Some(9)));
        assert_eq!((quantile(&[7], 0.5), quantile::<u32>(&[], 0.5)), (Some(7), None));
        assert_eq!((mean(&[1.0, 2.0]), mean(&[])), (Some(1.5), None));
        assert_eq!((number(Some(0.5), 2), number(Some(f64::NAN), 2)), ("0.50".to_owned(), "-".to_owned()));
    }
}
