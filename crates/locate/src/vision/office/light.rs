//! The color of the light, from edges whose two sides are known.
//!
//! What a camera sees of a surface is the surface's color times that of the light, channel by channel (von Kries). Across
//! an edge the light hardly changes, so the quotient of the colors on both sides is that of the surfaces, whatever the
//! light (Funt and Finlayson 1995). An edge whose quotient is that of a door and a wall shows what a wall looks like
//! now. No pose is needed for that, so it holds for a robot that does not know where it is.

use nalgebra::{Point2, Vector2};
use visloc_core::RgbImage;

use super::{EdgeSegment, OfficeColors};

/// Quotients this near to that of two surfaces are taken for it, as a share of it.
const MAX_OFF_SHARE: f64 = 0.3;
/// Surfaces that differ by less than this are not told apart without knowing the light, logarithm.
const MIN_DIFFERENCE: f64 = 0.4;
/// Brighter channels are cut off, darker ones are noise, 0 to 255.
const USABLE: std::ops::RangeInclusive<u8> = 12..=248;
/// Length of all edges that an image needs to say something, pixels.
const MIN_LENGTH_PX: f64 = 40.0;
/// The light is at most so far from white, as a logarithm of the quotient of two channels: a factor of 2.2.
const MAX_TINT: f64 = 0.8;
/// Distance from the edge at which colors are taken, pixels.
const OFFSET_PX: f64 = 3.4;
/// Places along the edge at which colors are taken at most.
const MAX_PLACES: usize = 8;

/// Color without brightness: logarithms of red and of blue over green.
type Chroma = Vector2<f64>;

fn chroma(rgb: [f64; 3]) -> Chroma {
    let [r, g, b] = rgb.map(|value| value.max(1.0).ln());
    Chroma::new(r - g, b - g)
}

/// A running estimate of the light's color.
#[derive(Debug, Clone)]
pub(super) struct LightColor {
    /// Surfaces that lie side by side in a building.
    pairs: Vec<[Chroma; 2]>,
    /// Chroma of the light; that of white is 0.
    tint: Chroma,
    /// Images that went into it.
    num_images: f64,
    /// What red and blue would be in white light.
    red: [u8; 256],
    blue: [u8; 256],
    /// Light and length of each edge of this image.
    samples: Vec<(Chroma, f64)>,
}

impl LightColor {
    /// White light on the surfaces of a building.
    pub fn white(colors: &OfficeColors) -> Self {
        let of = |rgb: [u8; 3]| chroma(rgb.map(f64::from));
        let (wall, floor) = (of(colors.wall), of(colors.floor));
        let mut pairs = vec![[wall, floor]];
        for door in &colors.doors {
            pairs.push([of(*door), wall]);
            pairs.push([of(*door), floor]);
        }
        pairs.retain(|[a, b]| (a - b).norm() >= MIN_DIFFERENCE);
        let same: [u8; 256] = std::array::from_fn(|i| i as u8);
        Self { pairs, tint: Chroma::zeros(), num_images: 0.0, red: same, blue: same, samples: Vec::new() }
    }

    /// Takes in the edges of an image. `follow` is the share of a new image once there were many.
    pub fn update(&mut self, image: &RgbImage, segments: &[EdgeSegment], follow: f64) {
        self.samples.clear();
        for segment in segments {
            let along = segment.direction();
            let right = Vector2::new(-along.y, along.x);
            if let (Some(a), Some(b)) = (mean(image, segment, &right), mean(image, segment, &-right))
                && let Some(tint) = self.tint_of([chroma(a), chroma(b)])
            {
                self.samples.push((tint, segment.length_px()));
            }
        }
        if self.samples.iter().map(|sample| sample.1).sum::<f64>() < MIN_LENGTH_PX {
            return;
        }
        self.num_images += 1.0;
        let seen = Chroma::new(median(&mut self.samples, 0), median(&mut self.samples, 1));
        self.tint += (seen - self.tint) * follow.max(1.0 / self.num_images);
        self.tint = self.tint.map(|part| part.clamp(-MAX_TINT, MAX_TINT));
        for (table, part) in [(&mut self.red, self.tint.x), (&mut self.blue, self.tint.y)] {
            let scale = (-part).exp();
            *table = std::array::from_fn(|i| (i as f64 * scale).round().min(255.0) as u8);
        }
    }

    /// The light that makes an edge's two sides those of two surfaces that lie side by side.
    fn tint_of(&self, sides: [Chroma; 2]) -> Option<Chroma> {
        let seen = sides[0] - sides[1];
        let mut best = (MAX_OFF_SHARE, None);
        for [a, b] in &self.pairs {
            for (surfaces, expected) in [([a, b], a - b), ([b, a], b - a)] {
                let off_share = (seen - expected).norm() / expected.norm();
                if off_share < best.0 {
                    let tint = 0.5 * ((sides[0] - surfaces[0]) + (sides[1] - surfaces[1]));
                    best = (off_share, Some(tint));
                }
            }
        }
        best.1.filter(|tint| tint.amax() < MAX_TINT)
    }

    /// What a color would be in white light.
    #[inline]
    pub fn in_white(&self, [r, g, b]: [u8; 3]) -> [u8; 3] {
        [self.red[usize::from(r)], g, self.blue[usize::from(b)]]
    }

    /// Red, green and blue of the light; green is 1.
    pub fn rgb(&self) -> [f64; 3] {
        [self.tint.x.exp(), 1.0, self.tint.y.exp()]
    }
}

/// Mean color on one side of an edge; `None` where a channel is cut off, dark, or beyond the image.
fn mean(image: &RgbImage, segment: &EdgeSegment, side: &Vector2<f64>) -> Option<[f64; 3]> {
    let num_places = ((segment.length_px() / 2.0) as usize).clamp(2, MAX_PLACES);
    let mut sum = [0.0; 3];
    let mut count = 0.0;
    for place in 0..num_places {
        let t = (place as f64 + 0.5) / num_places as f64;
        let at: Point2<f64> = segment.start + (segment.end - segment.start) * t + side * OFFSET_PX;
        let (x, y) = (at.x.round(), at.y.round());
        if x < 0.0 || y < 0.0 || x >= f64::from(image.width()) || y >= f64::from(image.height()) {
            continue;
        }
        let rgb = image.get(x as u32, y as u32);
        if rgb.iter().all(|value| USABLE.contains(value)) {
            sum = std::array::from_fn(|i| sum[i] + f64::from(rgb[i]));
            count += 1.0;
        }
    }
    (2.0 * count >= num_places as f64).then(|| sum.map(|sum| sum / count))
}

/// Median of one component, weighted.
fn median(samples: &mut [(Chroma, f64)], component: usize) -> f64 {
    samples.sort_by(|a, b| a.0[component].total_cmp(&b.0[component]));
    let half = 0.5 * samples.iter().map(|sample| sample.1).sum::<f64>();
    let mut sum = 0.0;
    let middle = samples.iter().find(|sample| {
        sum += sample.1;
        sum >= half
    });
    middle.map_or(0.0, |sample| sample.0[component])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::office::{GradientDetector, OfficeTable, SurfaceClass};

    const COLORS: ([u8; 3], [u8; 3], [u8; 3]) = ([235, 234, 228], [216, 181, 58], [176, 39, 31]);

    /// A door in a wall over the floor, in light of a color.
    fn image(light: [f64; 3]) -> RgbImage {
        let mut image = RgbImage::new(96, 96);
        for y in 0..96 {
            for x in 0..96 {
                let rgb = match (x, y) {
                    (_, 60..) => COLORS.1,
                    (30..60, _) => COLORS.2,
                    _ => COLORS.0,
                };
                image.set(x, y, std::array::from_fn(|i| (f64::from(rgb[i]) * light[i]).min(255.0) as u8));
            }
        }
        image
    }

    #[test]
    fn surfaces_keep_their_class_in_light_of_any_ordinary_color() {
        let colors = OfficeColors { wall: COLORS.0, floor: COLORS.1, doors: vec![COLORS.2] };
        let table = OfficeTable::new(&colors);
        // Candles, tungsten, shade, and the green of old tubes; dark and bright.
        for light in [[1.0, 0.72, 0.45], [0.5, 0.42, 0.3], [0.6, 0.75, 1.0], [0.45, 0.6, 0.42], [1.0; 3]] {
            let image = image(light);
            let mut segments = Vec::new();
            GradientDetector::default().detect(&image, 0, 9.0, 7.0, &mut segments);
            let mut seen = LightColor::white(&colors);
            seen.update(&image, &segments, 0.1);
            let class = |x, y| table.class(seen.in_white(image.get(x, y)));
            assert_eq!(class(10, 20), SurfaceClass::Wall, "{light:?} {:?}", seen.rgb());
            assert_eq!(class(45, 20), SurfaceClass::Door(0), "{light:?} {:?}", seen.rgb());
            assert_eq!(class(45, 80), SurfaceClass::Floor, "{light:?} {:?}", seen.rgb());
        }
    }

    #[test]
    fn things_of_other_colors_say_nothing_about_the_light() {
        let colors = OfficeColors { wall: COLORS.0, floor: COLORS.1, doors: vec![COLORS.2] };
        let mut image = image([1.0; 3]);
        for y in 0..96 {
            for x in 0..96 {
                image.set(x, y, if x < 48 { [40, 110, 60] } else { [150, 200, 140] });
            }
        }
        let mut segments = Vec::new();
        GradientDetector::default().detect(&image, 0, 9.0, 7.0, &mut segments);
        assert!(!segments.is_empty());
        let mut seen = LightColor::white(&colors);
        seen.update(&image, &segments, 0.1);
        assert!(seen.rgb().iter().all(|part| (part - 1.0).abs() < 1e-9));
    }
}
