//! The detectors.

use nalgebra::{Rotation3, Vector3};
use rand::{Rng as _, RngExt};
use visloc_calib::{
    Board, CameraFromBoard, DetectReject, detect,
    render::{RenderSettings, render},
};
use visloc_core::{GrayImage, RngTree, geom::Camera};

use crate::support::{CHECKERS, TAGS, fisheye, picture, webcam};

/// Errors of all corners, pixels, and the number of boards that were found.
fn errors(board: &Board, camera: &Camera, settings: &RenderSettings, num_views: u64) -> (Vec<f64>, usize) {
    let (mut errors, mut found) = (Vec::new(), 0);
    for index in 0..num_views {
        let (image, pose) = picture(board, camera, 7, index, settings);
        let detection = match detect(board, &image) {
            Ok(detection) => detection,
            Err(why) => {
                println!("view {index}: {why}");
                continue;
            }
        };
        found += 1;
        for corner in detection.corners {
            let mut truth = camera.project(&pose.transform(&board.corner_in_board(corner.id))).unwrap();
            let mut error = (corner.px - truth).norm();
            if let Board::Checkerboard(b) = board {
                // A board with an odd and an even side is the same from its other end when it is turned by half.
                let turned = b.columns * b.rows - 1 - corner.id;
                truth = camera.project(&pose.transform(&board.corner_in_board(turned))).unwrap();
                error = error.min((corner.px - truth).norm());
            }
            errors.push(error);
        }
    }
    errors.sort_by(f64::total_cmp);
    (errors, found)
}

#[test]
fn corners_are_found_to_a_tenth_of_a_pixel() {
    for (name, board, camera) in [
        ("checkers, webcam", CHECKERS, webcam()),
        ("checkers, fisheye", CHECKERS, fisheye()),
        ("tags, webcam", TAGS, webcam()),
        ("tags, fisheye", TAGS, fisheye()),
    ] {
        let (errors, found) = errors(&board, &camera, &RenderSettings::default(), 12);
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        println!(
            "{name}: {found} of 12, {} corners, median {:.3}, rms {rms:.3}, largest {:.3} px",
            errors.len(),
            errors[errors.len() / 2],
            errors[errors.len() - 1]
        );
        assert!(found >= 11, "{name}: {found} of 12 found");
        assert!(errors.len() > 9 * found * board.num_corners() / 10, "{name}: {} corners", errors.len());
        assert!(errors[errors.len() / 2] < 0.08, "{name}: median {}", errors[errors.len() / 2]);
        assert!(errors[errors.len() - 1] < 1.0, "{name}: worst {}", errors[errors.len() - 1]);
    }
}

#[test]
fn blur_noise_and_poor_light_are_survived() {
    // Tags carry bits, which need more than corners do.
    for (board, blur_px, noise) in [(CHECKERS, 1.8, 8.0), (TAGS, 1.0, 5.0)] {
        let settings = RenderSettings { blur_px, noise, light_gradient: 0.8, vignetting: 0.5 };
        let (errors, found) = errors(&board, &webcam(), &settings, 10);
        println!("{found} of 10, median {:?} of {}", errors.get(errors.len() / 2), errors.len());
        assert!(found >= 8, "{board:?}: {found} of 10");
        assert!(errors[errors.len() / 2] < 0.3, "{board:?}: {}", errors[errors.len() / 2]);
    }
}

#[test]
fn covered_corners_are_left_out_and_the_rest_keeps_its_numbers() {
    let camera = webcam();
    let pose =
        CameraFromBoard::new(Rotation3::from_euler_angles(0.2, 0.3, 0.1), Vector3::new(-0.17, -0.1, 0.5));
    let mut rng = RngTree::new(3).stream("covered", 0);
    for (board, least) in [(CHECKERS, 40), (TAGS, 72)] {
        let mut image = render(&board, &camera, &pose, &RenderSettings::default(), &mut rng);
        // A finger in the middle of the board.
        let width = image.width();
        for y in 200..260 {
            image.data_mut()[y * width + 290..y * width + 340].fill(140);
        }
        let detection = detect(&board, &image).unwrap();
        println!("{} of {}", detection.corners.len(), board.num_corners());
        assert!(detection.corners.len() >= least && detection.corners.len() < board.num_corners());
        for corner in detection.corners {
            let truth = camera.project(&pose.transform(&board.corner_in_board(corner.id))).unwrap();
            assert!((corner.px - truth).norm() < 1.5, "{}: {} {truth}", corner.id, corner.px);
        }
    }
}

#[test]
fn tags_at_the_border_of_the_image_keep_their_numbers() {
    let camera = webcam();
    let pose =
        CameraFromBoard::new(Rotation3::from_euler_angles(0.0, 0.2, 0.4), Vector3::new(-0.05, -0.2, 0.3));
    let mut rng = RngTree::new(3).stream("cut", 0);
    let image = render(&TAGS, &camera, &pose, &RenderSettings::default(), &mut rng);
    let detection = detect(&TAGS, &image).unwrap();
    assert!((16..TAGS.num_corners()).contains(&detection.corners.len()), "{}", detection.corners.len());
    for corner in detection.corners {
        let truth = camera.project(&pose.transform(&TAGS.corner_in_board(corner.id))).unwrap();
        assert!((corner.px - truth).norm() < 0.5);
    }
}

#[test]
fn a_board_of_another_size_is_named() {
    let (image, _) = picture(&CHECKERS, &webcam(), 1, 0, &RenderSettings::default());
    let Board::Checkerboard(board) = CHECKERS else { unreachable!() };
    for columns in [8, 12] {
        let other = Board::Checkerboard(visloc_calib::Checkerboard { columns, ..board });
        let reject = detect(&other, &image).unwrap_err();
        assert!(matches!(reject, DetectReject::OtherSize { columns: 9, rows: 6, .. }), "{reject}");
    }
}

#[test]
fn anything_may_be_in_the_image() {
    let mut rng = RngTree::new(1).stream("noise", 0);
    for (width, height) in [(0, 0), (1, 1), (31, 400), (32, 32), (33, 64), (200, 160)] {
        for kind in 0..4 {
            let data = (0..width * height).map(|i| match kind {
                0 => 0,
                1 => (rng.next_u32() & 255) as u8,
                2 => {
                    if (i / 8 + i / width.max(1) / 8) % 2 == 0 {
                        0
                    } else {
                        255
                    }
                }
                _ => {
                    if rng.random_range(0..3) == 0 {
                        255
                    } else {
                        (i % 251) as u8
                    }
                }
            });
            let image = GrayImage::from_raw(width, height, data.collect()).unwrap();
            for board in [CHECKERS, TAGS] {
                if let Ok(found) = detect(&board, &image) {
                    assert!(found.corners.iter().all(|c| c.px.iter().all(|v| v.is_finite())));
                }
            }
        }
    }
}
