//! Letters for boards and posters: capitals and digits of five by seven dots.

/// Rows of a letter.
pub(super) const ROWS: usize = 7;
/// Columns of a letter with the gap after it.
const PITCH: usize = 6;

/// Columns of a whole text, without the last gap.
pub(super) fn width(letters: &[char]) -> usize {
    (letters.len() * PITCH).saturating_sub(1)
}

/// How much ink is at a point of the text, in dots from its top-left corner: 0 to 1, smooth between the dots, so that
/// the edge at 0.5 rounds corners and fills diagonals.
pub(super) fn ink(letters: &[char], x: f32, y: f32) -> f32 {
    let (x, y) = (x - 0.5, y - 0.5);
    let (column, row) = (x.floor(), y.floor());
    let (fx, fy) = (x - column, y - row);
    let dot = |dx: f32, dy: f32| {
        let is_inside = column + dx >= 0.0 && row + dy >= 0.0;
        f32::from(u8::from(is_inside && is_set(letters, (column + dx) as usize, (row + dy) as usize)))
    };
    let top = dot(0.0, 0.0) * (1.0 - fx) + dot(1.0, 0.0) * fx;
    let bottom = dot(0.0, 1.0) * (1.0 - fx) + dot(1.0, 1.0) * fx;
    top * (1.0 - fy) + bottom * fy
}

/// Whether the dot at a column and row of the text is painted.
fn is_set(letters: &[char], column: usize, row: usize) -> bool {
    let Some(letter) = letters.get(column / PITCH) else { return false };
    let within = column % PITCH;
    row < ROWS && within < 5 && (rows(*letter)[row] >> (4 - within)) & 1 == 1
}

/// The rows of a letter from top to bottom, the leftmost dot in bit 4. Letters without a drawing are blank.
fn rows(letter: char) -> [u8; ROWS] {
    match letter.to_ascii_uppercase() {
        'A' => [14, 17, 17, 31, 17, 17, 17],
        'B' => [30, 17, 17, 30, 17, 17, 30],
        'C' => [14, 17, 16, 16, 16, 17, 14],
        'D' => [30, 17, 17, 17, 17, 17, 30],
        'E' => [31, 16, 16, 30, 16, 16, 31],
        'F' => [31, 16, 16, 30, 16, 16, 16],
        'G' => [14, 17, 16, 23, 17, 17, 15],
        'H' => [17, 17, 17, 31, 17, 17, 17],
        'I' => [14, 4, 4, 4, 4, 4, 14],
        'J' => [7, 2, 2, 2, 2, 18, 12],
        'K' => [17, 18, 20, 24, 20, 18, 17],
        'L' => [16, 16, 16, 16, 16, 16, 31],
        'M' => [17, 27, 21, 21, 17, 17, 17],
        'N' => [17, 25, 21, 19, 17, 17, 17],
        'O' => [14, 17, 17, 17, 17, 17, 14],
        'P' => [30, 17, 17, 30, 16, 16, 16],
        'Q' => [14, 17, 17, 17, 21, 18, 13],
        'R' => [30, 17, 17, 30, 20, 18, 17],
        'S' => [15, 16, 16, 14, 1, 1, 30],
        'T' => [31, 4, 4, 4, 4, 4, 4],
        'U' => [17, 17, 17, 17, 17, 17, 14],
        'V' => [17, 17, 17, 17, 17, 10, 4],
        'W' => [17, 17, 17, 21, 21, 27, 17],
        'X' => [17, 17, 10, 4, 10, 17, 17],
        'Y' => [17, 17, 10, 4, 4, 4, 4],
        'Z' => [31, 1, 2, 4, 8, 16, 31],
        '0' => [14, 17, 19, 21, 25, 17, 14],
        '1' => [4, 12, 4, 4, 4, 4, 14],
        '2' => [14, 17, 1, 6, 8, 16, 31],
        '3' => [30, 1, 1, 14, 1, 1, 30],
        '4' => [2, 6, 10, 18, 31, 2, 2],
        '5' => [31, 16, 30, 1, 1, 17, 14],
        '6' => [6, 8, 16, 30, 17, 17, 14],
        '7' => [31, 1, 2, 4, 8, 8, 8],
        '8' => [14, 17, 17, 14, 17, 17, 14],
        '9' => [14, 17, 17, 15, 1, 2, 12],
        _ => [0; ROWS],
    }
}
