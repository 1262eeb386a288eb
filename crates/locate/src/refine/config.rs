//! Parameters of the refinement.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::settings::check_ranges;

use crate::{ConfigError, ReliabilityConfig};

visloc_core::with_defaults! {
    /// Parameters of the tracks and their filters.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct RefinementConfig {
        /// Most tracks at a time.
        #[schemars(range(min = 1, max = 1000))]
        pub max_tracks: usize = 8,
        /// Most tracks that are fitted to one image. If there are more, the best ones always are and the others take turns, so
        /// that an image costs the same for any number of them.
        #[schemars(range(min = 1, max = 1000))]
        pub max_fits: usize = 5,
        /// Whether the map has many places that look alike. Then tracks begin only where the image leaves few places possible
        /// and no track is yet, images of few features say less about a track, and while no place has most of the odds the
        /// answer is the one with the least expected error.
        pub has_look_alikes: bool = false,
        /// Standard deviation of a border pixel, pixels.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub pixel_noise_px: f64 = 1.0,
        /// Neighboring pixels err alike: all pixels of an image together count as at most so many.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub max_independent_pixels: f64 = 15.0,
        /// All pixels of one view together are evidence for a place as at most so many: the errors of map, lens and what stands in the way repeat
        /// in all images of it.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub max_independent_evidence: f64 = 25.0,
        /// A pixel farther from its counterpart than this has none, pixels.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub gate_px: f64 = 8.0,
        /// Distance at which a pixel agrees by 60 % with the map, pixels.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub agreement_px: f64 = 3.0,
        /// Standard deviation of the camera's direction that changes with every image, radians.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub tilt_noise_rad: f64 = 0.004,
        /// Standard deviation of the camera's direction that changes slowly, radians.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub tilt_bias_rad: f64 = 0.005,
        /// Time in which the slow part changes, seconds; that of the height too.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub tilt_bias_secs: f64 = 8.0,
        /// Standard deviation among robots of the camera's constant error: how far it looks down, radians; 0 if it is where it is reported.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub mount_pitch_rad: f64 = 0.035,
        /// How far it is turned about its axis, radians.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub mount_roll_rad: f64 = 0.019,
        /// How far it looks to the side, radians.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub mount_yaw_rad: f64 = 0.005,
        /// Time in which a robot that is lost doubts what it has learned of its camera's constant error, seconds.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub mount_secs: f64 = 300.0,
        /// Standard deviation of the camera's place that changes with every image, each axis, meters.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub eye_noise_m: f64 = 0.002,
        /// Standard deviation of the camera's height that changes slowly, meters.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub raise_bias_m: f64 = 0.004,
        /// A larger motion between two images is a jump of the odometry and is not believed, meters; per second if they are farther apart
        /// than that.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub max_motion_m: f64 = 1.0,
        /// Position noise of the odometry, meters per square root of a meter.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub odometry_noise_m: f64 = 0.02,
        /// Heading noise of the odometry, radians per square root of a meter.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub odometry_noise_rad: f64 = 0.03,
        /// Heading noise of the odometry, radians per square root of a radian turned.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub odometry_turn_noise_rad: f64 = 0.02,
        /// Standard deviation of the systematic error of the odometry, a share of the motion.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub odometry_scale_error: f64 = 0.08,
        /// Standard deviation of the systematic turn of the odometry, radians per meter.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub odometry_drift_rad_per_m: f64 = 0.03,
        /// Standard deviation of the speed ahead that is expected without odometry, m/s.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub speed_m_per_s: f64 = 0.2,
        /// Standard deviation of the turning that is expected without odometry, rad/s.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub turn_rad_per_s: f64 = 0.6,
        /// Time in which the speed changes without odometry, seconds.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub speed_secs: f64 = 1.5,
        /// Standard deviation of a new track's position, meters.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub birth_noise_m: f64 = 0.3,
        /// Standard deviation of a new track's heading, radians.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub birth_noise_rad: f64 = 0.2,
        /// A new track must explain at least this share of the features.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub min_birth_agreement: f64 = 0.5,
        /// Where places look alike, evidence of one image, as the logarithm of the odds between a track that explains everything and one that explains
        /// nothing.
        #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub evidence_per_image: f64 = 6.0,
        /// Where places look alike, a track that explains less than the best one by no more than this loses nothing.
        #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub evidence_deadband: f64 = 0.0,
        /// Where places look alike, the largest difference that counts: one image with something strange in it must not decide.
        #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub max_evidence_difference: f64 = 1.0,
        /// The most that a track loses by needing a camera with another tilt or height than the robot's, as a logarithm of odds; counts
        /// where places look alike, for the answer and not for its reliability.
        #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub max_bend_evidence: f64 = 3.0,
        /// Poses that are weighed for one image in search of places while the robot is not localized.
        #[schemars(range(min = 1, max = 100_000))]
        pub search_poses: usize = 200,
        /// Places at which a track may begin in one image while the robot is not localized; each costs a fit. If more are found they
        /// take turns.
        #[schemars(range(min = 1, max = 1000))]
        pub max_births: usize = 3,
        /// Where places look alike, share of the evidence that is kept from image to image.
        #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub evidence_kept: f64 = 1.0,
        /// Where places look alike, a track whose turn it is not loses what it lost in its last image once more, this share of it in the first image and
        /// that much less in each one after.
        #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub stale_evidence_kept: f64 = 1.0,
        /// Turn rate of the camera at which an image is so blurred that it says half as much, radians per second; counts where places
        /// look alike.
        #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub blurring_turn_rad_per_s: f64 = 1.2,
        /// A track whose odds fall below the best one's by this is given up, as a logarithm.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub hopeless: f64 = 20.0,
        /// Tracks that are nearer than this are one, meters.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub merge_distance_m: f64 = 0.25,
        /// Tracks whose headings differ by less than this are one, radians.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub merge_turn_rad: f64 = 0.2,
        /// A track whose agreement of late is below this does not know where it is.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub lost_agreement: f64 = 0.35,
        /// Standard deviation of the position at which the reliability begins to shrink, meters. A robot that stands and sees nothing gets
        /// there in `reliability.blind_secs`.
        #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
        pub reliable_spread_m: f64 = 0.1,
        /// Reliability, driven by the agreement instead of the likelihood of twenty pixels.
        pub reliability: ReliabilityConfig = ReliabilityConfig {
                    high_likelihood: 0.85,
                    low_likelihood: 0.6,
                    ..ReliabilityConfig::published_2010()
                },
    }
}

impl RefinementConfig {
    /// Standard deviations of the camera's constant error about the axes of its frame, radians.
    pub(super) fn mount_error_rad(&self) -> Vector3<f64> {
        Vector3::new(self.mount_pitch_rad, self.mount_yaw_rad, self.mount_roll_rad)
    }

    /// Checks the ranges of all values, and those that must go together.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_ranges(self)?;
        self.reliability.check()
    }
}
