//! Labels agree with the geometry of the map, and with the pictures.

use nalgebra::{Point2, Point3};
use visloc_core::{
    RngTree, Source,
    geom::{Camera, CameraFrame, PlanarPose, Rigid3, World, nao},
};
use visloc_sim::{Color, FieldLook, Label, LabelImage, Renderer, Scenario, Scene, Shot, Simulation};
use visloc_world::{Map, field::Field};

fn field() -> Field {
    match Map::load("robocup-spl-2010").unwrap() {
        Map::Field(field) => field,
        _ => panic!("a field"),
    }
}

fn scene(field: &Field) -> Scene {
    let mut scene = Scene::new(vec![], 1.0, (3.0, 2.0));
    scene.add_field(field, &FieldLook::default(), &mut RngTree::new(1).stream("field", 0));
    scene
}

fn camera() -> Camera {
    Camera::pinhole((320, 240), (373.3, 373.3), (159.5, 119.5)).unwrap()
}

fn world_from_camera(x_m: f64, y_m: f64, yaw_deg: f64, tilt_deg: f64) -> Rigid3<World, CameraFrame> {
    let head = nao::HeadAngles { yaw_rad: 0.0, pitch_rad: tilt_deg.to_radians() };
    let mount = nao::robot_from_camera(&nao::Torso::upright(), &head, nao::NaoCamera::TopV4);
    PlanarPose::new(x_m, y_m, yaw_deg.to_radians()).to_rigid3() * mount
}

fn at(labels: &LabelImage, pose: &Rigid3<World, CameraFrame>, point: Point3<f64>) -> Option<Label> {
    let px: Point2<f64> = camera().project(&pose.inverse().transform(&point)).ok()?;
    labels.get(px.x.round() as i64, px.y.round() as i64)
}

#[test]
fn lines_carpet_posts_and_bases_have_their_labels() {
    let field = field();
    let scene = scene(&field);
    let mut renderer = Renderer::new(&camera());
    let pose = world_from_camera(0.6, 0.0, 0.0, 12.0);
    let labels = renderer.labels(&scene, &[], &pose);
    let [goal, _] = field.goals();
    assert_eq!(at(&labels, &pose, Point3::new(goal.x_m, goal.post_y_m, 0.3)), Some(Label::YellowGoal));
    assert_eq!(at(&labels, &pose, Point3::new(goal.x_m + 0.3, goal.post_y_m, 0.02)), Some(Label::GoalBack));
    // The penalty area's front line, 0.6 m before the goal line, and the carpet 10 cm before it.
    assert_eq!(at(&labels, &pose, Point3::new(goal.x_m - 0.6, 0.2, 0.0)), Some(Label::Line));
    assert_eq!(at(&labels, &pose, Point3::new(goal.x_m - 0.7, 0.2, 0.0)), Some(Label::Carpet));
    assert_eq!(labels.get(-1, 0), None);
    assert_eq!(labels.count(Label::BlueGoal), 0);
    let circle = world_from_camera(-1.5, 0.0, 0.0, 12.0);
    let labels = renderer.labels(&scene, &[], &circle);
    assert_eq!(at(&labels, &circle, Point3::new(field.circle_radius_m(), 0.0, 0.0)), Some(Label::Line));
}

#[test]
fn a_robot_hides_what_is_behind_it() {
    let field = field();
    let mut scene = scene(&field);
    let figure = scene.robot_figure(Color::from_hex(0x20_40c0));
    let mut moving = Vec::new();
    figure.place(&scene, &PlanarPose::new(2.2, 0.0, 3.1), (0.0, 0.0), &mut moving);
    let pose = world_from_camera(0.8, 0.0, 0.0, 12.0);
    let mut renderer = Renderer::new(&camera());
    let (free, hidden) = (renderer.labels(&scene, &[], &pose), renderer.labels(&scene, &moving, &pose));
    let behind = Point3::new(2.2, 0.0, 0.33);
    assert_eq!((free.count(Label::Robot), at(&hidden, &pose, behind)), (0, Some(Label::Robot)));
    assert!(hidden.count(Label::Line) < free.count(Label::Line));
}

#[test]
fn white_pixels_of_a_picture_are_labelled_line() {
    let scene = scene(&field());
    let mut renderer = Renderer::new(&camera());
    let pose = world_from_camera(-1.5, 0.3, 10.0, 25.0);
    let image = renderer.render(&scene, &[], &pose, &Shot::ideal());
    let labels = renderer.labels(&scene, &[], &pose);
    let (mut num_line, mut num_white) = (0, 0);
    for y in 0..240 {
        for x in 0..320 {
            if labels.get(x, y) == Some(Label::Line) {
                num_line += 1;
                num_white += usize::from(image.get(x as u32, y as u32)[0] > 120);
            } else if labels.get(x, y) == Some(Label::Carpet) {
                assert!(image.get(x as u32, y as u32)[0] < 215, "white at {x}, {y}");
            }
        }
    }
    assert!(num_line > 2000 && num_white * 100 > num_line * 93, "{num_white} of {num_line}");
}

#[test]
fn every_frame_of_a_simulation_has_labels_in_any_order() {
    let scenario = Scenario::load("crowd").unwrap();
    let mut simulation = Simulation::new(&scenario, 1).unwrap().with_num_frames(3);
    let last = simulation.labels(2).unwrap();
    while simulation.next_item().is_some() {}
    assert_eq!(simulation.labels(2), Some(last));
    assert_eq!(simulation.labels(3), None);
}

#[test]
fn the_head_looks_where_the_mean_pan_says() {
    let mut scenario = Scenario::load("still").unwrap();
    scenario.robot.head.pan_deg = 0.0;
    let mut yaw_deg = |pan_mean_deg| {
        scenario.robot.head.pan_mean_deg = pan_mean_deg;
        let mut simulation = Simulation::new(&scenario, 1).unwrap().with_num_frames(1);
        let frame = simulation.next_item().unwrap().unwrap().frame;
        let ahead = frame.robot_from_camera.rotate(&nalgebra::Vector3::z());
        ahead.y.atan2(ahead.x).to_degrees()
    };
    assert!((yaw_deg(40.0) - yaw_deg(0.0) - 40.0).abs() < 1.0);
}
