//! What a start prior says about each state.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::{Belief, Grid};
use crate::{PosePrior, Region, StartPrior};

/// A belief that follows a prior: the share `probability` is spread as the prior says, the rest over all states alike, as
/// the source does for a known start (section 4.3). What the prior puts outside of the tiles belongs to the outermost ones.
pub(super) fn belief_of(grid: Grid, prior: &StartPrior, probability: f64) -> Belief {
    let mut belief = Belief::uniform(grid);
    let parts = parts_of(prior);
    if parts.is_empty() {
        return belief;
    }
    let shares: Vec<f64> = (0..grid.num_states())
        .map(|state| parts.iter().map(|part| part.weight * part.share_of(&grid, state)).sum())
        .collect();
    let total: f64 = shares.iter().sum();
    if total > 0.0 && total.is_finite() {
        belief.weigh(|state| shares[state] / total);
        belief.mix_uniform(1.0 - probability);
    }
    belief
}

/// One dimension of a prior.
#[derive(Debug, Clone, Copy)]
enum Spread {
    /// Alike from here to there.
    Alike(f64, f64),
    /// Normal, by mean and standard deviation.
    Normal(f64, f64),
}

/// Part of a prior whose dimensions do not depend on each other.
#[derive(Debug, Clone, Copy)]
struct Part {
    weight: f64,
    x_m: Spread,
    y_m: Spread,
    /// `None` for any heading.
    yaw_rad: Option<Spread>,
}

fn parts_of(prior: &StartPrior) -> Vec<Part> {
    let alike = |region: &Region| {
        let (x, y) = ((region.min_x_m, region.max_x_m), (region.min_y_m, region.max_y_m));
        (Spread::Alike(x.0, x.1), Spread::Alike(y.0, y.1))
    };
    match prior {
        StartPrior::Uniform => Vec::new(),
        StartPrior::Region { region, heading } => {
            let (x_m, y_m) = alike(region);
            let yaw_rad = heading.map(|heading| Spread::Normal(heading.yaw_rad, heading.spread_rad));
            vec![Part { weight: 1.0, x_m, y_m, yaw_rad }]
        }
        StartPrior::Poses(poses) => poses.iter().filter(|pose| pose.weight > 0.0).map(near).collect(),
        StartPrior::SideLines(lines) => [1.0, -1.0]
            .map(|side| Part {
                weight: 0.5,
                x_m: Spread::Alike(lines.min_x_m, lines.max_x_m),
                y_m: Spread::Normal(side * lines.half_width_m, lines.position_spread_m),
                yaw_rad: Some(Spread::Normal(-side * FRAC_PI_2, lines.heading_spread_rad)),
            })
            .to_vec(),
    }
}

fn near(prior: &PosePrior) -> Part {
    let pose = &prior.world_from_robot;
    Part {
        weight: prior.weight,
        x_m: Spread::Normal(pose.x_m, prior.position_spread_m),
        y_m: Spread::Normal(pose.y_m, prior.position_spread_m),
        yaw_rad: Some(Spread::Normal(pose.yaw_rad, prior.heading_spread_rad)),
    }
}

impl Part {
    /// Probability of a state, 0 to 1. The tiles' sides are parallel to the axes of the map.
    fn share_of(&self, grid: &Grid, state: usize) -> f64 {
        let (middle, half_tile_m, half_step_rad) =
            (grid.pose(state), grid.tile_m() / 2.0, grid.heading_step_rad() / 2.0);
        let region = grid.region();
        let inside = |spread: &Spread, middle: f64, (min, max): (f64, f64)| {
            // The outermost tiles reach to infinity.
            let is_outermost = |edge: f64, border: f64| (edge - border).abs() < 1e-6 * half_tile_m;
            let (low, high) = (middle - half_tile_m, middle + half_tile_m);
            let low = if is_outermost(low, min) { f64::NEG_INFINITY } else { low };
            let high = if is_outermost(high, max) { f64::INFINITY } else { high };
            spread.share_between(low, high)
        };
        let heading = |spread: &Spread| {
            let offset = match spread {
                Spread::Normal(mean, _) => visloc_core::geom::angle::difference(middle.yaw_rad, *mean) + mean,
                Spread::Alike(..) => middle.yaw_rad,
            };
            let once = |turns: f64| {
                let middle = offset + turns * TAU;
                spread.share_between(middle - half_step_rad, middle + half_step_rad)
            };
            once(-1.0) + once(0.0) + once(1.0)
        };
        inside(&self.x_m, middle.x_m, (region.min_x_m, region.max_x_m))
            * inside(&self.y_m, middle.y_m, (region.min_y_m, region.max_y_m))
            * self.yaw_rad.as_ref().map_or(half_step_rad / PI, heading)
    }
}

impl Spread {
    fn share_between(&self, low: f64, high: f64) -> f64 {
        match *self {
            Self::Alike(min, max) if max > min => {
                ((high.min(max) - low.max(min)) / (max - min)).clamp(0.0, 1.0)
            }
            // A line is a point of this dimension.
            Self::Alike(at, _) => Self::Normal(at, 0.0).share_between(low, high),
            Self::Normal(mean, sigma) => {
                let below = |edge: f64| normal_below((edge - mean) / sigma.max(1e-9));
                (below(high) - below(low)).max(0.0)
            }
        }
    }
}

/// Share of the standard normal distribution below a value, to 1e-7.
/// Source: Abramowitz and Stegun 1964, formula 26.2.17.
fn normal_below(value: f64) -> f64 {
    if value.is_infinite() {
        return if value > 0.0 { 1.0 } else { 0.0 };
    }
    const FACTORS: [f64; 5] = [0.319_381_530, -0.356_563_782, 1.781_477_937, -1.821_255_978, 1.330_274_429];
    let t = 1.0 / (1.0 + 0.231_641_9 * value.abs());
    let tail = FACTORS.iter().rev().fold(0.0, |sum, factor| (sum + factor) * t);
    let above = tail * (-0.5 * value * value).exp() / TAU.sqrt();
    if value >= 0.0 { 1.0 - above } else { above }
}

#[cfg(test)]
mod tests {
    use visloc_core::{RngTree, geom::PlanarPose};

    use super::*;
    use crate::{HeadingPrior, SideLines, markov::Direction};

    const MAP: Region = Region { min_x_m: -3.0, max_x_m: 3.0, min_y_m: -2.0, max_y_m: 2.0 };

    fn priors() -> Vec<StartPrior> {
        let at = |x_m, y_m, yaw_rad, weight| PosePrior {
            world_from_robot: PlanarPose::new(x_m, y_m, yaw_rad),
            position_spread_m: 0.3,
            heading_spread_rad: 0.4,
            weight,
        };
        let region = Region { min_x_m: -1.0, max_x_m: 0.25, min_y_m: -2.0, max_y_m: 0.0 };
        let lines = SideLines {
            min_x_m: -3.0,
            max_x_m: 0.0,
            half_width_m: 2.0,
            position_spread_m: 0.15,
            heading_spread_rad: 0.2,
        };
        vec![
            StartPrior::Uniform,
            StartPrior::Region { region, heading: None },
            StartPrior::Region { region, heading: Some(HeadingPrior { yaw_rad: PI, spread_rad: 0.5 }) },
            StartPrior::Poses(vec![at(1.2, -0.4, 3.0, 2.0), at(-2.9, 1.9, -0.5, 1.0)]),
            StartPrior::SideLines(lines),
        ]
    }

    /// Every state's belief is the share of the prior's samples that fall into it, to three standard errors.
    #[test]
    fn beliefs_are_what_samples_say() {
        const DRAWS: u32 = 40_000;
        for direction in [Direction::PlusX, Direction::MinusX] {
            let grid = Grid::new(&MAP, 0.5, 8, direction);
            for prior in priors() {
                let mut rng = RngTree::new(3).stream("prior", 0);
                let mut counts = vec![0.0; grid.num_states()];
                (0..DRAWS).for_each(|_| counts[grid.nearest(&prior.sample(&MAP, &mut rng))] += 1.0);
                let belief = belief_of(grid, &prior, 1.0);
                for (state, (count, p)) in counts.iter().zip(belief.probabilities()).enumerate() {
                    let expected = p * f64::from(DRAWS);
                    let margin = 4.5 * expected.sqrt() + 4.0;
                    assert!(
                        (count - expected).abs() < margin,
                        "{prior:?}: {count} for {expected} in {state}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_rest_is_for_all_states() {
        let grid = Grid::new(&MAP, 0.5, 4, Direction::PlusX);
        let belief = belief_of(grid, &priors()[3], 0.8);
        assert!((belief.probabilities().iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let least = belief.probabilities().iter().copied().fold(1.0, f64::min);
        assert!((least - 0.2 / 384.0).abs() < 1e-6, "{least}");
        let nobody = belief_of(grid, &StartPrior::Poses(Vec::new()), 0.8);
        assert_eq!(nobody, Belief::uniform(grid));
    }

    #[test]
    fn normal_distribution_by_table() {
        for (value, below) in [(0.0, 0.5), (1.0, 0.841_344_7), (-1.96, 0.024_997_9), (3.0, 0.998_650_1)] {
            assert!((normal_below(value) - below).abs() < 1e-6, "{value}");
        }
    }
}
