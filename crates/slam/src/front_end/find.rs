//! The camera is lost, or may be at another place: it is looked for in all maps.

use visloc_core::{Clock, Timestamp};

use super::{FrontEnd, Keeping, PROBATION_FRAMES, Phase};
use crate::{
    map::{KeyframeId, Map},
    outcome::{FrameOutcome, TrackingState},
    recognize::{Located, Refusal, Rival, SURE, are_apart},
    schedule::Job,
    timing::StageTimer,
    track::{FrameWork, Incoming, LocalMap, TrackReport},
};

/// Images from one look elsewhere to the next while the place is in doubt: several a second, and one costs as much as some tracked images.
const LOOK_EVERY: usize = 5;

impl FrontEnd {
    pub(super) fn relocalize(
        &mut self,
        incoming: &Incoming<'_>,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Option<Job> {
        match self.recognize(incoming, timer) {
            Ok(located) => Some(self.go_on_at(located, outcome, timer)),
            Err(refused) => {
                // While the mapper is at work, the numbers of new keyframes are not known yet.
                let is_time = incoming.at.secs_since(self.lost_at) >= self.config.relocation.new_map_secs;
                let job = if is_time && !self.awaits_keyframe && self.keeping == Keeping::Growing {
                    self.start(incoming, outcome, timer)
                } else {
                    self.remember(incoming, None);
                    None
                };
                if job.is_none() {
                    outcome.state = TrackingState::Lost;
                    outcome.refusal = refused.map(|(_, reason)| reason);
                }
                job
            }
        }
    }

    /// Looks for the camera in the whole map; only what is found changes anything.
    pub(super) fn found_elsewhere(
        &mut self,
        incoming: &Incoming<'_>,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Option<Job> {
        let located = self.recognize(incoming, timer).ok()?;
        Some(self.go_on_at(located, outcome, timer))
    }

    /// Looks by descriptors for what the last frame saw: patches cannot be followed where the camera has turned too far from one image to the next.
    pub(super) fn found_near(
        &mut self,
        local_map: &LocalMap,
        incoming: &Incoming<'_>,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Option<Job> {
        let is_near = |id: KeyframeId| local_map.keyframes.contains(&id);
        let mut report = self.recognize_among(is_near, incoming, timer).ok()?.report;
        self.tracker.hold_place(&self.map, incoming, &mut report);
        self.num_bad = 0;
        self.remember(incoming, report.covariance);
        Some(self.accept(report, outcome, timer))
    }

    /// Looks for the camera in the fixed map while its place is in doubt; where more of that map is seen than here, it goes on.
    pub(super) fn look_elsewhere(
        &mut self,
        incoming: &Incoming<'_>,
        here: &TrackReport,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Option<Job> {
        if !self.is_in_doubt || !self.number().is_multiple_of(LOOK_EVERY) {
            return None;
        }
        let mut aside = StageTimer::start(Clock::still());
        let mut work = FrameWork { rng: &mut self.rng, timer: &mut aside };
        let is_candidate = |id| self.map.is_fixed(id);
        let found = self.relocator.attempt(&self.map, is_candidate, incoming, &mut work);
        timer.end("relocalize");
        let is_apart = |rival: &Rival| are_apart(&self.map, (self.map.active(), here), rival.pose());
        let elsewhere = |located: &Located| {
            let best = std::iter::once(located.as_rival(&self.map));
            best.chain(located.rivals.iter().copied()).filter(is_apart).collect()
        };
        outcome.rivals = Some(found.as_ref().map_or_else(|_| Vec::new(), elsewhere));
        let located = found.ok()?;
        let num_fixed = |report: &TrackReport| {
            report.frame.features.iter().filter(|f| self.map.is_fixed_landmark(f.landmark)).count()
        };
        let is_better =
            num_fixed(&located.report) > num_fixed(here) && is_apart(&located.as_rival(&self.map));
        is_better.then(|| self.go_on_at(located, outcome, timer))
    }

    /// Looks for the keyframe of any map that shows the place.
    fn recognize(
        &mut self,
        incoming: &Incoming<'_>,
        timer: &mut StageTimer,
    ) -> Result<Located, Option<(KeyframeId, Refusal)>> {
        self.recognize_among(|_| true, incoming, timer)
    }

    /// Looks for the keyframe, one of some, that shows the place.
    fn recognize_among(
        &mut self,
        is_candidate: impl Fn(KeyframeId) -> bool,
        incoming: &Incoming<'_>,
        timer: &mut StageTimer,
    ) -> Result<Located, Option<(KeyframeId, Refusal)>> {
        let mut aside = StageTimer::start(Clock::still());
        let mut work = FrameWork { rng: &mut self.rng, timer: &mut aside };
        let found = self.relocator.attempt(&self.map, is_candidate, incoming, &mut work);
        timer.end("relocalize");
        match found {
            Ok(located)
                if self.keeping == Keeping::Growing
                    && (!self.is_sure(&located)
                        || (self.is_refuted && !self.is_told_by_way_or_view(&located))) =>
            {
                let (num, of) = (located.report.num_matched, located.report.num_searched);
                Err(Some((located.keyframe, Refusal::FewFound { num, of })))
            }
            found => found,
        }
    }

    /// Whether more is seen of a place than of a thing that may be there twice, such as a door: what goes on at a wrong place bends the map.
    fn is_sure(&self, located: &Located) -> bool {
        let num = located.report.num_matched;
        num >= SURE * self.config.relocation.min_matches && num > located.num_elsewhere()
    }

    /// Goes on where the camera was found.
    fn go_on_at(&mut self, located: Located, outcome: &mut FrameOutcome, timer: &mut StageTimer) -> Job {
        if self.keeping != Keeping::Growing || self.is_told_by_way_or_view(&located) {
            self.be_sure();
        } else {
            self.suppose(&located.report);
        }
        self.phase = Phase::Tracking;
        self.num_bad = 0;
        outcome.is_relocalized = true;
        outcome.rivals = Some(located.rivals);
        self.tracker.forget();
        self.initializer.reset();
        (self.anchor, self.hangs_on) = (located.keyframe, located.keyframe);
        self.activate_anchor();
        self.rule.keyframe_made();
        self.accept(located.report, outcome, timer)
    }

    /// Gives up the pose. A map that has only just been started is given up with it.
    pub(super) fn lose(&mut self, at: Timestamp) -> Option<Job> {
        self.num_bad = 0;
        if !self.refute() {
            self.lost_at = at;
        }
        self.initializer.reset();
        let was_active = self.map.active();
        let is_young =
            self.started_map == Some(was_active) && self.number() < self.started_at + PROBATION_FRAMES;
        self.phase = Phase::Lost;
        if !is_young {
            return None;
        }
        self.tracker.forget();
        self.crossings.clear();
        if self.map.maps() != [was_active] {
            self.map.give_up(was_active);
            self.awaits_keyframe = true;
            return Some(Job::GiveUp(was_active));
        }
        self.backfill.forget_recent();
        self.phase = Phase::Starting;
        self.map = Map::new();
        self.epoch += 1;
        self.frames.forget_places();
        None
    }
}
