//! From light to bytes: exposure, vignetting, noise, tone curve.

use std::sync::LazyLock;

use visloc_core::{RgbImage, RngTree, gaussian};

use super::rays::Rays;
use crate::scene::linear_to_srgb;

/// The imaging chip and the lens in front of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Share of the light that is lost in the corners, 0 to 1.
    pub vignetting: f32,
    /// Variance of the photon noise per light, as share of the full scale.
    pub shot_noise: f32,
    /// Standard deviation of the noise in the dark, as share of the full scale.
    pub read_noise: f32,
}

impl Sensor {
    /// A sensor without noise and vignetting, for tests of image analysis.
    pub fn ideal() -> Self {
        Self { vignetting: 0.0, shot_noise: 0.0, read_noise: 0.0 }
    }

    /// The share of light that reaches each pixel.
    pub(super) fn lens_shading(&self, rays: &Rays) -> Vec<f32> {
        let radius2 = |i: usize| rays.x[i] * rays.x[i] + rays.y[i] * rays.y[i];
        let corner2 = radius2(0).max(radius2(rays.x.len() - 1)).max(1e-9);
        (0..rays.x.len()).map(|i| 1.0 - self.vignetting * (radius2(i) / corner2).min(1.0)).collect()
    }

    /// Develops an image. `exposure` is the light of each color that becomes full scale, inverted; the noise depends on the
    /// seed only.
    pub(super) fn develop(
        &self,
        light: &[[f32; 4]],
        shading: &[f32],
        exposure: [f32; 3],
        seed: u64,
        image: &mut RgbImage,
    ) {
        let tone = &*TONE;
        let bytes = image.data_mut().as_chunks_mut::<3>().0;
        if self.shot_noise <= 0.0 && self.read_noise <= 0.0 {
            for ((pixel, color), share) in bytes.iter_mut().zip(light).zip(shading) {
                let gain = exposure.map(|exposure| exposure * share);
                *pixel = [0, 1, 2].map(|i| tone.byte(color[i] * gain[i]));
            }
            return;
        }
        let normals: &[f32; NUM_NORMALS] = &NORMALS;
        let read_variance = self.read_noise * self.read_noise;
        let mut state = seed;
        for ((pixel, color), share) in bytes.iter_mut().zip(light).zip(shading) {
            let gain = exposure.map(|exposure| exposure * share);
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let bits = scramble(state);
            let noisy = |i: usize, bits: u64| {
                let value = color[i] * gain[i];
                let sigma = (self.shot_noise * value + read_variance).sqrt();
                tone.byte(value + sigma * normals[bits as usize % NUM_NORMALS])
            };
            *pixel = [noisy(0, bits), noisy(1, bits >> 16), noisy(2, bits >> 32)];
        }
    }
}

/// Two rounds of multiply and shift: enough for noise that nobody decodes.
#[inline]
fn scramble(state: u64) -> u64 {
    let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

const NUM_NORMALS: usize = 4096;

/// Draws of the standard normal distribution: looking one up costs a tenth of drawing it.
static NORMALS: LazyLock<Box<[f32; NUM_NORMALS]>> = LazyLock::new(|| {
    let mut rng = RngTree::new(0).stream("sensor-noise-table", 0);
    let draws: Vec<f64> = (0..NUM_NORMALS).map(|_| gaussian(&mut rng, 1.0)).collect();
    let mean = draws.iter().sum::<f64>() / NUM_NORMALS as f64;
    let variance = draws.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / NUM_NORMALS as f64;
    Box::new(std::array::from_fn(|i| ((draws[i] - mean) / variance.sqrt()) as f32))
});

/// The tone curve as a table.
struct Tone {
    bytes: [u8; TONE_STEPS],
}

const TONE_STEPS: usize = 4096;

static TONE: LazyLock<Tone> = LazyLock::new(|| Tone {
    bytes: std::array::from_fn(|i| {
        let value = (i as f32 + 0.5) / TONE_STEPS as f32;
        (linear_to_srgb(value) * 255.0 + 0.5) as u8
    }),
});

impl Tone {
    /// The byte of a light value, 0 to 1; cut off outside.
    #[inline]
    fn byte(&self, value: f32) -> u8 {
        self.bytes[((value * TONE_STEPS as f32) as i32).clamp(0, TONE_STEPS as i32 - 1) as usize]
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::geom::Camera;

    use super::*;

    fn develop(sensor: &Sensor, value: f32, seed: u64) -> Vec<u8> {
        let camera = Camera::pinhole((64, 48), (60.0, 60.0), (31.5, 23.5)).unwrap();
        let shading = sensor.lens_shading(&Rays::new(&camera));
        let mut image = RgbImage::new(64, 48);
        sensor.develop(&vec![[value; 4]; 64 * 48], &shading, [1.0; 3], seed, &mut image);
        image.into_raw()
    }

    #[test]
    fn noise_has_the_configured_strength_and_follows_the_seed() {
        let sensor = Sensor { vignetting: 0.0, shot_noise: 0.001, read_noise: 0.003 };
        let bytes = develop(&sensor, 0.2, 7);
        let mean = bytes.iter().map(|b| f64::from(*b)).sum::<f64>() / bytes.len() as f64;
        let variance = bytes.iter().map(|b| (f64::from(*b) - mean).powi(2)).sum::<f64>() / bytes.len() as f64;
        // 0.2 is byte 124; there the curve rises 255 * 1.1 bytes per full scale
        assert!((mean - 124.0).abs() < 1.0, "mean {mean}");
        let expected = (0.001_f64 * 0.2 + 0.003_f64.powi(2)).sqrt() * 255.0 * 1.13;
        assert!((variance.sqrt() / expected - 1.0).abs() < 0.1, "{} against {expected}", variance.sqrt());
        assert_eq!(bytes, develop(&sensor, 0.2, 7));
        assert_ne!(bytes, develop(&sensor, 0.2, 8));
    }

    #[test]
    fn vignetting_darkens_the_corners_only() {
        let sensor = Sensor { vignetting: 0.4, ..Sensor::ideal() };
        let bytes = develop(&sensor, 0.5, 0);
        let middle = bytes[(24 * 64 + 32) * 3];
        // The pixel nearest to the axis is half a pixel beside it.
        assert!(middle.abs_diff(develop(&Sensor::ideal(), 0.5, 0)[0]) <= 1);
        assert!(bytes[0] < middle - 30);
    }
}
