//! The camera's image in half blocks: two pixels in every character.

use std::fmt::Write;

use visloc_core::RgbImage;

/// The image in a number of columns, each pixel the mean of the pixels below it.
pub fn camera_rows(image: &RgbImage, columns: usize, rows: usize) -> Vec<String> {
    let (columns, half_rows) = (columns as u32, 2 * rows as u32);
    if columns > image.width() || half_rows > image.height() || columns == 0 {
        return Vec::new();
    }
    let area = |index: u32, count: u32, size: u32| (index * size / count, (index + 1) * size / count);
    let color =
        |x: u32, y: u32| mean(image, area(x, columns, image.width()), area(y, half_rows, image.height()));
    let row = |row: u32| {
        let mut text = String::new();
        for x in 0..columns {
            let ([r, g, b], [br, bg, bb]) = (color(x, 2 * row), color(x, 2 * row + 1));
            // writing to a string cannot fail
            let _ = write!(text, "\x1b[38;2;{r};{g};{b}m\x1b[48;2;{br};{bg};{bb}m\u{2580}");
        }
        text + "\x1b[0m"
    };
    (0..half_rows / 2).map(row).collect()
}

fn mean(image: &RgbImage, (left, right): (u32, u32), (top, bottom): (u32, u32)) -> [u8; 3] {
    let mut sums = [0_u32; 3];
    for y in top..bottom {
        for x in left..right {
            let rgb = image.get(x, y);
            (0..3).for_each(|i| sums[i] += u32::from(rgb[i]));
        }
    }
    let count = ((right - left) * (bottom - top)).max(1);
    sums.map(|sum| (sum / count) as u8)
}
