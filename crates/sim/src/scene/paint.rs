//! Named procedural textures.

use rand::RngExt as _;
use serde::Deserialize;
use visloc_core::Rng;

use super::{Canvas, Color, noise::NoiseTile};

/// The patterns that a surface can be painted with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pattern {
    /// One color.
    Flat,
    /// A painted wall: nearly even, with a dark strip along the lower edge.
    Wall,
    /// Blotchy concrete.
    Concrete,
    /// Wood with its grain along the width.
    Wood,
    /// Squares of two colors.
    Checker,
    /// A picture of random shapes in a frame of the second color.
    Poster,
    /// Shelves full of books; the color is that of the wood.
    Books,
    /// A carton with tape and label.
    Carton,
    /// Fronts of three drawers.
    Drawers,
    /// The text in the second color on an even ground.
    Board,
    /// A door with frame and handle.
    Door,
    /// Strong noise of many scales: a surface full of features.
    Noise,
}

visloc_core::with_defaults! {
    /// How a surface is painted.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct Paint {
        /// The pattern.
        pub pattern: Pattern = Pattern::Flat,
        /// Main color.
        pub color: Color = Color::from_hex(0xdc_dad2),
        /// Second color, where the pattern has one.
        pub second_color: Color = Color::from_hex(0x30_3236),
        /// Side of a checker's square, meters.
        pub pitch_m: f32 = 0.2,
        /// What is written on a board.
        pub text: String = String::new(),
    }
}

impl Paint {
    /// An even color.
    pub fn flat(color: Color) -> Self {
        Self { color, ..Self::default() }
    }

    /// A pattern in one color.
    pub fn of(pattern: Pattern, color: Color) -> Self {
        Self { pattern, color, ..Self::default() }
    }

    /// Paints a surface of the given width and height in meters. Flat paint needs one pixel only.
    pub fn canvas(&self, size_m: (f32, f32), px_per_m: f32, rng: &mut Rng) -> Canvas {
        if self.pattern == Pattern::Flat {
            return Canvas::new((1, 1), self.color);
        }
        let px = |length_m: f32| (length_m * px_per_m).round().clamp(8.0, 2048.0) as u32;
        let mut canvas = Canvas::new((px(size_m.0), px(size_m.1)), self.color);
        match self.pattern {
            Pattern::Flat => {}
            Pattern::Wall => self.wall(&mut canvas, size_m.1, rng),
            Pattern::Concrete => blotches(&mut canvas, (0.16, 0.10), rng),
            Pattern::Wood => wood(&mut canvas, rng),
            Pattern::Checker => self.checker(&mut canvas, px_per_m),
            Pattern::Poster => self.poster(&mut canvas, rng),
            Pattern::Books => books(&mut canvas, size_m, rng),
            Pattern::Carton => carton(&mut canvas, rng),
            Pattern::Drawers => drawers(&mut canvas),
            Pattern::Board => {
                canvas.text(&self.text, 0.8, self.second_color);
                blotches(&mut canvas, (0.02, 0.03), rng);
            }
            Pattern::Door => self.door(&mut canvas, rng),
            Pattern::Noise => blotches(&mut canvas, (0.9, 0.9), rng),
        }
        canvas
    }

    fn wall(&self, canvas: &mut Canvas, height_m: f32, rng: &mut Rng) {
        blotches(canvas, (0.035, 0.03), rng);
        canvas.rect((0.0, 1.0 - 0.09 / height_m.max(0.1)), (1.0, 1.0), self.second_color);
    }

    fn checker(&self, canvas: &mut Canvas, px_per_m: f32) {
        let side_px = (self.pitch_m * px_per_m).max(1.0);
        let (width, height) = canvas.size_px();
        let square = |px: u32| (px as f32 / side_px) as u32;
        for y in 0..height {
            for x in (0..width).filter(|x| (square(*x) + square(y)) % 2 == 1) {
                canvas.set(x, y, self.second_color);
            }
        }
    }

    fn poster(&self, canvas: &mut Canvas, rng: &mut Rng) {
        for _ in 0..9 {
            let color = random_color(rng);
            let (x, y) = (rng.random_range(0.05..0.75), rng.random_range(0.05..0.75));
            let (w, h) = (rng.random_range(0.06..0.4), rng.random_range(0.05..0.3));
            canvas.rect((x, y), ((x + w).min(0.95), (y + h).min(0.95)), color);
        }
        for line in 0..rng.random_range(2..6_u8) {
            let y = 0.3 + 0.1 * f32::from(line);
            canvas.rect((0.15, y), (rng.random_range(0.4..0.85), y + 0.03), self.second_color);
        }
        frame(canvas, 0.04, self.second_color);
    }

    fn door(&self, canvas: &mut Canvas, rng: &mut Rng) {
        blotches(canvas, (0.03, 0.03), rng);
        frame(canvas, 0.03, self.color.scaled(0.55));
        canvas.rect((0.84, 0.5), (0.95, 0.515), Color::from_hex(0xcd_cdc8));
    }
}

/// A border around a canvas, given as share of its width.
fn frame(canvas: &mut Canvas, share: f32, color: Color) {
    let (width, height) = canvas.size_px();
    let vertical = share * width as f32 / height as f32;
    canvas.rect((0.0, 0.0), (1.0, vertical), color);
    canvas.rect((0.0, 1.0 - vertical), (1.0, 1.0), color);
    canvas.rect((0.0, 0.0), (share, 1.0), color);
    canvas.rect((1.0 - share, 0.0), (1.0, 1.0), color);
}

/// Brightness noise: strengths of large blotches and of grain.
fn blotches(canvas: &mut Canvas, (large, grain): (f32, f32), rng: &mut Rng) {
    let blotch = NoiseTile::new(4, 5, 0.6, rng);
    let fine = NoiseTile::new(64, 3, 0.9, rng);
    canvas.modulate(|x, y| 1.0 + 2.2 * large * blotch.at(x, y) + 2.0 * grain * fine.at(x, y));
}

fn wood(canvas: &mut Canvas, rng: &mut Rng) {
    let grain = NoiseTile::new(16, 4, 0.7, rng);
    canvas.modulate(|x, y| 1.0 + 0.35 * grain.at_scale(x, y * 6, 6.0));
}

fn books(canvas: &mut Canvas, size_m: (f32, f32), rng: &mut Rng) {
    let shelves = (size_m.1 / 0.36).round().max(1.0) as u32;
    let dark = Color::from_hex(0x24_1c16);
    let pitch = 1.0 / shelves as f32;
    for shelf in 0..shelves {
        let floor = (shelf + 1) as f32 * pitch - 0.04 * pitch;
        canvas.rect((0.03, floor - 0.9 * pitch), (0.97, floor), dark);
        let mut x = 0.04;
        let end = rng.random_range(0.6..0.96);
        while x < end {
            let width = rng.random_range(0.02..0.06) / size_m.0;
            let height = rng.random_range(0.5..0.85) * pitch;
            canvas.rect((x, floor - height), ((x + width).min(0.96), floor), random_color(rng).scaled(0.8));
            x += width + 0.002;
        }
    }
}

fn carton(canvas: &mut Canvas, rng: &mut Rng) {
    blotches(canvas, (0.05, 0.04), rng);
    canvas.rect((0.0, 0.44), (1.0, 0.53), Color::from_hex(0xb8_8d58));
    canvas.rect((0.56, 0.12), (0.88, 0.36), Color::from_hex(0xe4_e2dc));
    for row in 0..3_u8 {
        let y = 0.16 + 0.06 * f32::from(row);
        canvas.rect((0.6, y), (rng.random_range(0.7..0.85), y + 0.025), Color::from_hex(0x30_3030));
    }
    canvas.rect((0.1, 0.68), (0.34, 0.88), Color::from_hex(0x80_5c38));
}

fn drawers(canvas: &mut Canvas) {
    let dark = Color::from_hex(0x28_2a2e);
    for drawer in 0..3_u8 {
        let top = 0.03 + 0.32 * f32::from(drawer);
        canvas.rect((0.0, top + 0.30), (1.0, top + 0.32), dark);
        canvas.rect((0.35, top + 0.06), (0.65, top + 0.09), dark);
    }
}

fn random_color(rng: &mut Rng) -> Color {
    const COLORS: [u32; 12] = [
        0xc0_2828, 0x1f_4fb0, 0xd9_c21a, 0x2a_8a3a, 0xe6_e6e4, 0x20_222a, 0xe8_641c, 0x6a_3a8a, 0x40_9a9a,
        0x8a_5a30, 0xd0_7090, 0x70_7880,
    ];
    Color::from_hex(COLORS[rng.random_range(0..COLORS.len())])
}

#[cfg(test)]
mod tests {
    use visloc_core::RngTree;

    use super::*;

    #[test]
    fn every_pattern_paints_the_asked_size_without_losing_light() {
        use Pattern::*;
        for pattern in [Wall, Concrete, Wood, Checker, Poster, Books, Carton, Drawers, Board, Door, Noise] {
            let paint = Paint { text: "A1".to_owned(), ..Paint::of(pattern, Color::from_hex(0xa0_9080)) };
            let canvas = paint.canvas((1.0, 0.5), 100.0, &mut RngTree::new(1).stream("paint", 0));
            assert_eq!(canvas.size_px(), (100, 50));
            let mean = canvas.pixels().iter().map(|p| p[1]).sum::<f32>() / 5000.0;
            assert!((0.02..0.9).contains(&mean), "{pattern:?}: mean {mean}");
        }
    }

    #[test]
    fn board_shows_its_text() {
        let mut paint = Paint::of(Pattern::Board, Color::from_hex(0xff_ffff));
        let dark = |paint: &Paint| {
            let canvas = paint.canvas((1.0, 0.5), 100.0, &mut RngTree::new(1).stream("paint", 0));
            canvas.pixels().iter().filter(|p| p[1] < 0.3).count()
        };
        assert_eq!(dark(&paint), 0);
        paint.text = "VISLOC".to_owned();
        assert!(dark(&paint) > 200);
    }
}
