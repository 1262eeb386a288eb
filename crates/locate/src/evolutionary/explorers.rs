//! Explorers: free individuals that look for new places, a few in each iteration.

use visloc_core::{Rng, geom::PlanarPose};

use super::{ExplorerConfig, ExplorerKind, race::Exploiter};
use crate::{ObservationModel, PlanarMotion, Region};

/// Radius of the ring of the local search, meters. Source: 2010 section 5.2.1.
const RING_RADIUS_M: f64 = 0.3;
/// Poses on the ring, and small turns in place. Source: 2010 section 5.2.1.
const RING_POSES: usize = 30;
const SMALL_TURNS_RAD: [f64; 4] = [-0.1, -0.05, 0.05, 0.1];
/// Candidates refined in one iteration.
const REFINED_AT_ONCE: usize = 2;
/// Headings of a grid position that is not aimed.
const GRID_HEADINGS: usize = 10;

/// A search in progress.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    /// No search is going on.
    Idle,
    /// Spreading: so many poses are done, of so many.
    Spread { done: usize, total: usize },
    /// Refining the best ones: so many are done.
    Refine { done: usize },
}

/// Looks for new places and remembers the best ones that it met.
#[derive(Debug, Clone)]
pub(super) struct Explorers {
    config: ExplorerConfig,
    /// What is less healthy cannot found a race.
    min_health: f64,
    phase: Phase,
    /// Iterations since the last search ended.
    rested: u32,
    best: Vec<Exploiter>,
    /// What the refinement starts from.
    seeds: Vec<Exploiter>,
}

impl Explorers {
    /// Explorers at rest. What is less healthy than `min_health` after the search is not of use.
    pub fn new(config: ExplorerConfig, min_health: f64) -> Self {
        let rested = config.period;
        Self { config, min_health, phase: Phase::Idle, rested, best: Vec::new(), seeds: Vec::new() }
    }

    /// Forgets the search in progress; the next one may begin at once.
    pub fn reset(&mut self) {
        self.phase = Phase::Idle;
        self.rested = self.config.period;
        self.best.clear();
    }

    /// What was found so far moves with the robot.
    pub fn apply_motion(&mut self, motion: &PlanarMotion) {
        for explorer in self.best.iter_mut().chain(&mut self.seeds) {
            explorer.pose = motion.apply(&explorer.pose);
        }
    }

    /// Begins or goes on with a search, if there is reason to. Returns the candidates when a search has ended.
    pub fn search(
        &mut self,
        model: &dyn ObservationModel,
        is_informative: bool,
        is_lost: bool,
        rng: &mut Rng,
    ) -> Option<&[Exploiter]> {
        self.rested = self.rested.saturating_add(1);
        if !is_informative {
            return self.cut_short();
        }
        if self.phase == Phase::Idle {
            if self.rested < self.config.period && !is_lost {
                return None;
            }
            self.best.clear();
            self.phase = Phase::Spread { done: 0, total: self.num_explorers(is_lost) };
        }
        if let Phase::Spread { done, total } = self.phase {
            self.phase = self.spread(model, done, total, rng);
        } else if let Phase::Refine { done } = self.phase {
            self.phase = self.refine(model, done);
        }
        if self.phase != Phase::Idle {
            return None;
        }
        self.rested = 0;
        Some(&self.best)
    }

    /// Nothing informative is in view any more: the best so far have to do.
    fn cut_short(&mut self) -> Option<&[Exploiter]> {
        if self.phase == Phase::Idle {
            return None;
        }
        self.phase = Phase::Idle;
        self.rested = 0;
        Some(&self.best)
    }

    fn num_explorers(&self, is_lost: bool) -> usize {
        match self.config.kind {
            ExplorerKind::Grid => self.config.num_grid,
            ExplorerKind::Random if is_lost => self.config.num_random * self.config.deep_factor,
            ExplorerKind::Random => self.config.num_random,
        }
    }

    fn spread(&mut self, model: &dyn ObservationModel, done: usize, total: usize, rng: &mut Rng) -> Phase {
        let slice = total.div_ceil(self.config.num_slices as usize);
        let end = (done + slice).min(total);
        for i in done..end {
            let pose = self.pose(model, i, total, rng);
            let Some(health) = model.likelihood_above(&pose, self.to_beat()) else { continue };
            if health < self.min_health && !self.config.is_refined {
                continue;
            }
            keep_best(&mut self.best, Exploiter { pose, health }, self.config.num_candidates);
        }
        if end < total {
            return Phase::Spread { done: end, total };
        }
        if !self.config.is_refined {
            return Phase::Idle;
        }
        self.seeds.clone_from(&self.best);
        Phase::Refine { done: 0 }
    }

    fn pose(&self, model: &dyn ObservationModel, i: usize, total: usize, rng: &mut Rng) -> PlanarPose {
        let region = model.region();
        match (self.config.kind, self.config.is_aimed) {
            (ExplorerKind::Random, true) => model.propose(rng),
            (ExplorerKind::Random, false) => model.sample(rng),
            (ExplorerKind::Grid, is_aimed) => {
                let headings = if is_aimed { 1 } else { GRID_HEADINGS };
                let (x, y) = grid_position(&region, i / headings, total.div_ceil(headings));
                let yaw = if is_aimed {
                    model.propose_heading(x, y, rng)
                } else {
                    (i % headings) as f64 * std::f64::consts::TAU / headings as f64
                };
                PlanarPose::new(x, y, yaw)
            }
        }
    }

    /// Small turns in place and a ring around each of the next of the best.
    fn refine(&mut self, model: &dyn ObservationModel, done: usize) -> Phase {
        let end = (done + REFINED_AT_ONCE).min(self.seeds.len());
        for seed in done..end {
            self.refine_around(model, self.seeds[seed].pose);
        }
        if end < self.seeds.len() { Phase::Refine { done: end } } else { Phase::Idle }
    }

    fn refine_around(&mut self, model: &dyn ObservationModel, center: PlanarPose) {
        let region = model.region();
        let turned =
            SMALL_TURNS_RAD.map(|turn| PlanarPose::new(center.x_m, center.y_m, center.yaw_rad + turn));
        let ring = (0..RING_POSES).map(|i| {
            let angle = i as f64 * std::f64::consts::TAU / RING_POSES as f64;
            // Alternating radii fill the circle instead of its border only.
            let radius = RING_RADIUS_M * [1.0, 0.67, 0.33][i % 3];
            let (sin, cos) = angle.sin_cos();
            PlanarPose::new(center.x_m + radius * cos, center.y_m + radius * sin, center.yaw_rad)
        });
        for pose in turned.into_iter().chain(ring).filter(|pose| region.contains(pose)) {
            let Some(health) = model.likelihood_above(&pose, self.to_beat()) else { continue };
            keep_best(&mut self.best, Exploiter { pose, health }, self.config.num_candidates);
        }
    }

    /// The health above which an explorer is among the best.
    fn to_beat(&self) -> f64 {
        let is_full = self.best.len() == self.config.num_candidates;
        self.best.last().filter(|_| is_full).map_or(f64::NEG_INFINITY, |last| last.health)
    }
}

/// Positions of a regular grid with about square cells.
fn grid_position(region: &Region, i: usize, count: usize) -> (f64, f64) {
    let (width, height) = (region.max_x_m - region.min_x_m, region.max_y_m - region.min_y_m);
    let columns = ((count as f64 * width / height).sqrt().round() as usize).max(1);
    let rows = count.div_ceil(columns);
    let place = |i: usize, n: usize, min: f64, size: f64| min + (i as f64 + 0.5) * size / n as f64;
    (place(i % columns, columns, region.min_x_m, width), place(i / columns, rows, region.min_y_m, height))
}

/// Keeps the healthiest `max` explorers, the best first. Two explorers of one place count once: only the better stays.
pub(super) fn keep_best(best: &mut Vec<Exploiter>, explorer: Exploiter, max: usize) {
    if best.len() == max && best.last().is_some_and(|last| last.health >= explorer.health) {
        return;
    }
    let is_same_place = |other: &Exploiter| {
        other.pose.distance_m(&explorer.pose) < RING_RADIUS_M
            && other.pose.heading_difference_rad(&explorer.pose) < 0.35
    };
    if best.iter().any(|other| is_same_place(other) && other.health >= explorer.health) {
        return;
    }
    best.retain(|other| !is_same_place(other));
    let at = best.partition_point(|other| other.health >= explorer.health);
    best.insert(at, explorer);
    best.truncate(max);
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn grid_covers_the_region() {
        let region = Region { min_x_m: -3.0, max_x_m: 3.0, min_y_m: -2.0, max_y_m: 2.0 };
        let positions: Vec<_> = (0..49).map(|i| grid_position(&region, i, 49)).collect();
        for corner in [(-3.0, -2.0), (3.0, -2.0), (-3.0, 1.9)] {
            let nearest = positions
                .iter()
                .map(|p: &(f64, f64)| (p.0 - corner.0).hypot(p.1 - corner.1))
                .fold(f64::MAX, f64::min);
            assert!(nearest < 0.7, "{corner:?}: {nearest}");
        }
        assert!(positions.iter().all(|p| p.0.abs() < 3.0 && p.1.abs() < 2.0));
    }

    #[test]
    fn only_the_best_of_one_place_is_kept() {
        let explorer = |x: f64, health: f64| Exploiter { pose: PlanarPose::new(x, 0.0, 0.0), health };
        let mut best = Vec::new();
        for (x, health) in [(0.0, 0.5), (0.1, 0.6), (2.0, 0.4), (0.2, 0.55), (-2.0, 0.9), (1.0, 0.1)] {
            keep_best(&mut best, explorer(x, health), 3);
        }
        assert_eq!(best, [explorer(-2.0, 0.9), explorer(0.1, 0.6), explorer(2.0, 0.4)]);
    }

    /// Counts how often it is asked.
    #[derive(Default)]
    struct Counting {
        num_asked: AtomicUsize,
    }

    impl ObservationModel for Counting {
        fn condition_on(&mut self, _: &crate::vision::Percept) {}
        fn has_evidence(&self) -> bool {
            true
        }
        fn likelihood(&self, pose: &PlanarPose) -> f64 {
            self.num_asked.fetch_add(1, Ordering::Relaxed);
            (-0.5 * (pose.x_m.powi(2) + pose.y_m.powi(2))).exp()
        }
        fn region(&self) -> Region {
            Region { min_x_m: -10.0, max_x_m: 10.0, min_y_m: -10.0, max_y_m: 10.0 }
        }
        fn max_jump_m(&self) -> f64 {
            2.0
        }
        fn propose(&self, rng: &mut Rng) -> PlanarPose {
            self.region().sample(rng)
        }
        fn propose_heading(&self, _: f64, _: f64, _: &mut Rng) -> f64 {
            0.0
        }
    }

    /// Poses weighed in each iteration of a search from its beginning to its end.
    fn costs(config: ExplorerConfig, is_lost: bool) -> Vec<usize> {
        let model = Counting::default();
        let mut rng = visloc_core::RngTree::new(1).stream("explorers", 0);
        let mut explorers = Explorers::new(config, 0.0);
        let mut costs = Vec::new();
        loop {
            model.num_asked.store(0, Ordering::Relaxed);
            let is_over = explorers.search(&model, true, is_lost, &mut rng).is_some();
            costs.push(model.num_asked.load(Ordering::Relaxed));
            if is_over {
                return costs;
            }
        }
    }

    #[test]
    fn a_search_when_lost_is_deep_and_its_cost_is_spread() {
        let config = ExplorerConfig { is_refined: false, ..ExplorerConfig::default() };
        assert!(config.deep_factor >= 10);
        let (ordinary, deep) = (costs(config, false), costs(config, true));
        assert_eq!(ordinary.iter().sum::<usize>(), config.num_random);
        assert_eq!(deep.iter().sum::<usize>(), config.num_random * config.deep_factor);
        for costs in [ordinary, deep] {
            assert_eq!(costs.len(), config.num_slices as usize);
            let total: usize = costs.iter().sum();
            let fair = total.div_ceil(costs.len());
            assert!(costs.iter().all(|cost| *cost <= fair), "{costs:?}");
        }
    }

    #[test]
    fn the_refinement_takes_two_candidates_in_an_iteration() {
        let costs = costs(ExplorerConfig::default(), true);
        let refinement = &costs[ExplorerConfig::default().num_slices as usize..];
        assert_eq!(refinement.len(), 3, "six candidates");
        assert!(refinement.iter().all(|cost| *cost <= 2 * 34), "{refinement:?}");
    }

    #[test]
    fn searches_have_a_pause_unless_the_robot_is_lost() {
        let config = ExplorerConfig { num_slices: 1, is_refined: false, ..ExplorerConfig::default() };
        let model = Counting::default();
        let mut rng = visloc_core::RngTree::new(1).stream("explorers", 0);
        let mut explorers = Explorers::new(config, 0.0);
        let mut is_over = |is_lost: bool, is_informative: bool| {
            explorers.search(&model, is_informative, is_lost, &mut rng).is_some()
        };
        assert!(is_over(false, true), "the first one begins at once");
        assert!((1..config.period).all(|_| !is_over(false, true)));
        assert!(is_over(false, true));
        assert!(is_over(true, true), "no pause when lost");
        assert!(!is_over(true, false), "none while nothing informative is seen");
    }
}
