//! Other robots of the team, over ROS 2.

use std::collections::BTreeSet;

use anyhow::{Result, ensure};
use serde::Serialize;
use visloc_core::{Clock, Timestamp, eval::TimingSummary};
use visloc_io::{
    bag::messages::to_cdr,
    ros2::{Network, TeamLink},
};
use visloc_locate::{
    Estimate, StartPrior,
    team::{Ignored, Member, Sighting, TeamConfig, TeamFilter, TeamMessage, WireSightings, WireTeamMessage},
};
use visloc_world::Map;

use super::{FrameView, Records, live::node_name};
use crate::{host, stopwatch::Stopwatch};

/// The robot among others of its team.
pub struct TeamOutput {
    filter: TeamFilter,
    /// Somebody else's detector sends sightings; until then the own one is believed.
    has_detector: bool,
    link: TeamLink<WireTeamMessage, WireSightings>,
    clock: Clock,
    started_at: Option<Timestamp>,
    now: Timestamp,
    times_ms: Records<f64>,
    sent_bytes: usize,
    num_sent: usize,
    num_heard: usize,
    num_refused: usize,
    /// Numbers that two robots have.
    twice: BTreeSet<u8>,
}

/// What the team was told and has told.
#[derive(Debug, Clone, Serialize)]
pub struct TeamReport {
    /// Other robots that are heard at the end.
    pub robots: usize,
    /// Messages that were sent.
    pub sent: usize,
    /// Their size without headers of the network, bytes for each second of the recording.
    pub bytes_per_s: f64,
    /// Messages of others.
    pub heard: usize,
    /// Those of them that could not be used.
    pub refused: usize,
    /// Numbers that two robots have; the messages of one of them are refused.
    pub numbers_twice: Vec<u8>,
    /// Time that the team took for each image, milliseconds.
    pub ms: TimingSummary,
}

impl TeamOutput {
    /// Joins the topics of a team, beside the node that publishes results.
    pub fn open(network: &Network, team: &str, number: u8, map: &Map) -> Result<Self> {
        let is_name = team.starts_with(|c: char| c.is_ascii_alphabetic())
            && team.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        ensure!(is_name, "--team: expected a letter, then letters, digits and underscores, found {team:?}");
        // Another one after each start: milliseconds of the wall clock.
        let session =
            u32::try_from(host::now().nanos() / 1_000_000 % i64::from(u32::MAX)).unwrap_or_default();
        let member = Member { team: team.into(), number, session };
        let name = format!("{}_team", node_name());
        let watch = Stopwatch::start();
        Ok(Self {
            filter: TeamFilter::new(TeamConfig::default(), member, map)?,
            has_detector: false,
            link: TeamLink::open(network, &name, team, number)?,
            clock: Clock::new(move || watch.secs()),
            started_at: None,
            now: Timestamp::default(),
            times_ms: Records::new(Records::<f64>::most_of(true, false)),
            sent_bytes: 0,
            num_sent: 0,
            num_heard: 0,
            num_refused: 0,
            twice: BTreeSet::new(),
        })
    }

    /// Hears the others, takes in the estimate of the own localizer, and tells the others.
    pub fn step(&mut self, view: &FrameView<'_>) -> Option<&Estimate> {
        let began = self.clock.secs();
        let at = view.frame.at;
        self.now = at;
        self.started_at.get_or_insert(at);
        let own = view.runners.first()?.pipeline().estimate();
        // Arrival is told by stamps of images, as everything else: a recording may be played at any speed and on any day.
        for message in self.link.messages() {
            self.hear(&message.read(), at);
        }
        let received = self.link.sightings();
        self.has_detector |= !received.is_empty();
        let mut sightings: Vec<_> = received.iter().flat_map(WireSightings::read).collect();
        if !self.has_detector {
            let objects = &view.runners.first()?.pipeline().percept().objects;
            sightings.extend(objects.iter().map(|object| Sighting::of_object(at, object)));
        }
        self.filter.step(at, own, view.frame.odometry, &sightings);
        if let Some(message) = self.filter.message() {
            let message = WireTeamMessage::from(&message);
            self.num_sent += 1;
            self.sent_bytes += to_cdr(&message).map_or(0, |bytes| bytes.len());
            self.link.publish(message);
        }
        self.times_ms.push((self.clock.secs() - began) * 1e3);
        Some(&self.filter.answer().estimate)
    }

    fn hear(&mut self, message: &TeamMessage, at: Timestamp) {
        let Member { team, number, session } = self.filter.member();
        if (&message.team, message.number, message.session) == (team, *number, *session) {
            return; // the own ones come back
        }
        self.num_heard += 1;
        let Err(reason) = self.filter.receive(message, at) else { return };
        self.num_refused += 1;
        let is_twice = matches!(reason, Ignored::OwnNumber | Ignored::SameNumber(_));
        if is_twice && self.twice.insert(message.number) {
            host::host().notice(&format!(
                "team {}: two robots have the number {}; give each its own with --number",
                message.team, message.number
            ));
        }
    }

    /// Where the localizer should look for a robot that is lost and that others see.
    pub fn advice(&mut self) -> Option<StartPrior> {
        self.filter.advice()
    }

    /// What was told so far.
    pub fn report(&self) -> TeamReport {
        let secs = self.started_at.map_or(0.0, |start| self.now.secs_since(start));
        TeamReport {
            robots: self.filter.mates().count(),
            sent: self.num_sent,
            #[allow(clippy::cast_precision_loss)]
            bytes_per_s: self.sent_bytes as f64 / secs.max(1e-9),
            heard: self.num_heard,
            refused: self.num_refused + self.link.num_failed().1,
            numbers_twice: self.twice.iter().copied().collect(),
            ms: TimingSummary::of_ms(&self.times_ms),
        }
    }
}
