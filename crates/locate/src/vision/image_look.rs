//! What an image is like as a whole.

use visloc_core::{RgbImage, hue_saturation_brightness};

use crate::vision::{
    color::{HueRange, luma},
    field::STEP_PX,
    px_in,
};

/// Brightness and color of an image, from a coarse grid of its pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageLook {
    /// Mean brightness, 0 to 255.
    pub brightness: f64,
    /// Mean difference between the largest and the smallest of red, green and blue, 0 to 255; 0 for gray images.
    pub chroma: f64,
    /// Share of the pixels in the color of the carpet, 0 to 1.
    pub carpet_share: f64,
}

impl ImageLook {
    /// Looks at an image; `carpet` is the color of a field's carpet.
    pub fn new(image: &RgbImage, carpet: &HueRange) -> Self {
        let step = px_in(image.width(), STEP_PX) as usize;
        let (mut brightness, mut chroma, mut num_carpet, mut num) = (0, 0, 0_u32, 0_u32);
        for y in (0..image.height()).step_by(step) {
            for x in (0..image.width()).step_by(step) {
                let rgb = image.get(x, y);
                let [r, g, b] = rgb;
                brightness += luma(rgb);
                chroma += u32::from(r.max(g).max(b) - r.min(g).min(b));
                let (hue_deg, saturation, largest) = hue_saturation_brightness(rgb);
                num_carpet += u32::from(carpet.contains(hue_deg, saturation, largest));
                num += 1;
            }
        }
        let mean = |sum: u32| f64::from(sum) / f64::from(num.max(1));
        Self { brightness: mean(brightness), chroma: mean(chroma), carpet_share: mean(num_carpet) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::color::ColorConfig;

    fn look(at: impl Fn(u32) -> [u8; 3]) -> ImageLook {
        let mut image = RgbImage::new(320, 240);
        for y in 0..240 {
            for x in 0..320 {
                image.set(x, y, at(y));
            }
        }
        ImageLook::new(&image, &ColorConfig::default().green)
    }

    #[test]
    fn gray_black_and_carpet() {
        let half_carpet = look(|y| if y < 120 { [100, 100, 100] } else { [60, 118, 68] });
        assert_eq!(half_carpet.carpet_share, 0.5);
        assert!((half_carpet.chroma - 29.0).abs() < 1e-9 && half_carpet.brightness > 80.0);
        let gray = look(|y| [(y % 200) as u8; 3]);
        assert_eq!((gray.chroma, gray.carpet_share), (0.0, 0.0));
        assert_eq!(look(|_| [0; 3]).brightness, 0.0);
        let empty = ImageLook::new(&RgbImage::default(), &ColorConfig::default().green);
        assert_eq!(empty, ImageLook { brightness: 0.0, chroma: 0.0, carpet_share: 0.0 });
    }
}
