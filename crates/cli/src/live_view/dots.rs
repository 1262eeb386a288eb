//! A canvas of braille dots: two by four in every character.

use std::fmt::Write;

/// Red, green and blue.
pub type Rgb = [u8; 3];

/// What is drawn later but on a lower layer does not change the color of a character.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Layer {
    /// Nothing yet.
    Empty,
    /// What always stands there.
    Ground,
    /// Particles.
    Cloud,
    /// Answers.
    Estimate,
    /// Where the robot is.
    Truth,
}

#[derive(Debug, Clone, Copy)]
struct Cell {
    mask: u8,
    layer: Layer,
    color: Rgb,
}

/// Dots with a color for each character. The origin is at the top left, y points down.
#[derive(Debug, Clone)]
pub struct DotCanvas {
    columns: usize,
    cells: Vec<Cell>,
}

/// Bits of the dots of a braille character, by column and row. Source: Unicode, block U+2800.
const BITS: [[u8; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

impl DotCanvas {
    /// An empty canvas of so many characters.
    pub fn new(columns: usize, rows: usize) -> Self {
        Self { columns, cells: vec![Cell { mask: 0, layer: Layer::Empty, color: [0; 3] }; columns * rows] }
    }

    /// Sets the dot nearest to a place. Outside of the canvas nothing happens.
    pub fn dot(&mut self, (x, y): (f64, f64), layer: Layer, color: Rgb) {
        if !(x >= 0.0 && y >= 0.0) {
            return;
        }
        let (x, y) = (x as usize, y as usize);
        if x >= 2 * self.columns {
            return;
        }
        let Some(cell) = self.cells.get_mut(y / 4 * self.columns + x / 2) else { return };
        if layer > cell.layer {
            // A lower layer keeps its dots only if they do not blur what is above.
            let keeps_dots = cell.layer == Layer::Ground && layer < Layer::Estimate;
            *cell = Cell { mask: if keeps_dots { cell.mask } else { 0 }, layer, color };
        }
        if layer == cell.layer {
            // One color for each character: the dots of another color must go, or they would change theirs.
            let mask = if color == cell.color { cell.mask } else { 0 };
            *cell = Cell { mask: mask | BITS[x % 2][y % 4], layer, color };
        }
    }

    /// A straight line of dots.
    pub fn line(&mut self, start: (f64, f64), end: (f64, f64), layer: Layer, color: Rgb) {
        let (dx, dy) = (end.0 - start.0, end.1 - start.1);
        let num_steps = dx.abs().max(dy.abs()).ceil().clamp(1.0, 1e4) as u32;
        for i in 0..=num_steps {
            let share = f64::from(i) / f64::from(num_steps);
            self.dot((start.0 + share * dx, start.1 + share * dy), layer, color);
        }
    }

    /// A circle of dots.
    pub fn ring(&mut self, center: (f64, f64), radius: f64, layer: Layer, color: Rgb) {
        let num_dots = (8.0 * radius).ceil().clamp(8.0, 2000.0) as u32;
        for i in 0..num_dots {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(num_dots)).sin_cos();
            self.dot((center.0 + radius * cos, center.1 + radius * sin), layer, color);
        }
    }

    /// The characters of a row on a background, with the codes for their colors.
    pub fn row(&self, row: usize, background: Rgb) -> String {
        let [r, g, b] = background;
        let mut text = format!("\x1b[48;2;{r};{g};{b}m");
        let mut color = None;
        for cell in self.cells.iter().skip(row * self.columns).take(self.columns) {
            if cell.mask != 0 && color != Some(cell.color) {
                color = Some(cell.color);
                let [r, g, b] = cell.color;
                // writing to a string cannot fail
                let _ = write!(text, "\x1b[38;2;{r};{g};{b}m");
            }
            let letter = char::from_u32(0x2800 + u32::from(cell.mask)).unwrap_or(' ');
            text.push(if cell.mask == 0 { ' ' } else { letter });
        }
        text + "\x1b[0m"
    }
}

/// Between `a` (share 0) and `b` (share 1).
pub fn mix(a: Rgb, b: Rgb, share: f64) -> Rgb {
    [0, 1, 2].map(|i| (f64::from(a[i]) + (f64::from(b[i]) - f64::from(a[i])) * share).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_are_where_unicode_has_them() {
        let mut canvas = DotCanvas::new(2, 1);
        canvas.dot((0.0, 0.0), Layer::Ground, [1, 2, 3]);
        canvas.dot((1.9, 3.9), Layer::Ground, [1, 2, 3]);
        canvas.dot((4.0, 0.0), Layer::Ground, [9, 9, 9]);
        canvas.dot((0.0, 4.0), Layer::Ground, [9, 9, 9]);
        canvas.dot((f64::NAN, -1.0), Layer::Ground, [9, 9, 9]);
        assert_eq!(canvas.row(0, [0; 3]), "\x1b[48;2;0;0;0m\x1b[38;2;1;2;3m\u{2881} \x1b[0m");
    }

    #[test]
    fn higher_layers_win() {
        let mut canvas = DotCanvas::new(1, 1);
        canvas.dot((0.0, 0.0), Layer::Truth, [1, 1, 1]);
        canvas.dot((1.0, 0.0), Layer::Ground, [2, 2, 2]);
        assert!(canvas.row(0, [0; 3]).contains("\x1b[38;2;1;1;1m\u{2801}"));
    }
}
