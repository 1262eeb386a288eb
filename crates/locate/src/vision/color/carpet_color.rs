//! The carpet's own color, learned from images: where colors without their brightness lie, and how far they scatter.

use nalgebra::{Matrix2, Vector2};
use visloc_core::hue_saturation_brightness;

use super::{
    classes::ANY_GREEN,
    table::{ColorClass, Shares, luma, shares},
};

/// Noise of a level of red, green or blue: of a sensor, of JPEG, and of rounding to the table's entries.
const LEVEL_NOISE: f64 = 2.5;
/// Shares of a color so dark that they are noisier than this tell nothing.
const MAX_SHARE_NOISE: f64 = 0.1;
/// A carpet's own shares scatter by this at least, and by about this before some were seen.
const MIN_SCATTER: f64 = 0.012;
const TYPICAL_SCATTER: f64 = 0.03;
/// Squared distance, in units of the scatter, within which 99 % of two normal numbers lie.
const NEAR_2: f64 = 9.2;
/// Farthest white from gray, or from a mixture of white and carpet, as a length of the difference of shares.
const WHITE_TOLERANCE: f64 = 0.08;
/// A color is gray rather than the carpet's below this part of the way from gray to the carpet's mean. A line that makes a pixel a fifth
/// brighter than the carpet takes it to 0.7 at most, and a carpet without line scatters around 1.
const GRAY_PART: f64 = 0.5;
const PALE_PART: f64 = 0.85;
/// So much darker than the darkest hundredth of the carpet is a shadow's core or a shoe.
const DARK_SHARE: f64 = 0.6;
/// Share of an image in what is learned.
pub(crate) const FOLLOW: f64 = 0.1;
/// So many colors tell the carpet's.
const MIN_SAMPLES: usize = 20;
/// Another carpet, or another light: less than this share of all greens is near what was learned.
const MIN_KNOWN_SHARE: f64 = 0.4;
/// Bins of the first search for the most frequent color, on each axis, over 0 to 1.
const BINS: usize = 32;
/// Rounds in which mean and scatter of the samples near the last mean settle.
const ROUNDS: usize = 4;

/// The carpet's color without its brightness: normally distributed shares of red and green.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CarpetColor {
    mean: Vector2<f64>,
    covariance: Matrix2<f64>,
    /// Below this luma nothing is carpet.
    darkest: f64,
}

impl CarpetColor {
    /// A test for carpet among the colors of one brightness, given as the sum of the three levels.
    pub fn at_brightness(&self, sum: f64) -> Option<CarpetTest> {
        let noise = share_noise(sum);
        let inverse = (self.covariance + Matrix2::identity() * noise.powi(2)).try_inverse()?;
        Some(CarpetTest {
            axis: self.mean - Vector2::repeat(1.0 / 3.0),
            inverse,
            noise,
            darkest: self.darkest,
        })
    }

    /// Whether classes made with another one would hardly differ.
    pub fn is_much_like(&self, other: &Self) -> bool {
        let scatter = |of: &Self| of.covariance.diagonal().map(f64::sqrt);
        (self.mean - other.mean).amax() < 0.1 * TYPICAL_SCATTER
            && (scatter(self) - scatter(other)).amax() < 0.1 * TYPICAL_SCATTER
            && (self.darkest - other.darkest).abs() < 1.0 + 0.1 * other.darkest
    }

    fn toward(&self, other: &Self, part: f64) -> Self {
        Self {
            mean: self.mean.lerp(&other.mean, part),
            covariance: self.covariance * (1.0 - part) + other.covariance * part,
            darkest: self.darkest + (other.darkest - self.darkest) * part,
        }
    }
}

/// Tells carpet and white apart among colors of one brightness.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CarpetTest {
    /// From gray to the carpet's mean.
    axis: Vector2<f64>,
    inverse: Matrix2<f64>,
    noise: f64,
    darkest: f64,
}

impl CarpetTest {
    /// What a color can be on the field.
    pub fn class(&self, rgb: [u8; 3]) -> ColorClass {
        let (from_gray, axis) = (vector(shares(rgb)) - Vector2::repeat(1.0 / 3.0), self.axis);
        // How far from gray to the carpet's mean.
        let part = dot_of_shares(&from_gray, &axis) / dot_of_shares(&axis, &axis);
        let off = from_gray - axis;
        let is_bright_enough = self.noise < MAX_SHARE_NOISE && f64::from(luma(rgb)) >= self.darkest;
        if is_bright_enough && part >= GRAY_PART && off.dot(&(self.inverse * off)) <= NEAR_2 {
            return if part < PALE_PART { ColorClass::PaleGreen } else { ColorClass::Green };
        }
        let beside = from_gray - axis * part.clamp(0.0, 1.0);
        let may_be_white = dot_of_shares(&beside, &beside).sqrt() <= WHITE_TOLERANCE + self.noise;
        if may_be_white { ColorClass::Neutral } else { ColorClass::Unknown }
    }
}

/// Product of two differences of shares, that of blue included.
fn dot_of_shares(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
    a.dot(b) + (a.x + a.y) * (b.x + b.y)
}

fn vector(Shares { red, green }: Shares) -> Vector2<f64> {
    Vector2::new(f64::from(red), f64::from(green))
}

fn share_noise(sum: f64) -> f64 {
    LEVEL_NOISE / sum.max(1.0)
}

/// A color seen on the ground near the robot.
#[derive(Debug, Clone, Copy)]
struct Sample {
    shares: Vector2<f64>,
    variance: f64,
    luma: f64,
}

impl Sample {
    /// Dark colors tell less.
    fn weight(&self) -> f64 {
        1.0 / (TYPICAL_SCATTER.powi(2) + self.variance)
    }
}

/// Learns the carpet's color from image to image, from nothing.
#[derive(Debug, Default)]
pub(crate) struct CarpetLearner {
    samples: Vec<Sample>,
    lumas: Vec<f64>,
    bins: Vec<f64>,
    color: Option<CarpetColor>,
    num_images: u32,
}

impl CarpetLearner {
    pub fn color(&self) -> Option<&CarpetColor> {
        self.color.as_ref()
    }

    /// Begins an image.
    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// Adds a color of the ground near the robot. Colors that no carpet has are left out.
    pub fn add(&mut self, rgb: [u8; 3]) {
        let noise = share_noise(rgb.iter().map(|v| f64::from(*v)).sum());
        let (hue_deg, saturation, brightness) = hue_saturation_brightness(rgb);
        if noise < MAX_SHARE_NOISE && ANY_GREEN.contains(hue_deg, saturation, brightness) {
            let (shares, luma) = (vector(shares(rgb)), f64::from(luma(rgb)));
            self.samples.push(Sample { shares, variance: noise.powi(2), luma });
        }
    }

    /// Ends an image: what was learned moves toward it. A color that is new altogether is learned from nothing.
    pub fn learn(&mut self) {
        if self.samples.len() < MIN_SAMPLES {
            return;
        }
        let known =
            self.color.and_then(|color| self.settle(&color, 1, MIN_KNOWN_SHARE).map(|now| (color, now)));
        if let Some((color, now)) = known {
            self.num_images += 1;
            let part = FOLLOW.max(1.0 / f64::from(self.num_images));
            self.color = Some(color.toward(&now, part));
        } else {
            let start = self.most_frequent();
            if let Some(new) = self.settle(&start, ROUNDS, 0.0) {
                (self.color, self.num_images) = (Some(new), 1);
            }
        }
    }

    /// The most frequent color, with a typical scatter.
    fn most_frequent(&mut self) -> CarpetColor {
        self.bins.clear();
        self.bins.resize(BINS * BINS, 0.0);
        let bin = |share: f64| ((share * BINS as f64) as usize).clamp(1, BINS - 2);
        for sample in &self.samples {
            let (x, y) = (bin(sample.shares.x), bin(sample.shares.y));
            // The bins around it as well: borders of bins may cut the carpet's colors anywhere.
            for at in [y - 1, y, y + 1].into_iter().flat_map(|y| [x - 1, x, x + 1].map(|x| y * BINS + x)) {
                self.bins[at] += sample.weight();
            }
        }
        let best = (0..self.bins.len()).max_by(|a, b| self.bins[*a].total_cmp(&self.bins[*b])).unwrap_or(0);
        let middle = |bin: usize| (bin as f64 + 0.5) / BINS as f64;
        CarpetColor {
            mean: Vector2::new(middle(best % BINS), middle(best / BINS)),
            covariance: Matrix2::identity() * TYPICAL_SCATTER.powi(2),
            darkest: 0.0,
        }
    }

    /// Mean and scatter of the samples near a color; `None` if less than a share of all are near.
    fn settle(&mut self, from: &CarpetColor, rounds: usize, min_share: f64) -> Option<CarpetColor> {
        let mut color = *from;
        for _ in 0..rounds {
            self.lumas.clear();
            let (mut sum, mut all) = (0.0, 0.0);
            let (mut mean, mut square, mut variance) = (Vector2::zeros(), Matrix2::zeros(), 0.0);
            for sample in &self.samples {
                all += sample.weight();
                let off = sample.shares - color.mean;
                let spread = color.covariance + Matrix2::identity() * sample.variance;
                if off.dot(&(spread.try_inverse()? * off)) <= NEAR_2 {
                    let weight = sample.weight();
                    sum += weight;
                    mean += off * weight;
                    square += off * off.transpose() * weight;
                    variance += sample.variance * weight;
                    self.lumas.push(sample.luma);
                }
            }
            if self.lumas.len() < MIN_SAMPLES || sum < min_share * all {
                return None;
            }
            let (mean, noise) = (mean / sum, Matrix2::identity() * (variance / sum));
            color.mean += mean;
            color.covariance = at_least(square / sum - mean * mean.transpose() - noise, MIN_SCATTER.powi(2));
        }
        let low = self.lumas.len() / 100;
        color.darkest = DARK_SHARE * *self.lumas.select_nth_unstable_by(low, f64::total_cmp).1;
        Some(color)
    }
}

/// A covariance whose variances are raised to a least value.
fn at_least(covariance: Matrix2<f64>, least: f64) -> Matrix2<f64> {
    let eigen = covariance.symmetric_eigen();
    let values = eigen.eigenvalues.map(|value| value.max(least));
    eigen.eigenvectors * Matrix2::from_diagonal(&values) * eigen.eigenvectors.transpose()
}

#[cfg(test)]
mod tests {
    use visloc_core::{Rng, RngTree, gaussian};

    use super::*;
    use crate::vision::color::{ColorConfig, ColorSource, ColorTable, GoalColors};

    /// Turf in the sun whose blades scatter.
    const TURF: [f64; 3] = [90.0, 110.0, 50.0];
    const WHITE: [f64; 3] = [200.0, 200.0, 190.0];

    fn seen(color: [f64; 3], light: f64, rng: &mut Rng) -> [u8; 3] {
        let light = light * (1.0 + gaussian(rng, 0.1));
        color.map(|v| (v * light + gaussian(rng, 3.0)).round().clamp(0.0, 255.0) as u8)
    }

    fn learn(learner: &mut CarpetLearner, color: [f64; 3], lights: [f64; 2], rng: &mut Rng) {
        learner.clear();
        for i in 0..200 {
            learner.add(seen(if i % 5 == 0 { WHITE } else { color }, lights[i % 2], rng));
        }
        learner.learn();
    }

    fn table(learner: &CarpetLearner) -> ColorTable {
        let config = ColorConfig { source: ColorSource::Learned, ..ColorConfig::default() };
        let mut table = ColorTable::new(&config, GoalColors { yellow: false, blue: false });
        table.follow(learner.color().unwrap());
        table
    }

    /// How many of a hundred pixels have a class beside carpet in the same light.
    fn count(table: &ColorTable, color: [f64; 3], light: f64, class: ColorClass, rng: &mut Rng) -> usize {
        let threshold = table.white_threshold((light * 84.0) as u32);
        let is = |rgb: [u8; 3]| table.class_beside_carpet(rgb, threshold) == class;
        (0..100).filter(|_| is(seen(color, light, rng))).count()
    }

    #[test]
    fn any_turf_is_learned_from_one_image_in_sun_and_shade_at_once() {
        let mut rng = RngTree::new(4).stream("turf", 0);
        for turf in [TURF, [60.0, 118.0, 68.0], [100.0, 100.0, 25.0], [20.0, 90.0, 60.0]] {
            let mut learner = CarpetLearner::default();
            learn(&mut learner, turf, [1.4, 0.5], &mut rng);
            let table = table(&learner);
            for light in [1.4, 0.5] {
                let carpet = count(&table, turf, light, ColorClass::Green, &mut rng);
                let white = count(&table, WHITE, light, ColorClass::White, &mut rng);
                assert!(carpet >= 90 && white >= 95, "{turf:?} in {light}: carpet {carpet}, white {white}");
            }
            // Much darker than the carpet in the shade.
            assert!(count(&table, turf, 0.15, ColorClass::Green, &mut rng) <= 3);
        }
    }

    #[test]
    fn a_pixel_that_a_line_covers_in_part_is_white_and_gray_is_not_carpet() {
        let mut rng = RngTree::new(5).stream("turf", 0);
        let mut learner = CarpetLearner::default();
        learn(&mut learner, TURF, [1.0, 1.0], &mut rng);
        let table = table(&learner);
        let third: [f64; 3] = std::array::from_fn(|i| TURF[i] + (WHITE[i] - TURF[i]) / 3.0);
        assert!(count(&table, third, 1.0, ColorClass::White, &mut rng) >= 85);
        assert!(count(&table, [60.0; 3], 1.0, ColorClass::Green, &mut rng) <= 2);
    }

    #[test]
    fn what_is_learned_follows_the_light_and_begins_anew_on_another_carpet() {
        let mut rng = RngTree::new(6).stream("turf", 0);
        let mut learner = CarpetLearner::default();
        for image in 0..=80 {
            let turf = [60.0 + 0.5 * f64::from(image), 110.0, 50.0];
            learn(&mut learner, turf, [1.0, 0.8], &mut rng);
        }
        assert!(count(&table(&learner), [100.0, 110.0, 50.0], 1.0, ColorClass::Green, &mut rng) >= 85);
        learn(&mut learner, [20.0, 90.0, 60.0], [1.0, 0.8], &mut rng);
        assert!(count(&table(&learner), [20.0, 90.0, 60.0], 1.0, ColorClass::Green, &mut rng) >= 90);
        // Nothing near to be seen: what was learned stays.
        let before = *learner.color().unwrap();
        learner.clear();
        learner.learn();
        assert_eq!(learner.color(), Some(&before));
    }
}
