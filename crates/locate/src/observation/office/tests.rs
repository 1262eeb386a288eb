mod winding_corridor;

use nalgebra::{Point2, Point3, Rotation3, Vector3};
use rand::RngExt;
use visloc_core::{
    Rng, RngTree, Timestamp,
    geom::{Camera, PlanarPose, Rigid3},
};
use visloc_world::{
    Map,
    office::{CorridorPlan, DoorPlan, Office, OfficePlan, SurfaceColor, Wall},
};

use self::winding_corridor::WindingCorridor;
use super::{OfficeFeatureModel, OfficeModelConfig, OfficeObservationModel, lines::theoretical_lines};
use crate::{
    Algorithm, Estimate, Localizer, ObservationModel, StepInput,
    algorithm::{in_building, refinement_defaults},
    observation::features::{CameraState, CameraVector, FeatureModel, Residual},
    refine::Refined,
    vision::{BorderPixel, FeatureKind, FeaturePixel, Percept},
};

fn office() -> Office {
    match Map::load("office").unwrap() {
        Map::Office(office) => office,
        other => panic!("a building, not {}", other.name()),
    }
}

/// A camera 0.5 m above the floor that looks 8 degrees down.
fn percept(pixels: Vec<FeaturePixel>) -> Percept {
    let camera = Camera::pinhole((320, 240), (373.3, 373.3), (159.5, 119.5)).unwrap();
    let down = 8.0_f64.to_radians();
    let optical = Rotation3::from_basis_unchecked(&[-Vector3::y(), -Vector3::z(), Vector3::x()]);
    let robot_from_camera = Rigid3::new(
        Rotation3::from_axis_angle(&Vector3::y_axis(), down) * optical,
        Vector3::new(0.05, 0.0, 0.5),
    );
    Percept { camera, robot_from_camera, pixels, ..Percept::default() }
}

fn free_pose(office: &Office, rng: &mut Rng) -> PlanarPose {
    let in_cell = [rng.random_range(0.0..1.0), rng.random_range(0.0..1.0)];
    let place = office.free_space().place(rng.random_range(0.0..1.0), in_cell).unwrap();
    PlanarPose::new(place.x, place.y, rng.random_range(-3.1..3.1))
}

/// All borders that are seen from a pose, point by point: nothing of the model's index, cells or clipping is used.
fn drawn(office: &Office, pose: &PlanarPose) -> Vec<FeaturePixel> {
    let template = percept(Vec::new());
    let eye = pose.to_rigid3().transform(&Point3::from(*template.robot_from_camera.translation()));
    let camera_from_robot = template.robot_from_camera.inverse();
    let robot_from_world = pose.to_rigid3().inverse();
    let mut pixels = Vec::new();
    for line in theoretical_lines(office) {
        for i in 0..=20 {
            let t = f64::from(i) / 20.0;
            let at = line.start + (line.end - line.start) * t;
            let z = line.end_height_m * t;
            let off_wall = at + line.normal * 1e-6;
            let is_hidden = |wall: &Wall| wall.hides(&Point2::new(eye.x, eye.y), &off_wall, 1e-3);
            let faces = (Point2::new(eye.x, eye.y) - at).dot(&line.normal) > 0.0;
            if !faces || (at - Point2::new(eye.x, eye.y)).norm() > 8.0 || office.walls().iter().any(is_hidden)
            {
                continue;
            }
            let in_camera =
                camera_from_robot.transform(&robot_from_world.transform(&Point3::new(at.x, at.y, z)));
            if let Ok(px) = template.camera.project(&in_camera)
                && in_camera.z > 0.2
                && template.camera.contains(&px)
            {
                pixels.push(FeaturePixel { px, ideal_px: px, kind: line.kind });
            }
        }
    }
    pixels
}

#[test]
fn everything_drawn_from_a_pose_is_explained_by_it() {
    let (office, mut rng) = (office(), RngTree::new(1).stream("poses", 0));
    let mut model = OfficeObservationModel::new(&office, &OfficeModelConfig::default()).unwrap();
    let (mut sum, mut count) = (0.0, 0.0);
    for _ in 0..200 {
        let pose = free_pose(&office, &mut rng);
        model.condition_on(&percept(drawn(&office, &pose)));
        if !model.has_evidence() {
            continue;
        }
        let likelihood = model.likelihood(&pose);
        assert!(likelihood > 0.99, "{pose:?}: {likelihood}");
        sum += likelihood;
        count += 1.0;
    }
    assert!(count > 120.0 && sum / count > 0.999, "{count}: {}", sum / count);
}

#[test]
fn likelihood_falls_with_the_distance_and_is_zero_outside() {
    let (office, mut rng) = (office(), RngTree::new(2).stream("poses", 0));
    let mut model = OfficeObservationModel::new(&office, &OfficeModelConfig::default()).unwrap();
    let mut worse = 0;
    for _ in 0..100 {
        let pose = free_pose(&office, &mut rng);
        model.condition_on(&percept(drawn(&office, &pose)));
        let turned = PlanarPose::new(pose.x_m, pose.y_m, pose.yaw_rad + 0.1);
        worse += usize::from(!model.has_evidence() || model.likelihood(&turned) < model.likelihood(&pose));
        for outside in [PlanarPose::new(5.0, 4.0, 0.0), PlanarPose::new(f64::NAN, 0.0, 0.0)] {
            assert!(model.likelihood(&outside).abs() < 1e-12);
        }
    }
    assert!(worse >= 98, "{worse} of 100");
}

/// One door straight ahead is seen from in front of every door alike, and proposals come to all of them.
#[test]
fn proposals_reach_every_door_that_fits() {
    let (office, mut rng) = (office(), RngTree::new(3).stream("poses", 0));
    let mut model = OfficeObservationModel::new(&office, &OfficeModelConfig::default()).unwrap();
    let door = &office.doors()[2];
    let middle = nalgebra::center(&door.left, &door.right) + office.walls()[door.wall].normal() * 1.3;
    let pose = PlanarPose::new(middle.x, middle.y, std::f64::consts::FRAC_PI_2);
    model.condition_on(&percept(drawn(&office, &pose)));
    let fits: Vec<PlanarPose> =
        (0..3000).map(|_| model.propose(&mut rng)).filter(|pose| model.likelihood(pose) > 0.8).collect();
    let is_reached = |door: &visloc_world::office::Door| {
        let front = nalgebra::center(&door.left, &door.right) + office.walls()[door.wall].normal() * 1.3;
        fits.iter().any(|pose| (pose.position() - front).norm() < 0.3)
    };
    let reached = office.doors().iter().filter(|door| is_reached(door)).count();
    assert!(reached * 10 >= office.doors().len() * 7, "{reached} of {}", office.doors().len());
}

/// What is looked at for a pose does not grow with the building.
#[test]
fn a_pose_looks_at_what_is_around_it_only() {
    let mut rng = RngTree::new(4).stream("building", 0);
    let lines_around = |num_legs: usize, rng: &mut Rng| {
        let corridor = WindingCorridor { num_legs, ..WindingCorridor::default() };
        let plan = corridor.plan("generated", || rng.random_range(0.0..1.0));
        let office = Office::new("generated", plan).unwrap();
        let mut model = OfficeObservationModel::new(&office, &OfficeModelConfig::default()).unwrap();
        model.condition_on(&percept(Vec::new()));
        let mut seen = 0;
        for _ in 0..500 {
            let pose = free_pose(&office, rng);
            model.theoretical_image(&pose, |_, _| seen += 1);
        }
        seen
    };
    let (small, large) = (lines_around(2, &mut rng), lines_around(10, &mut rng));
    assert!(large * 10 < small * 13, "{small} and {large}");
}

#[test]
fn an_open_door_shows_no_border() {
    let office = office();
    let mut plan = office.plan().clone();
    let all = theoretical_lines(&office).len();
    plan.doors[0].is_open = true;
    let opened = theoretical_lines(&Office::new("opened", plan).unwrap());
    // Two edges and the foot are gone.
    assert_eq!(opened.len(), all - 3);
    assert!(opened.iter().any(|line| line.kind == FeatureKind::WallFoot));
}

/// Border pixels as they are seen from a pose.
fn with_borders(office: &Office, pose: &PlanarPose) -> Percept {
    let pixels = drawn(office, pose);
    let border = |pixel: &FeaturePixel| BorderPixel {
        ideal_px: pixel.ideal_px,
        inward: nalgebra::Vector2::y(),
        kind: pixel.kind,
    };
    let borders = pixels.iter().map(border).collect();
    Percept { borders, quality: 1.0, is_informative: true, ..percept(pixels) }
}

fn models(office: &Office) -> (OfficeObservationModel, OfficeFeatureModel) {
    let pixels = OfficeObservationModel::new(office, &OfficeModelConfig::default()).unwrap();
    let features = OfficeFeatureModel::new(&pixels);
    (pixels, features)
}

#[test]
fn borders_seen_from_a_pose_fall_on_their_counterparts() {
    let (office, mut rng) = (office(), RngTree::new(5).stream("poses", 0));
    let (_, mut model) = models(&office);
    let (mut matched, mut count) = (0, 0);
    for _ in 0..100 {
        let pose = free_pose(&office, &mut rng);
        model.condition_on(&with_borders(&office, &pose));
        model.visit_matches(&CameraState::reported(pose), 8.0, 1, &mut |feature| {
            count += 1;
            matched += usize::from(feature.residual.is_some_and(|r| r.error_px.abs() < 1e-6));
        });
    }
    // Pieces that a corner hides in part are hidden as a whole.
    assert!(count > 3000 && matched * 100 > count * 97, "{matched} of {count}");
}

#[test]
fn derivatives_of_the_residuals_are_those_of_differences() {
    let (office, mut rng) = (office(), RngTree::new(6).stream("poses", 0));
    let (_, mut model) = models(&office);
    let residuals = |model: &OfficeFeatureModel, at: &CameraVector| {
        let mut all = Vec::new();
        model.visit_matches(&CameraState::from(at), 8.0, 1, &mut |feature| all.push(feature.residual));
        all
    };
    let mut count = 0;
    for _ in 0..40 {
        let pose = free_pose(&office, &mut rng);
        model.condition_on(&with_borders(&office, &pose));
        // Where all residuals are 0, the derivatives are exact.
        let at = CameraVector::from([pose.x_m, pose.y_m, pose.yaw_rad, 0.0, 0.0, 0.0, 0.0]);
        for axis in 0..at.len() {
            const STEP: f64 = 1e-6;
            let mut step = CameraVector::zeros();
            step[axis] = STEP;
            let here = residuals(&model, &at);
            let (ahead, behind) = (residuals(&model, &(at + step)), residuals(&model, &(at - step)));
            for ((here, ahead), behind) in here.iter().zip(&ahead).zip(&behind) {
                let (Some(here), Some(ahead), Some(behind)) = (here, ahead, behind) else { continue };
                let difference = (ahead.error_px - behind.error_px) / (2.0 * STEP);
                // A pixel at a corner may change its counterpart within the step.
                let is_same =
                    |other: &Residual| (other.jacobian - here.jacobian).norm() < 1e-3 * here.jacobian.norm();
                if is_same(ahead) && is_same(behind) {
                    assert!((difference - here.jacobian[axis]).abs() < 0.05 + 0.01 * difference.abs());
                    count += 1;
                }
            }
        }
    }
    assert!(count > 5000, "{count}");
}

/// In front of a door that stands alone in view the robot may be before any door like it. All of these places are held,
/// none is relied on, until the corridor's end comes into view.
#[test]
fn look_alike_doors_stay_hypotheses_until_something_tells_them_apart() {
    const SPACING_M: f64 = 4.0;
    let mut plan = OfficePlan::named("alike");
    plan.corridors.push(CorridorPlan::closed(vec![[0.0, -1.0], [25.0, -1.0], [25.0, 1.0], [0.0, 1.0]]));
    plan.doors = (0..6)
        .map(|i| DoorPlan {
            from: [2.0 + SPACING_M * f64::from(i), 1.0],
            to: [2.9 + SPACING_M * f64::from(i), 1.0],
            height_m: 2.05,
            color: SurfaceColor::RED,
            is_open: false,
        })
        .collect();
    let office = Office::new("alike", plan).unwrap();
    let (pixels, features) = models(&office);
    let algorithm = in_building(Algorithm::named("evolutionary").unwrap(), false);
    let search = algorithm.build(Box::new(pixels.clone())).unwrap();
    let mut localizer =
        Refined::new(refinement_defaults(), search, Box::new(features), Box::new(pixels)).unwrap();
    let mut rng = RngTree::new(7).stream("alike", 0);
    let mut odometry = PlanarPose::default();
    let mut pose = PlanarPose::new(18.45, -0.5, std::f64::consts::FRAC_PI_2);
    let mut step = |localizer: &mut Refined, pose: &PlanarPose, odometry: PlanarPose, i: i64| {
        let percept = Percept { at: Timestamp::from_nanos(33_000_000 * i), ..with_borders(&office, pose) };
        localizer
            .step(&StepInput { percept: &percept, odometry: Some(odometry), is_lifted: false }, &mut rng);
        localizer.estimate().clone()
    };
    let mut estimate = Estimate::unknown();
    for i in 0..60 {
        estimate = step(&mut localizer, &pose, odometry, i);
    }
    for i in 0..6 {
        let alike = Point2::new(2.45 + SPACING_M * f64::from(i), -0.5);
        let is_held =
            estimate.hypotheses.iter().any(|h| (h.world_from_robot.position() - alike).norm() < 0.1);
        assert!(is_held, "door {i}: {:?}", estimate.hypotheses);
    }
    assert!(estimate.reliability < 0.1, "{}", estimate.reliability);
    assert!(estimate.hypotheses[0].probability < 0.4, "{:?}", estimate.hypotheses);
    // It turns to the right: two doors ahead, then the end.
    for i in 60..200 {
        let turn = if i < 105 { -0.035 } else { 0.0 };
        let walked = if i < 105 { 0.0 } else { 0.02 };
        let motion = PlanarPose::new(walked, 0.0, turn);
        (pose, odometry) = (pose.compose(&motion), odometry.compose(&motion));
        estimate = step(&mut localizer, &pose, odometry, i);
    }
    assert!(estimate.world_from_robot.distance_m(&pose) < 0.1, "{:?} {pose:?}", estimate.world_from_robot);
    assert!(estimate.reliability > 0.6, "{}", estimate.reliability);
}
