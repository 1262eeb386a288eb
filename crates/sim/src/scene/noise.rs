//! Smooth random patterns.

use rand::RngExt as _;
use visloc_core::Rng;

const SIZE: usize = 256;

/// A square of smooth noise that continues over its border; mean 0, about -1 to 1.
pub(crate) struct NoiseTile {
    values: Vec<f32>,
}

impl NoiseTile {
    /// Adds octaves of noise; the coarsest has `coarsest` cells along the tile, each next one twice as many with
    /// `persistence` times the strength. All powers of two up to 256.
    pub(crate) fn new(coarsest: usize, octaves: u32, persistence: f32, rng: &mut Rng) -> Self {
        let mut values = vec![0.0_f32; SIZE * SIZE];
        let (mut strength, mut total) = (1.0_f32, 0.0_f32);
        for octave in 0..octaves {
            let cells = (coarsest << octave).min(SIZE);
            let lattice: Vec<f32> = (0..cells * cells).map(|_| rng.random_range(-1.0..1.0)).collect();
            add_octave(&mut values, &lattice, cells, strength);
            total += strength;
            strength *= persistence;
        }
        for value in &mut values {
            *value /= total;
        }
        Self { values }
    }

    /// The value at a pixel; the tile repeats.
    #[inline]
    pub(crate) fn at(&self, x: u32, y: u32) -> f32 {
        self.values[(y as usize % SIZE) * SIZE + x as usize % SIZE]
    }

    /// The value at a pixel of the tile stretched by a factor.
    #[inline]
    pub(crate) fn at_scale(&self, x: u32, y: u32, factor: f32) -> f32 {
        let (x, y) = (x as f32 / factor, y as f32 / factor);
        let (x0, y0) = (x as u32, y as u32);
        let (fx, fy) = (x - x0 as f32, y - y0 as f32);
        let top = self.at(x0, y0) * (1.0 - fx) + self.at(x0 + 1, y0) * fx;
        let bottom = self.at(x0, y0 + 1) * (1.0 - fx) + self.at(x0 + 1, y0 + 1) * fx;
        top * (1.0 - fy) + bottom * fy
    }
}

fn add_octave(values: &mut [f32], lattice: &[f32], cells: usize, strength: f32) {
    let step = SIZE / cells;
    let ease = |i: usize| {
        let s = (i % step) as f32 / step as f32;
        strength * s * s * (3.0 - 2.0 * s)
    };
    let eases: Vec<f32> = (0..step).map(ease).collect();
    let mut row_values = vec![0.0_f32; cells];
    for y in 0..SIZE {
        let top = &lattice[y / step * cells..][..cells];
        let bottom = &lattice[(y / step + 1) % cells * cells..][..cells];
        let fy = eases[y % step] / strength;
        for (value, (top, bottom)) in row_values.iter_mut().zip(top.iter().zip(bottom)) {
            *value = top + (bottom - top) * fy;
        }
        let row = &mut values[y * SIZE..(y + 1) * SIZE];
        for (left, cell) in row.chunks_exact_mut(step).enumerate() {
            let from = row_values[left];
            let rise = row_values[(left + 1) % cells] - from;
            for (value, ease) in cell.iter_mut().zip(&eases) {
                *value += from * strength + rise * ease;
            }
        }
    }
}
