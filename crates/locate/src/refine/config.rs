//! Parameters of the refinement.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{ConfigError, ReliabilityConfig, require};

/// Parameters of the tracks and their filters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RefinementConfig {
    /// Most tracks at a time.
    pub max_tracks: usize,
    /// Most tracks that are fitted to one image. If there are more, the best ones always are and the others take turns, so
    /// that an image costs the same for any number of them.
    pub max_fits: usize,
    /// Whether the map has many places that look alike. Then tracks begin only where the image leaves few places possible
    /// and no track is yet, images of few features say less about a track, and while no place has most of the odds the
    /// answer is the one with the least expected error.
    pub has_look_alikes: bool,
    /// Standard deviation of a border pixel, pixels.
    pub pixel_noise_px: f64,
    /// Neighboring pixels err alike: all pixels of an image together count as at most so many.
    pub max_independent_pixels: f64,
    /// All pixels of one view together are evidence for a place as at most so many: the errors of map, lens and what stands in the way repeat
    /// in all images of it.
    pub max_independent_evidence: f64,
    /// A pixel farther from its counterpart than this has none, pixels.
    pub gate_px: f64,
    /// Distance at which a pixel agrees by 60 % with the map, pixels.
    pub agreement_px: f64,
    /// Standard deviation of the camera's direction that changes with every image, radians.
    pub tilt_noise_rad: f64,
    /// Standard deviation of the camera's direction that changes slowly, radians.
    pub tilt_bias_rad: f64,
    /// Time in which the slow part changes, seconds; that of the height too.
    pub tilt_bias_secs: f64,
    /// Standard deviation among robots of the camera's constant error: how far it looks down, radians; 0 if it is where it is reported.
    pub mount_pitch_rad: f64,
    /// How far it is turned about its axis, radians.
    pub mount_roll_rad: f64,
    /// How far it looks to the side, radians.
    pub mount_yaw_rad: f64,
    /// Time in which a robot that is lost doubts what it has learned of its camera's constant error, seconds.
    pub mount_secs: f64,
    /// Standard deviation of the camera's place that changes with every image, each axis, meters.
    pub eye_noise_m: f64,
    /// Standard deviation of the camera's height that changes slowly, meters.
    pub raise_bias_m: f64,
    /// A larger motion between two images is a jump of the odometry and is not believed, meters; per second if they are farther apart
    /// than that.
    pub max_motion_m: f64,
    /// Position noise of the odometry, meters per square root of a meter.
    pub odometry_noise_m: f64,
    /// Heading noise of the odometry, radians per square root of a meter.
    pub odometry_noise_rad: f64,
    /// Heading noise of the odometry, radians per square root of a radian turned.
    pub odometry_turn_noise_rad: f64,
    /// Standard deviation of the systematic error of the odometry, a share of the motion.
    pub odometry_scale_error: f64,
    /// Standard deviation of the systematic turn of the odometry, radians per meter.
    pub odometry_drift_rad_per_m: f64,
    /// Standard deviation of the speed ahead that is expected without odometry, m/s.
    pub speed_m_per_s: f64,
    /// Standard deviation of the turning that is expected without odometry, rad/s.
    pub turn_rad_per_s: f64,
    /// Time in which the speed changes without odometry, seconds.
    pub speed_secs: f64,
    /// Standard deviation of a new track's position, meters.
    pub birth_noise_m: f64,
    /// Standard deviation of a new track's heading, radians.
    pub birth_noise_rad: f64,
    /// A new track must explain at least this share of the features.
    pub min_birth_agreement: f64,
    /// Where places look alike, evidence of one image, as the logarithm of the odds between a track that explains everything and one that explains
    /// nothing.
    #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
    pub evidence_per_image: f64,
    /// Where places look alike, a track that explains less than the best one by no more than this loses nothing.
    #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
    pub evidence_deadband: f64,
    /// Where places look alike, the largest difference that counts: one image with something strange in it must not decide.
    #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
    pub max_evidence_difference: f64,
    /// The most that a track loses by needing a camera with another tilt or height than the robot's, as a logarithm of odds; counts
    /// where places look alike, for the answer and not for its reliability.
    #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
    pub max_bend_evidence: f64,
    /// Poses that are weighed for one image in search of places while the robot is not localized.
    pub search_poses: usize,
    /// Places at which a track may begin in one image while the robot is not localized; each costs a fit. If more are found they
    /// take turns.
    pub max_births: usize,
    /// Where places look alike, share of the evidence that is kept from image to image.
    #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
    pub evidence_kept: f64,
    /// Where places look alike, a track whose turn it is not loses what it lost in its last image once more, this share of it in the first image and
    /// that much less in each one after.
    #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
    pub stale_evidence_kept: f64,
    /// Turn rate of the camera at which an image is so blurred that it says half as much, radians per second; counts where places
    /// look alike.
    #[schemars(extend("x-only-if" = "has_look_alikes = true"))]
    pub blurring_turn_rad_per_s: f64,
    /// A track whose odds fall below the best one's by this is given up, as a logarithm.
    pub hopeless: f64,
    /// Tracks that are nearer than this are one, meters.
    pub merge_distance_m: f64,
    /// Tracks whose headings differ by less than this are one, radians.
    pub merge_turn_rad: f64,
    /// A track whose agreement of late is below this does not know where it is.
    pub lost_agreement: f64,
    /// Standard deviation of the position at which the reliability begins to shrink, meters. A robot that stands and sees nothing gets
    /// there in `reliability.blind_secs`.
    pub reliable_spread_m: f64,
    /// Reliability, driven by the agreement instead of the likelihood of twenty pixels.
    pub reliability: ReliabilityConfig,
}

impl Default for RefinementConfig {
    fn default() -> Self {
        Self {
            max_tracks: 8,
            max_fits: 5,
            has_look_alikes: false,
            pixel_noise_px: 1.0,
            max_independent_pixels: 15.0,
            max_independent_evidence: 25.0,
            gate_px: 8.0,
            agreement_px: 3.0,
            tilt_noise_rad: 0.004,
            tilt_bias_rad: 0.005,
            tilt_bias_secs: 8.0,
            mount_pitch_rad: 0.035,
            mount_roll_rad: 0.019,
            mount_yaw_rad: 0.005,
            mount_secs: 300.0,
            eye_noise_m: 0.002,
            raise_bias_m: 0.004,
            max_motion_m: 1.0,
            odometry_noise_m: 0.02,
            odometry_noise_rad: 0.03,
            odometry_turn_noise_rad: 0.02,
            odometry_scale_error: 0.08,
            odometry_drift_rad_per_m: 0.03,
            speed_m_per_s: 0.2,
            turn_rad_per_s: 0.6,
            speed_secs: 1.5,
            birth_noise_m: 0.3,
            birth_noise_rad: 0.2,
            min_birth_agreement: 0.5,
            evidence_per_image: 6.0,
            evidence_deadband: 0.0,
            max_evidence_difference: 1.0,
            max_bend_evidence: 3.0,
            search_poses: 200,
            max_births: 6,
            evidence_kept: 1.0,
            stale_evidence_kept: 1.0,
            blurring_turn_rad_per_s: 1.2,
            hopeless: 20.0,
            merge_distance_m: 0.25,
            merge_turn_rad: 0.2,
            lost_agreement: 0.35,
            reliable_spread_m: 0.1,
            reliability: ReliabilityConfig {
                high_likelihood: 0.85,
                low_likelihood: 0.6,
                ..ReliabilityConfig::published_2010()
            },
        }
    }
}

impl RefinementConfig {
    /// Standard deviations of the camera's constant error about the axes of its frame, radians.
    pub(super) fn mount_error_rad(&self) -> Vector3<f64> {
        Vector3::new(self.mount_pitch_rad, self.mount_yaw_rad, self.mount_roll_rad)
    }

    /// Checks the ranges of all values.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        let counts = [
            ("refinement.max_tracks", self.max_tracks),
            ("refinement.max_fits", self.max_fits),
            ("refinement.max_births", self.max_births),
        ];
        for (key, count) in counts {
            require((1..=1000).contains(&count), key, "1 to 1000", count)?;
        }
        let poses = self.search_poses;
        require((1..=100_000).contains(&poses), "refinement.search_poses", "1 to 100000", poses)?;
        for (key, value) in [
            ("refinement.pixel_noise_px", self.pixel_noise_px),
            ("refinement.max_independent_pixels", self.max_independent_pixels),
            ("refinement.max_independent_evidence", self.max_independent_evidence),
            ("refinement.gate_px", self.gate_px),
            ("refinement.agreement_px", self.agreement_px),
            ("refinement.tilt_noise_rad", self.tilt_noise_rad),
            ("refinement.tilt_bias_rad", self.tilt_bias_rad),
            ("refinement.tilt_bias_secs", self.tilt_bias_secs),
            ("refinement.mount_secs", self.mount_secs),
            ("refinement.eye_noise_m", self.eye_noise_m),
            ("refinement.raise_bias_m", self.raise_bias_m),
            ("refinement.max_motion_m", self.max_motion_m),
            ("refinement.odometry_noise_m", self.odometry_noise_m),
            ("refinement.odometry_noise_rad", self.odometry_noise_rad),
            ("refinement.odometry_turn_noise_rad", self.odometry_turn_noise_rad),
            ("refinement.odometry_scale_error", self.odometry_scale_error),
            ("refinement.odometry_drift_rad_per_m", self.odometry_drift_rad_per_m),
            ("refinement.speed_m_per_s", self.speed_m_per_s),
            ("refinement.turn_rad_per_s", self.turn_rad_per_s),
            ("refinement.speed_secs", self.speed_secs),
            ("refinement.birth_noise_m", self.birth_noise_m),
            ("refinement.birth_noise_rad", self.birth_noise_rad),
            ("refinement.evidence_per_image", self.evidence_per_image),
            ("refinement.blurring_turn_rad_per_s", self.blurring_turn_rad_per_s),
            ("refinement.max_bend_evidence", self.max_bend_evidence),
            ("refinement.hopeless", self.hopeless),
            ("refinement.merge_distance_m", self.merge_distance_m),
            ("refinement.merge_turn_rad", self.merge_turn_rad),
            ("refinement.reliable_spread_m", self.reliable_spread_m),
        ] {
            require(value > 0.0 && value <= 1000.0, key, "above 0, at most 1000", value)?;
        }
        for (key, value) in [
            ("refinement.mount_pitch_rad", self.mount_pitch_rad),
            ("refinement.mount_roll_rad", self.mount_roll_rad),
            ("refinement.mount_yaw_rad", self.mount_yaw_rad),
            ("refinement.min_birth_agreement", self.min_birth_agreement),
            ("refinement.lost_agreement", self.lost_agreement),
            ("refinement.evidence_deadband", self.evidence_deadband),
            ("refinement.max_evidence_difference", self.max_evidence_difference),
            ("refinement.evidence_kept", self.evidence_kept),
            ("refinement.stale_evidence_kept", self.stale_evidence_kept),
        ] {
            require((0.0..=1.0).contains(&value), key, "0 to 1", value)?;
        }
        self.reliability.check()
    }
}
