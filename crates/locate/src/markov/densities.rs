//! Observations without cases: the size and the bearing of the goal as each state sees them, as densities.

use std::fmt::Write as _;

use super::{BlobView, TableError, table_text};

/// How likely a view of the goal is in each state.
pub trait ViewLikelihoods: Sync {
    /// Replaces `out` by the likelihood of a view, or of seeing no goal, in every state.
    fn likelihoods(&self, view: Option<&BlobView>, out: &mut Vec<f64>);
}

/// What a state sees of the goal: how often it sees it, and a normal density over bearing and logarithm of the area.
///
/// Deviation from the source, which sorts both into nine cases each and takes them for independent: a case of the
/// bearing is 8 degrees wide, in which a tile that is 5 m away moves by 5 degrees; and where the goal is cut off by the
/// border of the image, its area and its bearing go together. Learned from the same captures.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StateView {
    /// Share of the captures that show the goal, 0 to 1.
    seen: f64,
    /// Bearing, radians: mean and standard deviation.
    bearing_rad: [f64; 2],
    /// Natural logarithm of the area in pixels of [`BlobView`]: mean and standard deviation.
    log_area: [f64; 2],
    /// Correlation of the two, -1 to 1.
    correlation: f64,
}

/// The densities of all states, by number.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewDensities {
    states: Vec<StateView>,
    outlier: f64,
}

/// A few captures may agree by chance: variances are those of the captures and one more of this spread.
const PRIOR_BEARING_SIGMA_RAD: f64 = 0.1;
const PRIOR_LOG_AREA_SIGMA: f64 = 0.5;
/// What a state that never saw the goal expects: anything.
const UNSEEN: StateView =
    StateView { seen: 0.0, bearing_rad: [0.0, 0.4], log_area: [6.0, 1.5], correlation: 0.0 };
/// A larger correlation is due to few images; the density would be a line.
const MAX_CORRELATION: f64 = 0.95;
/// A view that can be anything is spread over so much of bearing (radians) times logarithm of area.
const ANYTHING: f64 = 0.8 * 5.0;

/// Learns the densities. A state whose captures never show the goal sees anything if it sees something. Captures of
/// states that do not exist are left out. `outlier` is the share, 0 to 1, of views that can be anything in any state.
pub fn learn_densities(
    num_states: usize,
    outlier: f64,
    captures: impl Iterator<Item = (usize, Option<BlobView>)>,
) -> ViewDensities {
    let mut views = vec![(0.0, Vec::new()); num_states];
    for (state, view) in captures.filter(|(state, _)| *state < num_states) {
        views[state].0 += 1.0;
        views[state].1.extend(view.map(|view| [view.bearing_rad, view.area_px.max(1e-9).ln()]));
    }
    let states = views.iter().map(|(count, seen)| StateView::of(*count, seen)).collect();
    ViewDensities { states, outlier }
}

impl StateView {
    fn of(num_captures: f64, seen: &[[f64; 2]]) -> Self {
        let count = seen.len() as f64;
        // Half a capture more of each kind: what did not happen is rare, not impossible.
        let share = (count + 0.5) / (num_captures + 1.0);
        if seen.is_empty() {
            return Self { seen: share, ..UNSEEN };
        }
        let mean = |i: usize| seen.iter().map(|v| v[i]).sum::<f64>() / count;
        let means = [mean(0), mean(1)];
        let moment = |i: usize, j: usize, prior: f64| {
            let sum: f64 = seen.iter().map(|v| (v[i] - means[i]) * (v[j] - means[j])).sum();
            (sum + prior) / (count + 1.0)
        };
        let sigmas = [
            moment(0, 0, PRIOR_BEARING_SIGMA_RAD.powi(2)).sqrt(),
            moment(1, 1, PRIOR_LOG_AREA_SIGMA.powi(2)).sqrt(),
        ];
        let correlation = moment(0, 1, 0.0) / (sigmas[0] * sigmas[1]);
        Self {
            seen: share,
            bearing_rad: [means[0], sigmas[0]],
            log_area: [means[1], sigmas[1]],
            correlation: correlation.clamp(-MAX_CORRELATION, MAX_CORRELATION),
        }
    }

    /// Density of a view over bearing and logarithm of area, if the goal is seen.
    fn density(&self, view: &BlobView) -> f64 {
        let standard = |value: f64, [mean, sigma]: [f64; 2]| (value - mean) / sigma;
        let b = standard(view.bearing_rad, self.bearing_rad);
        let a = standard(view.area_px.max(1e-9).ln(), self.log_area);
        let rest = 1.0 - self.correlation * self.correlation;
        let exponent = (b * b - 2.0 * self.correlation * a * b + a * a) / (2.0 * rest);
        let scale = std::f64::consts::TAU * self.bearing_rad[1] * self.log_area[1] * rest.sqrt();
        (-exponent).exp() / scale
    }
}

impl ViewLikelihoods for ViewDensities {
    fn likelihoods(&self, view: Option<&BlobView>, out: &mut Vec<f64>) {
        out.clear();
        out.extend(self.states.iter().map(|state| match view {
            None => 1.0 - state.seen,
            Some(view) => state.seen * ((1.0 - self.outlier) * state.density(view) + self.outlier / ANYTHING),
        }));
    }
}

impl ViewDensities {
    /// As text: one line for each state, its number, the share of captures with a goal, means and standard deviations
    /// of bearing (radians) and logarithm of area, and their correlation, with 4 decimals.
    pub fn to_csv(&self) -> String {
        let mut text =
            String::from("state,seen,bearing_rad,bearing_sigma,log_area,log_area_sigma,correlation\n");
        for (number, state) in self.states.iter().enumerate() {
            let ([b, b_sigma], [a, a_sigma]) = (state.bearing_rad, state.log_area);
            let _ = write!(text, "{number}");
            for value in [state.seen, b, b_sigma, a, a_sigma, state.correlation] {
                let _ = write!(text, ",{}", (value * 1e4).round() / 1e4);
            }
            text.push('\n');
        }
        text
    }

    /// Reads what [`ViewDensities::to_csv`] wrote.
    ///
    /// # Errors
    /// If a line has not seven numbers, states do not follow each other, or a number is out of its range.
    pub fn from_csv(outlier: f64, text: &str) -> Result<Self, TableError> {
        let rows = table_text::rows(text, 6, "numbers of its view")?;
        let is_good = |row: &&Vec<f64>| {
            (0.0..=1.0).contains(&row[0]) && row[2] > 0.0 && row[4] > 0.0 && row[5].abs() < 1.0
        };
        if let Some(i) = rows.iter().position(|row| !is_good(&row)) {
            let expected = "a share, means with standard deviations above 0, and a correlation".to_owned();
            return Err(TableError { line: i + 2, expected });
        }
        let state = |row: &Vec<f64>| StateView {
            seen: row[0],
            bearing_rad: [row[1], row[2]],
            log_area: [row[3], row[4]],
            correlation: row[5],
        };
        Ok(Self { states: rows.iter().map(state).collect(), outlier })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(area_px: f64, bearing_rad: f64) -> Option<BlobView> {
        Some(BlobView { area_px, bearing_rad })
    }

    #[test]
    fn a_state_expects_what_its_captures_showed() {
        let near = [0.2, 0.24, 0.28].map(|bearing| (0, view(400.0, bearing)));
        let far = [-0.1, 0.0, 0.1].map(|bearing| (1, view(400.0, bearing)));
        let blind = [(2, None); 3];
        let captures = near.into_iter().chain(far).chain(blind).chain([(9, None)]);
        let densities = learn_densities(3, 0.05, captures);
        let mut likelihoods = Vec::new();
        densities.likelihoods(view(400.0, 0.25).as_ref(), &mut likelihoods);
        assert!(likelihoods[0] > 5.0 * likelihoods[1] && likelihoods[1] > likelihoods[2], "{likelihoods:?}");
        assert!(likelihoods[2] > 0.0, "rare, not impossible");
        densities.likelihoods(None, &mut likelihoods);
        assert!((likelihoods[2] - 0.875).abs() < 1e-12 && (likelihoods[0] - 0.125).abs() < 1e-12);
    }

    /// The density of a state integrates to the share in which the goal is seen.
    #[test]
    fn densities_integrate_to_one() {
        let spread = [(0.02, 5.0), (0.1, 5.4), (0.05, 5.1), (0.16, 5.5), (-0.05, 4.9)];
        let captures = spread.map(|(bearing, log_area): (f64, f64)| (0, view(log_area.exp(), bearing)));
        let densities = learn_densities(1, 0.0, captures.into_iter());
        assert!(densities.states[0].correlation > 0.5);
        let (mut total, mut out) = (0.0, Vec::new());
        for i in -200..=200 {
            for j in 0..=200 {
                let area_px = (3.2 + 0.02 * f64::from(j)).exp();
                densities.likelihoods(view(area_px, 0.005 * f64::from(i)).as_ref(), &mut out);
                total += out[0] * 0.005 * 0.02;
            }
        }
        assert!((total - densities.states[0].seen).abs() < 1e-3, "{total}");
    }

    #[test]
    fn text_and_back() {
        let captures = [0.2, 0.24, 0.28].map(|bearing| (0, view(400.0, bearing)));
        let densities = learn_densities(2, 0.05, captures.into_iter());
        let again = ViewDensities::from_csv(0.05, &densities.to_csv()).unwrap();
        assert!((again.states[0].bearing_rad[0] - 0.24).abs() < 1e-4);
        assert_eq!(again.states.len(), 2);
        let error = ViewDensities::from_csv(0.0, "state\n0,1,2,0,1,1,0\n").unwrap_err().to_string();
        assert!(error.contains("line 2") && error.contains("standard deviations"), "{error}");
    }
}
