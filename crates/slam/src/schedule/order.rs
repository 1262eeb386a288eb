//! What tracking and mapping send each other.

use visloc_core::{Clock, geom::Camera};

use crate::{
    lie::CameraFromWorld,
    map::{Crossing, KeyframeId, Map, MapId, Packing},
    outcome::Mapped,
    shutter::Readout,
    start::StartedMap,
    track::TrackReport,
};

/// Work for the mapper.
#[derive(Debug)]
pub(crate) struct Order {
    /// Grows with every map that is started and when all are given up: what was done before is not the newest state.
    pub epoch: usize,
    /// Measures the work.
    pub clock: Clock,
    /// How images that have rested are packed; `None` if they stay as they are.
    pub packing: Option<Packing>,
    /// The work.
    pub job: Job,
}

impl Order {
    /// Whether tracking relies on it being done.
    pub fn must_be_done(&self) -> bool {
        match &self.job {
            Job::Adopt { .. } | Job::GiveUp(_) | Job::Complete => true,
            Job::Frame(job) => job.makes_keyframe,
        }
    }
}

/// Work for the mapper.
#[derive(Debug)]
pub(crate) enum Job {
    /// Take over a map that has just been started, beside those that there are.
    Adopt {
        /// The map.
        started: Box<StartedMap>,
        /// Whether there is no other map.
        is_only: bool,
    },
    /// Take out a map that was started wrongly.
    GiveUp(MapId),
    /// Bring the maps to their end: no more images come.
    Complete,
    /// Use a tracked frame.
    Frame(Box<FrameJob>),
}

/// A tracked frame.
#[derive(Debug)]
pub(crate) struct FrameJob {
    /// The frame and what was searched.
    pub report: TrackReport,
    /// Whether to make a keyframe of it; else candidates are measured in it.
    pub makes_keyframe: bool,
    /// The keyframe that the frame hangs on.
    pub anchor: KeyframeId,
    /// Pose of that keyframe in the map that the frame was tracked on.
    pub anchor_from_world: CameraFromWorld,
    /// Scale of that keyframe then.
    pub anchor_scale: f64,
    /// Frames that this map and an earlier one know, found since the last keyframe.
    pub crossings: Vec<Crossing>,
}

/// What the mapper has finished.
#[derive(Debug)]
pub(crate) struct Update {
    /// The number of the order.
    pub epoch: usize,
    /// The camera as it is known now.
    pub camera: Camera,
    /// How long it takes to expose an image.
    pub readout: Readout,
    /// The map as it is now.
    pub map: Map,
    /// Pose of the frame as tracking had it.
    pub camera_from_world: CameraFromWorld,
    /// Whether keyframes may have moved.
    pub has_moved: bool,
    /// Whether the whole map is being adjusted.
    pub is_adjusting: bool,
    /// Whether tracking relied on it being done.
    pub was_awaited: bool,
    /// What was done.
    pub mapped: Mapped,
}
