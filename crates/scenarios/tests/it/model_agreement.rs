//! The fast observation model agrees with the drawn theoretical image.

use std::f64::consts::PI;

use rand::RngExt;
use visloc_core::{
    Frame, Rng, RngTree, Timestamp, gaussian,
    geom::{PlanarPose, nao},
};
use visloc_locate::{
    ObservationModel,
    observation::field::{DrawnFieldModel, FieldModelConfig, FieldObservationModel},
    vision::{
        color::ColorConfig,
        field::{FieldAnalysisConfig, FieldAnalyzer},
    },
};
use visloc_sim::{Renderer, Scenario, Shot, Simulation};
use visloc_world::{Map, field::Field};

const NUM_IMAGES: u64 = 1000;

/// Images from all over the field, with poses from exact to anywhere.
fn for_each_image(
    mut visit: impl FnMut(&visloc_locate::vision::Percept, &PlanarPose, &PlanarPose),
    field: &Field,
) {
    let simulation = Simulation::new(&Scenario::load("still").unwrap(), 1).unwrap();
    let camera = *simulation.camera();
    let mut renderer = Renderer::new(&camera);
    let config = FieldAnalysisConfig { colors: ColorConfig::table(), ..FieldAnalysisConfig::default() };
    let mut analyzer = FieldAnalyzer::new(config).unwrap();
    for i in 0..NUM_IMAGES {
        let mut rng = RngTree::new(11).stream("pose", i);
        let truth = random_pose(field, &mut rng);
        let head =
            nao::HeadAngles { yaw_rad: rng.random_range(-0.9..0.9), pitch_rad: rng.random_range(0.05..0.35) };
        let robot_from_camera = nao::robot_from_camera(&nao::Torso::upright(), &head, nao::NaoCamera::TopV3);
        let world_from_camera = truth.to_rigid3() * robot_from_camera;
        let image = renderer.render(simulation.scene(), &[], &world_from_camera, &Shot::ideal());
        let frame = Frame {
            at: Timestamp::default(),
            image,
            camera_index: 0,
            camera,
            robot_from_camera,
            odometry: None,
            ground_contact: None,
        };
        let percept = analyzer.analyze(&frame, &mut rng).unwrap();
        let spread = [0.0, 0.1, 0.5, 2.0][(i % 4) as usize];
        let pose = PlanarPose::new(
            truth.x_m + gaussian(&mut rng, spread),
            truth.y_m + gaussian(&mut rng, spread),
            truth.yaw_rad + gaussian(&mut rng, spread * 0.5),
        );
        visit(percept, &truth, &pose);
    }
}

fn random_pose(field: &Field, rng: &mut Rng) -> PlanarPose {
    let d = field.dimensions();
    let (x, y) = (d.length_m / 2.0 - 0.3, d.width_m / 2.0 - 0.2);
    PlanarPose::new(rng.random_range(-x..x), rng.random_range(-y..y), rng.random_range(-PI..PI))
}

/// Measure: the absolute difference of the two likelihoods of one image and one pose, both 0 to 1. Bounds: 0.015 in the
/// mean, 0.05 for 95 % of the images; at poses within 0.3 m of the truth 0.1 for all. The fast model looks at the two
/// marks that are nearest on the ground and takes their images for straight; the reference looks at all marks and draws
/// them as they are. At a pose that is meters off the nearest on the ground need not be the nearest in the image: 0.3.
#[test]
fn fast_and_drawn_likelihood_agree() {
    let Map::Field(field) = Map::load("robocup-spl-2010").unwrap() else { panic!("a field") };
    let mut fast = FieldObservationModel::new(&field, &FieldModelConfig::default()).unwrap();
    let drawn = DrawnFieldModel::new(&field, &FieldModelConfig::default()).unwrap();
    let (mut differences, mut near_truth, mut at_truth) = (Vec::new(), Vec::new(), Vec::new());
    for_each_image(
        |percept, truth, pose| {
            fast.condition_on(percept);
            if fast.has_evidence() {
                let difference = (drawn.likelihood(percept, pose) - fast.likelihood(pose)).abs();
                differences.push(difference);
                if pose.distance_m(truth) < 0.3 {
                    near_truth.push(difference);
                }
                at_truth.push(fast.likelihood(truth));
            }
        },
        &field,
    );
    assert!(differences.len() > 800, "{} of {NUM_IMAGES} images show something", differences.len());
    differences.sort_by(f64::total_cmp);
    at_truth.sort_by(f64::total_cmp);
    let quantile = |sorted: &[f64], q: f64| sorted[(q * (sorted.len() - 1) as f64) as usize];
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    let (p95, largest) = (quantile(&differences, 0.95), quantile(&differences, 1.0));
    let largest_near = near_truth.iter().copied().fold(0.0, f64::max);
    println!(
        "difference: mean {mean:.4}, 95 % {p95:.4}, largest {largest:.4}, near the truth {largest_near:.4}"
    );
    assert!(mean < 0.015 && p95 < 0.05 && largest < 0.3, "mean {mean}, 95 % {p95}, largest {largest}");
    assert!(
        near_truth.len() > 400 && largest_near < 0.1,
        "{} near, largest {largest_near}",
        near_truth.len()
    );
    assert!(quantile(&at_truth, 0.5) > 0.95, "the true pose explains its image");
}
