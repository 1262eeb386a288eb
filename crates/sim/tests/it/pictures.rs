//! Pictures agree with the geometry of the map.

use nalgebra::{Point2, Point3};
use visloc_core::{
    RgbImage, RngTree,
    geom::{Camera, CameraFrame, Distortion, PlanarPose, Rigid3, World, nao},
};
use visloc_sim::{FieldLook, Renderer, Scene, Shot};
use visloc_world::{Map, field::Field};

fn field() -> Field {
    match Map::load("robocup-spl-2010").unwrap() {
        Map::Field(field) => field,
        _ => panic!("a field"),
    }
}

fn scene(field: &Field) -> Scene {
    let mut scene = Scene::new(vec![], 1.0, (3.0, 2.0));
    let look = FieldLook { wear: 0.0, ..FieldLook::default() };
    scene.add_field(field, &look, &mut RngTree::new(1).stream("field", 0));
    scene
}

fn cameras() -> [Camera; 2] {
    let lens = Distortion::RadialTangential([-0.25, 0.06, 1e-3, -5e-4, 0.0]);
    [
        Camera::pinhole((320, 240), (373.3, 373.3), (159.5, 119.5)).unwrap(),
        Camera::new((320, 240), (250.0, 250.0), (159.5, 119.5), lens).unwrap(),
    ]
}

fn world_from_camera(x_m: f64, y_m: f64, yaw_deg: f64, tilt_deg: f64) -> Rigid3<World, CameraFrame> {
    let head = nao::HeadAngles { yaw_rad: 0.0, pitch_rad: tilt_deg.to_radians() };
    let mount = nao::robot_from_camera(&nao::Torso::upright(), &head, nao::NaoCamera::TopV4);
    PlanarPose::new(x_m, y_m, yaw_deg.to_radians()).to_rigid3() * mount
}

/// The pixel of a world point, if it lies well inside the image.
fn pixel(
    camera: &Camera,
    world_from_camera: &Rigid3<World, CameraFrame>,
    point: Point3<f64>,
) -> Option<Point2<f64>> {
    let px = camera.project(&world_from_camera.inverse().transform(&point)).ok()?;
    let is_inside = (4.0..316.0).contains(&px.x) && (4.0..236.0).contains(&px.y);
    is_inside.then_some(px)
}

fn color(image: &RgbImage, px: &Point2<f64>) -> [i32; 3] {
    image.get(px.x.round() as u32, px.y.round() as u32).map(i32::from)
}

fn is_white([r, _, b]: [i32; 3]) -> bool {
    r > 170 && b > 170
}

fn is_green([r, g, b]: [i32; 3]) -> bool {
    g > r + 25 && g > b + 15 && r < 110
}

#[test]
fn projected_lines_are_white_and_the_carpet_beside_them_is_green() {
    let (field, mut checked) = (field(), 0);
    let scene = scene(&field);
    for camera in cameras() {
        let mut renderer = Renderer::new(&camera);
        for (x, y, yaw) in [
            (0.9, -0.6, 40.0),
            (-1.5, 0.2, 0.0),
            (1.4, 0.0, 180.0),
            (-0.5, 1.0, -80.0),
            (2.0, 1.2, 20.0),
            (-2.0, -1.0, 200.0),
        ] {
            let pose = world_from_camera(x, y, yaw, 18.0);
            let image = renderer.render(&scene, &[], &pose, &Shot::ideal());
            for line in field.lines() {
                let along = (line.end - line.start).normalize();
                let beside = nalgebra::Vector2::new(-along.y, along.x) * 0.065;
                // Not the ends, where other lines begin.
                for s in [0.21, 0.35, 0.43, 0.61, 0.83] {
                    let on = line.start + (line.end - line.start) * s;
                    let eye = pose.translation();
                    let is_near = (on.x - eye.x).hypot(on.y - eye.y) < 2.2;
                    let away = on + beside;
                    let other = field.lines().iter().filter(|l| *l != line);
                    let is_lonely = other.clone().all(|l| (l.nearest_point(&on) - on).norm() > 0.15)
                        && (on.coords.norm() - field.circle_radius_m()).abs() > 0.15;
                    let at = |p: &Point2<f64>| pixel(&camera, &pose, Point3::new(p.x, p.y, 0.0));
                    let (Some(on_px), Some(away_px)) = (at(&on), at(&away)) else { continue };
                    if !is_near || !is_lonely || (on_px - away_px).norm() < 4.0 {
                        continue;
                    }
                    assert!(
                        is_white(color(&image, &on_px)),
                        "{on:?} at {on_px}: {:?}",
                        color(&image, &on_px)
                    );
                    assert!(
                        is_green(color(&image, &away_px)),
                        "{away:?} at {away_px}: {:?}",
                        color(&image, &away_px)
                    );
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 25, "only {checked} places checked");
}

#[test]
fn goal_posts_have_the_color_of_their_goal_and_the_right_width() {
    let field = field();
    let scene = scene(&field);
    for camera in cameras() {
        for (goal, yaw_deg) in field.goals().iter().zip([0.0, 180.0]) {
            let pose = world_from_camera(goal.x_m - goal.x_m.signum() * 2.4, 0.0, yaw_deg, 0.0);
            let image = Renderer::new(&camera).render(&scene, &[], &pose, &Shot::ideal());
            for y in [goal.post_y_m, -goal.post_y_m] {
                let px = pixel(&camera, &pose, Point3::new(goal.x_m, y, 0.4)).unwrap();
                let has_color =
                    |c: [i32; 3]| if goal.x_m > 0.0 { c[0] > c[2] + 60 } else { c[2] > c[0] + 40 };
                assert!(has_color(color(&image, &px)), "{:?} at {px}", color(&image, &px));
                let row = px.y.round() as u32;
                let wide = (0..320).filter(|x| {
                    (f64::from(*x) - px.x).abs() < 40.0 && has_color(image.get(*x, row).map(i32::from))
                });
                let side = Point3::new(goal.x_m, y + goal.post_radius_m, 0.4);
                let expected = 2.0 * (pixel(&camera, &pose, side).unwrap().x - px.x).abs();
                let found = wide.count() as f64;
                assert!((found - expected).abs() < 2.5, "{found} px wide, expected {expected}");
            }
        }
    }
}

#[test]
fn ball_covers_its_projection() {
    let field = field();
    let mut scene = scene(&field);
    scene.add_ball(&field, &Point2::new(0.5, 0.3));
    let camera = cameras()[0];
    let pose = world_from_camera(-0.5, 0.2, 5.0, 20.0);
    let image = Renderer::new(&camera).render(&scene, &[], &pose, &Shot::ideal());
    let px = pixel(&camera, &pose, Point3::new(0.5, 0.3, 0.0325)).unwrap();
    let [r, g, b] = color(&image, &px);
    assert!(r > 120 && r > g + 40 && g > b, "{r} {g} {b} at {px}");
}

#[test]
fn distant_lines_keep_their_mean_brightness() {
    // A line 4 m away is about one pixel high; it must not break into dots.
    let field = field();
    let scene = scene(&field);
    let camera = cameras()[0];
    let pose = world_from_camera(-2.0, 0.0, 0.0, 5.0);
    let image = Renderer::new(&camera).render(&scene, &[], &pose, &Shot::ideal());
    let brightness: Vec<f64> = (-9..=9)
        .filter(|i: &i32| i.abs() > 1)
        .filter_map(|i| pixel(&camera, &pose, Point3::new(2.4, f64::from(i) * 0.1, 0.0)))
        .map(|px| {
            let row = px.y.round() as i32;
            (row - 2..=row + 2).map(|y| f64::from(image.get(px.x.round() as u32, y as u32)[0])).sum::<f64>()
        })
        .collect();
    let (low, high) = brightness.iter().fold((f64::MAX, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
    assert!(brightness.len() > 10 && low > 0.75 * high, "{brightness:?}");
}
