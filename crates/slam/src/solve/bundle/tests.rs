//! Tests of the bundle adjustment on synthetic scenes.

use rand::RngExt;
use visloc_core::{RngTree, gaussian, geom::World};

use nalgebra::Vector6;

use super::{equations::linearize, *};
use crate::lie::{exp, log};

const SETTINGS: BundleSettings = BundleSettings { max_iterations: 20, huber: 2.45 };

fn scene(seed: u64, noise: f64, outliers: f64) -> Bundle {
    let mut rng = RngTree::new(seed).stream("bundle", 0);
    let mut bundle = Bundle::default();
    for i in 0..6 {
        let twist =
            Vector6::new(-0.15 * f64::from(i), 0.02, 0.01 * f64::from(i), 0.01, 0.02 * f64::from(i), 0.0);
        let pose = exp::<World>(&twist);
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(*pose.rotation());
        bundle.cameras.push(CameraFromWorld::new(rotation, *pose.translation()));
        bundle.is_free.push(i > 1);
    }
    for point in 0..150 {
        let mut draw = || rng.random_range(-1.0..1.0);
        bundle.points.push(Point3::new(2.0 * draw(), 1.5 * draw(), 4.0 + draw()));
        for camera in 0..6 {
            let seen = bundle.cameras[camera].transform(&bundle.points[point]);
            let mut ray = Vector2::new(seen.x / seen.z, seen.y / seen.z);
            ray += Vector2::new(gaussian(&mut rng, noise), gaussian(&mut rng, noise)) / 500.0;
            if rng.random_range(0.0..1.0) < outliers {
                ray.x += 0.05;
            }
            bundle.observations.push(BundleObservation {
                point,
                camera,
                ray,
                whitening: Matrix2::identity() * 500.0,
            });
        }
    }
    bundle
}

fn disturb(bundle: &mut Bundle, seed: u64) {
    let mut rng = RngTree::new(seed).stream("disturb", 0);
    for camera in bundle.cameras.iter_mut().skip(2) {
        *camera = moved(&Vector6::from_fn(|_, _| gaussian(&mut rng, 0.02)), camera);
    }
    for point in &mut bundle.points {
        *point += Vector3::from_fn(|_, _| gaussian(&mut rng, 0.05));
    }
}

#[test]
fn recovers_the_scene_exactly_without_noise() {
    let truth = scene(1, 0.0, 0.0);
    let mut bundle = truth.clone();
    disturb(&mut bundle, 1);
    let report = bundle.solve(&BundleSettings { max_iterations: 40, huber: 1e9 });
    assert!(report.last_cost < 1e-6 * report.first_cost, "{report:?}");
    for (found, camera) in bundle.cameras.iter().zip(&truth.cameras) {
        assert!(log(&(*found * camera.inverse())).norm() < 1e-4);
    }
}

#[test]
fn few_outliers_move_cameras_little() {
    for seed in 0..5 {
        let truth = scene(seed, 0.5, 0.0);
        let mut bundle = scene(seed, 0.5, 0.05);
        disturb(&mut bundle, seed);
        bundle.solve(&SETTINGS);
        for (found, camera) in bundle.cameras.iter().zip(&truth.cameras) {
            let error = log(&(*found * camera.inverse())).norm();
            assert!(error < 0.04, "seed {seed}: {error}");
        }
    }
}

#[test]
fn jacobians_are_the_numeric_ones() {
    let bundle = scene(3, 0.5, 0.0);
    for (at, observation) in bundle.observations.iter().enumerate().step_by(17) {
        let l = linearize(&bundle, at, observation, 1e9).unwrap();
        for i in 0..9 {
            let shifted = |step: f64| {
                let mut other = bundle.clone();
                if i < 6 {
                    let mut twist = Vector6::zeros();
                    twist[i] = step;
                    other.cameras[observation.camera] = moved(&twist, &other.cameras[observation.camera]);
                } else {
                    other.points[observation.point][i - 6] += step;
                }
                other.residual(observation).unwrap()
            };
            let numeric = (shifted(1e-6) - shifted(-1e-6)) / 2e-6;
            let analytic = if i < 6 {
                l.by_camera.column(i).into_owned()
            } else {
                l.by_point.column(i - 6).into_owned()
            };
            assert!((numeric - analytic).norm() < 1e-3, "{i}: {numeric} {analytic}");
        }
    }
}

#[test]
fn jacobians_of_ties_are_the_numeric_ones() {
    let mut bundle = scene(6, 0.0, 0.0);
    bundle.observations.clear();
    bundle.ties.push(BundleTie { cameras: (4, 2), sigma: 0.1 });
    let gradient = NormalEquations::of(&bundle, 1.0).camera_gradient;
    for camera in [2, 4] {
        for i in 0..6 {
            let shifted = |step: f64| {
                let mut twist = Vector6::zeros();
                twist[i] = step;
                let mut state = State::of(&bundle);
                state.cameras[camera] = moved(&twist, &state.cameras[camera]);
                bundle.cost(&state, 1.0)
            };
            let numeric = (shifted(1e-6) - shifted(-1e-6)) / 2e-6;
            let analytic = -gradient[camera - 2][i];
            assert!((numeric - analytic).abs() < 1e-4, "{camera} {i}: {numeric} {analytic}");
        }
    }
}

#[test]
fn tied_cameras_come_to_the_same_place() {
    let mut bundle = scene(7, 0.3, 0.0);
    // Camera 5 stands where camera 4 is and sees two points only.
    let turned = moved(&Vector6::new(0.0, 0.0, 0.0, 0.0, 0.1, 0.0), &bundle.cameras[4]);
    bundle.cameras[5] = moved(&Vector6::new(0.2, 0.1, -0.1, 0.0, 0.0, 0.0), &turned);
    bundle.observations.retain(|o| o.camera != 5);
    for point in [3, 8] {
        let seen = turned.transform(&bundle.points[point]);
        let at = bundle.observations.iter().rposition(|o| o.point == point).unwrap();
        let ray = Vector2::new(seen.x / seen.z, seen.y / seen.z);
        let whitening = Matrix2::identity() * 500.0;
        bundle.observations.insert(at, BundleObservation { point, camera: 5, ray, whitening });
    }
    bundle.ties.push(BundleTie { cameras: (5, 4), sigma: 0.001 });
    bundle.solve(&BundleSettings { max_iterations: 30, huber: 2.45 });
    let center = |camera: usize| *bundle.cameras[camera].inverse().translation();
    assert!((center(4) - center(5)).norm() < 0.005);
}

#[test]
fn scaling_the_scene_scales_the_result() {
    let mut bundle = scene(4, 0.3, 0.0);
    disturb(&mut bundle, 4);
    let mut large = bundle.clone();
    let scaled = |camera: &CameraFromWorld| {
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(*camera.rotation());
        CameraFromWorld::new(rotation, camera.translation() * 3.0)
    };
    large.cameras = large.cameras.iter().map(scaled).collect();
    large.points.iter_mut().for_each(|p| p.coords *= 3.0);
    let settings = BundleSettings { max_iterations: 40, huber: 2.45 };
    bundle.solve(&settings);
    large.solve(&settings);
    for (small, large) in bundle.points.iter().zip(&large.points) {
        assert!((small.coords * 3.0 - large.coords).norm() < 0.02, "{small} {large}");
    }
}

/// A scene seen through a lens whose first radial coefficient is off by so much.
fn scene_through_lens(seed: u64, noise: f64, coefficient: f64) -> Bundle {
    let mut bundle = scene(seed, noise, 0.0);
    let by_lens = |ray: &Vector2<f64>| -ray * ray.norm_squared();
    for observation in &mut bundle.observations {
        observation.ray -= by_lens(&observation.ray) * coefficient;
    }
    let ray_by_change = bundle.observations.iter().map(|o| by_lens(&o.ray)).collect();
    bundle.lens.push(BundleLens {
        change: 0.0,
        expected: 0.0,
        sigma: 0.1,
        ray_by_change,
        size_by_change: Vec::new(),
    });
    bundle
}

#[test]
fn a_wrong_lens_is_found_with_the_scene() {
    for (seed, coefficient) in [(8, 0.03), (9, -0.02), (10, 0.0)] {
        let mut bundle = scene_through_lens(seed, 0.02, coefficient);
        disturb(&mut bundle, seed);
        bundle.solve(&BundleSettings { max_iterations: 30, huber: 2.45 });
        let found = bundle.lens[0].change;
        assert!((found - coefficient).abs() < 0.005, "{found} for {coefficient}");
    }
}

#[test]
fn a_wrong_focal_length_is_found_within_what_is_told() {
    for (seed, focal) in [(13, 0.06), (14, -0.06)] {
        let mut bundle = scene(seed, 0.02, 0.0);
        // A longer focal length than the right one makes all rays shorter, and pixels smaller.
        bundle.observations.iter_mut().for_each(|o| o.ray *= 1.0 + focal);
        let ray_by_change = bundle.observations.iter().map(|o| -o.ray).collect();
        let size_by_change = vec![-Matrix2::identity(); bundle.observations.len()];
        bundle.lens.push(BundleLens {
            change: 0.0,
            expected: 0.0,
            sigma: 1.0,
            ray_by_change,
            size_by_change,
        });
        disturb(&mut bundle, seed);
        bundle.solve(&BundleSettings { max_iterations: 50, huber: 2.45 });
        let found = bundle.lens[0].change;
        let deviation = bundle.lens_covariance(2.45, (4.0, 1.0)).unwrap()[(0, 0)].sqrt();
        // To first order the change is linear.
        assert!((found - focal).abs() < 4.0 * deviation + focal * focal, "{found} +- {deviation}");
        assert!(deviation < 0.1, "{deviation}");
    }
}

#[test]
fn a_lens_of_which_nothing_is_seen_stays_as_expected() {
    let mut bundle = scene_through_lens(11, 0.3, 0.0);
    for lens in &mut bundle.lens {
        lens.expected = 0.01;
        lens.ray_by_change.fill(Vector2::zeros());
    }
    bundle.solve(&SETTINGS);
    assert!((bundle.lens[0].change - 0.01).abs() < 1e-9);
}

#[test]
fn a_rejected_step_costs_no_iteration() {
    let truth = scene(12, 0.0, 0.0);
    let mut bundle = truth.clone();
    disturb(&mut bundle, 12);
    for point in bundle.points.iter_mut().step_by(3) {
        // So far that the first step overshoots.
        point.z += 6.0;
    }
    let report = bundle.solve(&BundleSettings { max_iterations: 25, huber: 1e9 });
    assert!(report.last_cost < 1e-3 * report.first_cost, "{report:?}");
}
