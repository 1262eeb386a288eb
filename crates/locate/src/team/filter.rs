//! One robot's view of its team.

use visloc_core::{Timestamp, geom::PlanarPose, settings::check_ranges};
use visloc_world::Map;

use super::{
    TeamConfig,
    answer::{Help, MateView, TeamEstimate},
    belief::Spare,
    decision::{Decision, Terms},
    evidence::{Scene, SightingModel},
    joint::{Factor, Joint, MAX_COMBINATIONS, Variable},
    mate::{Mate, Seen},
    message::{
        Ignored, MAX_MATES, Member, Sighting, SightingKind, TEAM_MESSAGE_VERSION, TeamMessage, ToldHalf,
    },
    names::Names,
    outbox::{Outbox, turned},
    placement::{Placement, Search},
    symmetry::Symmetry,
};
use crate::{ConfigError, Estimate, PosePrior, StartPrior, estimate::LOST_RELIABILITY};

/// It is told where to look when it has been lost for so long, and not again for some time, seconds: a localizer that finds by itself where it
/// was put down is not to be disturbed, and what others saw before that is forgotten.
const LOST_SECS: f64 = 3.0;
const ADVICE_SECS: f64 = 3.0;
/// Nothing is decided before others have had so long to contradict: they have to find their places first, seconds.
const LISTENING_SECS: f64 = 2.0;
/// Where to look is told if others see the robot there with this probability.
const ADVICE_PROBABILITY: f64 = 0.5;

/// Joins what the robots of a team tell each other, for one of them.
#[derive(Debug)]
pub struct TeamFilter {
    config: TeamConfig,
    member: Member,
    symmetry: Symmetry,
    scene: Scene,
    own: Mate,
    names: Names,
    mates: Vec<Mate>,
    joint: Joint,
    factor: Factor,
    decision: Decision,
    outbox: Outbox,
    seen: Vec<Sighting>,
    placement: Option<Placement>,
    lost_since: Option<Timestamp>,
    /// When the first message came.
    heard_since: Option<Timestamp>,
    advised_at: Option<Timestamp>,
    answer: TeamEstimate,
}

impl TeamFilter {
    /// A robot that has heard of nobody.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn new(config: TeamConfig, member: Member, map: &Map) -> Result<Self, ConfigError> {
        check_ranges(&config)?;
        let own = Mate::new(member.number, member.session);
        Ok(Self {
            symmetry: Symmetry::of(map),
            scene: Scene::new(area_m2(map), &config),
            config,
            member,
            own,
            names: Names::default(),
            mates: Vec::new(),
            joint: Joint::default(),
            factor: Factor::default(),
            decision: Decision::default(),
            outbox: Outbox::default(),
            seen: Vec::new(),
            placement: None,
            lost_since: None,
            heard_since: None,
            advised_at: None,
            answer: TeamEstimate { estimate: Estimate::unknown(), help: Help::Alone },
        })
    }

    /// Takes in a message of another robot, which arrived at a time of the own clock.
    ///
    /// # Errors
    /// Why it was left out; nothing has changed then.
    pub fn receive(&mut self, message: &TeamMessage, arrived: Timestamp) -> Result<(), Ignored> {
        if message.version != TEAM_MESSAGE_VERSION {
            return Err(Ignored::Version(message.version));
        }
        if message.team != self.member.team {
            return Err(Ignored::OtherTeam);
        }
        if message.number == self.member.number {
            return Err(Ignored::OwnNumber);
        }
        if let Some(fault) = message.fault() {
            return Err(Ignored::Fault(fault));
        }
        let index = match self.mates.iter().position(|mate| mate.number == message.number) {
            Some(index) if self.mates[index].is_another(message, arrived) => {
                return Err(Ignored::SameNumber(message.number));
            }
            Some(index) if self.mates[index].has_heard(message) => return Err(Ignored::Old),
            Some(index) => index,
            None if self.mates.len() == MAX_MATES => return Err(Ignored::TooMany),
            None => {
                self.mates.push(Mate::new(message.number, message.session));
                self.mates.len() - 1
            }
        };
        if !self.mates[index].admits(arrived, &self.config) {
            return Err(Ignored::TooMany);
        }
        self.mates[index].hear(message, arrived, self.symmetry);
        self.heard_since.get_or_insert(arrived);
        self.enter(Some(index));
        self.weigh_sightings(Some(index));
        Ok(())
    }

    /// Takes in the estimate of the own localizer after an image, the odometry, and what a detector saw, which may be late. `at` is the stamp
    /// of the image by the own clock, which must be the one of the times of arrival.
    pub fn step(
        &mut self,
        at: Timestamp,
        estimate: &Estimate,
        odometry: Option<PlanarPose>,
        sightings: &[Sighting],
    ) -> &TeamEstimate {
        let before = self.own.belief.at;
        let odometry = odometry.unwrap_or_default();
        self.own.belief.motion.push(at, odometry);
        self.own.belief.at = at;
        self.own.belief.reliability = estimate.reliability_up_to_symmetry;
        self.names.tracks(estimate, self.symmetry, &odometry, at, &mut self.own.belief.tracks);
        self.see(before, at, sightings);
        self.answer.estimate.clone_from(estimate);
        self.answer.help = Help::Alone;
        self.part_from_silent(at);
        if self.mates.is_empty() {
            self.decision.keep(self.own.belief.tracks.first().map(|track| track.id));
            (self.placement, self.lost_since) = (None, None);
            self.help();
            return &self.answer;
        }
        self.enter(None);
        let secs = at.secs_since(before).clamp(0.0, self.config.forget_secs);
        let kept = 0.5_f64.powf(secs / self.config.forget_secs);
        self.joint.forget(kept);
        self.own.doubt.forget(kept);
        self.mates.iter_mut().for_each(|mate| mate.doubt.forget(kept));
        self.weigh_sightings(None);
        self.decide(at);
        self.help();
        &self.answer
    }

    /// Who this robot is.
    pub fn member(&self) -> &Member {
        &self.member
    }

    /// The same between two of its starts.
    #[cfg(test)]
    pub(super) fn own_root(&self) -> super::message::Root {
        self.own.root()
    }

    /// The answer of the last step.
    pub fn answer(&self) -> &TeamEstimate {
        &self.answer
    }

    /// What to tell the others, if it is time for it.
    pub fn message(&mut self) -> Option<TeamMessage> {
        let half = self
            .decision
            .half()
            .map(|half| ToldHalf { id: half.id + u16::from(half.side == 1), root: half.root });
        self.outbox.message(&self.own, half, &self.member, self.symmetry, &self.config)
    }

    /// Where the localizer should look for the robot, which is lost: where others see it. On a symmetric map both mirrored places are told,
    /// so that what the localizer finds stays its own knowledge.
    pub fn advice(&mut self) -> Option<StartPrior> {
        let at = self.own.belief.at;
        let is_long = |since: Timestamp| at.secs_since(since) >= LOST_SECS;
        let is_new = |advised: Timestamp| at.secs_since(advised) >= ADVICE_SECS;
        if !self.lost_since.is_some_and(is_long) || !self.advised_at.is_none_or(is_new) {
            return None;
        }
        let placement = self.placement.filter(|placement| placement.probability >= ADVICE_PROBABILITY)?;
        self.advised_at = Some(at);
        let prior = |world_from_robot: PlanarPose| PosePrior {
            world_from_robot,
            position_spread_m: placement.spread_m(),
            heading_spread_rad: placement.heading_spread_rad(),
            weight: 1.0,
        };
        let pose = placement.pose();
        let mirrored = self.symmetry.mirrored(&pose);
        Some(StartPrior::Poses(std::iter::once(pose).chain(mirrored).map(prior).collect()))
    }

    /// All teammates that are heard, in the order in which they came.
    pub fn mates(&self) -> impl Iterator<Item = MateView> + '_ {
        self.mates.iter().map(|mate| {
            let shares = self.joint.find(mate.number).and_then(|index| self.decision.posterior(index));
            let best =
                shares.and_then(|shares| (1..shares.len()).max_by(|a, b| shares[*a].total_cmp(&shares[*b])));
            let place =
                best.and_then(|option| mate.place(option, mate.belief.at, self.symmetry, &self.spare()));
            let honesty = 1.0 - mate.doubt.probability(self.config.honesty);
            MateView {
                number: mate.number,
                world_from_robot: place.map(|place| place.pose),
                trust: shares.map_or(0.0, |shares| honesty * (1.0 - shares[0])),
                heard_at: mate.heard_at,
            }
        })
    }

    fn spare(&self) -> Spare {
        Spare { robot_m_per_s: self.config.robot_m_per_s, clock_secs: self.config.clock_secs }
    }

    /// The own sightings, in the frame of the robot now.
    fn see(&mut self, before: Timestamp, at: Timestamp, sightings: &[Sighting]) {
        self.seen.clear();
        for sighting in sightings.iter().filter(|s| s.is_valid()) {
            let (step, _) = self.own.belief.motion.between(sighting.at, at);
            self.seen.push(turned(sighting, &step.inverse()));
        }
        let (step, _) = self.own.belief.motion.between(before, at);
        self.outbox.collect(at, &self.seen, &step);
        self.own.sightings.clone_from(&self.seen);
        self.own.seen_from = at;
        self.own.looked_secs = at.secs_since(before);
    }

    /// Forgets robots that have been silent for long.
    fn part_from_silent(&mut self, at: Timestamp) {
        let (joint, silence_secs) = (&mut self.joint, self.config.silence_secs);
        self.mates.retain(|mate| {
            let is_there = at.secs_since(mate.heard_at) <= silence_secs;
            if !is_there {
                joint.remove(mate.number, &mate.priors);
            }
            is_there
        });
    }

    /// Brings the options of a teammate, or of this robot, up to date.
    fn enter(&mut self, index: Option<usize>) {
        let others: usize = self
            .joint
            .variables()
            .iter()
            .filter(|variable| variable.number != index.map_or(self.own.number, |i| self.mates[i].number))
            .map(Variable::num_options)
            .product();
        let robot = index.map_or(&mut self.own, |index| &mut self.mates[index]);
        // The more robots the fewer hypotheses of each.
        while others * robot.belief.num_options(self.symmetry) > MAX_COMBINATIONS {
            if robot.belief.tracks.pop().is_none() {
                break;
            }
        }
        let ids = robot.belief.ids(self.symmetry).collect();
        let variable = Variable { number: robot.number, session: robot.session, ids };
        self.joint.set(&variable, &robot.priors);
        // The own knowledge is not doubted by half as much as what others say.
        let wrong = 1.0 - self.config.honesty;
        let honesty = match index {
            None => 1.0 - 0.5 * wrong,
            // Who makes up what it sees makes up its place, too.
            Some(_) => self.config.honesty.min(1.0 - robot.doubt.probability(self.config.honesty)),
        };
        robot.weigh_options(self.symmetry, honesty);
    }

    /// A teammate, or this robot.
    fn robot_mut(&mut self, index: Option<usize>) -> &mut Mate {
        match index {
            Some(index) => &mut self.mates[index],
            None => &mut self.own,
        }
    }

    /// All robots in the order of the joint, and the place of this one.
    fn robots(&self, joint: &Joint) -> (Vec<&Mate>, usize) {
        let find = |number: u8| self.mates.iter().find(|mate| mate.number == number).unwrap_or(&self.own);
        let robots = joint.variables().iter().map(|variable| find(variable.number)).collect();
        (robots, joint.find(self.own.number).unwrap_or(0))
    }

    /// Counts the newest sightings of a teammate, or of this robot.
    fn weigh_sightings(&mut self, index: Option<usize>) {
        let TeamConfig { messages_per_sec, correlation_secs, detection, .. } = self.config;
        let robot = self.robot_mut(index);
        // Messages that were lost may have told of more.
        let looked = robot.looked_secs.clamp(0.0, 1.0 / messages_per_sec) / correlation_secs;
        robot.doubt.look(detection * looked);
        let robot = index.map_or(&self.own, |index| &self.mates[index]);
        if robot.sightings.is_empty() || self.joint.variables().len() < 2 {
            return;
        }
        let mut joint = std::mem::take(&mut self.joint);
        let mut factor = std::mem::take(&mut self.factor);
        let (robots, _) = self.robots(&joint);
        let observer = joint.find(robot.number).unwrap_or(0);
        let model = SightingModel {
            robots: &robots,
            observer,
            symmetry: self.symmetry,
            scene: &self.scene,
            spare: self.spare(),
            ball_m_per_s: self.config.ball_m_per_s,
        };
        let priors: Vec<&[f64]> = robots.iter().map(|robot| robot.neutral.as_slice()).collect();
        let (mut doubt, mut seen) = (robot.doubt, Vec::new());
        for sighting in robot.sightings.iter().filter(|s| s.kind != SightingKind::Opponent) {
            let mut counted = 0.0;
            if model.densities(sighting, &mut factor) {
                for case in factor.cases.iter().filter(|case| case.share > 0.0) {
                    let of_anything = joint.weigh(observer, &factor, case, &priors);
                    doubt.weigh(factor.invented + case.same, of_anything, looked * case.share);
                }
                counted = factor.again;
            }
            seen.push(Seen { sighting: *sighting, again: factor.again, counted });
        }
        (self.joint, self.factor) = (joint, factor);
        let robot = self.robot_mut(index);
        robot.doubt = doubt;
        robot.remember(&seen, correlation_secs);
    }

    /// Decides the half, and looks for this robot in what others see if it does not know its place.
    fn decide(&mut self, at: Timestamp) {
        let mut decision = std::mem::take(&mut self.decision);
        let mut joint = std::mem::take(&mut self.joint);
        let (robots, own) = self.robots(&joint);
        let has_listened = self.heard_since.is_some_and(|since| at.secs_since(since) >= LISTENING_SECS);
        let decided = has_listened.then_some(self.config.decided);
        let terms = Terms { decided, honesty: self.config.honesty, at };
        decision.update(&mut joint, &robots, own, self.symmetry, &terms);
        let is_lost = self.own.belief.tracks.is_empty() || self.own.belief.reliability < LOST_RELIABILITY;
        self.placement = is_lost
            .then(|| {
                let search = Search {
                    robots: &robots,
                    own,
                    posterior: &|index| decision.posterior(index),
                    symmetry: self.symmetry,
                    scene: &self.scene,
                    spare: &self.spare(),
                    at,
                    seen: &self.seen,
                };
                search.run()
            })
            .flatten();
        self.lost_since = if is_lost { self.lost_since.or(Some(at)) } else { None };
        self.joint = joint;
        self.decision = decision;
    }

    /// Puts what the team knows into the answer.
    fn help(&mut self) {
        let track = self.own.belief.tracks.first();
        if let (Some(half), Some(track)) = (self.decision.half(), track) {
            self.answer.take_half(&half, track, self.symmetry);
        } else if let Some(placement) = self.placement.filter(|_| self.answer.estimate.hypotheses.is_empty())
        {
            self.answer.take_placement(&placement, self.symmetry);
        }
    }
}

/// Where robots can be, square meters.
fn area_m2(map: &Map) -> f64 {
    match map {
        Map::Field(field) => {
            let (half_x_m, half_y_m) = field.half_carpet_m();
            4.0 * half_x_m * half_y_m
        }
        _ => BUILDING_M2,
    }
}

/// Floor of a building, square meters: only how rare chance meetings are depends on it.
const BUILDING_M2: f64 = 200.0;
