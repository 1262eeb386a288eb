//! Color classes from labelled pixels.

use thiserror::Error;
use visloc_core::hue_saturation_brightness;

use super::{ColorClass, ColorConfig, ColorSource, HueRange, table::luma};

/// Too little to learn from.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CalibrationError {
    /// A class has too few labelled pixels.
    #[error("color calibration: {}: expected at least {expected} labelled pixels, found {found}", class.name())]
    TooFew {
        /// The class.
        class: ColorClass,
        /// How many are needed.
        expected: usize,
        /// How many there are.
        found: usize,
    },
}

/// Pixels of a class that must be labeled, so that the share left out at each end is less than one pixel.
const MIN_SAMPLES: usize = 20;
/// Share of the samples left out at each end, against wrong labels and mixed pixels at borders.
const TRIM: f64 = 0.02;

/// Learns the color classes from labelled pixels. Carpet (`Green`) and lines (`White`) are needed; classes without
/// samples keep the values of `base`.
///
/// # Errors
/// If a class has some samples, or is needed, but has fewer than 20.
pub fn calibrate_colors(
    base: &ColorConfig,
    labelled: &[([u8; 3], ColorClass)],
) -> Result<ColorConfig, CalibrationError> {
    let of =
        |class| labelled.iter().filter(move |(_, c)| *c == class).map(|(rgb, _)| *rgb).collect::<Vec<_>>();
    let (green, white) = (of(ColorClass::Green), of(ColorClass::White));
    require(ColorClass::Green, green.len())?;
    require(ColorClass::White, white.len())?;
    let mut config = ColorConfig { source: ColorSource::Table, ..*base };
    config.green = hue_range(&green);
    let goals_and_ball = [
        (ColorClass::Yellow, &mut config.yellow),
        (ColorClass::Blue, &mut config.blue),
        (ColorClass::Orange, &mut config.orange),
    ];
    for (class, range) in goals_and_ball {
        let samples = of(class);
        if !samples.is_empty() {
            require(class, samples.len())?;
            *range = hue_range(&samples);
        }
    }
    let saturation = sorted(white.iter().map(|rgb| hue_saturation_brightness(*rgb).1));
    config.white_max_saturation = (quantile(&saturation, 1.0 - TRIM) + 0.08).min(0.6);
    let green_luma = sorted(green.iter().map(|rgb| f64::from(luma(*rgb))));
    let white_luma = sorted(white.iter().map(|rgb| f64::from(luma(*rgb))));
    // Halfway between typical carpet and the darkest lines.
    let ratio = quantile(&white_luma, 0.1) / quantile(&green_luma, 0.5).max(1.0);
    config.white_over_green = (0.5 * (1.0 + ratio)).clamp(1.1, 3.0);
    Ok(config)
}

fn require(class: ColorClass, found: usize) -> Result<(), CalibrationError> {
    if found < MIN_SAMPLES {
        return Err(CalibrationError::TooFew { class, expected: MIN_SAMPLES, found });
    }
    Ok(())
}

fn hue_range(samples: &[[u8; 3]]) -> HueRange {
    let colors: Vec<_> = samples.iter().map(|rgb| hue_saturation_brightness(*rgb)).collect();
    // Hues relative to their mean direction, so that a class around red (0) is one range.
    let (sin, cos) = colors
        .iter()
        .fold((0.0, 0.0), |(s, c), (hue, ..)| (s + hue.to_radians().sin(), c + hue.to_radians().cos()));
    let center = sin.atan2(cos).to_degrees();
    let offsets = sorted(colors.iter().map(|(hue, ..)| (hue - center + 180.0).rem_euclid(360.0) - 180.0));
    let saturation = sorted(colors.iter().map(|c| c.1));
    let brightness = sorted(colors.iter().map(|c| c.2));
    HueRange {
        from_deg: (center + quantile(&offsets, TRIM) - 6.0).rem_euclid(360.0),
        to_deg: (center + quantile(&offsets, 1.0 - TRIM) + 6.0).rem_euclid(360.0),
        min_saturation: (quantile(&saturation, TRIM) * 0.85).clamp(0.1, 0.8),
        // Half of the darkest sample: shadows and shorter exposure.
        min_brightness: (quantile(&brightness, TRIM) * 0.5).clamp(12.0, 120.0),
    }
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    let index = (share * (sorted.len() - 1) as f64).round() as usize;
    sorted[index.min(sorted.len() - 1)]
}

#[cfg(test)]
mod tests {
    use visloc_core::{RngTree, gaussian};

    use super::*;
    use crate::vision::color::{ColorTable, GoalColors};

    fn samples(rgb: [f64; 3], class: ColorClass, light: f64) -> Vec<([u8; 3], ColorClass)> {
        let mut rng = RngTree::new(3).stream("samples", class as u64);
        (0..200)
            .map(|_| (rgb.map(|v| (v * light + gaussian(&mut rng, 4.0)).clamp(0.0, 255.0) as u8), class))
            .collect()
    }

    const COLORS: [([f64; 3], ColorClass); 4] = [
        ([150.0, 60.0, 140.0], ColorClass::Green), // a violet carpet: nothing like the defaults
        ([240.0, 235.0, 225.0], ColorClass::White),
        ([200.0, 30.0, 35.0], ColorClass::Yellow), // a red "first" goal, across hue 0
        ([20.0, 170.0, 180.0], ColorClass::Blue),
    ];

    #[test]
    fn learned_classes_hold_in_other_light() {
        let labelled: Vec<_> = COLORS.iter().flat_map(|(rgb, class)| samples(*rgb, *class, 0.9)).collect();
        let config = calibrate_colors(&ColorConfig::default(), &labelled).unwrap();
        config.check().unwrap();
        let table = ColorTable::new(&config, GoalColors::default());
        for light in [0.6, 1.0] {
            let green_luma = luma([150.0, 60.0, 140.0].map(|v| (v * light) as u8));
            for (rgb, class) in COLORS {
                let found = samples(rgb, class, light)
                    .iter()
                    .filter(|(rgb, class)| {
                        table.class_beside_carpet(*rgb, table.white_threshold(green_luma)) == *class
                    })
                    .count();
                assert!(found >= 185, "{class:?} in light {light}: {found} of 200");
            }
        }
    }

    #[test]
    fn too_few_samples_are_refused() {
        let labelled = samples([60.0, 140.0, 80.0], ColorClass::Green, 1.0);
        let error = calibrate_colors(&ColorConfig::default(), &labelled).unwrap_err();
        assert_eq!(error, CalibrationError::TooFew { class: ColorClass::White, expected: 20, found: 0 });
    }
}
