//! A detector of robots and balls, as far as its results go: who is in view, with errors.

use nalgebra::{Point2, Point3};
use rand::RngExt as _;
use visloc_core::{
    Rng, gaussian,
    geom::{Camera, CameraFrame, PlanarPose, Rigid3, World},
};

/// Height of what is looked for on a robot, meters.
const CHEST_M: f64 = 0.35;
/// Half the width of a robot: who stands behind it is hidden, meters.
const HALF_WIDTH_M: f64 = 0.13;

visloc_core::with_defaults! {
    /// Errors of the detector.
    /// By default one in five is missed, one image in twenty has a false one; 3 degrees and 10 % of the range; robots to 5 m, balls to 3 m.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DetectorSetup {
        /// Probability that something in view is not seen.
        pub miss: f64 = 0.2,
        /// False detections for each image.
        pub false_per_image: f64 = 0.05,
        /// Standard deviation of the bearing, radians.
        pub bearing_sigma_rad: f64 = 3.0_f64.to_radians(),
        /// Standard deviation of the range as a share of it.
        pub range_sigma: f64 = 0.1,
        /// Farthest robot and farthest ball that are seen, meters.
        pub max_range_m: (f64, f64) = (5.0, 3.0),
    }
}

/// Something that was detected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Whether it looks like a ball; otherwise like a robot of the own team.
    pub is_ball: bool,
    /// From straight ahead of the body to the left, radians.
    pub bearing_rad: f64,
    /// Along the floor, meters.
    pub range_m: f64,
    /// Which of the others it is, for evaluation; `None` for the ball and what is not there.
    pub who: Option<usize>,
    /// Whether it is there.
    pub is_true: bool,
}

/// What a robot could see.
#[derive(Debug, Clone, Copy)]
pub(super) struct View<'a> {
    pub camera: &'a Camera,
    pub world_from_camera: Rigid3<World, CameraFrame>,
    pub world_from_robot: PlanarPose,
    /// All other robots.
    pub others: &'a [PlanarPose],
    pub ball: Point2<f64>,
}

impl View<'_> {
    /// What a detector makes of it.
    pub fn detect(&self, setup: &DetectorSetup, rng: &mut Rng) -> Vec<Detection> {
        let mut found = Vec::new();
        let robots = self.others.iter().enumerate().map(|(i, pose)| (Some(i), pose.position(), CHEST_M));
        for (who, at, height_m) in robots.chain([(None, self.ball, 0.05)]) {
            let max_m = if who.is_some() { setup.max_range_m.0 } else { setup.max_range_m.1 };
            // Drawn in any case, so that what one robot sees does not change what the next one draws.
            let is_missed = rng.random_bool(setup.miss);
            let (bearing_noise, range_noise) = (gaussian(rng, 1.0), gaussian(rng, 1.0));
            let (bearing_rad, range_m) = self.polar(&at);
            if is_missed || range_m > max_m || !self.is_in_view(&at, height_m) || self.is_hidden(&at) {
                continue;
            }
            found.push(Detection {
                is_ball: who.is_none(),
                bearing_rad: bearing_rad + setup.bearing_sigma_rad * bearing_noise,
                range_m: (range_m * (1.0 + setup.range_sigma * range_noise)).max(0.1),
                who,
                is_true: true,
            });
        }
        if rng.random_bool(setup.false_per_image) {
            let is_ball = rng.random_bool(0.5);
            let axis = self.world_from_camera.rotation().column(2).into_owned();
            let ahead_rad = axis.y.atan2(axis.x) - self.world_from_robot.yaw_rad;
            let half_rad = 0.5 * f64::from(self.camera.size_px().0) / self.camera.focal_px().0;
            let max_m = if is_ball { setup.max_range_m.1 } else { setup.max_range_m.0 };
            let bearing_rad = ahead_rad + rng.random_range(-half_rad..=half_rad);
            let range_m = rng.random_range(0.5..=max_m);
            found.push(Detection { is_ball, bearing_rad, range_m, who: None, is_true: false });
        }
        found
    }

    fn polar(&self, at: &Point2<f64>) -> (f64, f64) {
        let point = self.world_from_robot.inverse().transform(at);
        (point.y.atan2(point.x), point.coords.norm())
    }

    fn is_in_view(&self, at: &Point2<f64>, height_m: f64) -> bool {
        let in_camera = self.world_from_camera.inverse().transform(&Point3::new(at.x, at.y, height_m));
        self.camera.project(&in_camera).is_ok_and(|px| self.camera.contains(&px))
    }

    /// Whether another robot stands in the line of sight.
    fn is_hidden(&self, at: &Point2<f64>) -> bool {
        let eye = self.world_from_robot.position();
        let way = at - eye;
        let length_m = way.norm();
        self.others.iter().any(|other| {
            let to = other.position() - eye;
            let along_m = to.dot(&way) / length_m;
            let across_m = (to - way * (along_m / length_m)).norm();
            across_m < HALF_WIDTH_M && along_m > 0.0 && along_m < length_m - 2.0 * HALF_WIDTH_M
        })
    }
}
