//! How a source is opened.

use std::path::PathBuf;

use visloc_data::{bag::BagTopics, sequence::SequenceRange};

use crate::Mount;

/// How a source is opened. What a kind of source has no use for is ignored, except where that would surprise.
#[derive(Debug, Clone)]
pub struct SourceOptions {
    /// Topics and frames of bags and of live topics.
    pub topics: BagTopics,
    /// Calibration of the camera, over what the source itself says.
    pub camera: Option<PathBuf>,
    /// Where the camera is on the robot, for sources without kinematics.
    pub mount: Option<Mount>,
    /// Which images of a recorded source are used.
    pub range: SequenceRange,
    /// Size of gray images as a factor; the camera is adapted.
    pub scale: f64,
    /// Images a second, for sources without times of their own.
    pub rate_hz: Option<f64>,
    /// Seed of a simulation.
    pub seed: u64,
    /// Threads of a simulation.
    pub num_threads: usize,
    /// Most frames of a simulation.
    pub max_frames: Option<usize>,
    /// A live source from which nothing comes for so long ends, seconds; `None` waits on.
    pub patience_secs: Option<f64>,
    /// The program that decodes video.
    pub ffmpeg: PathBuf,
    /// Domain of live topics, as `ROS_DOMAIN_ID`.
    pub domain_id: u16,
}

impl Default for SourceOptions {
    fn default() -> Self {
        Self {
            topics: BagTopics::default(),
            camera: None,
            mount: None,
            range: SequenceRange::default(),
            scale: 1.0,
            rate_hz: None,
            seed: 1,
            num_threads: 1,
            max_frames: None,
            patience_secs: None,
            ffmpeg: "ffmpeg".into(),
            domain_id: 0,
        }
    }
}
