//! A robot of the team: its localizer, what it makes of what others tell, and what people do to it.

use visloc_core::{Clock, Rng, RngTree, SourceFrame, Timestamp, Truth};
use visloc_io::bag::messages::to_cdr;
use visloc_locate::{
    Pipeline, StartPrior,
    lineup::LineupError,
    team::{
        Liar, Member, Sighting, SightingKind, TeamConfig, TeamEstimate, TeamFilter, TeamMessage,
        WireTeamMessage,
    },
};
use visloc_sim::{Detection, DetectorSetup, TeamFrame};
use visloc_world::Map;

use crate::StudioError;

/// Bytes are counted over so long, seconds.
const METER_SECS: f64 = 2.0;

/// One robot.
pub(super) struct Robot {
    number: u8,
    pipeline: Pipeline,
    filter: TeamFilter,
    frame: SourceFrame,
    sightings: Vec<Sighting>,
    /// Whether the others hear it, and it them.
    pub is_linked: bool,
    /// How it lies.
    pub liar: Option<Liar>,
    liar_rng: Rng,
    /// When it has sent how many bytes.
    sent: Vec<(Timestamp, usize)>,
}

impl Robot {
    /// A robot that knows nothing but `start`; `frame` is what it shows until it takes in another one.
    pub fn new(
        number: u8,
        (map, start): (&Map, StartPrior),
        frame: SourceFrame,
        random: &RngTree,
        clock: &Clock,
    ) -> Result<Self, StudioError> {
        let random = random.subtree("robot", u64::from(number));
        let builder = Pipeline::builder(map).rng(random).start(start).clock(clock.clone());
        let member = Member { team: "studio".into(), number, session: 1 };
        Ok(Self {
            number,
            pipeline: builder.build().map_err(LineupError::from)?,
            filter: TeamFilter::new(TeamConfig::default(), member, map)?,
            frame,
            sightings: Vec::new(),
            is_linked: true,
            liar: None,
            liar_rng: random.stream("liar", 0),
            sent: Vec::new(),
        })
    }

    /// Takes in an image; what it tells the others, if it is time for that.
    pub fn take(
        &mut self,
        frame: TeamFrame,
        detector: &DetectorSetup,
    ) -> Result<Option<TeamMessage>, StudioError> {
        self.frame = frame.source;
        let at = self.frame.frame.at;
        self.sightings = frame.detections.iter().map(|seen| sighting(seen, at, detector)).collect();
        let frame = &self.frame.frame;
        if let Some(prior) = self.filter.advice() {
            self.pipeline.reset_to(&prior);
        }
        self.pipeline.step(frame)?;
        self.filter.step(frame.at, self.pipeline.estimate(), frame.odometry, &self.sightings);
        self.sent.retain(|(at, _)| frame.at.secs_since(*at) < METER_SECS);
        let Some(mut message) = self.filter.message().filter(|_| self.is_linked) else { return Ok(None) };
        if let (Some(liar), Some(truth)) = (self.liar, self.frame.truth) {
            liar.lie(&mut message, &truth.world_from_robot, &mut self.liar_rng);
        }
        let num_bytes = to_cdr(&WireTeamMessage::from(&message)).map_or(0, |bytes| bytes.len());
        self.sent.push((frame.at, num_bytes));
        Ok(Some(message))
    }

    /// Hears another one, unless the link is cut.
    pub fn hear(&mut self, message: &TeamMessage, arrived: Timestamp) {
        if self.is_linked {
            // Whatever is wrong with a message, the robot goes on without it.
            let _ = self.filter.receive(message, arrived);
        }
    }

    pub fn number(&self) -> u8 {
        self.number
    }

    pub fn frame(&self) -> &SourceFrame {
        &self.frame
    }

    pub fn truth(&self) -> Option<Truth> {
        self.frame.truth
    }

    pub fn pipeline(&self) -> &Pipeline {
        &self.pipeline
    }

    pub fn filter(&self) -> &TeamFilter {
        &self.filter
    }

    /// What it answers with its team.
    pub fn answer(&self) -> &TeamEstimate {
        self.filter.answer()
    }

    /// What a detector sees in its last image.
    pub fn sightings(&self) -> &[Sighting] {
        &self.sightings
    }

    /// What it sends of late, without headers of the network.
    pub fn bytes_per_sec(&self) -> f64 {
        self.sent.iter().map(|(_, num_bytes)| num_bytes).sum::<usize>() as f64 / METER_SECS
    }
}

/// What a detector makes of an image, with the errors that it has.
fn sighting(seen: &Detection, at: Timestamp, detector: &DetectorSetup) -> Sighting {
    let kind = if seen.is_ball { SightingKind::Ball } else { SightingKind::Teammate };
    let range_sigma_m = detector.range_sigma * seen.range_m;
    Sighting::polar(at, kind, (seen.bearing_rad, detector.bearing_sigma_rad), (seen.range_m, range_sigma_m))
}
