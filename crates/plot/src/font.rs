//! The font of all pictures and the width of text.

#[cfg(feature = "png")]
use std::sync::Arc;

#[cfg(feature = "png")]
use resvg::usvg::fontdb;

/// First choice, then fonts of similar width for viewers that do not have it.
pub(crate) const FAMILIES: &str = "DejaVu Sans, Verdana, Arial, sans-serif";

#[cfg(feature = "png")]
const FAMILY: &str = "DejaVu Sans";
#[cfg(feature = "png")]
const REGULAR: &[u8] = include_bytes!("../fonts/DejaVuSans-subset.ttf");
#[cfg(feature = "png")]
const BOLD: &[u8] = include_bytes!("../fonts/DejaVuSans-Bold-subset.ttf");

/// Thickness of letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Weight {
    Regular,
    Bold,
}

/// The embedded fonts, also in place of every generic family.
#[cfg(feature = "png")]
pub(crate) fn database() -> Arc<fontdb::Database> {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(REGULAR.to_vec());
    fonts.load_font_data(BOLD.to_vec());
    fonts.set_sans_serif_family(FAMILY);
    fonts.set_serif_family(FAMILY);
    fonts.set_monospace_family(FAMILY);
    Arc::new(fonts)
}

/// Width of `text` set in letters of `size_px`, pixels.
pub(crate) fn width_px(text: &str, size_px: f64, weight: Weight) -> f64 {
    let table = match weight {
        Weight::Regular => &REGULAR_ADVANCES,
        Weight::Bold => &BOLD_ADVANCES,
    };
    let advance = |c: char| {
        let index = (c as usize).checked_sub(0x20);
        index.and_then(|i| table.get(i)).copied().unwrap_or(OTHER_ADVANCE)
    };
    text.chars().map(|c| f64::from(advance(c))).sum::<f64>() * size_px / 1000.0
}

/// Breaks `text` into lines of at most `max_px`: at spaces, and words that are longer than a line where it ends.
pub(crate) fn wrap(text: &str, size_px: f64, weight: Weight, max_px: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let fits = |line: &String| width_px(&format!("{line} {word}"), size_px, weight) <= max_px;
        match lines.last_mut().filter(|line| fits(line)) {
            Some(line) => {
                line.push(' ');
                line.push_str(word);
            }
            None => lines.extend(pieces(word, size_px, weight, max_px)),
        }
    }
    lines
}

/// A word in pieces that fit; a letter is a piece at least.
fn pieces(word: &str, size_px: f64, weight: Weight, max_px: f64) -> Vec<String> {
    let mut pieces = vec![String::new()];
    for letter in word.chars() {
        let begins = pieces.last().is_some_and(|piece| {
            !piece.is_empty() && width_px(&format!("{piece}{letter}"), size_px, weight) > max_px
        });
        if begins {
            pieces.push(String::new());
        }
        if let Some(piece) = pieces.last_mut() {
            piece.push(letter);
        }
    }
    pieces
}

/// Of letters beyond ASCII, thousandths of the size: above the width of most of them.
const OTHER_ADVANCE: u16 = 700;

/// Advance widths of U+0020 to U+007E in DejaVu Sans 2.37, thousandths of the size.
#[rustfmt::skip]
const REGULAR_ADVANCES: [u16; 95] = [
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337, 636, 636, 636, 636, 636, 636, 636,
    636, 636, 636, 337, 337, 838, 838, 838, 531, 1000, 684, 686, 698, 770, 632, 575, 775, 752, 295, 295, 656, 557, 863,
    748, 787, 603, 787, 695, 635, 611, 732, 684, 989, 685, 611, 685, 390, 337, 390, 838, 500, 500, 613, 635, 550, 635,
    615, 352, 635, 634, 278, 278, 579, 278, 974, 634, 612, 635, 635, 411, 521, 392, 634, 592, 818, 592, 592, 525, 636,
    337, 636, 838,
];

/// The same for DejaVu Sans Bold.
#[rustfmt::skip]
const BOLD_ADVANCES: [u16; 95] = [
    348, 456, 521, 838, 696, 1002, 872, 306, 457, 457, 523, 838, 380, 415, 380, 365, 696, 696, 696, 696, 696, 696, 696,
    696, 696, 696, 400, 400, 838, 838, 838, 580, 1000, 774, 762, 734, 830, 683, 683, 821, 837, 372, 372, 775, 637, 995,
    837, 850, 733, 850, 770, 720, 682, 812, 774, 1103, 771, 724, 725, 457, 365, 457, 838, 500, 500, 675, 716, 593, 716,
    678, 435, 716, 712, 343, 343, 665, 343, 1042, 712, 687, 716, 716, 493, 595, 478, 712, 652, 924, 645, 652, 582, 712,
    365, 712, 838,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn width_of_known_letters() {
        assert!((width_px("m m", 10.0, Weight::Regular) - 22.66).abs() < 1e-9);
        assert!(width_px("error", 12.0, Weight::Bold) > width_px("error", 12.0, Weight::Regular));
    }

    #[test]
    fn lines_fit() {
        let lines = wrap("mean error 0.12 m unbreakablyverylongword", 10.0, Weight::Regular, 80.0);
        assert_eq!(lines.concat().replace(' ', ""), "meanerror0.12munbreakablyverylongword");
        assert_eq!(lines[0], "mean error");
        assert!(lines.iter().all(|line| width_px(line, 10.0, Weight::Regular) <= 80.0), "{lines:?}");
        assert_eq!(wrap("mm", 10.0, Weight::Bold, 1.0), ["m", "m"]);
        assert!(wrap("  ", 10.0, Weight::Regular, 80.0).is_empty());
    }
}
