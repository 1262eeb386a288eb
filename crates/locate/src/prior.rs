//! What is known about the pose before the first image.

use std::f64::consts::FRAC_PI_2;

use rand::RngExt;
use serde::{Deserialize, Serialize};
use visloc_core::{
    Rng, gaussian,
    geom::{PlanarPose, angle},
};
use visloc_world::{Map, field::Field};

use crate::{ConfigError, Region, require};

/// A pose agrees with a prior within so many standard deviations.
const MAX_DEVIATION: f64 = 3.0;

/// Where the robot may be at the start.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub enum StartPrior {
    /// Anywhere on the map with any heading.
    #[default]
    Uniform,
    /// Anywhere in a part of the map, with a heading if that is known.
    Region {
        /// The part of the map.
        region: Region,
        /// The heading; `None` if it may be any.
        heading: Option<HeadingPrior>,
    },
    /// Near one of several poses.
    Poses(Vec<PosePrior>),
    /// On one of the side lines, facing the field: where a robot comes back after a penalty.
    SideLines(SideLines),
}

/// A heading that is roughly known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HeadingPrior {
    /// The heading, radians.
    pub yaw_rad: f64,
    /// Its standard deviation, radians.
    pub spread_rad: f64,
}

/// A pose that is roughly known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PosePrior {
    /// The pose.
    pub world_from_robot: PlanarPose,
    /// Standard deviation of x and y, meters.
    pub position_spread_m: f64,
    /// Standard deviation of the heading, radians.
    pub heading_spread_rad: f64,
    /// How probable it is beside the others; the sum may be anything.
    pub weight: f64,
}

/// The stretches of the two side lines where robots come back, facing the field.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SideLines {
    /// Least x, meters.
    pub min_x_m: f64,
    /// Largest x, meters.
    pub max_x_m: f64,
    /// The side lines are this far to both sides of the middle, meters.
    pub half_width_m: f64,
    /// Standard deviation of the distance from the line, meters.
    pub position_spread_m: f64,
    /// Standard deviation of the heading, radians.
    pub heading_spread_rad: f64,
}

/// The half of the field that a robot comes back to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Half {
    /// Negative x.
    Negative,
    /// Positive x.
    Positive,
    /// Either.
    Both,
}

impl SideLines {
    /// The side lines of a field, with a spread of 0.15 m and 0.2 rad: robots are put down by hand.
    pub fn of(field: &Field, half: Half) -> Self {
        let dimensions = field.dimensions();
        let half_length = dimensions.length_m / 2.0;
        let (min_x_m, max_x_m) = match half {
            Half::Negative => (-half_length, 0.0),
            Half::Positive => (0.0, half_length),
            Half::Both => (-half_length, half_length),
        };
        Self {
            min_x_m,
            max_x_m,
            half_width_m: dimensions.width_m / 2.0,
            position_spread_m: 0.15,
            heading_spread_rad: 0.2,
        }
    }

    fn sample(&self, rng: &mut Rng) -> PlanarPose {
        let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        PlanarPose::new(
            rng.random_range(self.min_x_m..=self.max_x_m),
            side * self.half_width_m + gaussian(rng, self.position_spread_m),
            -side * FRAC_PI_2 + gaussian(rng, self.heading_spread_rad),
        )
    }
}

impl PosePrior {
    /// A random pose around it.
    pub fn sample(&self, rng: &mut Rng) -> PlanarPose {
        let center = &self.world_from_robot;
        PlanarPose::new(
            center.x_m + gaussian(rng, self.position_spread_m),
            center.y_m + gaussian(rng, self.position_spread_m),
            center.yaw_rad + gaussian(rng, self.heading_spread_rad),
        )
    }
}

impl StartPrior {
    /// The half of a field in which a pose lies, with any heading; anywhere on other maps.
    pub fn half_of(map: &Map, world_from_robot: &PlanarPose) -> Self {
        let Map::Field(field) = map else { return Self::Uniform };
        let (half_x, half_y) = field.half_carpet_m();
        let (min_x_m, max_x_m) = if world_from_robot.x_m > 0.0 { (0.0, half_x) } else { (-half_x, 0.0) };
        let region = Region { min_x_m, max_x_m, min_y_m: -half_y, max_y_m: half_y };
        Self::Region { region, heading: None }
    }

    /// Refuses what no pose can be drawn from: values that are not finite, spreads and weights below 0, regions whose end comes before their begin.
    ///
    /// # Errors
    /// With what was expected and found.
    pub fn check(&self) -> Result<(), ConfigError> {
        let finite = |key, found: f64| require(found.is_finite(), key, "a finite number", found);
        let spread = |key, found: f64| {
            require(found.is_finite() && found >= 0.0, key, "a finite number of at least 0", found)
        };
        let range = |key, (least, most): (f64, f64)| {
            let is_range = least.is_finite() && most.is_finite() && least <= most;
            require(
                is_range,
                key,
                "a finite range whose end is not before its begin",
                format!("{least} to {most}"),
            )
        };
        match self {
            Self::Uniform => Ok(()),
            Self::Region { region, heading } => {
                range("start.region.x_m", (region.min_x_m, region.max_x_m))?;
                range("start.region.y_m", (region.min_y_m, region.max_y_m))?;
                let Some(heading) = heading else { return Ok(()) };
                finite("start.heading.yaw_rad", heading.yaw_rad)?;
                spread("start.heading.spread_rad", heading.spread_rad)
            }
            Self::Poses(poses) => {
                for pose in poses {
                    let found = &pose.world_from_robot;
                    require(
                        found.is_finite(),
                        "start.poses.world_from_robot",
                        "finite numbers",
                        format!("{found:?}"),
                    )?;
                    spread("start.poses.position_spread_m", pose.position_spread_m)?;
                    spread("start.poses.heading_spread_rad", pose.heading_spread_rad)?;
                    spread("start.poses.weight", pose.weight)?;
                }
                Ok(())
            }
            Self::SideLines(lines) => {
                range("start.side_lines.x_m", (lines.min_x_m, lines.max_x_m))?;
                finite("start.side_lines.half_width_m", lines.half_width_m)?;
                spread("start.side_lines.position_spread_m", lines.position_spread_m)?;
                spread("start.side_lines.heading_spread_rad", lines.heading_spread_rad)
            }
        }
    }

    /// Whether nothing is known.
    pub fn is_uniform(&self) -> bool {
        *self == Self::Uniform
    }

    /// Probability that a pose agrees with it, 0 to 1, whose position is known to `spread_m` (standard deviation in meters, in each axis): at the edge
    /// of a region it is even. Of poses and side lines three of their own standard deviations are allowed.
    pub fn agreement(&self, pose: &PlanarPose, spread_m: f64) -> f64 {
        let is_near = |yaw_rad: f64, spread_rad: f64| {
            angle::difference(pose.yaw_rad, yaw_rad).abs() <= MAX_DEVIATION * spread_rad
        };
        let whether = |agrees: bool| f64::from(u8::from(agrees));
        match self {
            Self::Uniform => 1.0,
            Self::Region { region, heading } => {
                whether(heading.is_none_or(|h| is_near(h.yaw_rad, h.spread_rad)))
                    * probability_inside(region, pose, spread_m)
            }
            Self::Poses(poses) => whether(poses.iter().any(|p| {
                pose.distance_m(&p.world_from_robot) <= MAX_DEVIATION * p.position_spread_m
                    && is_near(p.world_from_robot.yaw_rad, p.heading_spread_rad)
            })),
            Self::SideLines(lines) => whether([1.0, -1.0].into_iter().any(|side| {
                let reach = MAX_DEVIATION * lines.position_spread_m;
                (lines.min_x_m - reach..=lines.max_x_m + reach).contains(&pose.x_m)
                    && (pose.y_m - side * lines.half_width_m).abs() <= reach
                    && is_near(-side * FRAC_PI_2, lines.heading_spread_rad)
            })),
        }
    }

    /// Whether it tells the heading.
    pub fn has_heading(&self) -> bool {
        match self {
            Self::Uniform => false,
            Self::Region { heading, .. } => heading.is_some(),
            Self::Poses(_) | Self::SideLines(_) => true,
        }
    }

    /// A random pose from the prior. What falls outside of the map is moved to its edge.
    pub fn sample(&self, map: &Region, rng: &mut Rng) -> PlanarPose {
        let pose = match self {
            Self::Uniform => map.sample(rng),
            Self::Region { region, heading } => {
                let mut pose = region.sample(rng);
                if let Some(heading) = heading {
                    let yaw_rad = heading.yaw_rad + gaussian(rng, heading.spread_rad);
                    pose = PlanarPose::new(pose.x_m, pose.y_m, yaw_rad);
                }
                pose
            }
            Self::Poses(poses) => match choose(poses, rng) {
                Some(pose) => pose.sample(rng),
                None => map.sample(rng),
            },
            Self::SideLines(lines) => lines.sample(rng),
        };
        let x_m = pose.x_m.clamp(map.min_x_m, map.max_x_m);
        PlanarPose { x_m, y_m: pose.y_m.clamp(map.min_y_m, map.max_y_m), ..pose }
    }
}

/// One of the poses by weight; `None` if there is none with a weight.
fn choose<'a>(poses: &'a [PosePrior], rng: &mut Rng) -> Option<&'a PosePrior> {
    let total: f64 = poses.iter().map(|pose| pose.weight.max(0.0)).sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let mut mark = rng.random::<f64>() * total;
    for pose in poses.iter().filter(|pose| pose.weight > 0.0) {
        mark -= pose.weight;
        if mark < 0.0 {
            return Some(pose);
        }
    }
    poses.iter().rfind(|pose| pose.weight > 0.0)
}

/// Probability that a position is inside of a region, with errors of a logistic distribution in each axis.
fn probability_inside(region: &Region, pose: &PlanarPose, spread_m: f64) -> f64 {
    let is_beyond = |by_m: f64| {
        1.0 / (1.0 + (-by_m * std::f64::consts::PI / (3.0_f64.sqrt() * spread_m.max(1e-9))).exp())
    };
    let is_between =
        |at_m: f64, least_m: f64, most_m: f64| is_beyond(at_m - least_m) * is_beyond(most_m - at_m);
    is_between(pose.x_m, region.min_x_m, region.max_x_m)
        * is_between(pose.y_m, region.min_y_m, region.max_y_m)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use visloc_core::RngTree;
    use visloc_world::Map;

    use super::*;

    const MAP: Region = Region { min_x_m: -4.0, max_x_m: 4.0, min_y_m: -3.0, max_y_m: 3.0 };

    fn samples(prior: &StartPrior) -> Vec<PlanarPose> {
        let mut rng = RngTree::new(8).stream("prior", 0);
        (0..4000).map(|_| prior.sample(&MAP, &mut rng)).collect()
    }

    fn share(samples: &[PlanarPose], holds: impl Fn(&PlanarPose) -> bool) -> f64 {
        samples.iter().filter(|pose| holds(pose)).count() as f64 / samples.len() as f64
    }

    #[test]
    fn a_prior_that_no_pose_can_be_drawn_from_is_refused() {
        let pose = PosePrior {
            world_from_robot: PlanarPose::new(1.0, 0.5, 0.2),
            position_spread_m: 0.0,
            heading_spread_rad: 0.1,
            weight: 0.0,
        };
        let region = MAP;
        let heading = HeadingPrior { yaw_rad: 1.0, spread_rad: 0.2 };
        let lines = SideLines {
            min_x_m: -3.0,
            max_x_m: 0.0,
            half_width_m: 2.0,
            position_spread_m: 0.1,
            heading_spread_rad: 0.1,
        };
        let good = [
            StartPrior::Uniform,
            StartPrior::Region { region, heading: Some(heading) },
            StartPrior::Poses(vec![pose]),
            StartPrior::Poses(Vec::new()),
            StartPrior::SideLines(lines),
        ];
        for prior in good {
            assert_eq!(prior.check(), Ok(()), "{prior:?}");
        }
        let bad = |prior: StartPrior| prior.check().unwrap_err().to_string();
        let nowhere = PlanarPose { x_m: f64::NAN, ..pose.world_from_robot };
        assert!(
            bad(StartPrior::Poses(vec![pose, PosePrior { world_from_robot: nowhere, ..pose }]))
                .contains("NaN")
        );
        assert_eq!(
            bad(StartPrior::Poses(vec![PosePrior { position_spread_m: -1.0, ..pose }])),
            "start.poses.position_spread_m: expected a finite number of at least 0, found -1"
        );
        let turned = Region { min_x_m: 4.0, max_x_m: -4.0, ..region };
        assert_eq!(
            bad(StartPrior::Region { region: turned, heading: None }),
            "start.region.x_m: expected a finite range whose end is not before its begin, found 4 to -4"
        );
        let turned = SideLines { max_x_m: -5.0, ..lines };
        assert!(bad(StartPrior::SideLines(turned)).contains("found -3 to -5"));
        let map = Map::built_in("robocup-spl-2010").unwrap();
        assert!(crate::Pipeline::builder(&map).start(StartPrior::SideLines(turned)).build().is_err());
    }

    #[test]
    fn uniform_fills_the_map() {
        let all = samples(&StartPrior::Uniform);
        assert!(all.iter().all(|pose| MAP.contains(pose)));
        assert!((share(&all, |p| p.x_m > 0.0 && p.y_m < 0.0) - 0.25).abs() < 0.03);
        assert!((share(&all, |p| p.yaw_rad > PI / 2.0) - 0.25).abs() < 0.03);
    }

    #[test]
    fn region_with_and_without_heading() {
        let region = Region { min_x_m: -4.0, max_x_m: -2.0, min_y_m: 0.0, max_y_m: 3.0 };
        let any = samples(&StartPrior::Region { region, heading: None });
        assert!(any.iter().all(|pose| region.contains(pose)));
        assert!((share(&any, |p| p.yaw_rad > 0.0) - 0.5).abs() < 0.03);
        let heading = Some(HeadingPrior { yaw_rad: PI, spread_rad: 0.1 });
        let west = samples(&StartPrior::Region { region, heading });
        assert!(west.iter().all(|p| p.heading_difference_rad(&PlanarPose::new(0.0, 0.0, PI)) < 0.5));
        assert!((share(&west, |p| p.yaw_rad > 0.0) - 0.5).abs() < 0.03, "on both sides of pi");
    }

    #[test]
    fn poses_by_weight_and_spread() {
        let at = |x, weight| PosePrior {
            world_from_robot: PlanarPose::new(x, 0.0, 0.5),
            position_spread_m: 0.1,
            heading_spread_rad: 0.05,
            weight,
        };
        let all = samples(&StartPrior::Poses(vec![at(-2.0, 3.0), at(1.0, 0.0), at(2.0, 1.0)]));
        assert!((share(&all, |p| (p.x_m + 2.0).abs() < 0.6) - 0.75).abs() < 0.03);
        assert!((share(&all, |p| (p.x_m - 2.0).abs() < 0.6) - 0.25).abs() < 0.03);
        let deviation = (all.iter().map(|p| p.y_m * p.y_m).sum::<f64>() / 4000.0).sqrt();
        assert!((deviation - 0.1).abs() < 0.01, "{deviation}");
        assert!(samples(&StartPrior::Poses(Vec::new())).iter().all(|pose| MAP.contains(pose)));
    }

    #[test]
    fn side_lines_face_the_field() {
        let Map::Field(field) = Map::load("robocup-spl-2010").unwrap() else { panic!("a field") };
        let lines = SideLines::of(&field, Half::Negative);
        assert_eq!((lines.min_x_m, lines.max_x_m, lines.half_width_m), (-3.0, 0.0, 2.0));
        let all = samples(&StartPrior::SideLines(lines));
        assert!(all.iter().all(|p| p.x_m <= 0.0 && (p.y_m.abs() - 2.0).abs() < 1.0));
        // half a meter ahead is nearer to the middle
        assert!(all.iter().all(|p| (p.y_m + 0.5 * p.yaw_rad.sin()).abs() < p.y_m.abs()));
        assert!((share(&all, |p| p.y_m > 0.0) - 0.5).abs() < 0.03);
    }

    #[test]
    fn samples_stay_on_the_map() {
        let far = PosePrior {
            world_from_robot: PlanarPose::new(9.0, 0.0, 0.0),
            position_spread_m: 0.1,
            heading_spread_rad: 0.1,
            weight: 1.0,
        };
        assert!(samples(&StartPrior::Poses(vec![far])).iter().all(|pose| MAP.contains(pose)));
    }
}
