//! Raster images on surfaces, prefiltered so that they can be seen from any distance.

use super::Canvas;

/// Most samples along the direction in which a pixel's footprint is longest.
const MAX_TAPS: f32 = 8.0;

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
}

/// Texels hold the square root of linear light (and of the opacity): eight bits suffice, decoding is one product.
#[derive(Debug, Clone)]
struct Level {
    width: i32,
    height: i32,
    texels: Vec<[u8; 4]>,
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
    #[must_use]
    pub fn new(canvas: &Canvas, wrap: Wrap) -> Self {
        let (mut width, mut height) = canvas.size_px();
        assert!(
            wrap == Wrap::Clamp || (width.is_power_of_two() && height.is_power_of_two()),
            "a repeating texture needs sizes that are powers of two, found {width} x {height}"
        );
        let mut linear = canvas.pixels().to_vec();
        let mut levels = vec![Level::encode(width, height, &linear)];
        while width > 1 || height > 1 {
            (width, height, linear) = halve(width, height, &linear);
            levels.push(Level::encode(width, height, &linear));
        }
        Self { levels, wrap }
    }

    /// Whether the texture is one single color.
    pub(crate) fn is_flat(&self) -> bool {
        self.levels.len() == 1
    }

    /// The one color of a flat texture, or the mean of another.
    pub(crate) fn mean(&self) -> [f32; 4] {
        self.levels.last().map_or([0.0; 4], |level| decode(level.texels[0]))
    }

    /// Linear light and opacity at a point, averaged over a footprint: several samples along its longer side, each
    /// from the mip map that fits the shorter one. So a line far away on the floor keeps its sharp edges.
    #[inline]
    pub(crate) fn sample(&self, at: [f32; 2], footprint: &Footprint) -> [f32; 4] {
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
        let texel = (level.width as f32 / width).max(1e-6);
        let taps = (long_texels * texel * 0.9 + 0.5).clamp(1.0, MAX_TAPS) as u32;
        if taps == 1 {
            return level.bilinear(at, self.wrap);
        }
        let step = 1.0 / taps as f32;
        let mut sum = [0.0_f32; 4];
        for tap in 0..taps {
            let s = (tap as f32 + 0.5) * step - 0.5;
            let color = level.bilinear([at[0] + long[0] * s, at[1] + long[1] * s], self.wrap);
            for (total, part) in sum.iter_mut().zip(color) {
                *total += part;
            }
        }
        sum.map(|part| part * step)
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
        let encode = |part: f32| (part.clamp(0.0, 1.0).sqrt() * 255.0 + 0.5) as u8;
        Self {
            width: width as i32,
            height: height as i32,
            texels: linear.iter().map(|p| p.map(encode)).collect(),
        }
    }

    #[inline]
    fn bilinear(&self, at: [f32; 2], wrap: Wrap) -> [f32; 4] {
        let (x, y) = (at[0] * self.width as f32 - 0.5, at[1] * self.height as f32 - 0.5);
        let (x0, y0) = (fast_floor(x), fast_floor(y));
        let (fx, fy) = (x - x0 as f32, y - y0 as f32);
        let (xs, ys) = match wrap {
            Wrap::Clamp => (
                [x0.clamp(0, self.width - 1), (x0 + 1).clamp(0, self.width - 1)],
                [y0.clamp(0, self.height - 1), (y0 + 1).clamp(0, self.height - 1)],
            ),
            Wrap::Repeat => (
                [x0 & (self.width - 1), (x0 + 1) & (self.width - 1)],
                [y0 & (self.height - 1), (y0 + 1) & (self.height - 1)],
            ),
        };
        let (top, bottom) = ((ys[0] * self.width) as usize, (ys[1] * self.width) as usize);
        let (left, right) = (xs[0] as usize, xs[1] as usize);
        let (a, b) = (decode(self.texels[top + left]), decode(self.texels[top + right]));
        let (c, d) = (decode(self.texels[bottom + left]), decode(self.texels[bottom + right]));
        let (wa, wb, wc, wd) = ((1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy);
        std::array::from_fn(|i| a[i] * wa + b[i] * wb + c[i] * wc + d[i] * wd)
    }
}

/// Rounds down. `f32::floor` is a function call on processors without a rounding instruction.
#[inline]
fn fast_floor(value: f32) -> i32 {
    (value + 32_768.0) as i32 - 32_768
}

#[inline]
fn decode(texel: [u8; 4]) -> [f32; 4] {
    let part = texel.map(|byte| f32::from(byte) * (1.0 / 255.0));
    part.map(|part| part * part)
}

/// Half the size by averaging two by two pixels; an odd last row or column joins its neighbor.
fn halve(width: u32, height: u32, pixels: &[[f32; 4]]) -> (u32, u32, Vec<[f32; 4]>) {
    let (half_width, half_height) = ((width / 2).max(1), (height / 2).max(1));
    let at = |x: u32, y: u32| pixels[(y.min(height - 1) * width + x.min(width - 1)) as usize];
    let mut half = Vec::with_capacity((half_width * half_height) as usize);
    for y in 0..half_height {
        for x in 0..half_width {
            let four = [at(2 * x, 2 * y), at(2 * x + 1, 2 * y), at(2 * x, 2 * y + 1), at(2 * x + 1, 2 * y + 1)];
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
