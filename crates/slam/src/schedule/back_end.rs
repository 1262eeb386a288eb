//! The mapping side: the only writer of the map.

use visloc_core::geom::Camera;

use super::{FrameJob, Job, Order, Update};
use crate::{
    config::SlamConfig,
    map::Map,
    mapping::{Mapper, MappingReport},
    outcome::Mapped,
    start::StartedMap,
    timing::StageTimer,
};

/// The map and what changes it.
#[derive(Debug)]
pub(crate) struct BackEnd {
    camera: Camera,
    config: SlamConfig,
    map: Map,
    mapper: Mapper,
}

impl BackEnd {
    /// Without a map.
    pub fn new(camera: &Camera, config: &SlamConfig) -> Self {
        Self { camera: *camera, config: config.clone(), map: Map::new(), mapper: Mapper::new(camera, config) }
    }

    /// Does one piece of work.
    pub fn process(&mut self, order: Order) -> Update {
        let has_moved = order.must_be_done();
        let Order { epoch, clock, job } = order;
        let mut timer = StageTimer::start(clock);
        let (camera_from_world, frame, report) = match job {
            Job::Adopt(started) => {
                let (pose, frame) = (started.frame.camera_from_world, started.frame.number);
                self.adopt(*started);
                timer.end("start map");
                (pose, frame, MappingReport::default())
            }
            Job::Frame(job) => {
                let (pose, frame) = (job.report.frame.camera_from_world, job.report.frame.number);
                (pose, frame, self.use_frame(*job, &mut timer))
            }
        };
        let mapped = Mapped { frame, report, times: timer.finish() };
        Update { epoch, map: self.map.clone(), camera_from_world, has_moved, mapped }
    }

    fn adopt(&mut self, started: StartedMap) {
        let StartedMap { map, first, second, .. } = started;
        self.map = map;
        self.mapper = Mapper::new(&self.camera, &self.config);
        self.mapper.populate(&mut self.map, second, first);
    }

    fn use_frame(&mut self, job: FrameJob, timer: &mut StageTimer) -> MappingReport {
        let FrameJob { report, makes_keyframe, anchor, anchor_from_world } = job;
        self.map.count_matches(&report);
        let (mut frame, local) = (report.frame, report.local_map.landmarks);
        let anchor_now = self.map.pose_of(anchor);
        if anchor_now != anchor_from_world {
            // The map was corrected since the frame was tracked.
            frame.camera_from_world = frame.camera_from_world * anchor_from_world.inverse() * anchor_now;
        }
        if makes_keyframe {
            self.mapper.add_keyframe(&mut self.map, &frame, &local, timer)
        } else {
            let report = self.mapper.add_frame(&mut self.map, &frame);
            timer.end("update points");
            report
        }
    }
}
