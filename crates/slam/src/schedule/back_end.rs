//! The mapping side: the only writer of the map.

use visloc_core::geom::Camera;

use super::{FrameJob, Job, Order, Update, at_hand::AtHand};
use crate::{
    atlas::{Recognizer, was_seen_again},
    config::SlamConfig,
    lie::CameraFromWorld,
    map::{Map, Packing, SessionCamera, scaled},
    mapping::{Mapper, MappingReport},
    outcome::Mapped,
    start::StartedMap,
    timing::StageTimer,
};

/// The map and what changes it.
#[derive(Debug)]
pub(crate) struct BackEnd {
    map: Map,
    mapper: Mapper,
    recognizer: Recognizer,
    at_hand: AtHand,
}

impl BackEnd {
    /// Without a map.
    pub fn new(camera: &Camera, config: &SlamConfig, seed: u64) -> Self {
        Self {
            map: Map::new(),
            mapper: Mapper::new(camera, config),
            recognizer: Recognizer::new(camera, config, seed),
            at_hand: AtHand::default(),
        }
    }

    /// With maps of an earlier session and what they know of the camera.
    pub fn resume(map: &Map, known: &SessionCamera, config: &SlamConfig, seed: u64) -> Self {
        Self {
            map: map.clone(),
            mapper: Mapper::resume(map, known, config),
            recognizer: Recognizer::new(&known.camera, config, seed),
            at_hand: AtHand::of(map),
        }
    }

    /// Does one piece of work.
    pub fn process(&mut self, order: Order) -> Update {
        let was_awaited = order.must_be_done();
        let Order { epoch, clock, packing, job } = order;
        let mut timer = StageTimer::start(clock);
        let (camera_from_world, frame, report) = match job {
            Job::Adopt { started, is_only } => {
                let (pose, frame) = (started.frame.camera_from_world, started.frame.number);
                self.adopt(&started, is_only);
                timer.end("start map");
                (pose, frame, MappingReport::default())
            }
            Job::GiveUp(map) => {
                self.mapper.forget_candidates(&mut self.map);
                self.map.give_up(map);
                self.recognizer.forget();
                (CameraFromWorld::identity(), usize::MAX, MappingReport::default())
            }
            Job::Complete => {
                self.complete(packing.as_ref());
                (CameraFromWorld::identity(), 0, MappingReport::default())
            }
            Job::Frame(job) => {
                let (pose, frame) = (job.report.frame.camera_from_world, job.report.frame.number);
                (pose, frame, self.use_frame(*job, &mut timer))
            }
        };
        if report.has_settled {
            self.recognizer.start_from(self.mapper.camera());
        }
        let meeting =
            report.keyframe.and_then(|keyframe| self.recognizer.look(&mut self.map, keyframe, &mut timer));
        // Never together with the work on a keyframe.
        let has_moved = was_awaited || self.recognizer.adjust(&mut self.map, &mut timer);
        if let Some(packing) = packing.filter(|_| !was_awaited) {
            self.at_hand.pack_one(&mut self.map, &packing);
            timer.end("pack");
        }
        let mapped = Mapped { frame, report, meeting, times: timer.finish() };
        let (camera, readout, map) = (*self.mapper.camera(), self.mapper.readout(), self.map.clone());
        let is_adjusting = self.recognizer.is_adjusting();
        Update {
            epoch,
            camera,
            readout,
            map,
            camera_from_world,
            has_moved,
            is_adjusting,
            was_awaited,
            mapped,
        }
    }

    /// Completes the maps with places that were visited again. Elsewhere adjustments on the way have had all that there is. The images of the map that
    /// was tracked are at hand: it comes first, and makes room for the others.
    fn complete(&mut self, packing: Option<&Packing>) {
        let active = self.map.active();
        let mut maps = self.map.maps();
        maps.sort_by_key(|map| *map != active);
        for map in maps {
            if let Some(packing) = packing.filter(|_| map != active) {
                self.at_hand.pack_all(&mut self.map, packing);
            }
            self.map.activate(map);
            if was_seen_again(&self.map) {
                self.mapper.complete(&mut self.map);
            }
        }
        self.map.activate(active);
        self.recognizer.start_from(self.mapper.camera());
    }

    fn adopt(&mut self, started: &StartedMap, is_only: bool) {
        self.mapper.forget_candidates(&mut self.map);
        if is_only {
            self.map = Map::new();
            self.at_hand = AtHand::default();
        }
        self.recognizer.forget();
        let offsets = self.map.append(&started.map);
        let (first, second) = (offsets.keyframe(started.first), offsets.keyframe(started.second));
        self.mapper.restart(&mut self.map);
        self.mapper.populate(&mut self.map, second, first);
        for keyframe in [first, second] {
            self.at_hand.add(keyframe);
            self.recognizer.describe(&mut self.map, keyframe);
        }
    }

    fn use_frame(&mut self, job: FrameJob, timer: &mut StageTimer) -> MappingReport {
        let FrameJob { report, makes_keyframe, anchor, anchor_from_world, anchor_scale, crossings } = job;
        crossings.into_iter().for_each(|crossing| self.map.add_crossing(crossing));
        if let Some(map) = self.map.map_of(anchor).filter(|map| *map != self.map.active()) {
            // The camera was found again in another map.
            self.mapper.forget_candidates(&mut self.map);
            self.recognizer.forget();
            self.map.activate(map);
        }
        self.map.count_matches(&report);
        self.at_hand.come_near(&report.local_map.keyframes);
        let (mut frame, local) = (report.frame, report.local_map.landmarks);
        let anchor_now = self.map.pose_of(anchor);
        if anchor_now != anchor_from_world {
            // The map was corrected since the frame was tracked.
            let from_anchor = frame.camera_from_world * anchor_from_world.inverse();
            let grown = self.map.scale_of(anchor) / anchor_scale;
            frame.camera_from_world = scaled(&from_anchor, grown) * anchor_now;
        }
        if makes_keyframe {
            let report = self.mapper.add_keyframe(&mut self.map, &frame, &local, timer);
            report.keyframe.into_iter().for_each(|made| self.at_hand.add(made));
            report
        } else {
            let report = self.mapper.add_frame(&mut self.map, &frame);
            timer.end("update points");
            report
        }
    }
}
