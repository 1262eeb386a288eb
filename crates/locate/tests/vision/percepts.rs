//! What the whole analysis, all filters on, makes of an image.

use visloc_core::{RgbImage, RngTree, geom::Mount};
use visloc_locate::vision::{
    AnalysisError, FeatureKind, Percept,
    field::{FieldAnalysisConfig, FieldAnalyzer},
};

use crate::painter::{BLUE, Painter, carpet, carpet_with_line, fill};

fn analyze(painter: &Painter, image: RgbImage, seed: u64) -> Percept {
    let mut analyzer = FieldAnalyzer::new(FieldAnalysisConfig::default()).unwrap();
    analyzer.analyze(&painter.frame(image), &mut RngTree::new(seed).stream("analysis", 0)).unwrap().clone()
}

#[test]
fn line_pixels_lie_on_the_borders_of_the_line() {
    let painter = Painter::new(10.0);
    let percept = analyze(&painter, painter.paint(carpet_with_line), 1);
    assert_eq!(percept.pixels.len(), 12);
    for pixel in &percept.pixels {
        let ground = painter.ground(pixel.px.x, pixel.px.y).unwrap();
        let off_m = ((ground.x - 1.5).abs() - 0.025).abs();
        assert!(off_m < 0.02, "{} sees {ground}, {off_m} m from the border", pixel.px);
    }
    assert!((percept.quality - 0.4).abs() < 1e-12 && !percept.is_informative);
}

#[test]
fn light_from_a_third_to_full_changes_nothing() {
    let painter = Painter::new(10.0);
    for light in [0.33, 0.6, 1.0, 1.08] {
        let mut image = painter.paint(carpet_with_line);
        let foot = painter.pixel(2.0, 0.0, 0.0).y as u32;
        fill(&mut image, 200..214, 0..foot, BLUE);
        image.data_mut().iter_mut().for_each(|v| *v = (f64::from(*v) * light).min(255.0) as u8);
        let percept = analyze(&painter, image, 1);
        assert_eq!(percept.pixels.len(), 20, "light {light}");
        assert!((percept.quality - 1.0).abs() < 1e-12 && percept.is_informative, "light {light}");
    }
}

#[test]
fn uneven_light_across_the_image_changes_nothing() {
    let painter = Painter::new(10.0);
    let mut image = painter.paint(carpet_with_line);
    for y in 0..240 {
        for x in 0..320 {
            let light = 0.4 + 0.6 * f64::from(x) / 320.0;
            image.set(x, y, image.get(x, y).map(|v| (f64::from(v) * light) as u8));
        }
    }
    let mut config = FieldAnalysisConfig::default();
    config.filters.random_discard = false;
    let mut analyzer = FieldAnalyzer::new(config).unwrap();
    let percept = analyzer.analyze(&painter.frame(image), &mut RngTree::new(1).stream("a", 0)).unwrap();
    for third in 0..3 {
        let (from, to) = (f64::from(third) * 107.0, f64::from(third + 1) * 107.0);
        let found = percept.pixels.iter().filter(|pixel| (from..to).contains(&pixel.px.x)).count();
        assert!(found >= 10, "third {third}: {found}");
    }
}

#[test]
fn an_empty_carpet_says_nothing() {
    let painter = Painter::new(10.0);
    let percept = analyze(&painter, painter.paint(carpet), 1);
    assert!(percept.pixels.is_empty());
    assert!(percept.quality.abs() < 1e-12);
}

#[test]
fn same_seed_same_pixels() {
    let painter = Painter::new(10.0);
    let image = painter.paint(carpet_with_line);
    assert_eq!(analyze(&painter, image.clone(), 5).pixels, analyze(&painter, image.clone(), 5).pixels);
    assert_ne!(analyze(&painter, image.clone(), 5).pixels, analyze(&painter, image, 6).pixels);
}

#[test]
fn an_image_of_another_size_is_refused() {
    let painter = Painter::new(10.0);
    let mut analyzer = FieldAnalyzer::new(FieldAnalysisConfig::default()).unwrap();
    let result =
        analyzer.analyze(&painter.frame(RgbImage::new(640, 480)), &mut RngTree::new(1).stream("a", 0));
    assert!(matches!(result, Err(AnalysisError::Size { found_px: (640, 480), .. })));
}

#[test]
fn a_camera_that_is_nowhere_on_the_robot_is_refused() {
    let painter = Painter::new(10.0);
    let mut analyzer = FieldAnalyzer::new(FieldAnalysisConfig::default()).unwrap();
    let mut frame = painter.frame(RgbImage::new(320, 240));
    for mount in [
        Mount { height_m: f64::NAN, ..Mount::default() },
        Mount { tilt_rad: f64::INFINITY, ..Mount::default() },
    ] {
        frame.robot_from_camera = mount.robot_from_camera();
        let error = analyzer.analyze(&frame, &mut RngTree::new(1).stream("a", 0)).unwrap_err();
        assert!(matches!(error, AnalysisError::Mount { .. }), "{error}");
        assert!(error.to_string().contains("expected a pose of the camera on the robot in finite numbers"));
    }
}

#[test]
fn black_white_and_tiny_images_do_no_harm() {
    let painter = Painter::new(10.0);
    for value in [0, 128, 255] {
        let mut image = RgbImage::new(320, 240);
        image.data_mut().fill(value);
        assert!(analyze(&painter, image, 1).pixels.is_empty());
    }
    let mut small = Painter::new(10.0);
    small.camera = visloc_core::geom::Camera::pinhole((3, 2), (3.0, 3.0), (1.0, 0.5)).unwrap();
    assert!(analyze(&small, RgbImage::new(3, 2), 1).pixels.is_empty());
}

#[test]
fn larger_images_give_the_same_features() {
    let mut painter = Painter::new(10.0);
    let small = analyze(&painter, painter.paint(carpet_with_line), 1);
    let mut image = RgbImage::new(640, 480);
    let painted = painter.paint(carpet_with_line);
    for y in 0..480 {
        for x in 0..640 {
            image.set(x, y, painted.get(x / 2, y / 2));
        }
    }
    painter.camera = visloc_core::geom::Camera::pinhole((640, 480), (746.6, 746.6), (319.5, 239.5)).unwrap();
    let large = analyze(&painter, image, 1);
    assert_eq!(small.pixels.len(), large.pixels.len());
    for pixel in &large.pixels {
        assert_eq!(pixel.kind, FeatureKind::FieldLine);
        let ground = painter.ground(pixel.px.x, pixel.px.y).unwrap();
        assert!(((ground.x - 1.5).abs() - 0.025).abs() < 0.03);
    }
}
