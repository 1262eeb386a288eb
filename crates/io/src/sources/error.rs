//! Why a source cannot be opened.

use std::{io, path::PathBuf};

use thiserror::Error;
use visloc_core::SourceError;
use visloc_sim::{ScenarioError, TourError};

use crate::{
    FileError,
    bag::{BagError, TopicRole},
};

/// Why a source cannot be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SourcesError {
    /// The word before the colon is no kind of source.
    #[error("unknown kind of source '{scheme}:'{}; known are {known}", did_you_mean(nearest))]
    UnknownKind {
        /// The word.
        scheme: String,
        /// The known one most like it.
        nearest: Option<String>,
        /// All kinds.
        known: String,
    },
    /// There is no such file, and it is no name either.
    #[error(
        "{argument}: no such file or folder{}; expected one, or a source such as {known}",
        did_you_mean(nearest)
    )]
    NotFound {
        /// What the user wrote.
        argument: String,
        /// Something that exists and looks like it.
        nearest: Option<String>,
        /// All kinds.
        known: String,
    },
    /// The system refuses to look at it.
    #[error("{argument}: {source}")]
    Unreadable {
        /// What the user wrote.
        argument: String,
        /// What the system says.
        source: io::Error,
    },
    /// A device, a pipe or a socket.
    #[error(
        "{argument}: expected a file or a folder, found a device, pipe or socket, which may never end; write what comes from it to a \
         file first, or name a camera as v4l2:DEVICE"
    )]
    NoFile {
        /// What the user wrote.
        argument: String,
    },
    /// A photo in place of a recording.
    #[error(
        "{}: expected a recording, a folder of images or a camera, found a single image; where it was taken says visloc locate PHOTO --map M \
         --camera C",
        path.display()
    )]
    Photo {
        /// The file.
        path: PathBuf,
    },
    /// A file that no kind of source claims.
    #[error("{}: cannot tell what it is from its name; expected {known}, or say the kind, such as video:FILE", path.display())]
    UnknownFile {
        /// The file.
        path: PathBuf,
        /// What would be known.
        known: String,
    },
    /// The kind of source has no such thing to give.
    #[error("{argument}: {reason}")]
    CannotDeliver {
        /// What the user wrote.
        argument: String,
        /// What it is and what it would have to be.
        reason: String,
    },
    /// An option that the source has no use for, or whose value makes no sense.
    #[error("{flag}: {reason}")]
    Refused {
        /// The option as it is typed.
        flag: &'static str,
        /// Why, and what to do.
        reason: String,
    },
    /// Part of the program was left out when it was built.
    #[error("{argument}: this visloc was built without {feature}; build with --features {feature}")]
    NotBuilt {
        /// What the user wrote.
        argument: String,
        /// The feature.
        feature: &'static str,
    },
    /// There is no ffmpeg.
    #[error(
        "{argument}: videos, cameras and loop: are read by ffmpeg, and '{}' cannot be started: {source}. Install it (Debian, \
         Ubuntu: apt install ffmpeg; macOS: brew install ffmpeg), name it with --ffmpeg PATH, or make a folder of \
         images from the video elsewhere",
        program.display()
    )]
    NoFfmpeg {
        /// What the user wrote.
        argument: String,
        /// The program that was tried.
        program: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The calibration is missing.
    #[error(
        "{argument}: expected a calibration of the camera; give one with --camera FILE (docs/own-camera.md), visloc calibrate makes it, of photos of a board or of a video itself"
    )]
    NoCamera {
        /// What the user wrote.
        argument: String,
    },
    /// Nothing says where the camera is on the robot.
    #[error(
        "{argument}: a source without kinematics needs the camera's place on the robot: --camera-height METERS and \
         --camera-tilt DEGREES (down is positive)"
    )]
    NoMount {
        /// What the user wrote.
        argument: String,
    },
    /// The source ended before its first image.
    #[error("{argument}: no image came{why}")]
    Empty {
        /// What the user wrote.
        argument: String,
        /// Why, as the end of a sentence; may be empty.
        why: String,
    },
    /// The first image cannot be had.
    #[error(transparent)]
    First(#[from] SourceError),
    /// A bag.
    #[error(transparent)]
    Bag(#[from] BagError),
    /// A dataset, a folder of images or a calibration.
    #[error(transparent)]
    Sequence(#[from] FileError),
    /// A simulated robot.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A simulated tour of a camera.
    #[error(transparent)]
    Tour(#[from] TourError),
    /// Live topics.
    #[cfg(feature = "ros2")]
    #[error(transparent)]
    Ros2(#[from] crate::ros2::Ros2Error),
}

impl SourcesError {
    /// Whether all that is missing is a calibration of the camera.
    #[must_use]
    pub fn lacks_camera(&self) -> bool {
        matches!(self, Self::NoCamera { .. } | Self::Sequence(FileError::NoCamera { .. }))
    }

    /// Whether nothing says where the camera is on a robot: there may be none.
    #[must_use]
    pub fn lacks_mount(&self) -> bool {
        use BagError::{MissingTopic, NoMessages, NotRead};
        match self {
            Self::NoMount { .. } => true,
            Self::Bag(MissingTopic { role, .. } | NoMessages { role, .. } | NotRead { role, .. }) => {
                *role == TopicRole::Tf
            }
            _ => false,
        }
    }
}

fn did_you_mean(nearest: &Option<String>) -> String {
    nearest.as_ref().map(|name| format!("; did you mean '{name}'?")).unwrap_or_default()
}
