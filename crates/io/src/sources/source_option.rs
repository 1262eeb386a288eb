//! Options of sources, one by one.

use super::Purpose;

/// An option of a source as a user knows it. Each kind of source lists the ones that it honors; the others are refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum SourceOption {
    /// Calibration.
    Camera,
    /// The camera's place on the robot.
    Mount,
    /// Description of the robot.
    Urdf,
    /// File with names of topics.
    Topics,
    /// Topic of the images.
    ImageTopic,
    /// Topic of the calibration.
    CameraInfoTopic,
    /// Topic of the odometry.
    OdometryTopic,
    /// Topic of the truth.
    TruthTopic,
    /// Frame of the robot.
    BaseFrame,
    /// Frame of the camera.
    CameraFrame,
    /// First image.
    Start,
    /// One past the last image.
    End,
    /// One of so many images is used.
    Stride,
    /// Size of the images.
    Scale,
    /// Images a second.
    Fps,
    /// Seed of everything random.
    Seed,
    /// Threads that draw.
    Threads,
    /// End of a silent source.
    Patience,
    /// How images are asked for.
    ImageQos,
    /// Decoder of videos.
    Ffmpeg,
    /// Domain of ROS 2.
    RosDomain,
}

impl SourceOption {
    /// Every option.
    pub const ALL: [Self; 21] = [
        Self::Camera,
        Self::Mount,
        Self::Urdf,
        Self::Topics,
        Self::ImageTopic,
        Self::CameraInfoTopic,
        Self::OdometryTopic,
        Self::TruthTopic,
        Self::BaseFrame,
        Self::CameraFrame,
        Self::Start,
        Self::End,
        Self::Stride,
        Self::Scale,
        Self::Fps,
        Self::Seed,
        Self::Threads,
        Self::Patience,
        Self::ImageQos,
        Self::Ffmpeg,
        Self::RosDomain,
    ];

    /// Names of topics and frames.
    pub const TOPICS: [Self; 7] = [
        Self::Topics,
        Self::ImageTopic,
        Self::CameraInfoTopic,
        Self::OdometryTopic,
        Self::TruthTopic,
        Self::BaseFrame,
        Self::CameraFrame,
    ];

    /// How it is typed.
    pub fn flag(self) -> &'static str {
        match self {
            Self::Camera => "--camera",
            Self::Mount => "--camera-height",
            Self::Urdf => "--urdf",
            Self::Topics => "--topics",
            Self::ImageTopic => "--image-topic",
            Self::CameraInfoTopic => "--camera-info-topic",
            Self::OdometryTopic => "--odometry-topic",
            Self::TruthTopic => "--truth-topic",
            Self::BaseFrame => "--base-frame",
            Self::CameraFrame => "--camera-frame",
            Self::Start => "--start",
            Self::End => "--end",
            Self::Stride => "--stride",
            Self::Scale => "--scale",
            Self::Fps => "--fps",
            Self::Seed => "--seed",
            Self::Threads => "--threads",
            Self::Patience => "--patience",
            Self::ImageQos => "--image-qos",
            Self::Ffmpeg => "--ffmpeg",
            Self::RosDomain => "--ros-domain",
        }
    }

    /// Why a source may have no use for it, as the end of a sentence about that source.
    pub(super) fn reason(self, purpose: Purpose) -> &'static str {
        match self {
            Self::Camera => "its camera is known; leave it out, or set [camera] in a scenario of your own",
            Self::Mount if purpose == Purpose::Frames => {
                "where its camera is on the robot is known; leave it out"
            }
            Self::Urdf if purpose == Purpose::Frames => "no positions of joints come from it; leave it out",
            Self::Mount | Self::Urdf => "only images are taken, and they do not depend on it; leave it out",
            Self::Topics
            | Self::ImageTopic
            | Self::CameraInfoTopic
            | Self::OdometryTopic
            | Self::TruthTopic
            | Self::BaseFrame
            | Self::CameraFrame => "nothing of that name is read from it here; leave it out",
            Self::Start | Self::End | Self::Stride => "all of it is used; leave it out",
            Self::Scale => "its images are used in their own size; leave it out",
            Self::Fps => "its images have times of their own; leave it out",
            Self::Seed => "nothing in it is random; leave it out",
            Self::Threads => "only simulated images are drawn by threads; leave it out",
            Self::Patience => "it is no live source and ends by itself; leave it out",
            Self::Ffmpeg => "it is read without ffmpeg; leave it out",
            Self::ImageQos => "its images do not come over topics of ROS 2; leave it out",
            Self::RosDomain => "it is not in the network of ROS 2; leave it out",
        }
    }
}

/// Images a second that may be asked for.
pub const RATES_HZ: (f64, f64) = (0.01, 10_000.0);
/// How long a silent source may be waited for, seconds.
pub const PATIENCES_SECS: (f64, f64) = (0.01, 1e6);
/// Heights of a camera above the ground, meters.
pub const HEIGHTS_M: (f64, f64) = (0.01, 100.0);
/// How far a camera may be ahead of the robot's middle, meters.
pub const FORWARD_M: (f64, f64) = (-100.0, 100.0);
