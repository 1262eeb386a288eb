//! A camera from its own images.

#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use visloc_core::{GrayImage, Source, Timestamp};
use visloc_io::sequence::{SequenceRange, open_tum};
use visloc_slam::{SelfCalibrationError, SelfCalibrator, SlamConfig};

fn clip() -> Vec<(Timestamp, GrayImage)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip");
    let mut source = open_tum(&folder, SequenceRange::default()).unwrap();
    let mut images = Vec::new();
    while let Some(frame) = source.next_item() {
        let frame = frame.unwrap();
        images.push((frame.at, frame.image));
    }
    images
}

/// Of the clip's camera, pixels.
const FOCAL_PX: f64 = 262.5;

#[test]
fn the_focal_length_of_a_moving_camera_is_found_and_its_error_told() {
    let mut calibrator = SelfCalibrator::default();
    for (at, image) in clip() {
        calibrator.add(at, image).unwrap();
    }
    for seed in 1..=3 {
        let found = calibrator.calibrate(&SlamConfig::default(), seed, || true).unwrap();
        let error = (found.camera.focal_px().0 / FOCAL_PX - 1.0).abs();
        assert!(error < 0.05 && error < 3.0 * found.focal_deviation, "{found:?}");
        assert_eq!(found.num_tracked, calibrator.num_images());
        assert_eq!(
            found,
            calibrator.calibrate(&SlamConfig::default(), seed, || true).unwrap(),
            "the same bits"
        );
    }
}

#[test]
fn a_camera_that_stands_still_is_not_told() {
    let mut calibrator = SelfCalibrator::default();
    let (_, image) = clip().swap_remove(0);
    for i in 0..20 {
        calibrator.add(Timestamp::from_secs(f64::from(i) / 30.0), image.clone()).unwrap();
    }
    let error = calibrator.calibrate(&SlamConfig::default(), 1, || true).unwrap_err();
    assert!(matches!(error, SelfCalibrationError::TooLittle { num_images: 20, .. }), "{error}");
    let ended = calibrator.calibrate(&SlamConfig::default(), 1, || false).unwrap_err();
    assert!(matches!(ended, SelfCalibrationError::Ended), "{ended}");
    let error = calibrator.add(Timestamp::from_secs(9.0), GrayImage::new(32, 24)).unwrap_err();
    assert!(error.to_string().contains("32 x 24"), "{error}");
}
