//! The codes.

use std::sync::LazyLock;

/// Bits along a side of the code.
pub const GRID: usize = 6;
/// How many codes there are.
pub const NUM_CODES: usize = 587;
/// Any two codes differ by at least 11 bits, so up to five wrong ones could be told; with three, noise is hardly ever a tag.
const MAX_WRONG_BITS: u32 = 3;

static CODES: LazyLock<Vec<u64>> = LazyLock::new(|| {
    let lines = include_str!("../../data/tag36h11.txt").lines();
    lines
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| u64::from_str_radix(line, 16).ok())
        .collect()
});

/// The code of a tag: rows of six bits from the top, the upper left one is the highest, 1 is white.
pub fn code_of(id: usize) -> Option<u64> {
    CODES.get(id).copied()
}

/// The tag whose code, turned clockwise by so many quarters, is nearest to the bits; `None` if none is near enough.
pub fn nearest(bits: u64) -> Option<(usize, usize)> {
    let mut turned = bits;
    let mut best: Option<(u32, usize, usize)> = None;
    for quarters in 0..4 {
        for (id, code) in CODES.iter().enumerate() {
            let wrong = (code ^ turned).count_ones();
            if wrong <= MAX_WRONG_BITS && best.is_none_or(|b| wrong < b.0) {
                best = Some((wrong, id, quarters));
            }
        }
        turned = turned_back(turned);
    }
    best.map(|(_, id, quarters)| (id, quarters))
}

/// The bits turned counterclockwise by a quarter.
fn turned_back(bits: u64) -> u64 {
    let bit = |x: usize, y: usize| bits >> (GRID * GRID - 1 - (y * GRID + x)) & 1;
    let places = (0..GRID).flat_map(|y| (0..GRID).map(move |x| (x, y)));
    // What is at (x, y) afterwards was at (GRID - 1 - y, x).
    places.fold(0, |all, (x, y)| all << 1 | bit(GRID - 1 - y, x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_all_there_and_far_from_each_other() {
        assert_eq!(CODES.len(), NUM_CODES);
        for (i, a) in CODES.iter().enumerate() {
            let mut turned = *a;
            for quarters in 0..4 {
                for (j, b) in CODES.iter().enumerate() {
                    assert!(
                        (i == j && quarters == 0) || (turned ^ b).count_ones() >= 10,
                        "{i} {j} {quarters}"
                    );
                }
                turned = turned_back(turned);
            }
            assert_eq!(turned, *a);
        }
    }

    #[test]
    fn wrong_bits_are_forgiven_up_to_a_point() {
        let code = code_of(17).unwrap();
        assert_eq!(nearest(code ^ 0b1001_0000_0100), Some((17, 0)));
        assert_eq!(nearest(turned_back(code)), Some((17, 3)));
        assert_eq!(nearest(0), None);
    }
}
