//! What comes of a frame.

use nalgebra::Matrix6;
use thiserror::Error;
use visloc_core::{
    GrayImage, Timestamp,
    geom::{CameraFrame, Rigid3, World},
};

use crate::{
    atlas::Meeting,
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkId, MapId},
    mapping::MappingReport,
    odometry::OdomPose,
    recognize::{Refusal, Rival},
    start::StartWait,
    timing::StageTimes,
    track::{Feature, Quality},
};

/// A frame that cannot be used. Nothing else changes: the next frame is welcome.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The image has another size than the camera.
    #[error("expected an image of {} x {} px, found {} x {}", expected.0, expected.1, found.0, found.1)]
    Size {
        /// Width and height of the camera.
        expected: (usize, usize),
        /// Width and height of the image.
        found: (usize, usize),
    },
    /// The frame is not later than the one before.
    #[error("expected a time after {last}, found {found}")]
    Time {
        /// Time of the frame before.
        last: Timestamp,
        /// Time of this frame.
        found: Timestamp,
    },
}

/// What the system knows about where the camera is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum TrackingState {
    /// There is no map yet, and why.
    Starting(StartWait),
    /// The camera is tracked.
    Tracking(Quality),
    /// The camera was lost and is followed where it may be: more of that place is missed than seen. The map does not change. Unless the place
    /// proves to be the right one, these frames have no pose in the end.
    Supposed,
    /// The image shows too little of the map; the robot's odometry carries the pose on.
    Carried,
    /// The camera is lost in its map.
    #[default]
    Lost,
}

impl TrackingState {
    /// The state in a word: `starting`, `tracking`, `supposed`, `carried` or `lost`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Starting(_) => "starting",
            Self::Tracking(_) => "tracking",
            Self::Supposed => "supposed",
            Self::Carried => "carried",
            Self::Lost => "lost",
        }
    }
}

/// What became of a frame.
#[derive(Debug, Clone, Default)]
pub struct FrameOutcome {
    /// What the system knows now.
    pub state: TrackingState,
    /// Pose as known at this moment; `None` unless the frame is tracked, supposed or carried.
    pub camera_from_world: Option<CameraFromWorld>,
    /// Covariance of the pose over a twist in the frame of the camera: translation first, map units and radians. What the map itself
    /// is off by is not in it.
    pub covariance: Option<Matrix6<f64>>,
    /// The map that the pose is in; `None` without a pose. Maps are joined later when they meet.
    pub map: Option<MapId>,
    /// Places searched and landmarks found.
    pub matches: (usize, usize),
    /// Landmarks found that belong to a fixed map, and how they are seen.
    pub fixed: Vec<Feature>,
    /// Landmarks of a fixed map that were looked for.
    pub fixed_tried: Vec<LandmarkId>,
    /// Places of the image where they were.
    pub num_fixed_searched: usize,
    /// Of a lost frame: why the keyframe that looks most like it is another place.
    pub refusal: Option<Refusal>,
    /// Whether a lost camera was found again in this frame.
    pub is_relocalized: bool,
    /// Other places where the frame may have been taken; `None` unless they were looked for.
    pub rivals: Option<Vec<Rival>>,
    /// Time of tracking by stage.
    pub tracking: StageTimes,
    /// Pixels of the landmarks found, and whether each has converged; for pictures.
    pub features: Vec<(nalgebra::Point2<f64>, bool)>,
    /// What the mapper has finished: in sequence this very frame, with threads earlier ones.
    pub mapped: Vec<Mapped>,
}

/// What the mapper did with a frame.
#[derive(Debug, Clone)]
pub struct Mapped {
    /// Number of the frame.
    pub frame: usize,
    /// What was done.
    pub report: MappingReport,
    /// What came of a place that looks like one that was seen before.
    pub meeting: Option<Meeting>,
    /// Time by stage.
    pub times: StageTimes,
}

/// A frame's place in the trajectory: relative to a keyframe, so that it moves when the map is corrected.
#[derive(Debug, Clone, Copy)]
pub struct FramePose {
    /// When the frame was taken.
    pub at: Timestamp,
    /// The keyframe it hangs on and its pose relative to it; `None` for a frame without a pose.
    pub place: Option<(KeyframeId, Rigid3<CameraFrame, CameraFrame>)>,
    /// Scale of that keyframe then, see [`crate::map::Map::scale_of`].
    pub scale: f64,
    /// Whether the frame had no pose when it was taken: the start of a map found it afterwards.
    pub is_filled_in: bool,
    /// Whether the pose is that of the last tracked frame, carried on by odometry.
    pub is_carried: bool,
    /// Where the odometry has it.
    pub odometry: Option<OdomPose>,
}

impl FramePose {
    /// A frame without a pose.
    #[must_use]
    pub fn unknown(at: Timestamp) -> Self {
        Self { at, place: None, scale: 1.0, is_filled_in: false, is_carried: false, odometry: None }
    }
}

/// A pose of the final trajectory.
#[derive(Debug, Clone, Copy)]
pub struct TrajectoryPose {
    /// When.
    pub at: Timestamp,
    /// Where the camera was, map units.
    pub world_from_camera: Rigid3<World, CameraFrame>,
    /// The map that this is in: poses of different maps have nothing to do with each other.
    pub map: MapId,
    /// Whether the frame had no pose when it was taken: the start of a map found it afterwards.
    pub is_filled_in: bool,
    /// Whether the image told nothing: the pose is that of the last tracked frame, carried on by odometry.
    pub is_carried: bool,
}

/// A frame that the system has taken in, for those who look on.
#[derive(Debug, Clone, Copy)]
pub struct SlamFrame<'a> {
    /// When it was taken.
    pub at: Timestamp,
    /// Its image.
    pub image: &'a GrayImage,
    /// What became of it.
    pub outcome: &'a FrameOutcome,
}
