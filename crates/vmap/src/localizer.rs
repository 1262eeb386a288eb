//! Where a camera is in a map that was made before.

use nalgebra::{Matrix6, Rotation3, Vector3};
use visloc_core::{
    Clock, GrayImage, Timestamp,
    geom::{Camera, CameraFrame, PlanarPose, Rigid3, Robot, World},
};
use visloc_slam::{
    ConfigError, FrameError, Slam, SlamConfig, TrackingState,
    map::{Map, MapId},
    track::Quality,
};

/// From this reliability on a camera counts as localized, as a robot on a drawn map does.
pub const LOCALIZED_RELIABILITY: f64 = 0.6;
/// Probability that an image that was recognized from nothing shows another place that looks alike. A dozen pairs agree on a pose then, and
/// as many landmarks again are found in five parts of the image, so it is a guess on the safe side.
const MISTAKEN: f64 = 0.3;
/// Factor on the odds of a mistake with every image in which a camera is followed well: a wrong place fits one image in three.
const MISTAKEN_AGAIN: f64 = 1.0 / 3.0;
/// Factor on the reliability with every image in which only a part of what should be seen is found.
const DOUBTED: f64 = 0.95;
/// Distance by odometry after which half of the reliability is gone, meters.
const CARRIED_HALF_M: f64 = 3.0;

/// What is known of a camera at one moment.
#[derive(Debug, Clone, Copy)]
pub struct CameraEstimate {
    /// When.
    pub at: Timestamp,
    /// The map.
    pub map: MapId,
    /// Where the camera is, in the frame and unit of the map.
    pub world_from_camera: Rigid3<World, CameraFrame>,
    /// Covariance over a twist in the frame of the camera: translation first, map units and radians.
    pub covariance: Matrix6<f64>,
    /// How far the pose can be trusted, 0 to 1; localized above [`LOCALIZED_RELIABILITY`].
    pub reliability: f64,
    /// Whether the image says nothing of the place: the pose is the last one, carried on by odometry.
    pub is_carried: bool,
    /// Whether the camera was found from nothing in this image.
    pub is_found: bool,
}

impl CameraEstimate {
    /// Whether the camera counts as localized.
    #[must_use]
    pub fn is_localized(&self) -> bool {
        self.reliability >= LOCALIZED_RELIABILITY
    }
}

/// What a robot knows beside the image.
#[derive(Debug, Clone, Copy)]
pub struct RobotMotion {
    /// The camera on the robot.
    pub robot_from_camera: Rigid3<Robot, CameraFrame>,
    /// Pose by odometry, in a frame of its own, meters.
    pub odometry: PlanarPose,
}

/// Finds a camera in a map and follows it there. The map stays as it is.
#[derive(Debug)]
pub struct MapLocalizer {
    slam: Slam,
    /// Odds that the place is another one.
    odds: f64,
    last: Option<CameraEstimate>,
    last_motion: Option<RobotMotion>,
    meters_per_unit: Option<f64>,
}

impl MapLocalizer {
    /// For one camera in a map. Where the scale of the map is known, odometry carries the pose on. The seed fixes every random choice.
    ///
    /// # Errors
    /// If a parameter is out of range.
    pub fn new(
        map: &Map,
        meters_per_unit: Option<f64>,
        camera: &Camera,
        config: &SlamConfig,
        seed: u64,
    ) -> Result<Self, ConfigError> {
        let slam = Slam::in_fixed_map(map.clone(), camera, config, seed)?;
        Ok(Self { slam, odds: 1.0, last: None, last_motion: None, meters_per_unit })
    }

    /// Measures times with a clock.
    pub fn set_clock(&mut self, clock: Clock) {
        self.slam.set_clock(clock);
    }

    /// The system below, to look at its map.
    #[must_use]
    pub fn slam(&self) -> &Slam {
        &self.slam
    }

    /// Takes the next image. `None` where nothing is known of the place.
    ///
    /// # Errors
    /// If the image cannot be used; it is left out.
    pub fn step(
        &mut self,
        at: Timestamp,
        image: GrayImage,
        motion: Option<RobotMotion>,
    ) -> Result<Option<CameraEstimate>, FrameError> {
        let outcome = self.slam.add_frame(at, image)?;
        let before = std::mem::replace(&mut self.last_motion, motion);
        let seen = outcome.camera_from_world.zip(outcome.covariance).zip(outcome.map);
        self.last = match (outcome.state, seen) {
            (TrackingState::Tracking(quality), Some(((pose, covariance), map)))
                if quality != Quality::Bad =>
            {
                if outcome.is_relocalized {
                    self.odds = MISTAKEN / (1.0 - MISTAKEN);
                } else if quality == Quality::Good {
                    self.odds *= MISTAKEN_AGAIN;
                }
                let mut reliability = 1.0 / (1.0 + self.odds);
                if quality != Quality::Good {
                    reliability *= DOUBTED;
                    self.odds = (1.0 - reliability) / reliability;
                }
                Some(CameraEstimate {
                    at,
                    map,
                    world_from_camera: pose.inverse(),
                    covariance,
                    reliability,
                    is_carried: false,
                    is_found: outcome.is_relocalized,
                })
            }
            _ => self
                .last
                .zip(before.zip(motion))
                .and_then(|(last, (before, now))| self.carried(&last, at, &before, &now)),
        };
        Ok(self.last)
    }

    /// The last estimate moved on by odometry.
    fn carried(
        &self,
        last: &CameraEstimate,
        at: Timestamp,
        before: &RobotMotion,
        now: &RobotMotion,
    ) -> Option<CameraEstimate> {
        let meters_per_unit = self.meters_per_unit?;
        let moved = planar(&before.odometry).inverse() * planar(&now.odometry);
        let camera_from_camera: Rigid3<CameraFrame, CameraFrame> =
            before.robot_from_camera.inverse() * moved * now.robot_from_camera;
        let meters = camera_from_camera.translation().norm();
        let turn = Rotation3::from_matrix_unchecked(*camera_from_camera.rotation());
        let step = Rigid3::new(turn, camera_from_camera.translation() / meters_per_unit);
        // Odometry is off by about a tenth of the way and of the turn. Source: Thrun, Burgard and Fox, "Probabilistic Robotics", 2005,
        // section 5.4, has the model; the tenth is what this program's robots are taken for.
        let (drift, twist) = (0.1 * meters / meters_per_unit, 0.1 * turn.angle());
        let mut covariance = last.covariance;
        for i in 0..3 {
            covariance[(i, i)] += drift * drift;
            covariance[(i + 3, i + 3)] += twist * twist;
        }
        Some(CameraEstimate {
            at,
            world_from_camera: last.world_from_camera * step,
            covariance,
            reliability: last.reliability * (-meters / CARRIED_HALF_M).exp2(),
            is_carried: true,
            is_found: false,
            ..*last
        })
    }
}

/// A pose on the ground as a motion in space.
fn planar(pose: &PlanarPose) -> Rigid3<Robot, Robot> {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), pose.yaw_rad);
    Rigid3::new(turn, Vector3::new(pose.x_m, pose.y_m, 0.0))
}
