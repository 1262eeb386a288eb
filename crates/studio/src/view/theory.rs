//! The theoretical image: what the map looks like from a pose.
//!
//! Source: 2010 section 4.3. For pictures only; the algorithms have models of their own.

use nalgebra::{Point2, Point3, Vector2};
use visloc_core::geom::{Camera, CameraFrame, PlanarPose, Rigid3, Robot};
use visloc_world::{
    Map,
    field::{Field, Goal, Segment},
    office::Office,
};

use super::polylines::Projector;

/// Corners of the polygon that stands for the center circle.
const CIRCLE_CORNERS: i32 = 48;
/// How far from a corner a line may begin and still be seen past it, meters.
const SLACK_M: f64 = 0.03;
/// Borders of the floor are seen or hidden in pieces of this length, meters.
const PIECE_M: f64 = 0.5;

/// Borders of the map in the image of a robot at a pose: x and y in pixels, a pair of NaN after each line.
pub fn theoretical_image(
    map: &Map,
    camera: &Camera,
    world_from_robot: &PlanarPose,
    robot_from_camera: &Rigid3<Robot, CameraFrame>,
) -> Vec<f64> {
    let world_from_camera = world_from_robot.to_rigid3() * *robot_from_camera;
    let eye = Point3::from(*world_from_camera.translation());
    let mut projector = Projector::new(camera, &world_from_camera);
    match map {
        Map::Field(field) => draw_field(field, &eye, &mut projector),
        Map::Office(office) => draw_office(office, &eye, &mut projector),
        _ => {}
    }
    projector.finish()
}

fn draw_field(field: &Field, eye: &Point3<f64>, projector: &mut Projector<'_>) {
    let half_width_m = field.dimensions().line_width_m / 2.0;
    for segment in field.lines().iter().chain(field.marks()) {
        draw_strip(segment, half_width_m, projector);
    }
    for radius_m in [-half_width_m, half_width_m].map(|offset| field.circle_radius_m() + offset) {
        let corner = |i: i32| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / f64::from(CIRCLE_CORNERS)).sin_cos();
            Point3::new(radius_m * cos, radius_m * sin, 0.0)
        };
        projector.path(&(0..=CIRCLE_CORNERS).map(corner).collect::<Vec<_>>());
    }
    for goal in field.goals() {
        draw_goal(goal, eye, projector);
    }
}

fn draw_strip(segment: &Segment, half_width_m: f64, projector: &mut Projector<'_>) {
    let along = (segment.end - segment.start).normalize();
    let across = Vector2::new(-along.y, along.x) * half_width_m;
    for side in [across, -across] {
        projector.line(on_floor(&(segment.start + side)), on_floor(&(segment.end + side)));
    }
}

/// Both borders of each post as the eye sees them, and those of the crossbar.
fn draw_goal(goal: &Goal, eye: &Point3<f64>, projector: &mut Projector<'_>) {
    for y_m in [-goal.post_y_m, goal.post_y_m] {
        let post = Point2::new(goal.x_m, y_m);
        let ahead = (post - eye.xy()).normalize();
        let across = Vector2::new(-ahead.y, ahead.x) * goal.post_radius_m;
        for side in [across, -across] {
            let foot = post + side;
            projector.line(on_floor(&foot), Point3::new(foot.x, foot.y, goal.crossbar_z_m));
        }
    }
    for z_m in [-goal.post_radius_m, goal.post_radius_m].map(|offset| goal.crossbar_z_m + offset) {
        projector.line(Point3::new(goal.x_m, -goal.post_y_m, z_m), Point3::new(goal.x_m, goal.post_y_m, z_m));
    }
}

fn draw_office(office: &Office, eye: &Point3<f64>, projector: &mut Projector<'_>) {
    let eye_on_floor = eye.xy();
    let is_seen =
        |point: &Point2<f64>| office.walls().iter().all(|wall| !wall.hides(&eye_on_floor, point, SLACK_M));
    for wall in office.walls() {
        if (eye_on_floor - wall.start).dot(&wall.normal()) <= 0.0 {
            continue;
        }
        let length_m = (wall.end - wall.start).norm();
        let num_pieces = (length_m / PIECE_M).ceil().clamp(1.0, 200.0);
        let mut i = 0.0;
        while i < num_pieces {
            let [from, to] = [i, i + 1.0].map(|k| wall.start + (wall.end - wall.start) * (k / num_pieces));
            if is_seen(&nalgebra::center(&from, &to)) {
                projector.line(on_floor(&from), on_floor(&to));
            }
            i += 1.0;
        }
    }
    for door in office.doors() {
        let Some(wall) = office.walls().get(door.wall) else { continue };
        if (eye_on_floor - wall.start).dot(&wall.normal()) <= 0.0 {
            continue;
        }
        for edge in [door.left, door.right].iter().filter(|edge| is_seen(edge)) {
            projector.line(on_floor(edge), Point3::new(edge.x, edge.y, door.height_m));
        }
    }
}

fn on_floor(point: &Point2<f64>) -> Point3<f64> {
    Point3::new(point.x, point.y, 0.0)
}
