//! The races together: creation, merging, deletion, and which one wins.
//!
//! Source: 2010 sections 5.2.2 and 5.2.4, 2017 sections 4.2.3 and 4.2.5.

use visloc_core::Rng;

use super::{
    EvolutionaryConfig,
    race::{Exploiter, Race},
};

/// With evidence, a race must have this much more of it than the last winner: logarithm of odds.
const TAKEOVER_EVIDENCE: f64 = 0.7;

/// All living races.
#[derive(Debug, Clone, Default)]
pub(super) struct Races {
    races: Vec<Race>,
    next_id: u64,
    /// The race whose pose was the last answer.
    winner: Option<u64>,
    /// Reliability of the last answer, 0 to 1: the larger, the more evidence a new race needs.
    trust: f64,
}

/// The answer changed to another race.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WinnerChange {
    /// Distance of the two races, meters; `None` if the old winner is gone or there was none.
    pub distance_m: Option<f64>,
}

impl Races {
    pub fn clear(&mut self) {
        self.races.clear();
        self.winner = None;
        self.trust = 0.0;
    }

    /// How reliable the last answer was, 0 to 1.
    pub fn set_trust(&mut self, reliability: f64) {
        self.trust = reliability;
    }

    pub fn iter(&self) -> impl Iterator<Item = &Race> {
        self.races.iter()
    }

    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Race> {
        self.races.iter_mut()
    }

    pub fn is_empty(&self) -> bool {
        self.races.is_empty()
    }

    pub fn winner(&self) -> Option<&Race> {
        self.races.iter().find(|race| Some(race.id) == self.winner)
    }

    /// Whether no race explains the images.
    pub fn all_below(&self, health: f64) -> bool {
        self.races.iter().all(|race| race.health < health)
    }

    /// Offers the best explorers as founders of races.
    pub fn offer(&mut self, candidates: &[Exploiter], config: &EvolutionaryConfig, rng: &mut Rng) {
        for candidate in candidates.iter().filter(|candidate| candidate.health >= config.min_health) {
            if let Some(race) = self.races.iter_mut().find(|race| race.is_near(&candidate.pose, config)) {
                race.life += 1;
                continue;
            }
            if self.races.len() >= config.max_races && !self.remove_replaceable(candidate.health) {
                continue;
            }
            let size = config.race_size(self.races.len() + 1);
            let handicap = if self.races.is_empty() { 0.0 } else { config.evidence.handicap(self.trust) };
            let race = Race::new(self.next_id, *candidate, size, config, rng);
            self.races.push(Race { evidence: -handicap, ..race });
            self.next_id += 1;
        }
    }

    /// Makes room: removes the least healthy race that has neither life nor victories and is below `health`.
    fn remove_replaceable(&mut self, health: f64) -> bool {
        let replaceable = (0..self.races.len())
            .filter(|i| self.races[*i].is_expendable() && self.races[*i].health < health)
            .min_by(|a, b| self.races[*a].health.total_cmp(&self.races[*b].health));
        replaceable.map(|i| self.races.remove(i)).is_some()
    }

    /// Of two races at one place only the one with more victories, then the healthier, lives on.
    pub fn merge(&mut self, config: &EvolutionaryConfig) {
        let mut i = 0;
        while i < self.races.len() {
            let j = (i + 1..self.races.len()).find(|j| self.races[i].is_near(&self.races[*j].pose, config));
            let Some(j) = j else {
                i += 1;
                continue;
            };
            let rank = |race: &Race| (race.victories, race.health);
            let loser = if rank(&self.races[j]) > rank(&self.races[i]) { i } else { j };
            if Some(self.races[loser].id) == self.winner {
                // The answer moves to the race that takes its place.
                let heir = if loser == i { j } else { i };
                self.winner = Some(self.races[heir].id);
            }
            let evidence = self.races[i].evidence.max(self.races[j].evidence);
            (self.races[i].evidence, self.races[j].evidence) = (evidence, evidence);
            self.races.remove(loser);
        }
    }

    /// Counts the last image: races that explain it worse than the best one lose odds, and hopeless ones are given up.
    pub fn compete(&mut self, config: &EvolutionaryConfig) {
        let evidence = &config.evidence;
        if !evidence.is_on() {
            return;
        }
        let best_health = self.races.iter().map(|race| race.last_health).fold(0.0, f64::max);
        for race in &mut self.races {
            let worse = (best_health - race.last_health).min(evidence.max_difference) - evidence.deadband;
            let worse = worse.max(0.0);
            race.evidence = evidence.kept * race.evidence - evidence.per_image * worse;
        }
        let best = self.races.iter().map(|race| race.evidence).fold(f64::NEG_INFINITY, f64::max);
        for race in &mut self.races {
            race.evidence -= best;
        }
        self.races.retain(|race| race.evidence > -evidence.hopeless);
    }

    /// How undisputed the winner is, 0 to 1: 0 if all others together are as probable. 1 if evidence is not counted.
    pub fn undisputed(&self, config: &EvolutionaryConfig) -> f64 {
        let Some(winner) = self.winner().filter(|_| config.evidence.is_on()) else { return 1.0 };
        let total: f64 = self.races.iter().map(|race| race.evidence.exp()).sum();
        (2.0 * winner.evidence.exp() / total - 1.0).max(0.0)
    }

    /// Takes one life from every race and deletes those without life, victories and health.
    pub fn age(&mut self, config: &EvolutionaryConfig) {
        for race in &mut self.races {
            race.life = race.life.saturating_sub(1);
        }
        self.races.retain(|race| !(race.is_expendable() && race.health < config.min_health));
    }

    /// The next generation of every race. The races share the exploiters equally.
    pub fn evolve(&mut self, config: &EvolutionaryConfig, rng: &mut Rng, parents: &mut Vec<Exploiter>) {
        let size = config.race_size(self.races.len());
        for race in &mut self.races {
            race.evolve(size, config, rng, parents);
        }
    }

    /// Counts the victories of this iteration and chooses the winner: the race with most victories.
    pub fn choose_winner(
        &mut self,
        config: &EvolutionaryConfig,
        reliability: f64,
        is_informative: bool,
    ) -> Option<WinnerChange> {
        let rank = |i: usize| {
            let race = &self.races[i];
            if config.evidence.is_on() { race.evidence } else { race.health }
        };
        let healthiest = (0..self.races.len()).min_by(|a, b| rank(*b).total_cmp(&rank(*a)).then(a.cmp(b)))?;
        self.races[healthiest].life = self.races[healthiest].life.max(config.winner_life);
        let best = &self.races[healthiest];
        let needed = config.takeover_health
            + config.takeover_per_reliability * reliability
            + if is_informative { 0.0 } else { config.takeover_uninformative };
        let previous = self.winner();
        let is_victory = previous
            .is_none_or(|previous| previous.id == best.id || is_better(best, previous, needed, config));
        if is_victory {
            for (i, race) in self.races.iter_mut().enumerate() {
                race.victories = if i == healthiest {
                    (race.victories + 1).min(config.max_victories)
                } else {
                    race.victories.saturating_sub(1)
                };
            }
        }
        self.elect()
    }

    /// The race with most victories; the previous winner stays at equal victories.
    fn elect(&mut self) -> Option<WinnerChange> {
        let previous = self.winner().map(|race| (race.id, race.pose));
        let is_previous = |race: &Race| previous.is_some_and(|(id, _)| id == race.id);
        let elected = self.races.iter().max_by(|a, b| {
            (a.victories, is_previous(a))
                .cmp(&(b.victories, is_previous(b)))
                .then(a.health.total_cmp(&b.health))
        })?;
        if is_previous(elected) {
            return None;
        }
        let distance_m = previous.map(|(_, pose)| pose.distance_m(&elected.pose));
        self.winner = Some(elected.id);
        Some(WinnerChange { distance_m })
    }
}

/// Whether a race is so much better than the last winner that it takes a victory from it.
fn is_better(race: &Race, winner: &Race, needed_health: f64, config: &EvolutionaryConfig) -> bool {
    if config.evidence.is_on() {
        return race.evidence - winner.evidence > TAKEOVER_EVIDENCE;
    }
    race.health - winner.health > needed_health
}

#[cfg(test)]
mod tests {
    use visloc_core::{RngTree, geom::PlanarPose};

    use super::*;

    struct Setup {
        config: EvolutionaryConfig,
        races: Races,
        rng: Rng,
    }

    impl Setup {
        /// Races at x = 0, 1, 2 ... with the given healths, without life or victories.
        fn new(healths: &[f64]) -> Self {
            let config = EvolutionaryConfig::default();
            let mut rng = RngTree::new(1).stream("races", 0);
            let mut races = Races::default();
            for (i, health) in healths.iter().enumerate() {
                races.offer(&[candidate(i as f64, 0.99)], &config, &mut rng);
                races.races[i].health = *health;
                races.races[i].life = 0;
            }
            Self { config, races, rng }
        }

        fn offer(&mut self, x: f64, health: f64) {
            self.races.offer(&[candidate(x, health)], &self.config, &mut self.rng);
        }

        fn places(&self) -> Vec<f64> {
            self.races.iter().map(|race| race.pose.x_m).collect()
        }
    }

    fn candidate(x: f64, health: f64) -> Exploiter {
        Exploiter { pose: PlanarPose::new(x, 0.0, 0.0), health }
    }

    #[test]
    fn a_candidate_near_a_race_lengthens_its_life() {
        let mut s = Setup::new(&[0.8]);
        s.offer(0.1, 0.9);
        assert_eq!((s.races.races.len(), s.races.races[0].life), (1, 1));
    }

    #[test]
    fn a_new_race_has_three_lives_and_a_winner_nine() {
        let mut s = Setup::new(&[]);
        s.offer(0.0, 0.9);
        assert_eq!(s.races.races[0].life, 3);
        s.races.choose_winner(&s.config, 0.0, true);
        assert_eq!(s.races.races[0].life, 9);
    }

    #[test]
    fn when_full_the_least_healthy_expendable_race_is_replaced() {
        let mut s = Setup::new(&[0.9, 0.65, 0.62, 0.8]);
        s.races.races[2].victories = 1; // the least healthy, but not expendable
        s.offer(10.0, 0.7);
        assert_eq!(s.places(), [0.0, 2.0, 3.0, 10.0]);
        s.offer(12.0, 0.64); // nothing expendable is less healthy
        assert_eq!(s.places(), [0.0, 2.0, 3.0, 10.0]);
    }

    #[test]
    fn merging_keeps_more_victories_then_health() {
        let mut s = Setup::new(&[0.7, 0.9]);
        s.races.races[1].pose.x_m = 0.1;
        s.races.races[0].victories = 2;
        s.races.merge(&s.config);
        assert_eq!(s.places(), [0.0]);
        let mut s = Setup::new(&[0.7, 0.9]);
        s.races.races[1].pose.x_m = 0.1;
        s.races.merge(&s.config);
        assert_eq!(s.places(), [0.1]);
    }

    #[test]
    fn only_races_without_life_victories_and_health_are_deleted() {
        let mut s = Setup::new(&[0.5, 0.5, 0.5, 0.7]);
        s.races.races[0].life = 2;
        s.races.races[1].victories = 1;
        s.races.age(&s.config);
        assert_eq!(s.places(), [0.0, 1.0, 3.0]);
        s.races.age(&s.config);
        assert_eq!(s.places(), [1.0, 3.0], "the life of the first has run out");
    }

    #[test]
    fn a_small_advantage_does_not_take_a_victory() {
        let mut s = Setup::new(&[0.8, 0.7]);
        s.races.choose_winner(&s.config, 0.0, true);
        s.races.races[1].health = 0.815;
        assert_eq!(s.races.choose_winner(&s.config, 0.0, true), None);
        assert_eq!(s.races.races[1].victories, 0);
        s.races.races[1].health = 0.83; // more than takeover_health
        s.races.choose_winner(&s.config, 0.0, true);
        assert_eq!((s.races.races[0].victories, s.races.races[1].victories), (0, 1));
        assert_eq!(s.races.winner().unwrap().pose.x_m, 1.0);
    }

    #[test]
    fn reliability_and_poor_images_make_a_takeover_harder() {
        for (reliability, is_informative, advantage, is_taken) in [
            (0.0, true, 0.03, true),
            (1.0, true, 0.03, false),
            (1.0, true, 0.07, true),
            (0.0, false, 0.07, false),
            (0.0, false, 0.11, true),
            (1.0, false, 0.11, false),
            (1.0, false, 0.15, true),
        ] {
            let mut s = Setup::new(&[0.8, 0.7]);
            s.races.choose_winner(&s.config, 0.0, true);
            s.races.races[1].health = 0.8 + advantage;
            s.races.choose_winner(&s.config, reliability, is_informative);
            assert_eq!(
                s.races.races[1].victories == 1,
                is_taken,
                "{reliability} {is_informative} {advantage}"
            );
        }
    }

    #[test]
    fn the_race_with_most_victories_is_the_answer() {
        let mut s = Setup::new(&[0.8, 0.7]);
        for _ in 0..5 {
            s.races.choose_winner(&s.config, 0.0, true);
        }
        s.races.races[1].health = 0.95;
        let changes: Vec<_> = (0..5).map(|_| s.races.choose_winner(&s.config, 0.0, true).is_some()).collect();
        // 5 to 0, 4 to 1, 3 to 2, 2 to 3
        assert_eq!(changes, [false, false, true, false, false]);
    }

    #[test]
    fn races_share_the_exploiters_equally() {
        let mut s = Setup::new(&[]);
        s.config.num_exploiters = 60;
        s.config.max_exploiters = 120;
        let mut sizes = Vec::new();
        for x in [0.0, 2.0, 4.0, 6.0] {
            s.offer(x, 0.9);
            s.races.evolve(&s.config, &mut s.rng, &mut Vec::new());
            assert!(s.races.iter().all(|race| race.exploiters.len() == s.races.races[0].exploiters.len()));
            sizes.push(s.races.races[0].exploiters.len());
        }
        assert_eq!(sizes, [60, 60, 40, 30]);
        s.races.races.truncate(1);
        s.races.evolve(&s.config, &mut s.rng, &mut Vec::new());
        assert_eq!(s.races.races[0].exploiters.len(), 60, "the one that is left grows");
    }
}
