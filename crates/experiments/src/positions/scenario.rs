//! Where the positions are in every iteration.

use rand::RngExt;
use serde::{Deserialize, Serialize};
use visloc_core::Rng;

/// Half the side of the square, meters. Source: 2017 section 5.1, 20 m x 20 m.
pub(super) const HALF_SIDE_M: f64 = 10.0;
/// Least distance of a position from the border, meters. Localizers know that the robot is inside, so the cloud around a
/// position at the border would lose its outer half. The documents do not say how positions are placed.
const BORDER_M: f64 = 0.5;
/// Least distance of two positions, meters: twice the radius in which individuals count as near a position, so that no
/// individual is near two.
const MIN_DISTANCE_M: f64 = 4.0;
/// New directions that a wandering position tries before it waits for one iteration.
const MAX_TURNS: usize = 16;
/// Placements that are tried before all of them are drawn anew.
const MAX_TRIES: usize = 200;

type Point = [f64; 2];

/// How positions move.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Movement {
    /// Not at all.
    Static,
    /// Each in a direction of its own, straight ahead, meters per iteration. The whole path lies inside the square,
    /// and positions are apart at the start and at the end.
    Straight(f64),
    /// Each in a direction of its own, meters per iteration, with a new random direction where the way ahead leaves the
    /// square or comes too near another position. So the positions are apart at all times, however long it takes.
    Wandering(f64),
}

/// What a scenario is drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ScenarioShape {
    /// How many positions there are.
    pub num_positions: usize,
    /// How they move.
    pub movement: Movement,
    /// For how long they move.
    pub num_iterations: usize,
}

/// Positions over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    frames: Vec<Vec<Point>>,
}

impl Scenario {
    /// Draws a scenario.
    pub fn draw(shape: &ScenarioShape, rng: &mut Rng) -> Self {
        let num = shape.num_positions;
        let frames = match shape.movement {
            Movement::Static => vec![places(num, rng)],
            Movement::Straight(step_m) => straight(num, step_m, shape.num_iterations, rng),
            Movement::Wandering(step_m) => wandering(num, step_m, shape.num_iterations, rng),
        };
        Self { frames }
    }

    /// One position that jumps to another place, at least `min_jump_m` away, at the iteration `at`.
    pub fn kidnap(at: usize, min_jump_m: f64, rng: &mut Rng) -> Self {
        let before = anywhere(rng);
        let mut after = anywhere(rng);
        while distance_m(before, after) < min_jump_m {
            after = anywhere(rng);
        }
        let mut frames = vec![vec![before]; at];
        frames.push(vec![after]);
        Self { frames }
    }

    /// Positions at an iteration, from 0. After the last one they stay.
    pub fn positions(&self, iteration: usize) -> &[Point] {
        &self.frames[iteration.min(self.frames.len() - 1)]
    }
}

pub(super) fn distance_m(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn anywhere(rng: &mut Rng) -> Point {
    let half_side_m = HALF_SIDE_M - BORDER_M;
    [rng.random_range(-half_side_m..=half_side_m), rng.random_range(-half_side_m..=half_side_m)]
}

fn is_inside(place: Point) -> bool {
    place.iter().all(|v| v.abs() <= HALF_SIDE_M - BORDER_M)
}

fn is_apart(place: Point, others: &[Point]) -> bool {
    others.iter().all(|other| distance_m(place, *other) >= MIN_DISTANCE_M)
}

/// Uniform places that are apart.
fn places(num: usize, rng: &mut Rng) -> Vec<Point> {
    loop {
        let mut chosen: Vec<Point> = Vec::with_capacity(num);
        for _ in 0..MAX_TRIES {
            let place = anywhere(rng);
            if is_apart(place, &chosen) {
                chosen.push(place);
            }
            if chosen.len() == num {
                return chosen;
            }
        }
    }
}

fn straight(num: usize, step_m: f64, num_iterations: usize, rng: &mut Rng) -> Vec<Vec<Point>> {
    let at = |place: Point, step: Point, iteration: usize| {
        [place[0] + step[0] * iteration as f64, place[1] + step[1] * iteration as f64]
    };
    loop {
        let starts = places(num, rng);
        let steps: Vec<Point> = starts.iter().map(|_| step(step_m, rng)).collect();
        let frame = |iteration: usize| -> Vec<Point> {
            starts.iter().zip(&steps).map(|(place, step)| at(*place, *step, iteration)).collect()
        };
        let last = frame(num_iterations);
        let is_valid =
            last.iter().enumerate().all(|(i, place)| is_inside(*place) && is_apart(*place, &last[..i]));
        if is_valid {
            return (0..=num_iterations).map(frame).collect();
        }
    }
}

fn wandering(num: usize, step_m: f64, num_iterations: usize, rng: &mut Rng) -> Vec<Vec<Point>> {
    let mut now = places(num, rng);
    let mut steps: Vec<Point> = now.iter().map(|_| step(step_m, rng)).collect();
    let mut frames = vec![now.clone()];
    for _ in 0..num_iterations {
        for i in 0..num {
            for _ in 0..MAX_TURNS {
                let next = [now[i][0] + steps[i][0], now[i][1] + steps[i][1]];
                if is_inside(next) && is_apart(next, &now[..i]) && is_apart(next, &now[i + 1..]) {
                    now[i] = next;
                    break;
                }
                steps[i] = step(step_m, rng);
            }
        }
        frames.push(now.clone());
    }
    frames
}

fn step(step_m: f64, rng: &mut Rng) -> Point {
    let (sin, cos) = rng.random_range(0.0..std::f64::consts::TAU).sin_cos();
    [step_m * cos, step_m * sin]
}

#[cfg(test)]
mod tests {
    use visloc_core::RngTree;

    use super::*;

    fn all_apart(frame: &[Point]) -> bool {
        frame.iter().enumerate().all(|(i, place)| is_inside(*place) && is_apart(*place, &frame[..i]))
    }

    fn draw(movement: Movement, num_positions: usize, run: u64) -> Scenario {
        let shape = ScenarioShape { num_positions, movement, num_iterations: 300 };
        Scenario::draw(&shape, &mut RngTree::new(1).stream("scenario", run))
    }

    #[test]
    fn straight_paths_have_their_length_and_stay_inside() {
        for run in 0..20 {
            let scenario = draw(Movement::Straight(0.01), 4, run);
            let (first, last) = (scenario.positions(0), scenario.positions(300));
            assert!(all_apart(first) && all_apart(last));
            assert!(first.iter().zip(last).all(|(a, b)| (distance_m(*a, *b) - 3.0).abs() < 1e-9));
            assert_eq!(scenario.positions(301), last, "they stay at the end");
        }
    }

    #[test]
    fn wandering_positions_keep_moving_and_never_meet() {
        for run in 0..5 {
            let scenario = draw(Movement::Wandering(0.05), 8, run);
            assert!(scenario.frames.iter().all(|frame| all_apart(frame)));
            let num_moved = scenario.frames.windows(2).filter(|pair| pair[0][0] != pair[1][0]).count();
            assert!(num_moved > 280, "{num_moved} of 300");
        }
    }

    #[test]
    fn a_kidnapped_position_jumps_once_and_far() {
        let scenario = Scenario::kidnap(200, 8.0, &mut RngTree::new(1).stream("kidnap", 0));
        assert_eq!(scenario.positions(0), scenario.positions(199));
        assert!(distance_m(scenario.positions(199)[0], scenario.positions(200)[0]) >= 8.0);
        assert_eq!(scenario.positions(200), scenario.positions(399));
    }
}
