//! One robot of the team, as far as its messages tell.

use nalgebra::{Matrix3, Vector3};
use visloc_core::Timestamp;

use super::{
    TeamConfig,
    belief::{Belief, Place, Spare, Track},
    clock::ClockOffset,
    joint::MAX_DIFFERENCE,
    message::{Root, Sighting, SightingKind, TeamMessage, ToldHalf, ToldHypothesis},
    names::MAX_TRACKS,
    outbox::{is_same_thing, turned},
    symmetry::{Symmetry, mirrored_covariance},
};

/// No place is known better than this, whatever is claimed: 1 cm and half a degree.
const LEAST_M: f64 = 0.01;
const LEAST_RAD: f64 = 0.009;
/// So many messages may come at once after a while of silence; beyond that, and beyond so many times the usual rate, they are left out.
const BURST: f64 = 10.0;
const MAX_RATE: f64 = 3.0;

/// What a start or a map tells makes a side more probable than this; where the robot was last does not.
pub(super) const KNOWN: f64 = 0.95;

/// Something that was seen a moment ago.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    pub sighting: Sighting,
    /// Probability that it was not seen for the first time.
    pub again: f64,
    /// How much of what it says has counted, 0 to 1.
    pub counted: f64,
}

/// One robot: a teammate, or oneself.
#[derive(Debug, Clone, Default)]
pub(super) struct Mate {
    pub number: u8,
    pub session: u32,
    pub sequence: u32,
    /// Sessions before this one.
    past_sessions: Vec<u32>,
    /// When its last message arrived, by the own clock.
    pub heard_at: Timestamp,
    /// When its first message of this session arrived, and the last one in which it knew its half and trusted its place.
    since: Option<Timestamp>,
    claimed_at: Option<Timestamp>,
    allowance: f64,
    pub clock: ClockOffset,
    pub belief: Belief,
    pub half: Option<ToldHalf>,
    /// What it told last of what it sees, in its frame at `seen_from`.
    pub sightings: Vec<Sighting>,
    pub seen_from: Timestamp,
    /// Its last sighting of each thing that there is one of, and the time of the frame that this is in.
    singles: Vec<(Sighting, Timestamp)>,
    /// What it has seen of late, in its frame at a time.
    pub weighed: Vec<Seen>,
    pub weighed_from: Timestamp,
    /// Time between its last two messages, or images, seconds.
    pub looked_secs: f64,
    /// Whether it makes them up.
    pub doubt: Doubt,
    /// Probabilities of its options by what it says, and the same if nobody knew a half.
    pub priors: Vec<f64>,
    pub neutral: Vec<f64>,
}

impl Mate {
    /// A robot of which nothing is known.
    pub fn new(number: u8, session: u32) -> Self {
        Self { number, session, allowance: BURST, ..Self::default() }
    }

    pub fn root(&self) -> Root {
        Root { number: self.number, session: self.session }
    }

    /// Whether one more message at a time is not too many.
    pub fn admits(&mut self, arrived: Timestamp, config: &TeamConfig) -> bool {
        let secs = arrived.secs_since(self.heard_at).clamp(0.0, BURST);
        self.allowance = (self.allowance + secs * MAX_RATE * config.messages_per_sec).min(BURST);
        let is_admitted = self.allowance >= 1.0;
        self.allowance -= if is_admitted { 1.0 } else { 0.0 };
        is_admitted
    }

    /// Whether a message is one that was heard already, or older than the newest one.
    pub fn has_heard(&self, message: &TeamMessage) -> bool {
        if message.session == self.session {
            return message.sequence <= self.sequence || message.at <= self.belief.at;
        }
        self.past_sessions.contains(&message.session)
    }

    /// Whether a message comes from another robot of the same number: of one that has started anew nothing is on its way for so long.
    pub fn is_another(&self, message: &TeamMessage, arrived: Timestamp) -> bool {
        const MAX_DELAY_SECS: f64 = 2.0;
        self.past_sessions.contains(&message.session)
            && self.since.is_some_and(|since| arrived.secs_since(since) > MAX_DELAY_SECS)
    }

    /// Takes in a message.
    pub fn hear(&mut self, message: &TeamMessage, arrived: Timestamp, symmetry: Symmetry) {
        const MAX_SESSIONS: usize = 8;
        if message.session != self.session {
            let mut past_sessions = std::mem::take(&mut self.past_sessions);
            past_sessions.push(self.session);
            if past_sessions.len() > MAX_SESSIONS {
                past_sessions.remove(0);
            }
            *self = Self {
                past_sessions,
                allowance: self.allowance,
                belief: Belief { tracks: std::mem::take(&mut self.belief.tracks), ..Belief::default() },
                priors: std::mem::take(&mut self.priors),
                ..Self::new(self.number, message.session)
            };
        }
        self.sequence = message.sequence;
        self.heard_at = arrived;
        self.clock.hear(message.at, arrived);
        self.belief.at = message.at;
        self.belief.reliability = message.reliability;
        if let Some(odometry) = message.odometry {
            self.belief.motion.push(message.at, odometry);
        }
        tracks_of(&message.hypotheses, symmetry, &mut self.belief.tracks);
        self.since.get_or_insert(arrived);
        if self.claim().is_some_and(|claim| claim.is_trusted) {
            self.claimed_at = Some(arrived);
        }
        self.half = message.half;
        self.sightings.clone_from(&message.sightings);
        self.looked_secs = message.at.secs_since(self.seen_from);
        self.seen_from = message.at;
    }

    /// Takes in what it sees now, and keeps what it has seen for so long, seconds. What was seen once, ball or person, is none yet.
    pub fn remember(&mut self, seen: &[Seen], secs: f64) {
        let (step, _) = self.belief.motion.between(self.weighed_from, self.seen_from);
        let back = step.inverse();
        let is_over = |old: &Seen, new: &Seen| {
            new.sighting.at.secs_since(old.sighting.at) > secs || is_same_thing(&old.sighting, &new.sighting)
        };
        self.weighed.iter_mut().for_each(|old| old.sighting = turned(&old.sighting, &back));
        self.weighed.retain(|old| !seen.iter().any(|new| is_over(old, new)));
        self.weighed.extend_from_slice(seen);
        self.weighed_from = self.seen_from;
        for kind in SightingKind::SINGLE {
            let is_it = |seen: &&Seen| seen.sighting.kind == kind && seen.again >= 0.5;
            if let Some(new) = seen.iter().rfind(is_it) {
                self.singles.retain(|(old, _)| old.kind != kind);
                self.singles.push((new.sighting, self.seen_from));
            }
        }
    }

    /// Its last sighting of a thing that there is one of, and the time of the frame that this is in.
    pub fn single(&self, kind: SightingKind) -> Option<&(Sighting, Timestamp)> {
        self.singles.iter().find(|(sighting, _)| sighting.kind == kind)
    }

    /// Brings the probabilities of its options up to date. A robot that is sure may be wrong about its half or lie: that is `1 - honesty`.
    pub fn weigh_options(&mut self, symmetry: Symmetry, honesty: f64) {
        self.belief.priors(symmetry, honesty, &mut self.priors);
        self.neutral.clone_from(&self.priors);
        if symmetry != Symmetry::None {
            for sides in self.neutral[1..].chunks_exact_mut(2) {
                sides.fill(0.5 * (sides[0] + sides[1]));
            }
        }
    }

    /// Where it is by one of its options, at a time of its own clock.
    pub fn place(&self, option: usize, at: Timestamp, symmetry: Symmetry, spare: &Spare) -> Option<Place> {
        self.belief.place(option, at, symmetry, spare)
    }

    /// Whether it knew its half and its place a moment ago, or has not found its place yet: it may soon contradict.
    pub fn is_absent(&self, at: Timestamp) -> bool {
        /// Who has not found its place for so long may never find it, seconds.
        const ABSENT_SECS: f64 = 10.0;
        let is_recent =
            |moment: Option<Timestamp>| moment.is_some_and(|moment| at.secs_since(moment) < ABSENT_SECS);
        let claim = self.claim();
        let is_trusted = claim.is_some_and(|claim| claim.is_trusted);
        let may_know = claim.is_some() || self.belief.tracks.is_empty();
        !is_trusted && (is_recent(self.claimed_at) || may_know && is_recent(self.since))
    }

    /// The side of its first track that it knows by itself, and whether it trusts the place.
    pub fn claim(&self) -> Option<Claim> {
        const TRUSTED: f64 = 0.5;
        let track = self.belief.tracks.first()?;
        let share = track.shares[0] / (track.shares[0] + track.shares[1]);
        let side = usize::from(share < 0.5);
        let is_known = share.max(1.0 - share) >= KNOWN;
        is_known.then_some(Claim { side, is_trusted: self.belief.reliability > TRUSTED })
    }
}

/// Whether a robot makes up what it sees, or its detector is at fault: then its sightings of late are explained by nobody where others are.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Doubt {
    log_odds: f64,
}

impl Doubt {
    /// Takes in a sighting, given its density if it is made up and if it is of anything.
    pub fn weigh(&mut self, invented: f64, of_anything: f64, weight: f64) {
        let change = weight * (invented / of_anything).ln();
        self.log_odds = (self.log_odds + change).clamp(-MAX_DIFFERENCE, MAX_DIFFERENCE);
    }

    /// Takes in that it has looked: who makes nothing up sees so many fewer. Having seen nothing clears of a doubt, but earns no trust.
    pub fn look(&mut self, num_fewer: f64) {
        self.log_odds -= num_fewer.min(self.log_odds.max(0.0));
    }

    /// What was said longer ago counts less: `kept` is 0 to 1.
    pub fn forget(&mut self, kept: f64) {
        self.log_odds *= kept;
    }

    /// Probability of it, given how honest robots are.
    pub fn probability(self, honesty: f64) -> f64 {
        let others = honesty / (1.0 - honesty);
        1.0 / (1.0 + others * (-self.log_odds).exp())
    }
}

/// What a robot says about its half.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Claim {
    /// The even hypothesis of its first track (0) or the mirrored one (1).
    pub side: usize,
    /// Whether it trusts its place, mirrored or not.
    pub is_trusted: bool,
}

/// Tracks of the hypotheses in a message. Covariances that are too small to be true are made larger.
fn tracks_of(told: &[ToldHypothesis], symmetry: Symmetry, out: &mut Vec<Track>) {
    let least = Matrix3::from_diagonal(&Vector3::new(LEAST_M.powi(2), LEAST_M.powi(2), LEAST_RAD.powi(2)));
    out.clear();
    for hypothesis in told {
        let side = if symmetry == Symmetry::None { 0 } else { usize::from(hypothesis.id % 2 == 1) };
        let id = if side == 1 { hypothesis.id - 1 } else { hypothesis.id };
        if let Some(track) = out.iter_mut().find(|track| track.id == id) {
            track.shares[side] += hypothesis.probability;
            continue;
        }
        if out.len() == MAX_TRACKS {
            continue;
        }
        let told = (hypothesis.world_from_robot, hypothesis.covariance + least);
        let (world_from_robot, covariance) = match symmetry.mirrored(&told.0) {
            Some(mirrored) if side == 1 => (mirrored, mirrored_covariance(&told.1)),
            _ => told,
        };
        let mut shares = [0.0; 2];
        shares[side] = hypothesis.probability;
        out.push(Track { id, world_from_robot, covariance, shares });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_sees_what_nobody_explains_is_doubted() {
        let (honesty, invented) = (0.9, 0.05);
        let mut doubt = Doubt::default();
        assert!((doubt.probability(honesty) - 0.1).abs() < 1e-9);
        (0..20).for_each(|_| doubt.look(0.2));
        assert!((doubt.probability(honesty) - 0.1).abs() < 1e-9, "having seen nothing earns no trust");
        (0..20).for_each(|_| doubt.weigh(invented, 0.003, 0.2));
        assert!(doubt.probability(honesty) > 0.99);
        (0..40).for_each(|_| doubt.weigh(invented, 5.0, 0.2));
        assert!(doubt.probability(honesty) < 0.01, "what is explained earns it");
        // Some false ones among many images are no reason to doubt.
        for image in 0..400 {
            doubt.look(0.16);
            if image % 20 == 0 {
                doubt.weigh(invented, 0.003, 0.2);
            }
            doubt.forget(0.995);
        }
        assert!(doubt.probability(honesty) < 0.3);
    }
}
