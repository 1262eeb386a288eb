//! How well the features of an image fit at a place.

use std::f64::consts::TAU;

use super::{RefinementConfig, filter::LANDMARKS};
use crate::observation::features::{CameraState, FeatureMatch, FeatureModel, OnBar};

/// A feature that belongs to nothing on the map lies anywhere within so many pixels of something that is; as the coarsest gate of a fit.
const ASTRAY_PX: f64 = 40.0;
/// Share of the features that belong to nothing on the map: robots, boards, people.
const OUTLIERS: f64 = 0.15;

/// Probability that an image shows nothing by itself, wherever the robot is: somebody stands before the camera, or it is dark.
const HIDDEN: f64 = 0.01;

/// Probability that an image shows nothing where it should show borders of this length, pixels: all of them are hidden. What hides one hides
/// all that is near.
pub(super) fn hidden(expected_px: f64) -> f64 {
    OUTLIERS.powf(expected_px / (2.0 * ASTRAY_PX)).max(HIDDEN)
}

/// What features tell of a place, as a logarithm of the likelihood against that of features that belong to nothing.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Told {
    pub by_all: f64,
    /// The part of it that landmarks tell; `None` if there are none in the image.
    pub by_landmarks: Option<f64>,
}

impl Told {
    pub fn by_lines(&self) -> f64 {
        self.by_all - self.by_landmarks.unwrap_or(0.0)
    }
}

/// Logarithm of the likelihood of the features, against features that belong to nothing: each belongs to its counterpart with Gaussian
/// noise, or to nothing. Neighboring pixels err alike, so all count as few. A bar whose place the map does not know explains its features
/// as a line does, less for the place that it had to have.
pub(super) fn log_likelihood(
    model: &dyn FeatureModel,
    camera: &CameraState,
    config: &RefinementConfig,
) -> Told {
    let num_features = model.num_features().max(1) as f64;
    let share = (config.max_independent_evidence / num_features).min(1.0);
    let noise = Noise::new(config);
    let mut bars = [Bar::default(); 2];
    let mut sum = 0.0;
    let mut by_landmarks = None;
    model.visit_matches(camera, ASTRAY_PX, 1, &mut |feature| {
        let density = noise.density(&feature);
        sum += density.ln();
        if feature.group == LANDMARKS {
            *by_landmarks.get_or_insert(0.0) += share * density.ln();
        }
        if let Some(on_bar) = feature.on_bar
            && density < 0.5 * noise.peak
        {
            bars[on_bar.side].add(&on_bar);
        }
    });
    sum = share * sum + hidden(model.missed_px(camera)).ln();
    if bars.iter().all(|bar| bar.num == 0) {
        return Told { by_all: sum, by_landmarks };
    }
    bars.iter_mut().for_each(Bar::settle);
    let mut gains = [0.0; 2];
    model.visit_matches(camera, ASTRAY_PX, 1, &mut |feature| {
        if let Some(on_bar) = feature.on_bar {
            let error_px = (on_bar.at - bars[on_bar.side].at) * on_bar.range_px;
            gains[on_bar.side] += (noise.match_density(error_px) / noise.density(&feature)).ln_1p();
        }
    });
    let gain = |(bar, gain): (&Bar, f64)| (share * gain - bar.cost(share, &noise)).max(0.0);
    Told { by_all: sum + bars.iter().zip(gains).map(gain).sum::<f64>(), by_landmarks }
}

/// How far a feature lies from its counterpart.
struct Noise {
    sigma_px: f64,
    peak: f64,
}

impl Noise {
    fn new(config: &RefinementConfig) -> Self {
        let sigma_px = config.agreement_px;
        Self { sigma_px, peak: (1.0 - OUTLIERS) * 2.0 * ASTRAY_PX / (sigma_px * TAU.sqrt()) }
    }

    /// Density of a feature so far from its counterpart, against that of one that belongs to nothing.
    fn match_density(&self, error_px: f64) -> f64 {
        self.peak * (-0.5 * (error_px / self.sigma_px).powi(2)).exp()
    }

    /// The same of a feature that may belong to nothing as well.
    fn density(&self, feature: &FeatureMatch) -> f64 {
        let matched = feature.residual.map_or(0.0, |residual| self.match_density(residual.error_px));
        matched + OUTLIERS + (1.0 - OUTLIERS) * feature.unmatched_agreement
    }
}

visloc_core::with_defaults! {
    /// A border that may be anywhere in a range, and is where most features of it are.
    #[derive(Clone, Copy)]
    struct Bar {
        counts: [u32; Self::BINS] = [0; Self::BINS],
        num: u32 = 0,
        range_px: f64 = 0.0,
        at: f64 = 0.0,
    }
}

impl Bar {
    const BINS: usize = 40;

    fn add(&mut self, feature: &OnBar) {
        let bin = (feature.at * Self::BINS as f64) as usize;
        self.counts[bin.min(Self::BINS - 1)] += 1;
        self.num += 1;
        self.range_px += feature.range_px;
    }

    /// It is where it explains most.
    fn settle(&mut self) {
        let near = |i: usize| {
            let bins = i.saturating_sub(1)..(i + 2).min(Self::BINS);
            let num: u32 = self.counts[bins.clone()].iter().sum();
            let sum: f64 = bins.map(|j| (j as f64 + 0.5) * f64::from(self.counts[j])).sum();
            (num, sum)
        };
        let mut best = near(0);
        for i in 1..Self::BINS {
            let other = near(i);
            if other.0 > best.0 {
                best = other;
            }
        }
        self.at = best.1 / f64::from(best.0.max(1)) / Self::BINS as f64;
        self.range_px /= f64::from(self.num.max(1));
    }

    /// What it costs that it may be anywhere: minus the logarithm of the share of the range that fits as well.
    fn cost(&self, share: f64, noise: &Noise) -> f64 {
        let fits_px = noise.sigma_px * TAU.sqrt() / (share * f64::from(self.num)).max(1.0).sqrt();
        (self.range_px / fits_px).max(1.0).ln()
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::geom::PlanarPose;

    use super::*;
    use crate::vision::Percept;

    /// Features that match nothing, at these shares of a range of 80 pixels, and borders that are missed.
    struct Loose(Vec<f64>, f64);

    impl FeatureModel for Loose {
        fn condition_on(&mut self, _: &Percept) {}

        fn num_features(&self) -> usize {
            self.0.len()
        }

        fn missed_px(&self, _: &CameraState) -> f64 {
            self.1
        }

        fn visit_matches(&self, _: &CameraState, _: f64, _: usize, visit: &mut dyn FnMut(FeatureMatch)) {
            for at in &self.0 {
                let on_bar = Some(OnBar { side: 0, at: *at, range_px: 80.0 });
                visit(FeatureMatch { group: 0, residual: None, unmatched_agreement: 0.9, on_bar });
            }
        }
    }

    #[test]
    fn a_bar_is_explained_nearly_as_a_line_and_what_is_scattered_is_not() {
        let config = RefinementConfig::default();
        let camera = CameraState::reported(PlanarPose::default());
        let log_likelihood = |at: Vec<f64>| log_likelihood(&Loose(at, 0.0), &camera, &config).by_all;
        let line = config.max_independent_evidence * Noise::new(&config).peak.ln();
        let bar = log_likelihood((0..100).map(|i| 0.4 + 0.01 * f64::from(i % 2)).collect());
        let scattered = log_likelihood((0..100).map(|i| f64::from(i) / 100.0).collect());
        assert!((0.8 * line..line).contains(&bar), "{bar} of a line's {line}");
        assert!((-0.2 * line..0.2 * line).contains(&scattered), "{scattered} of a line's {line}");
    }

    #[test]
    fn lines_that_are_not_where_they_should_be_speak_against_a_place_within_bounds() {
        let config = RefinementConfig::default();
        let camera = CameraState::reported(PlanarPose::default());
        let told = |missed_px| log_likelihood(&Loose(vec![0.5; 20], missed_px), &camera, &config).by_all;
        assert!(told(0.0) - told(80.0) > 1.5 && told(80.0) - told(160.0) > 1.5);
        assert!(told(0.0) - told(1e4) < 5.0, "the field may lack a line of the map");
    }
}
