//! Poses that agree with a part of what is seen: a door's edge on a wall gives the whole pose, once for each door.

use std::f64::consts::PI;

use nalgebra::{Point2, Point3, Vector2};
use rand::RngExt;
use visloc_core::{
    Rng,
    geom::{PlanarPose, angle},
};
use visloc_world::office::Office;

use super::lines::TheoreticalLine;
use crate::vision::{DoorSide, FeatureKind, Percept};

/// A door's edge as it is seen: from the camera along a direction on the ground, in the robot's axes.
#[derive(Debug, Clone, Copy)]
struct DoorRay {
    direction: Vector2<f64>,
    side: DoorSide,
    paint: u8,
}

/// What a percept says about the place.
#[derive(Debug, Clone, Default)]
pub(super) struct Clues {
    doors: Vec<DoorRay>,
    /// Where walls and doors meet the floor, (x, y) of the robot, meters.
    feet: Vec<Point2<f64>>,
    eye: Point2<f64>,
}

/// Two points of the floor's border must be this far apart to tell the direction of a wall, meters.
const MIN_BASE_M: f64 = 0.15;
/// Farther doors are too uncertain, meters.
const MAX_DOOR_M: f64 = 8.0;
/// Tries until a proposal lies where a robot can be.
const TRIES: usize = 6;
/// Share of the proposals that do not trust the walls' directions.
const LOOSE_SHARE: f64 = 0.1;

impl Clues {
    /// Takes the pixels of a percept apart.
    pub fn collect(&mut self, percept: &Percept) {
        self.doors.clear();
        self.feet.clear();
        let eye = Point3::from(*percept.robot_from_camera.translation());
        self.eye = Point2::new(eye.x, eye.y);
        let camera = percept.camera.without_distortion();
        for pixel in &percept.pixels {
            let ray = percept.robot_from_camera.rotate(&camera.bearing(&pixel.ideal_px));
            let ahead = Vector2::new(ray.x, ray.y);
            match pixel.kind {
                FeatureKind::DoorEdge { side, paint } => {
                    if let Some(direction) = ahead.try_normalize(1e-9) {
                        self.doors.push(DoorRay { direction, side, paint });
                    }
                }
                FeatureKind::WallFoot | FeatureKind::DoorFoot if ray.z < 0.0 => {
                    self.feet.push(self.eye + ahead * (-eye.z / ray.z));
                }
                _ => {}
            }
        }
    }

    /// A pose anywhere in the building.
    pub fn anywhere(&self, office: &Office, rng: &mut Rng) -> PlanarPose {
        let in_cell = [rng.random_range(0.0..1.0), rng.random_range(0.0..1.0)];
        let place = office.free_space().place(rng.random_range(0.0..1.0), in_cell).unwrap_or_default();
        PlanarPose::new(place.x, place.y, rng.random_range(-PI..PI))
    }

    /// A pose that agrees with a door's edge and a wall that are seen, or else with a wall.
    pub fn propose(&self, office: &Office, rng: &mut Rng) -> PlanarPose {
        for _ in 0..TRIES {
            let Some(wall) = self.seen_wall(rng) else { break };
            let is_loose = rng.random_bool(LOOSE_SHARE);
            let pose = if self.doors.is_empty() || is_loose {
                Self::along_a_wall(&wall, office, rng)
            } else {
                self.at_a_door(&wall, office, rng)
            };
            if let Some(pose) = pose.filter(|pose| office.free_space().contains(pose.x_m, pose.y_m)) {
                return pose;
            }
        }
        self.anywhere(office, rng)
    }

    /// Two points of the floor's border, taken at random, as a wall.
    fn seen_wall(&self, rng: &mut Rng) -> Option<SeenWall> {
        for _ in 0..TRIES {
            if self.feet.len() < 2 {
                return None;
            }
            let [a, b] = [0, 1].map(|_| self.feet[rng.random_range(0..self.feet.len())]);
            let along = b - a;
            if along.norm() > MIN_BASE_M {
                let along = along.normalize();
                // From left to right for the robot: the robot is at the right of the way along it.
                let sign = if along.perp(&(self.eye - a)) < 0.0 { 1.0 } else { -1.0 };
                return Some(SeenWall { at: a, along: along * sign });
            }
        }
        None
    }

    /// One of the building's doors in place of the one that is seen.
    fn at_a_door(&self, wall: &SeenWall, office: &Office, rng: &mut Rng) -> Option<PlanarPose> {
        let seen = self.doors[rng.random_range(0..self.doors.len())];
        // Where the ray meets the wall.
        let across = seen.direction.perp(&wall.along);
        let distance_m = (wall.at - self.eye).perp(&wall.along) / across;
        if !(0.0..=MAX_DOOR_M).contains(&distance_m) {
            return None;
        }
        let edge_in_robot = self.eye + seen.direction * distance_m;
        let door = &office.doors()[rng.random_range(0..office.doors().len())];
        if door.paint != seen.paint || door.is_open {
            return None;
        }
        let edge = match seen.side {
            DoorSide::Left => door.left,
            DoorSide::Right => door.right,
        };
        Some(pose_at(&edge, &office.walls()[door.wall].direction(), &edge_in_robot, &wall.along))
    }

    /// One of the building's walls in place of the one that is seen, anywhere along it.
    fn along_a_wall(wall: &SeenWall, office: &Office, rng: &mut Rng) -> Option<PlanarPose> {
        let along_all: f64 = rng.random_range(0.0..1.0) * office.wall_length_m();
        let mut rest_m = along_all;
        for real in office.walls() {
            let length_m = (real.end - real.start).norm();
            if rest_m <= length_m {
                let at = real.start + real.direction() * rest_m;
                return Some(pose_at(&at, &real.direction(), &wall.at, &wall.along));
            }
            rest_m -= length_m;
        }
        None
    }

    /// A heading that turns a door's edge that is seen onto one of the lines around, or a wall onto a wall.
    pub fn propose_heading<'a>(
        &self,
        (x_m, y_m): (f64, f64),
        num_lines: usize,
        line: impl Fn(usize) -> &'a TheoreticalLine,
        rng: &mut Rng,
    ) -> f64 {
        let uniform = rng.random_range(-PI..PI);
        if num_lines == 0 {
            return uniform;
        }
        for _ in 0..4 * TRIES {
            let line = line(rng.random_range(0..num_lines));
            match line.kind {
                FeatureKind::DoorEdge { side, paint } if !self.doors.is_empty() => {
                    let seen = self.doors[rng.random_range(0..self.doors.len())];
                    if (seen.side, seen.paint) == (side, paint) {
                        let to_edge = line.start - Point2::new(x_m, y_m);
                        return angle::wrap(direction_rad(&to_edge) - direction_rad(&seen.direction));
                    }
                }
                _ if self.doors.is_empty() => {
                    if let Some(wall) = self.seen_wall(rng) {
                        // A wall's direction, from left to right, is its normal turned to the left.
                        let real = Vector2::new(-line.normal.y, line.normal.x);
                        return angle::wrap(direction_rad(&real) - direction_rad(&wall.along));
                    }
                }
                _ => {}
            }
        }
        uniform
    }
}

/// A wall as it is seen: a point on it and its direction from left to right, in the robot's axes.
#[derive(Debug, Clone, Copy)]
struct SeenWall {
    at: Point2<f64>,
    along: Vector2<f64>,
}

/// The pose from which a point of the world with a direction is seen at a place of the robot's axes with a direction.
fn pose_at(
    world: &Point2<f64>,
    world_direction: &Vector2<f64>,
    in_robot: &Point2<f64>,
    robot_direction: &Vector2<f64>,
) -> PlanarPose {
    let yaw_rad = angle::wrap(direction_rad(world_direction) - direction_rad(robot_direction));
    let (sin, cos) = yaw_rad.sin_cos();
    PlanarPose::new(
        world.x - (cos * in_robot.x - sin * in_robot.y),
        world.y - (sin * in_robot.x + cos * in_robot.y),
        yaw_rad,
    )
}

fn direction_rad(v: &Vector2<f64>) -> f64 {
    v.y.atan2(v.x)
}
