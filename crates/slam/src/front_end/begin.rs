//! A map is started, and the frames before it are filled in.

use visloc_core::{
    Timestamp,
    geom::{CameraFrame, Rigid3},
};

use super::{FrontEnd, PROBATION_FRAMES, Phase};
use crate::{
    atlas::Similarity,
    backfill::BackfillStep,
    lie::{exp, log},
    map::KeyframeId,
    outcome::{FrameOutcome, TrackingState},
    schedule::Job,
    start::{StartStep, StartedMap},
    timing::StageTimer,
    track::{Incoming, Quality},
};

/// Longest time for which somebody carries a robot, seconds.
const MOST_IN_THE_AIR_SECS: f64 = 10.0;

impl FrontEnd {
    /// Whether the robot's feet were in the air just now: where it is put down is another place, and what it saw until then tells no
    /// lengths. Without odometry for longer than it takes to carry a robot, there is none any more.
    fn was_in_the_air(&self, at: Timestamp) -> bool {
        self.odometry_at.is_some_and(|last| at.secs_since(last) < MOST_IN_THE_AIR_SECS)
            && self.frames.poses().iter().rev().take(2).any(|frame| frame.odometry.is_none())
    }

    pub(super) fn start(
        &mut self,
        incoming: &Incoming<'_>,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Option<Job> {
        if self.was_in_the_air(incoming.at) {
            self.initializer.reset();
        }
        let step = self.initializer.add(incoming, &mut self.rng);
        timer.end("start map");
        match step {
            StartStep::Waiting(wait) => {
                self.backfill.keep(incoming);
                outcome.state = TrackingState::Starting(wait);
                None
            }
            StartStep::Started(mut started) => {
                let is_only = self.map.maps().is_empty();
                self.measure_start(&mut started);
                self.adopt(&started, outcome);
                Some(Job::Adopt { started, is_only })
            }
        }
    }

    /// Brings a started map to meters if odometry tells how long its baseline is; if not, odometry is of no use in it.
    fn measure_start(&self, started: &mut StartedMap) {
        let first = started.map.keyframe(started.first);
        let pose = *first.camera_from_world();
        let units = (started.map.keyframe(started.second).center_in_world() - first.center_in_world()).norm();
        match self.odometry(first.frame, started.frame.number) {
            Some(motion) => {
                let meters_per_unit = motion.translation().norm() / units.max(f64::MIN_POSITIVE);
                started.move_by(&Similarity::between(&pose, &pose, meters_per_unit));
            }
            None => started.forget_odometry(),
        }
    }

    /// Goes on with a started map. Earlier ones stay as they are.
    fn adopt(&mut self, started: &StartedMap, outcome: &mut FrameOutcome) {
        let StartedMap { map, first, second, frame, between } = started;
        let offsets = self.map.append(map);
        self.epoch += 1;
        let (first_id, second_id) = (offsets.keyframe(*first), offsets.keyframe(*second));
        self.anchor_scale = self.map.scale_of(second_id);
        self.place(map.keyframe(*first).frame, (first_id, Rigid3::identity()), self.anchor_scale);
        let world_from_first = map.keyframe(*first).camera_from_world().inverse();
        for (number, pose) in between {
            self.place(*number, (first_id, *pose * world_from_first), self.anchor_scale);
        }
        self.backfill.start(first_id, second_id);
        let number = self.number();
        for earlier in std::iter::once(map.keyframe(*first).frame).chain(between.iter().map(|b| b.0)) {
            if let Some(pose) = self.frames.get_mut(earlier) {
                pose.is_filled_in = true;
            }
        }
        self.place(number, (second_id, Rigid3::identity()), self.anchor_scale);
        outcome.state = TrackingState::Tracking(Quality::Good);
        outcome.camera_from_world = Some(frame.camera_from_world);
        outcome.map = Some(self.map.active());
        outcome.matches = (frame.features.len(), frame.features.len());
        let mut frame = frame.clone();
        for feature in &mut frame.features {
            feature.landmark = offsets.landmark(feature.landmark);
        }
        self.tracker.restart_from(frame);
        self.rule.restart();
        (self.anchor, self.hangs_on) = (second_id, second_id);
        self.awaits_keyframe = true;
        self.started_at = number;
        self.started_map = Some(self.map.active());
        self.num_bad = 0;
        self.is_refuted = false;
        self.phase = Phase::Tracking;
    }

    /// Finds the pose of one of the frames before the start, once the map has proved to be right.
    pub(super) fn fill_back(&mut self) {
        if self.number() < self.started_at + PROBATION_FRAMES / 2 {
            return;
        }
        let found = match self.backfill.next(&self.map, &mut self.rng) {
            None => return,
            Some(BackfillStep::Found(found)) => found,
            Some(BackfillStep::Ended { followed, tracked }) => {
                self.crossings.extend(self.crossing_between(*tracked, &followed));
                return;
            }
        };
        self.crossings.extend(self.crossing_at(&found));
        self.fill_in(found.number, (found.keyframe, found.camera_from_keyframe));
        if let Some((next, camera_from_keyframe)) = found.next {
            // Those in between were let go since they show the same.
            let motion = camera_from_keyframe * found.camera_from_keyframe.inverse();
            let secs = |number: usize| Some(self.frames.get(number)?.at.secs_since(found.at));
            let shares: Vec<_> = (found.number + 1..next)
                .filter_map(|number| Some((number, secs(number)? / secs(next)?)))
                .collect();
            for (number, share) in shares {
                let camera_from_keyframe = exp(&(log(&motion) * share)) * found.camera_from_keyframe;
                self.fill_in(number, (found.keyframe, camera_from_keyframe));
            }
        }
    }

    /// Notes where a frame was, unless its pose is known already.
    fn fill_in(&mut self, number: usize, place: (KeyframeId, Rigid3<CameraFrame, CameraFrame>)) {
        if self.frames.get_mut(number).is_some_and(|frame| frame.place.is_none() || frame.is_carried) {
            self.place(number, place, self.map.scale_of(place.0));
            if let Some(frame) = self.frames.get_mut(number) {
                frame.is_filled_in = true;
            }
        }
    }
}
