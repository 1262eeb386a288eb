//! Axes: from values to pixels, and their ticks.

/// Range of the values of a vertical axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ValueAxis {
    /// From 0 (or the smallest value, if negative) to a round number above the largest.
    #[default]
    Auto,
    /// Even steps. Values outside are shown at the border.
    Linear {
        /// At the lower end.
        min: f64,
        /// At the upper end.
        max: f64,
    },
    /// Equal factors. Values outside are shown at the border.
    Log {
        /// At the lower end, above 0.
        min: f64,
        /// At the upper end.
        max: f64,
    },
}

/// A labelled place of an axis; no label for minor ticks.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tick {
    pub(crate) value: f64,
    pub(crate) label: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Spacing {
    Linear,
    Log,
}

/// Maps values to pixels along one direction of the picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Axis {
    spacing: Spacing,
    min: f64,
    max: f64,
    px_at_min: f64,
    px_at_max: f64,
}

impl Axis {
    /// Even steps from `range.0` to `range.1`; an empty range or one that is not finite becomes 0 to 1.
    pub(crate) fn linear(range: (f64, f64), px: (f64, f64)) -> Self {
        let (min, max) = sane_range(range);
        Self { spacing: Spacing::Linear, min, max, px_at_min: px.0, px_at_max: px.1 }
    }

    /// As `axis` says, where `Auto` covers all finite `values`.
    pub(crate) fn of_values(axis: ValueAxis, values: impl Iterator<Item = f64>, px: (f64, f64)) -> Self {
        match axis {
            ValueAxis::Auto => Self::linear(round_range(finite_range(values)), px),
            ValueAxis::Linear { min, max } => Self::linear((min, max), px),
            ValueAxis::Log { min, max } => {
                let is_valid = min > 0.0 && max > min && max.is_finite();
                let (min, max) = if is_valid { (min, max) } else { (0.01, 10.0) };
                Self { spacing: Spacing::Log, min, max, px_at_min: px.0, px_at_max: px.1 }
            }
        }
    }

    pub(crate) fn range(&self) -> (f64, f64) {
        (self.min, self.max)
    }

    /// Pixel of a value, also outside the range. Values that a logarithm does not have lie far below.
    pub(crate) fn px(&self, value: f64) -> f64 {
        let fraction = match self.spacing {
            Spacing::Linear => (value - self.min) / (self.max - self.min),
            Spacing::Log if value > 0.0 => (value / self.min).ln() / (self.max / self.min).ln(),
            Spacing::Log => -1.0,
        };
        self.px_at_min + fraction * (self.px_at_max - self.px_at_min)
    }

    /// Round values of the range, labels at least `spacing_px` apart.
    pub(crate) fn ticks(&self, spacing_px: f64) -> Vec<Tick> {
        let length_px = (self.px_at_max - self.px_at_min).abs();
        match self.spacing {
            Spacing::Linear => linear_ticks(self.min, self.max, (length_px / spacing_px).floor().max(1.0)),
            Spacing::Log => log_ticks(self.min, self.max),
        }
    }
}

/// Smallest and largest finite value.
pub(crate) fn finite_range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.is_finite()).fold(None, |range, value| match range {
        None => Some((value, value)),
        Some((min, max)) => Some((value.min(min), value.max(max))),
    })
}

fn sane_range((min, max): (f64, f64)) -> (f64, f64) {
    let is_valid = min < max && (max - min).is_finite() && (max - min) > 1e-12 * min.abs().max(max.abs());
    match (is_valid, min.is_finite() && min == max) {
        (true, _) => (min, max),
        (false, true) => (min - 0.5 * min.abs().max(1.0), max + 0.5 * max.abs().max(1.0)),
        (false, false) => (0.0, 1.0),
    }
}

fn round_range(range: Option<(f64, f64)>) -> (f64, f64) {
    let Some((min, max)) = range else { return (0.0, 1.0) };
    let (min, max) = (min.min(0.0), max.max(0.0));
    if min == max {
        return (0.0, 1.0);
    }
    let step = round_step((max - min) / 5.0);
    // 3 % of room keeps the highest line off the border
    let room = 0.03 * (max - min);
    let min = if min < 0.0 { ((min - room) / step).floor() * step } else { 0.0 };
    let max = if max > 0.0 { ((max + room) / step).ceil() * step } else { 0.0 };
    (min, max)
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `step`.
pub(crate) fn round_step(step: f64) -> f64 {
    let power = 10f64.powf(step.log10().floor());
    let factors = [1.0, 2.0, 5.0, 10.0];
    let factor = factors.into_iter().find(|factor| factor * power >= step * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

fn linear_ticks(min: f64, max: f64, max_steps: f64) -> Vec<Tick> {
    let step = round_step((max - min) / max_steps);
    let first = (min / step - 1e-6).ceil();
    let count = ((max / step + 1e-6).floor() - first + 1.0).clamp(0.0, 200.0) as u32;
    (0..count)
        .map(|i| {
            let value = (first + f64::from(i)) * step;
            Tick { value, label: Some(label(value, step)) }
        })
        .collect()
}

fn label(value: f64, step: f64) -> String {
    if value.abs() < step * 1e-6 {
        return "0".to_owned();
    }
    if step < 1e-4 || value.abs() >= 1e6 {
        return format!("{value:.1e}");
    }
    let decimals = (-(step * 1.000_001).log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}").replace('-', "\u{2212}")
}

fn log_ticks(min: f64, max: f64) -> Vec<Tick> {
    let (first, last) = (min.log10().floor() as i32, max.log10().ceil() as i32);
    let num_decades = (max / min).log10();
    let mut ticks = Vec::new();
    for exponent in first..=last {
        for factor in 1..10 {
            let value = f64::from(factor) * 10f64.powi(exponent);
            if value < min * (1.0 - 1e-9) || value > max * (1.0 + 1e-9) {
                continue;
            }
            let is_labelled = factor == 1 || (num_decades < 2.0 && (factor == 2 || factor == 5));
            let text = || label(value, 10f64.powi(exponent.min(0)));
            ticks.push(Tick { value, label: is_labelled.then(text) });
        }
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, spacing_px: f64) -> Vec<String> {
        axis.ticks(spacing_px).into_iter().filter_map(|tick| tick.label).collect()
    }

    #[test]
    fn linear_axis_maps_and_has_round_ticks() {
        let axis = Axis::linear((0.0, 70.0), (100.0, 800.0));
        assert_eq!(axis.px(35.0), 450.0);
        assert_eq!(labels(&axis, 70.0), ["0", "10", "20", "30", "40", "50", "60", "70"]);
        let axis = Axis::linear((-0.25, 0.25), (0.0, 100.0));
        assert_eq!(labels(&axis, 15.0), ["\u{2212}0.2", "\u{2212}0.1", "0", "0.1", "0.2"]);
    }

    #[test]
    fn log_axis_maps_decades_evenly() {
        let log = ValueAxis::Log { min: 0.01, max: 10.0 };
        let axis = Axis::of_values(log, std::iter::empty(), (300.0, 0.0));
        assert!((axis.px(0.1) - 200.0).abs() < 1e-9);
        assert!(axis.px(0.0) > 300.0 && axis.px(f64::NEG_INFINITY) > 300.0);
        assert_eq!(labels(&axis, 20.0), ["0.01", "0.1", "1", "10"]);
    }

    #[test]
    fn automatic_range_covers_values_and_starts_at_zero() {
        let values = [0.3, f64::NAN, 4.2, f64::INFINITY];
        let axis = Axis::of_values(ValueAxis::Auto, values.into_iter(), (0.0, 1.0));
        assert_eq!(axis.range(), (0.0, 5.0));
    }

    #[test]
    fn senseless_ranges_become_sensible() {
        for range in [(f64::NAN, 1.0), (1.0, 0.0), (0.0, f64::INFINITY), (3.0, 3.0)] {
            let axis = Axis::linear(range, (0.0, 100.0));
            assert!(axis.px(0.0).is_finite());
            assert!(!axis.ticks(20.0).is_empty(), "{range:?}");
        }
        let wrong = ValueAxis::Log { min: -1.0, max: 1.0 };
        assert_eq!(Axis::of_values(wrong, std::iter::empty(), (0.0, 1.0)).range(), (0.01, 10.0));
    }
}
