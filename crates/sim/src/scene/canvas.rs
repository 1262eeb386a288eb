//! Painting of textures.

use super::{Color, glyphs};

/// An image to paint on: linear light (red, green, blue) and opacity, rows from top to bottom.
#[derive(Debug, Clone)]
pub struct Canvas {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 4]>,
}

impl Canvas {
    /// A canvas of one opaque color. Sizes of 0 become 1.
    pub fn new(size_px: (u32, u32), color: Color) -> Self {
        let (width, height) = (size_px.0.max(1), size_px.1.max(1));
        Self { width, height, pixels: vec![opaque(color); width as usize * height as usize] }
    }

    /// Width and height, pixels.
    pub fn size_px(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    pub(crate) fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// Paints one pixel; pixels outside are ignored.
    pub fn set(&mut self, x: u32, y: u32, color: Color) {
        self.blend(i64::from(x), i64::from(y), color, 1.0);
    }

    /// Lays a color over one pixel with the given share, 0 to 1; pixels outside are ignored.
    pub fn blend(&mut self, x: i64, y: i64, color: Color, share: f32) {
        if (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y) {
            let pixel = &mut self.pixels[y as usize * self.width as usize + x as usize];
            let over = opaque(color);
            *pixel = std::array::from_fn(|i| pixel[i] + (over[i] - pixel[i]) * share);
        }
    }

    /// Fills the rectangle from `from` to `to`, given as shares (0 to 1) of width and height.
    pub fn rect(&mut self, from: (f32, f32), to: (f32, f32), color: Color) {
        let px = |share: f32, size: u32| (share * size as f32).round() as i64;
        for y in px(from.1, self.height)..px(to.1, self.height) {
            for x in px(from.0, self.width)..px(to.0, self.width) {
                self.blend(x, y, color, 1.0);
            }
        }
    }

    /// Multiplies every pixel by a brightness given by its position, pixels.
    pub fn modulate(&mut self, mut brightness: impl FnMut(u32, u32) -> f32) {
        for (i, pixel) in self.pixels.iter_mut().enumerate() {
            let i = i as u32;
            let factor = brightness(i % self.width, i / self.width).max(0.0);
            for part in &mut pixel[..3] {
                *part *= factor;
            }
        }
    }

    /// Sets the opacity, 0 to 1, of every pixel.
    pub fn set_opacity(&mut self, mut opacity: impl FnMut(u32, u32) -> f32) {
        for (i, pixel) in self.pixels.iter_mut().enumerate() {
            pixel[3] = opacity(i as u32 % self.width, i as u32 / self.width);
        }
    }

    /// Writes a text as large as fits into the middle `share` of width and height. Capital letters and digits.
    pub fn text(&mut self, text: &str, share: f32, color: Color) {
        let letters: Vec<char> = text.chars().collect();
        let columns = glyphs::width(&letters);
        if columns == 0 {
            return;
        }
        let (width, height) = (self.width as f32, self.height as f32);
        let dot = (width * share / columns as f32).min(height * share / glyphs::ROWS as f32);
        let left = (width - dot * columns as f32) / 2.0;
        let top = (height - dot * glyphs::ROWS as f32) / 2.0;
        for y in 0..self.height {
            for x in 0..self.width {
                let ink = glyphs::ink(&letters, (x as f32 + 0.5 - left) / dot, (y as f32 + 0.5 - top) / dot);
                let cover = ((ink - 0.42) * dot * 0.8 + 0.5).clamp(0.0, 1.0);
                if cover > 0.0 {
                    self.blend(i64::from(x), i64::from(y), color, cover);
                }
            }
        }
    }
}

fn opaque(color: Color) -> [f32; 4] {
    let [r, g, b] = color.linear();
    [r, g, b, 1.0]
}
