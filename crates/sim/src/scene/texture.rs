//! Raster images on surfaces, prefiltered so that they can be seen from any distance.

use super::Canvas;

/// Most samples along the direction in which a pixel's footprint is longest.
const MAX_TAPS: f32 = 6.0;
/// Taps per texel along that direction: each tap already averages over about one and a half texels.
const TAPS_PER_TEXEL: f32 = 0.7;

/// What happens beyond the border of a texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wrap {
    /// The border texel goes on.
    Clamp,
    /// The texture repeats; its sizes must be powers of two.
    Repeat,
}

/// A texture with its mip maps.
#[derive(Debug, Clone)]
pub struct Texture {
    levels: Vec<Level>,
    wrap: Wrap,
    is_flat: bool,
    mean: [f32; 4],
}

/// Texels hold the square root of linear light (and of the opacity): eight bits suffice, decoding is one product. The
/// four parts of a texel stand in the four 16-bit lanes of a word, so that one multiplication weighs all of them.
#[derive(Debug, Clone)]
struct Level {
    width: i32,
    height: i32,
    texels: Vec<u64>,
}

/// How a pixel's square appears in texture coordinates (0 to 1 over the texture): the steps to the next pixel to the
/// right and to the next one below.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Footprint {
    pub(crate) right: [f32; 2],
    pub(crate) down: [f32; 2],
}

impl Texture {
    /// Makes the mip maps of a painted canvas.
    ///
    /// # Panics
    /// If a repeating texture's size is not a power of two.
    pub fn new(canvas: &Canvas, wrap: Wrap) -> Self {
        let (mut width, mut height) = canvas.size_px();
        assert!(
            wrap == Wrap::Clamp || (width.is_power_of_two() && height.is_power_of_two()),
            "a repeating texture needs sizes that are powers of two, found {width} x {height}"
        );
        let is_flat = (width, height) == (1, 1);
        let mut linear = canvas.pixels().to_vec();
        let count = linear.len() as f32;
        let mean = std::array::from_fn(|i| linear.iter().map(|p| p[i]).sum::<f32>() / count);
        if width.min(height) < 2 {
            (width, height, linear) = doubled(width, height, &linear);
        }
        let mut levels = vec![Level::encode(width, height, &linear)];
        // Every level has at least two texels each way to interpolate between.
        while width.min(height) >= 4 {
            (width, height, linear) = halve(width, height, &linear);
            levels.push(Level::encode(width, height, &linear));
        }
        Self { levels, wrap, is_flat, mean }
    }

    /// Whether the texture is one single color.
    pub(crate) fn is_flat(&self) -> bool {
        self.is_flat
    }

    /// The mean of all texels.
    pub(crate) fn mean(&self) -> [f32; 4] {
        self.mean
    }

    /// Linear light and opacity at a point, averaged over a footprint.
    #[cfg(test)]
    fn sample(&self, at: [f32; 2], footprint: &Footprint) -> [f32; 4] {
        self.taps(footprint).sample(at)
    }

    /// How to average over a footprint: several samples along its longer side, each from the mip map that fits the
    /// shorter one. So a line far away on the floor keeps its sharp edges.
    #[inline]
    pub(crate) fn taps(&self, footprint: &Footprint) -> Taps<'_> {
        let base = &self.levels[0];
        let (width, height) = (base.width as f32, base.height as f32);
        let right = [footprint.right[0] * width, footprint.right[1] * height];
        let down = [footprint.down[0] * width, footprint.down[1] * height];
        let right2 = right[0] * right[0] + right[1] * right[1];
        let down2 = down[0] * down[0] + down[1] * down[1];
        let (long, long2) = if right2 > down2 { (footprint.right, right2) } else { (footprint.down, down2) };
        let area = (right[0] * down[1] - right[1] * down[0]).abs();
        let long_texels = long2.sqrt().max(1e-6);
        let short_texels = (area / long_texels).max(long_texels / MAX_TAPS);
        let level = &self.levels[level_for(short_texels).min(self.levels.len() - 1)];
        let texel = level.width as f32 / width;
        let count = (long_texels * texel * TAPS_PER_TEXEL + 0.5).clamp(1.0, MAX_TAPS) as i32;
        let scale = [level.width as f32 * 256.0, level.height as f32 * 256.0];
        let step = [0, 1].map(|axis| (long[axis] * scale[axis] / count as f32) as i32);
        // Half a texel, because texels have their centers in their middle, and half the way of the taps.
        let shift = step.map(|step| -128 - step * (count - 1) / 2);
        Taps { level, wrap: self.wrap, scale, shift, step, count }
    }
}

/// A few samples on a short way across one mip map. Good for all pixels near the one it was made for. Positions are in
/// 1/256 of a texel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Taps<'a> {
    level: &'a Level,
    wrap: Wrap,
    scale: [f32; 2],
    shift: [i32; 2],
    step: [i32; 2],
    count: i32,
}

impl Taps<'_> {
    /// The mean of the samples around a point of the texture.
    #[inline]
    pub(crate) fn sample(&self, at: [f32; 2]) -> [f32; 4] {
        let mut x = (at[0] * self.scale[0]) as i32 + self.shift[0];
        let mut y = (at[1] * self.scale[1]) as i32 + self.shift[1];
        if self.count == 1 {
            return self.level.bilinear((x, y), self.wrap);
        }
        let mut sum = [0.0_f32; 4];
        for _ in 0..self.count {
            let color = self.level.bilinear((x, y), self.wrap);
            sum = [sum[0] + color[0], sum[1] + color[1], sum[2] + color[2], sum[3] + color[3]];
            x += self.step[0];
            y += self.step[1];
        }
        let share = 1.0 / self.count as f32;
        [sum[0] * share, sum[1] * share, sum[2] * share, sum[3] * share]
    }
}

/// The mip level whose texels are about as large as the footprint: log2, rounded to the nearest.
#[inline]
fn level_for(texels: f32) -> usize {
    // The exponent of a float is its log2 rounded down; the factor moves the rounding to the nearest.
    let exponent = ((texels * std::f32::consts::SQRT_2).to_bits() >> 23) as usize;
    exponent.saturating_sub(127).min(31)
}

impl Level {
    fn encode(width: u32, height: u32, linear: &[[f32; 4]]) -> Self {
        let encode = |part: f32| (part.clamp(0.0, 1.0).sqrt() * 255.0 + 0.5) as u64;
        let pack = |p: &[f32; 4]| (0..4).fold(0, |word, i| word | encode(p[i]) << (16 * i));
        Self { width: width as i32, height: height as i32, texels: linear.iter().map(pack).collect() }
    }

    /// At a position in 1/256 of a texel, relative to the center of the first.
    #[inline]
    fn bilinear(&self, (x, y): (i32, i32), wrap: Wrap) -> [f32; 4] {
        let (width, height) = (self.width, self.height);
        let (x, y) = match wrap {
            Wrap::Clamp => (x.clamp(0, (width - 1) * 256 - 1), y.clamp(0, (height - 1) * 256 - 1)),
            Wrap::Repeat => (x & (width * 256 - 1), y & (height * 256 - 1)),
        };
        let (left, fx, fy) = (x >> 8, x & 255, y & 255);
        let (top, mut right, mut bottom) = ((y >> 8) * width, left + 1, ((y >> 8) + 1) * width);
        if wrap == Wrap::Repeat {
            right &= width - 1;
            bottom = if bottom == width * height { 0 } else { bottom };
        }
        let texel = |row: i32, column: i32| self.texels[(row + column) as usize];
        // Weights in 1/256; their sum is 256, so no lane overflows into the next.
        let (fx, fy) = (fx as u64, fy as u64);
        let lower_right = (fx * fy) >> 8;
        let weights = [256 + lower_right - fx - fy, fx - lower_right, fy - lower_right, lower_right];
        decode(
            texel(top, left) * weights[0]
                + texel(top, right) * weights[1]
                + texel(bottom, left) * weights[2]
                + texel(bottom, right) * weights[3],
        )
    }
}

/// Linear parts of a word with lanes of 256 times a byte.
#[inline]
fn decode(word: u64) -> [f32; 4] {
    let part = |i: u32| ((word >> (16 * i)) & 0xffff) as u32 as i32 as f32 * (1.0 / 65_280.0);
    let [r, g, b, opacity] = [part(0), part(1), part(2), part(3)];
    [r * r, g * g, b * b, opacity * opacity]
}

/// Every pixel four times.
fn doubled(width: u32, height: u32, pixels: &[[f32; 4]]) -> (u32, u32, Vec<[f32; 4]>) {
    let pixel = |i: u32| pixels[(i / (2 * width) / 2 * width + i % (2 * width) / 2) as usize];
    (2 * width, 2 * height, (0..4 * width * height).map(pixel).collect())
}

/// Half the size by averaging two by two pixels; an odd last row or column joins its neighbor.
fn halve(width: u32, height: u32, pixels: &[[f32; 4]]) -> (u32, u32, Vec<[f32; 4]>) {
    let (half_width, half_height) = ((width / 2).max(1), (height / 2).max(1));
    let at = |x: u32, y: u32| pixels[(y.min(height - 1) * width + x.min(width - 1)) as usize];
    let mut half = Vec::with_capacity((half_width * half_height) as usize);
    for y in 0..half_height {
        for x in 0..half_width {
            let four =
                [at(2 * x, 2 * y), at(2 * x + 1, 2 * y), at(2 * x, 2 * y + 1), at(2 * x + 1, 2 * y + 1)];
            half.push(std::array::from_fn(|i| four.iter().map(|p| p[i]).sum::<f32>() * 0.25));
        }
    }
    (half_width, half_height, half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Color;

    fn checker() -> Texture {
        let mut canvas = Canvas::new((64, 64), Color::from_hex(0));
        for y in 0..64 {
            for x in 0..64 {
                if (x / 8 + y / 8) % 2 == 0 {
                    canvas.set(x, y, Color::from_hex(0xff_ffff));
                }
            }
        }
        Texture::new(&canvas, Wrap::Repeat)
    }

    fn footprint(texels: f32) -> Footprint {
        Footprint { right: [texels / 64.0, 0.0], down: [0.0, texels / 64.0] }
    }

    #[test]
    fn near_samples_are_sharp_and_far_samples_are_the_mean() {
        let texture = checker();
        assert!(texture.sample([4.0 / 64.0, 4.0 / 64.0], &footprint(0.5))[0] > 0.99);
        assert!(texture.sample([12.0 / 64.0, 4.0 / 64.0], &footprint(0.5))[0] < 0.01);
        assert!((texture.sample([0.3, 0.7], &footprint(64.0))[1] - 0.5).abs() < 0.02);
    }

    #[test]
    fn slanted_footprint_keeps_edges_along_its_long_side() {
        let mut canvas = Canvas::new((64, 64), Color::from_hex(0));
        for y in 0..64 {
            for x in 32..64 {
                canvas.set(x, y, Color::from_hex(0xff_ffff));
            }
        }
        let texture = Texture::new(&canvas, Wrap::Clamp);
        let slanted = Footprint { right: [0.5 / 64.0, 0.0], down: [0.0, 6.0 / 64.0] };
        assert!(texture.sample([30.5 / 64.0, 0.5], &slanted)[0] < 0.01);
        assert!(texture.sample([33.5 / 64.0, 0.5], &slanted)[0] > 0.99);
    }

    #[test]
    fn repeat_continues_and_clamp_holds() {
        let texture = checker();
        let at = |u: f32| texture.sample([u, 4.0 / 64.0], &footprint(0.5))[0];
        assert!((at(4.0 / 64.0) - at(1.0 + 4.0 / 64.0)).abs() < 1e-3);
        assert!((at(12.0 / 64.0) - at(-1.0 + 12.0 / 64.0)).abs() < 1e-3);
    }
}
