//! Which half of a symmetric map the robot is in.

use super::{joint::Joint, mate::Mate, message::Root, symmetry::Symmetry};

/// Sightings tie the halves of two robots if they make one of both combinations so probable.
const TIED: f64 = 0.9;

/// A half that was decided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Half {
    /// Name of the track.
    pub id: u16,
    /// Its even (0) or its mirrored hypothesis (1).
    pub side: usize,
    /// Probability of that side.
    pub share: f64,
    /// Who knew.
    pub root: Root,
}

/// Joins what all robots claim about their halves.
#[derive(Debug, Clone, Default)]
pub(super) struct Decision {
    half: Option<Half>,
    /// Probabilities of every robot's options if nobody knew a half.
    neutral: Vec<Vec<f64>>,
    /// Probabilities of every robot's options with all claims.
    claimed: Vec<Vec<f64>>,
    /// Probabilities of every robot's options by claims and sightings.
    posterior: Vec<Vec<f64>>,
    /// Of each robot: weights of the two sides of the own first track together with each of its options.
    pairs: Vec<Vec<[f64; 2]>>,
}

/// What a robot says about the own half.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Vote {
    root: Root,
    /// The side of the own first track that it speaks for; `None` while sightings do not tie the robot to this one.
    side: Option<usize>,
    /// Whether the robot knows by itself.
    is_first_hand: bool,
}

impl Decision {
    pub fn half(&self) -> Option<Half> {
        self.half
    }

    /// Nobody is heard: what was decided stays while the robot follows the same track.
    pub fn keep(&mut self, track: Option<u16>) {
        self.half = self.half.filter(|half| Some(half.id) == track);
        self.posterior.clear();
    }

    /// Probabilities of the options of the robot in this place of the joint, as of the last [`Decision::update`].
    pub fn posterior(&self, index: usize) -> Option<&[f64]> {
        self.posterior.get(index).map(Vec::as_slice)
    }

    /// Takes in what all say. `robots` are in the order of the joint, and `own` is the own place among them.
    pub fn update(
        &mut self,
        joint: &mut Joint,
        robots: &[&Mate],
        own: usize,
        symmetry: Symmetry,
        decided: f64,
    ) {
        self.claimed.resize_with(robots.len(), Vec::new);
        for (claimed, robot) in self.claimed.iter_mut().zip(robots) {
            claimed.clone_from(&robot.priors);
        }
        let Some(track) = robots[own].belief.tracks.first().filter(|_| symmetry != Symmetry::None) else {
            self.half = None;
            self.sum_posterior(joint);
            return;
        };
        self.half = self.half.filter(|half| half.id == track.id);
        self.sum_pairs(joint, own);
        let votes = self.votes(robots, own);
        self.take_relays(robots, &votes);
        self.sum_posterior(joint);
        let count = |side: usize| votes.iter().filter(|vote| vote.side == Some(side)).count();
        let num_open = votes.iter().filter(|vote| vote.side.is_none() && vote.is_first_hand).count();
        let sides = [self.posterior[own][1], self.posterior[own][2]];
        for side in [0, 1] {
            let share = sides[side] / (sides[0] + sides[1]);
            // Who has not been seen yet may contradict.
            if count(side) > count(1 - side) + num_open && share >= decided {
                let supports = |vote: &&Vote| vote.side == Some(side);
                let Some(vote) = votes.iter().filter(supports).max_by_key(|vote| vote.is_first_hand) else {
                    continue;
                };
                self.half = Some(Half { id: track.id, side, share, root: vote.root });
                return;
            }
        }
        // A half once decided stays while nobody speaks against it: the one that knew may have left.
        self.half = self.half.filter(|half| {
            let against = count(1 - half.side);
            against == 0 || count(half.side) > against
        });
    }

    /// The robots whose claims tell something about the own half.
    fn votes(&self, robots: &[&Mate], own: usize) -> Vec<Vote> {
        let me = robots[own].root();
        let mut votes: Vec<Vote> = Vec::new();
        for (index, robot) in robots.iter().enumerate() {
            let Some(side) = robot.known_side() else { continue };
            let spoken_for = if index == own { Some(side) } else { self.tied_side(index, 1 + side) };
            votes.push(Vote { root: robot.root(), side: spoken_for, is_first_hand: true });
        }
        // A half that was decided by one that is no longer there; told by many it is still one vote.
        for (index, robot) in robots.iter().enumerate().filter(|(index, _)| *index != own) {
            let Some(told) = robot.half.filter(|_| robot.known_side().is_none()) else { continue };
            if told.root == me || votes.iter().any(|vote| vote.root == told.root) {
                continue;
            }
            let option = robot
                .belief
                .tracks
                .first()
                .filter(|track| track.id == told.id & !1)
                .map(|_| 1 + usize::from(told.id % 2));
            if let Some(side) = option.and_then(|option| self.tied_side(index, option)) {
                votes.push(Vote { root: told.root, side: Some(side), is_first_hand: false });
            }
        }
        votes
    }

    /// The side of the own first track that goes with an option of another robot, if the sightings tell.
    fn tied_side(&self, index: usize, option: usize) -> Option<usize> {
        let weights = self.pairs.get(index)?.get(option)?;
        let total = weights[0] + weights[1];
        (0..2).find(|side| total > 0.0 && weights[*side] / total >= TIED)
    }

    /// Told halves become probabilities: one robot for each that knew, since all others repeat the same.
    fn take_relays(&mut self, robots: &[&Mate], votes: &[Vote]) {
        let mut taken: Vec<Root> = Vec::new();
        for (claimed, robot) in self.claimed.iter_mut().zip(robots) {
            let Some(told) = robot.half.filter(|_| robot.known_side().is_none()) else { continue };
            let is_vote = |vote: &Vote| vote.root == told.root && !vote.is_first_hand;
            if taken.contains(&told.root) || !votes.iter().any(is_vote) || claimed.len() < 3 {
                continue;
            }
            taken.push(told.root);
            let (right, wrong) = if told.id.is_multiple_of(2) { (1, 2) } else { (2, 1) };
            let both = claimed[1] + claimed[2];
            (claimed[right], claimed[wrong]) = (0.95 * both, 0.05 * both);
        }
    }

    /// How the own sides go together with the options of all others, by sightings alone.
    fn sum_pairs(&mut self, joint: &mut Joint, own: usize) {
        self.neutral.resize_with(self.claimed.len(), Vec::new);
        self.pairs.resize_with(self.claimed.len(), Vec::new);
        for ((neutral, pairs), claimed) in self.neutral.iter_mut().zip(&mut self.pairs).zip(&self.claimed) {
            neutral.clone_from(claimed);
            for sides in neutral[1..].chunks_exact_mut(2) {
                sides.fill(0.5 * (sides[0] + sides[1]));
            }
            pairs.clear();
            pairs.resize(claimed.len(), [0.0; 2]);
        }
        let pairs = &mut self.pairs;
        joint.for_each(&self.neutral, |options, weight| {
            if let side @ (1 | 2) = options[own] {
                for (pairs, option) in pairs.iter_mut().zip(options) {
                    pairs[*option][side - 1] += weight;
                }
            }
        });
    }

    fn sum_posterior(&mut self, joint: &mut Joint) {
        self.posterior.resize_with(self.claimed.len(), Vec::new);
        for (posterior, claimed) in self.posterior.iter_mut().zip(&self.claimed) {
            posterior.clear();
            posterior.resize(claimed.len(), 0.0);
        }
        let (posterior, mut total) = (&mut self.posterior, 0.0);
        joint.for_each(&self.claimed, |options, weight| {
            total += weight;
            for (sums, option) in posterior.iter_mut().zip(options) {
                sums[*option] += weight;
            }
        });
        if total > 0.0 {
            posterior.iter_mut().flatten().for_each(|sum| *sum /= total);
        }
    }
}
