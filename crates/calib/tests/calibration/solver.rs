//! The whole calibration.

use nalgebra::Vector2;
use visloc_calib::{
    Board, BoardCorner, CalibrateError, Calibration, DropReason, LensModel, ViewInput, calibrate, coverage,
    detect,
    render::{RenderSettings, random_pose},
    several_cameras,
};
use visloc_core::{RngTree, gaussian, geom::Camera};

use crate::support::{CHECKERS, TAGS, fisheye, picture, webcam};

const SEEDS: [u64; 3] = [1, 2, 3];

fn cases() -> Vec<(&'static str, Board, Camera, LensModel)> {
    vec![
        ("checkers, radtan", CHECKERS, webcam(), LensModel::RadialTangential),
        ("tags, radtan", TAGS, webcam(), LensModel::RadialTangential),
        ("checkers, fisheye", CHECKERS, fisheye(), LensModel::KannalaBrandt),
        ("tags, fisheye", TAGS, fisheye(), LensModel::KannalaBrandt),
    ]
}

/// Corners with normal noise, without any picture.
fn corners(board: &Board, camera: &Camera, seed: u64, num_views: u64, noise_px: f64) -> Vec<ViewInput> {
    let view = |index: u64| {
        let mut rng = RngTree::new(seed).stream("view", index);
        let pose = random_pose(board, camera, &mut rng).expect("the board can be seen");
        let corner = |id: usize| {
            let px = camera.project(&pose.transform(&board.corner_in_board(id))).unwrap();
            let noise = Vector2::new(gaussian(&mut rng, noise_px), gaussian(&mut rng, noise_px));
            BoardCorner { id, px: px + noise }
        };
        ViewInput { name: index.to_string(), corners: (0..board.num_corners()).map(corner).collect() }
    };
    (0..num_views).map(view).collect()
}

/// Largest error of a focal length, as a share, and of the principal point, pixels.
fn errors(found: &Calibration, truth: &Camera) -> (f64, f64) {
    let (f, g) = (found.camera.focal_px(), truth.focal_px());
    let (c, d) = (found.camera.center_px(), truth.center_px());
    ((f.0 / g.0 - 1.0).abs().max((f.1 / g.1 - 1.0).abs()), (c.0 - d.0).abs().max((c.1 - d.1).abs()))
}

#[test]
fn exact_corners_give_the_exact_camera() {
    for (name, board, camera, model) in cases() {
        let inputs = corners(&board, &camera, 5, 12, 0.0);
        let found = calibrate(&board, camera.size_px(), &inputs, model).unwrap();
        let (focal, center) = errors(&found, &camera);
        assert!(focal < 1e-6 && center < 1e-3, "{name}: {focal} {center} {:?}", found.parameters);
        assert!(found.rms_px < 1e-5, "{name}: {}", found.rms_px);
    }
}

#[test]
fn residuals_are_the_injected_noise_and_the_deviations_are_honest() {
    for (name, board, camera, model) in cases() {
        let mut normalized = Vec::new();
        for seed in SEEDS {
            let noise_px = 0.1;
            let inputs = corners(&board, &camera, seed, 25, noise_px);
            let found = calibrate(&board, camera.size_px(), &inputs, model).unwrap();
            assert!(
                (found.corner_noise_px / noise_px - 1.0).abs() < 0.1,
                "{name}: {}",
                found.corner_noise_px
            );
            let rms = found.rms_px / std::f64::consts::SQRT_2;
            assert!((rms / noise_px - 1.0).abs() < 0.1, "{name}: {rms}");
            assert!(errors(&found, &camera).0 < 0.002, "{name}, seed {seed}: {:?}", found.parameters);
            let truth =
                [camera.focal_px().0, camera.focal_px().1, camera.center_px().0, camera.center_px().1];
            for (parameter, truth) in found.parameters.iter().zip(truth) {
                normalized.push(((parameter.value - truth) / parameter.standard_deviation).powi(2));
            }
        }
        let mean = normalized.iter().sum::<f64>() / normalized.len() as f64;
        assert!((0.2..3.0).contains(&mean), "{name}: normalized squared error {mean}");
    }
}

/// A board that is held still for a while in a video: neighbors differ by noise and a slight tremor.
#[test]
fn a_view_that_is_shown_again_does_not_make_the_camera_known_better() {
    let (camera, model) = (webcam(), LensModel::RadialTangential);
    let views = corners(&CHECKERS, &camera, 3, 14, 0.1);
    let alone = calibrate(&CHECKERS, camera.size_px(), &views, model).unwrap();
    let mut rng = RngTree::new(4).stream("tremor", 0);
    let held: Vec<ViewInput> = views
        .iter()
        .flat_map(|view| (0..8).map(move |i| (view, i)))
        .map(|(view, i)| {
            let shift = Vector2::new(gaussian(&mut rng, 2.0), gaussian(&mut rng, 2.0));
            let moved = |c: &BoardCorner| BoardCorner { px: c.px + shift, ..*c };
            ViewInput {
                name: format!("{}.{i}", view.name),
                corners: view.corners.iter().map(moved).collect(),
            }
        })
        .collect();
    let held = calibrate(&CHECKERS, camera.size_px(), &held, model).unwrap();
    assert_eq!((alone.views.len(), held.views.len()), (14, 14));
    assert!(
        held.dropped.iter().all(|view| matches!(view.reason, DropReason::SameView(_))),
        "{:?}",
        held.dropped
    );
    for (alone, held) in alone.parameters.iter().zip(&held.parameters) {
        let ratio = held.standard_deviation / alone.standard_deviation;
        assert!((0.8..1.25).contains(&ratio), "{}: {ratio}", alone.name);
    }
}

#[test]
fn rendered_pictures_give_the_camera() {
    for (name, board, camera, model) in cases() {
        for seed in SEEDS {
            let inputs: Vec<ViewInput> = (0..16)
                .filter_map(|index| {
                    let (image, _) = picture(&board, &camera, seed, index, &RenderSettings::default());
                    Some(ViewInput { name: index.to_string(), corners: detect(&board, &image).ok()?.corners })
                })
                .collect();
            assert!(inputs.len() >= 14, "{name}: {} of 16 found", inputs.len());
            let found = calibrate(&board, camera.size_px(), &inputs, model).unwrap();
            let (focal, center) = errors(&found, &camera);
            println!(
                "{name}, seed {seed}: focal {:.4} %, center {center:.3} px, rms {:.3} px, {} views, {} outliers",
                100.0 * focal,
                found.rms_px,
                found.views.len(),
                found.num_outliers()
            );
            assert!(focal < 0.002, "{name}, seed {seed}: focal {focal}");
            assert!(center < 0.5, "{name}, seed {seed}: center {center}");
        }
    }
}

#[test]
fn a_wrong_picture_and_wrong_corners_are_left_out() {
    let camera = webcam();
    let mut inputs = corners(&CHECKERS, &camera, 4, 15, 0.1);
    // The board was bent in one picture, and two corners of another one are reflections.
    for corner in &mut inputs[3].corners {
        corner.px.x += 8.0 * (corner.px.y * 0.02).sin();
    }
    inputs[7].corners[5].px.x += 15.0;
    inputs[7].corners[30].px.y -= 6.0;
    inputs.push(ViewInput { name: "empty".into(), corners: Vec::new() });
    let found = calibrate(&CHECKERS, camera.size_px(), &inputs, LensModel::RadialTangential).unwrap();
    let dropped: Vec<&str> = found.dropped.iter().map(|view| view.name.as_str()).collect();
    assert_eq!(dropped, ["empty", "3"]);
    assert!(matches!(found.dropped[1].reason, DropReason::LargeResiduals { .. }));
    assert_eq!(found.num_outliers(), 2);
    let (focal, center) = errors(&found, &camera);
    assert!(focal < 0.003 && center < 4.0 * found.parameters[2].standard_deviation, "{focal} {center}");
}

#[test]
fn pictures_of_another_size_are_refused() {
    let camera = webcam();
    let inputs = corners(&CHECKERS, &camera, 1, 5, 0.1);
    let (width, height) = camera.size_px();
    for size_px in [(width / 4, height / 4), (0, 0)] {
        let error = calibrate(&CHECKERS, size_px, &inputs, LensModel::RadialTangential).unwrap_err();
        assert!(matches!(error, CalibrateError::Outside { size_px: told, .. } if told == size_px), "{error}");
    }
}

#[test]
fn too_few_or_degenerate_pictures_say_so() {
    let camera = webcam();
    let run =
        |inputs: &[ViewInput]| calibrate(&CHECKERS, camera.size_px(), inputs, LensModel::RadialTangential);
    let two = corners(&CHECKERS, &camera, 1, 2, 0.1);
    assert!(matches!(run(&two), Err(CalibrateError::TooFewViews { expected: 3, found: 2, .. })));
    // The board always flat in front of the camera.
    let flat: Vec<ViewInput> = (0..8)
        .map(|i| {
            let mut rng = RngTree::new(2).stream("flat", i);
            let shift = nalgebra::Vector3::new(-0.2 + 0.02 * i as f64, -0.1, 0.5 + 0.01 * i as f64);
            let pose = visloc_calib::CameraFromBoard::new(nalgebra::Rotation3::identity(), shift);
            let corner = |id: usize| {
                let px = camera.project(&pose.transform(&CHECKERS.corner_in_board(id))).unwrap();
                BoardCorner { id, px: px + Vector2::new(gaussian(&mut rng, 0.2), gaussian(&mut rng, 0.2)) }
            };
            ViewInput { name: i.to_string(), corners: (0..54).map(corner).collect() }
        })
        .collect();
    let error = run(&flat).unwrap_err();
    assert!(matches!(error, CalibrateError::Degenerate { .. } | CalibrateError::NoStart), "{error}");
}

#[test]
fn coverage_asks_for_what_is_missing() {
    let camera = webcam();
    let full = calibrate(
        &CHECKERS,
        camera.size_px(),
        &corners(&CHECKERS, &camera, 1, 40, 0.1),
        LensModel::RadialTangential,
    )
    .unwrap();
    let few = calibrate(
        &CHECKERS,
        camera.size_px(),
        &corners(&CHECKERS, &camera, 1, 4, 0.1),
        LensModel::RadialTangential,
    )
    .unwrap();
    let (full, few) = (coverage(&full), coverage(&few));
    assert!(full.covered > 0.9 && full.advice.len() <= 3, "{full:?}");
    assert!(few.covered < full.covered && few.advice.len() > full.advice.len(), "{few:?}");
    assert!(few.advice.iter().any(|a| a.to_string() == "take 8 more pictures, each from another direction"));
}

#[test]
fn pictures_of_two_cameras_are_told_by_their_names() {
    let webcam = webcam();
    let other =
        Camera::new(webcam.size_px(), webcam.focal_px(), (309.0, 249.0), webcam.distortion()).unwrap();
    for (right, is_other) in [(&webcam, false), (&other, true)] {
        let named = |camera: &Camera, seed: u64, name: &str| -> Vec<ViewInput> {
            let views = corners(&CHECKERS, camera, seed, 13, 0.2).into_iter();
            views.map(|view| ViewInput { name: format!("in/{name}{}.png", view.name), ..view }).collect()
        };
        let views = [named(&webcam, 1, "left"), named(right, 2, "right")].concat();
        let told = several_cameras(&CHECKERS, webcam.size_px(), &views, LensModel::RadialTangential);
        assert_eq!(told.as_ref().map(|told| told.groups.concat()), is_other.then(|| "leftright".to_owned()));
        assert!(told.is_none_or(|told| matches!(told.parameter, "cx" | "cy")));
    }
}
