//! What is kept of a drive.

use thiserror::Error;
use visloc_core::{Timestamp, geom::PlanarPose};

use crate::vision::Percept;

/// A drive that tells too little.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RobotCalibrationError {
    /// The robot did not know where it is, or saw too little.
    #[error(
        "expected at least {expected} images in which the robot knows its place and sees enough lines, found {found}; drive longer, \
         over all of the field, and check the map and the camera's pose"
    )]
    FewViews {
        /// Needed.
        expected: usize,
        /// Found.
        found: usize,
    },
    /// No image came with odometry.
    #[error(
        "expected odometry beside the images, found none; does the robot report its motion, and on which topic?"
    )]
    NoOdometry,
    /// The robot hardly moved.
    #[error(
        "expected at least {expected} stretches of motion with odometry, found {found}; drive and turn more"
    )]
    LittleMotion {
        /// Needed.
        expected: usize,
        /// Found.
        found: usize,
    },
}

/// A view of the map from a known place.
#[derive(Debug, Clone)]
pub(super) struct MappedView {
    pub percept: Percept,
    pub world_from_robot: PlanarPose,
}

/// Where the robot was, and what its odometry said.
#[derive(Debug, Clone, Copy)]
pub(super) struct DrivePoint {
    pub at: Timestamp,
    /// `None` while the place is not known.
    pub world_from_robot: Option<PlanarPose>,
    pub odometry: Option<PlanarPose>,
}

/// Views and odometry of a drive. Memory is bounded: of long drives every second view is kept, then every fourth and so on.
#[derive(Debug, Clone, Default)]
pub struct DriveRecord {
    pub(super) views: Vec<MappedView>,
    pub(super) points: Vec<DrivePoint>,
    num_seen: usize,
    stride: usize,
}

/// Most views that are kept: more tell nothing new.
const MAX_VIEWS: usize = 400;
/// Fewer border pixels say little about height and tilt.
const MIN_BORDERS: usize = 30;

impl DriveRecord {
    /// Takes in a frame: what was seen, where the localizer says that the robot is (if it is localized), and the reported
    /// odometry, `odom_from_robot`.
    pub fn add(
        &mut self,
        percept: &Percept,
        world_from_robot: Option<PlanarPose>,
        odometry: Option<PlanarPose>,
    ) {
        self.points.push(DrivePoint { at: percept.at, world_from_robot, odometry });
        let Some(pose) = world_from_robot.filter(|_| percept.borders.len() >= MIN_BORDERS) else { return };
        self.stride = self.stride.max(1);
        if self.num_seen.is_multiple_of(self.stride) {
            self.views.push(MappedView { percept: percept.clone(), world_from_robot: pose });
        }
        self.num_seen += 1;
        if self.views.len() > MAX_VIEWS {
            self.stride *= 2;
            let mut index = 0;
            self.views.retain(|_| {
                index += 1;
                index % 2 == 1
            });
        }
    }

    /// Views that are kept.
    pub fn num_views(&self) -> usize {
        self.views.len()
    }
}
