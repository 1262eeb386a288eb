//! Options of sources, one by one.

use super::Purpose;

visloc_core::worded_enum! {
    /// An option of a source as a user knows it. Each kind of source lists the ones that it honors; the others are refused.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum SourceOption {
        /// Calibration.
        Camera = "--camera",
        /// The camera's place on the robot.
        Mount = "--camera-height",
        /// Description of the robot.
        Urdf = "--urdf",
        /// File with names of topics.
        Topics = "--topics",
        /// Topic of the images.
        ImageTopic = "--image-topic",
        /// Topic of the calibration.
        CameraInfoTopic = "--camera-info-topic",
        /// Topic of the odometry.
        OdometryTopic = "--odometry-topic",
        /// Topic of the truth.
        TruthTopic = "--truth-topic",
        /// Frame of the robot.
        BaseFrame = "--base-frame",
        /// Frame of the camera.
        CameraFrame = "--camera-frame",
        /// First image.
        Start = "--from",
        /// One past the last image.
        End = "--until",
        /// One of so many images is used.
        Stride = "--stride",
        /// Most images that are used.
        Frames = "--frames",
        /// Size of the images.
        Scale = "--scale",
        /// Images a second.
        Fps = "--fps",
        /// Seed of everything random.
        Seed = "--seed",
        /// Threads that draw.
        Threads = "--threads",
        /// End of a silent source.
        Patience = "--patience",
        /// How images are asked for.
        ImageQos = "--image-qos",
        /// Decoder of videos.
        Ffmpeg = "--ffmpeg",
        /// Domain of ROS 2.
        RosDomain = "--ros-domain",
    }

    /// How it is typed.
    flag
}

impl SourceOption {
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
            Self::Start | Self::End | Self::Stride | Self::Frames => "all of it is used; leave it out",
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
