//! Which half of a symmetric map the robot is in.

use visloc_core::Timestamp;

use super::{
    joint::Joint,
    mate::{KNOWN, Mate},
    message::Root,
    symmetry::Symmetry,
};

/// Sightings tie the halves of two robots if they make one of both combinations so probable. Each pair is asked with every message, and one
/// wrong answer drags a robot, so this is far more than what makes a robot's own half known.
const TIED: f64 = 0.999;
/// A robot that is so probably elsewhere than it says, or makes up what it sees, has no say.
const DISTRUSTED: f64 = KNOWN;
/// From this probability on it supports nobody, but may contradict.
const DOUBTFUL: f64 = 0.5;

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
    /// Probabilities of every robot's options with all claims.
    claimed: Vec<Vec<f64>>,
    /// Probabilities of every robot's options by claims and sightings.
    posterior: Vec<Vec<f64>>,
    /// Of each robot: weights of the two sides of the own first track together with each of its options.
    pairs: Vec<Vec<[f64; 2]>>,
    /// Of each robot: probability that it is not where it says or makes up what it sees.
    doubts: Vec<f64>,
}

/// What a robot says about the own half.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Vote {
    root: Root,
    /// The side of the own first track that it speaks for; `None` while sightings do not tie the robot to this one.
    side: Option<usize>,
    /// Whether the robot knows by itself.
    is_first_hand: bool,
    /// Whether it trusts its place; else it may contradict, but not support.
    is_trusted: bool,
    /// Whether it has lost its place for a moment, or not found it yet.
    is_absent: bool,
}

/// When a half is decided.
#[derive(Debug, Clone, Copy)]
pub(super) struct Terms {
    /// From this probability on; `None` while nothing is to be decided.
    pub decided: Option<f64>,
    /// Probability that a robot neither errs nor lies.
    pub honesty: f64,
    /// Now.
    pub at: Timestamp,
}

/// Counts votes.
struct Poll<'a>(&'a [Vote]);

impl Poll<'_> {
    fn supporters(&self, side: usize) -> usize {
        self.0.iter().filter(|vote| vote.is_trusted && vote.side == Some(side)).count()
    }

    /// Who contradicts, and who has not been seen yet and may contradict; with those that are absent, or without.
    fn opponents(&self, side: usize, with_absent: bool) -> usize {
        let opposes = |vote: &&Vote| vote.side != Some(side);
        self.0.iter().filter(|vote| with_absent || !vote.is_absent).filter(opposes).count()
    }

    /// One that supports a side, rather one that knows by itself.
    fn root(&self, side: usize) -> Option<Root> {
        let supports = |vote: &&Vote| vote.is_trusted && vote.side == Some(side);
        self.0.iter().filter(supports).max_by_key(|vote| vote.is_first_hand).map(|vote| vote.root)
    }
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
        terms: &Terms,
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
        self.sum_pairs(joint, robots, own, terms.honesty);
        let votes = self.votes(robots, own, terms.at);
        self.take_relays(robots, &votes);
        self.sum_posterior(joint);
        let poll = Poll(&votes);
        let sides = [self.posterior[own][1], self.posterior[own][2]];
        for side in [0, 1] {
            let share = sides[side] / (sides[0] + sides[1]);
            let is_outvoted = poll.supporters(side) <= poll.opponents(side, true);
            let root = poll
                .root(side)
                .filter(|_| terms.decided.is_some_and(|decided| share >= decided) && !is_outvoted);
            if let Some(root) = root {
                self.half = Some(Half { id: track.id, side, share, root });
                return;
            }
        }
        // A half once decided stays while nobody speaks against it: the one that knew may have left.
        self.half = self.half.filter(|half| {
            let opponents = poll.opponents(half.side, false);
            opponents == 0 || poll.supporters(half.side) > opponents
        });
    }

    /// The robots whose claims tell something about the own half.
    fn votes(&self, robots: &[&Mate], own: usize, at: Timestamp) -> Vec<Vote> {
        let mut votes: Vec<Vote> = Vec::new();
        for (index, robot) in robots.iter().enumerate() {
            let claim = robot.claim().filter(|_| index == own || !self.is_doubted(index, DISTRUSTED));
            if claim.is_none() && (index == own || !robot.is_absent(at)) {
                continue;
            }
            let side = claim.and_then(|claim| match index == own {
                true => Some(claim.side),
                false => self.tied_side(index, 1 + claim.side),
            });
            votes.push(Vote {
                root: robot.root(),
                side,
                is_first_hand: true,
                is_trusted: claim.is_some_and(|claim| claim.is_trusted) && !self.is_doubted(index, DOUBTFUL),
                is_absent: claim.is_none(),
            });
        }
        // A half that others have decided; told by many it is still one vote, of the one that knew.
        for (index, robot) in robots.iter().enumerate().filter(|(index, _)| *index != own) {
            let is_heard = robot.claim().is_none() && !self.is_doubted(index, DOUBTFUL);
            let Some(told) = robot.half.filter(|_| is_heard) else { continue };
            let option = robot
                .belief
                .tracks
                .first()
                .filter(|track| track.id == told.id & !1)
                .map(|_| 1 + usize::from(told.id % 2));
            let Some(side) = option.and_then(|option| self.tied_side(index, option)) else { continue };
            match votes.iter_mut().find(|vote| vote.root == told.root && !vote.is_absent) {
                // What others have of it contradicts it, so some tie is wrong.
                Some(vote) => vote.side = vote.side.filter(|said| *said == side),
                None => votes.push(Vote {
                    root: told.root,
                    side: Some(side),
                    is_first_hand: false,
                    is_trusted: true,
                    is_absent: false,
                }),
            }
        }
        votes
    }

    /// Whether the sightings say with this probability or more that a robot is not where it says or makes up what it sees.
    fn is_doubted(&self, index: usize, from: f64) -> bool {
        self.doubts.get(index).is_some_and(|share| *share >= from)
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
            let Some(told) = robot.half.filter(|_| robot.claim().is_none()) else { continue };
            let is_vote = |vote: &Vote| vote.root == told.root && !vote.is_first_hand && vote.side.is_some();
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
    fn sum_pairs(&mut self, joint: &mut Joint, robots: &[&Mate], own: usize, honesty: f64) {
        self.pairs.resize_with(self.claimed.len(), Vec::new);
        for (pairs, claimed) in self.pairs.iter_mut().zip(&self.claimed) {
            pairs.clear();
            pairs.resize(claimed.len(), [0.0; 2]);
        }
        self.doubts.clear();
        self.doubts.resize(self.claimed.len(), 0.0);
        let (pairs, doubts, mut total) = (&mut self.pairs, &mut self.doubts, 0.0);
        let neutral: Vec<&[f64]> = robots.iter().map(|robot| robot.neutral.as_slice()).collect();
        joint.for_each(&neutral, |options, weight| {
            total += weight;
            for (sum, _) in doubts.iter_mut().zip(options).filter(|(_, option)| **option == 0) {
                *sum += weight;
            }
            if let side @ (1 | 2) = options[own] {
                for (pairs, option) in pairs.iter_mut().zip(options) {
                    pairs[*option][side - 1] += weight;
                }
            }
        });
        for (doubt, robot) in doubts.iter_mut().zip(robots) {
            let is_here = if total > 0.0 { 1.0 - *doubt / total } else { 1.0 };
            *doubt = 1.0 - is_here * (1.0 - robot.doubt.probability(honesty));
        }
    }

    fn sum_posterior(&mut self, joint: &mut Joint) {
        self.posterior.resize_with(self.claimed.len(), Vec::new);
        for (posterior, claimed) in self.posterior.iter_mut().zip(&self.claimed) {
            posterior.clear();
            posterior.resize(claimed.len(), 0.0);
        }
        let (posterior, mut total) = (&mut self.posterior, 0.0);
        let claimed: Vec<&[f64]> = self.claimed.iter().map(Vec::as_slice).collect();
        joint.for_each(&claimed, |options, weight| {
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
