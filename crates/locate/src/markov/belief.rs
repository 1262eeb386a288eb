//! A probability for every state.

use super::{Action, Grid, Outcomes};

/// A probability distribution over the states of a grid. It always sums to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Belief {
    grid: Grid,
    probabilities: Vec<f64>,
    next: Vec<f64>,
}

impl Belief {
    /// Unknown start: every state has 1 / |S|.
    pub fn uniform(grid: Grid) -> Self {
        let share = 1.0 / grid.num_states() as f64;
        Self { grid, probabilities: vec![share; grid.num_states()], next: Vec::new() }
    }

    /// Known start: one state has `probability`, all others share the rest. Source: section 4.3, 0.8.
    pub fn known(grid: Grid, state: usize, probability: f64) -> Self {
        let mut belief = Self::uniform(grid);
        let num_others = belief.probabilities.len() - 1;
        if num_others > 0 && state <= num_others {
            let other = (1.0 - probability) / num_others as f64;
            belief.probabilities.fill(other);
            belief.probabilities[state] = probability;
        }
        belief
    }

    /// The states.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Probability of each state, by number.
    pub fn probabilities(&self) -> &[f64] {
        &self.probabilities
    }

    /// The most probable state and its probability; the first of equal ones.
    pub fn best(&self) -> (usize, f64) {
        let better = |best: (usize, f64), (i, p): (usize, &f64)| if *p > best.1 { (i, *p) } else { best };
        self.probabilities.iter().enumerate().fold((0, f64::NEG_INFINITY), better)
    }

    /// Prediction: Bel'(s') = sum over s of P(s' | s, a) Bel(s). At a wall the robot stays in the last tile that it
    /// reaches. With headings that are not multiples of 90 degrees a motion ends between tiles and is shared out among
    /// them so that its mean is right (not in the source).
    pub fn predict(&mut self, action: Action, outcomes: &Outcomes) {
        let mut next = std::mem::take(&mut self.next);
        next.clear();
        next.resize(self.probabilities.len(), 0.0);
        let shares = outcomes.of(action);
        for (index, &probability) in self.probabilities.iter().enumerate() {
            if probability > 0.0 {
                for (times, share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
                    self.add_outcome(index, action, times, probability * share, &mut next);
                }
            }
        }
        self.next = std::mem::replace(&mut self.probabilities, next);
    }

    fn add_outcome(&self, index: usize, action: Action, times: usize, mass: f64, next: &mut [f64]) {
        let (grid, state) = (&self.grid, self.grid.state(index));
        match action {
            Action::Turn(steps) => {
                let times = i32::try_from(times).unwrap_or(0);
                let heading = grid.turned(state.heading, steps.saturating_mul(times));
                next[grid.index(super::State { heading, ..state })] += mass;
            }
            Action::Walk { ahead, left } => {
                let (sin, cos) = grid.heading_rad(state.heading).sin_cos();
                let (ahead, left) = (f64::from(ahead) * times as f64, f64::from(left) * times as f64);
                let column = split(state.column as f64 + cos * ahead - sin * left, grid.num_columns());
                let row = split(state.row as f64 + sin * ahead + cos * left, grid.num_rows());
                for (column, column_share) in column {
                    for (row, row_share) in row {
                        let share = column_share * row_share;
                        if share > 0.0 {
                            next[grid.index(super::State { column, row, ..state })] += mass * share;
                        }
                    }
                }
            }
        }
    }

    /// Estimation: Bel(s) = eta p(o | s) Bel'(s). A likelihood that is negative or not a number counts as 0, an infinite
    /// one as the largest number. If nothing is left, the observation is impossible: the belief stays as it was and the
    /// answer is false.
    pub fn weigh(&mut self, likelihood: impl Fn(usize) -> f64) -> bool {
        let mut next = std::mem::take(&mut self.next);
        next.clear();
        next.extend(self.probabilities.iter().enumerate().map(|(index, probability)| {
            let likelihood = likelihood(index);
            if likelihood > 0.0 { likelihood.min(f64::MAX) * probability } else { 0.0 }
        }));
        // Two steps, so that the sum can neither overflow nor underflow.
        let largest = next.iter().copied().fold(0.0, f64::max);
        let is_possible = largest > 0.0;
        if is_possible {
            next.iter_mut().for_each(|p| *p /= largest);
            let total: f64 = next.iter().sum();
            next.iter_mut().for_each(|p| *p /= total);
            std::mem::swap(&mut self.probabilities, &mut next);
        }
        self.next = next;
        is_possible
    }

    /// Gives a share of the belief back to all states alike, so that no state is lost for good.
    pub fn mix_uniform(&mut self, share: f64) {
        if share > 0.0 {
            let floor = share.min(1.0) / self.probabilities.len() as f64;
            self.probabilities.iter_mut().for_each(|p| *p = *p * (1.0 - share.min(1.0)) + floor);
        }
    }

    /// Gives a share of the belief, 0 to 1, to another belief over the same states.
    pub(super) fn mix(&mut self, other: &Self, share: f64) {
        for (p, q) in self.probabilities.iter_mut().zip(&other.probabilities) {
            *p += share * (q - *p);
        }
    }

    /// Probability of a state together with the states that touch it.
    pub fn mass_around(&self, index: usize) -> f64 {
        let near = |(i, _): &(usize, &f64)| self.grid.are_neighbors(index, *i);
        self.probabilities.iter().enumerate().filter(near).map(|(_, p)| p).sum()
    }
}

/// The two tiles on both sides of a place, with their shares; places outside belong to the outermost tile.
fn split(place: f64, count: usize) -> [(usize, f64); 2] {
    let place = place.clamp(0.0, (count - 1) as f64);
    // Multiples of 90 degrees must hit their tile exactly.
    let place = if (place - place.round()).abs() < 1e-9 { place.round() } else { place };
    let lower = place.floor();
    let upper_share = place - lower;
    let lower = lower as usize;
    [(lower, 1.0 - upper_share), ((lower + 1).min(count - 1), upper_share)]
}
