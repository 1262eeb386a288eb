//! Straight lines in pictures tell whether the distortion is right.

use visloc_calib::{Severity, check_camera, render::RenderSettings};
use visloc_core::geom::{Camera, Distortion};

use crate::support::{CHECKERS, picture, webcam};

#[test]
fn a_wrong_distortion_bends_lines() {
    let truth = webcam();
    let images: Vec<_> =
        (0..6).map(|i| picture(&CHECKERS, &truth, 11, i, &RenderSettings::default()).0).collect();
    let with =
        |lens: Distortion| Camera::new(truth.size_px(), truth.focal_px(), truth.center_px(), lens).unwrap();
    let lines = |camera: &Camera| {
        let check = check_camera(camera, &images);
        let finding = check.findings.into_iter().find(|f| f.subject == "straight lines").unwrap();
        println!("{}", finding.message);
        finding.severity
    };
    assert_eq!(lines(&truth), Severity::Fine);
    assert!(lines(&with(Distortion::None)) > Severity::Fine);
    assert!(lines(&with(Distortion::RadialTangential([-0.5, 0.25, 0.0, 0.0, 0.0]))) > Severity::Fine);
}
