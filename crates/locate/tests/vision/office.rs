//! A drawn corridor wall with one door: where its borders are is known exactly.

use nalgebra::{Rotation3, Vector3};
use visloc_core::{
    Frame, RgbImage, RngTree, Timestamp,
    geom::{Camera, Rigid3},
};
use visloc_locate::vision::{
    DoorSide, DropReason, FeatureKind, Percept,
    office::{OfficeAnalysisConfig, OfficeAnalyzer, OfficeColors, OfficeFilters, SegmentDetector},
};

const WALL: [u8; 3] = [200, 198, 190];
const FLOOR: [u8; 3] = [190, 160, 50];
const DOOR: [u8; 3] = [160, 36, 30];
/// Columns of the door's edges, and the row of the floor's border.
const LEFT: f64 = 99.5;
const RIGHT: f64 = 180.5;
const FOOT: f64 = 170.5;

/// A door in a wall straight ahead, darkened to a percentage of the light; `extra` paints over it.
fn frame(percent: u16, extra: impl Fn(f64, f64) -> Option<[u8; 3]>) -> Frame {
    let mut image = RgbImage::new(320, 240);
    for y in 0..240 {
        for x in 0..320 {
            let (u, v) = (f64::from(x), f64::from(y));
            let rgb = extra(u, v).unwrap_or(if v > FOOT {
                FLOOR
            } else if (LEFT..RIGHT).contains(&u) {
                DOOR
            } else {
                WALL
            });
            image.set(x, y, rgb.map(|value| (u16::from(value) * percent / 100) as u8));
        }
    }
    let optical = Rotation3::from_basis_unchecked(&[-Vector3::y(), -Vector3::z(), Vector3::x()]);
    Frame {
        at: Timestamp::default(),
        image,
        camera_index: 0,
        camera: Camera::pinhole((320, 240), (373.3, 373.3), (159.5, 90.0)).unwrap(),
        robot_from_camera: Rigid3::new(optical, Vector3::new(0.0, 0.0, 0.5)),
        odometry: None,
        ground_contact: None,
    }
}

fn analyze(frame: &Frame, config: OfficeAnalysisConfig) -> Percept {
    let colors = OfficeColors { wall: [235, 234, 228], floor: [216, 181, 58], doors: vec![[176, 39, 31]] };
    let mut analyzer = OfficeAnalyzer::new(config, &colors).unwrap();
    analyzer.analyze(frame, &mut RngTree::new(1).stream("analysis", 0)).unwrap().clone()
}

fn configs() -> [OfficeAnalysisConfig; 2] {
    [SegmentDetector::Gradient, SegmentDetector::Contour]
        .map(|detector| OfficeAnalysisConfig { detector, ..OfficeAnalysisConfig::default() })
}

#[test]
fn both_detectors_find_every_border_to_half_a_pixel() {
    for config in configs() {
        for percent in [30, 60, 100] {
            let percept = analyze(&frame(percent, |_, _| None), config);
            let of = |kind: FeatureKind| percept.pixels.iter().filter(move |pixel| pixel.kind == kind);
            let edge = |side| FeatureKind::DoorEdge { side, paint: 0 };
            for (kind, column) in [(edge(DoorSide::Left), LEFT), (edge(DoorSide::Right), RIGHT)] {
                assert!(of(kind).count() >= 3, "{:?} {percent} {kind:?}", config.detector);
                assert!(of(kind).all(|pixel| (pixel.px.x - column).abs() < 0.75), "{:?}", config.detector);
            }
            for kind in [FeatureKind::WallFoot, FeatureKind::DoorFoot] {
                assert!(of(kind).count() >= 3, "{:?} {percent} {kind:?}", config.detector);
                assert!(of(kind).all(|pixel| (pixel.px.y - FOOT).abs() < 0.75), "{:?}", config.detector);
            }
            assert!(percept.is_informative);
        }
    }
}

#[test]
fn a_foot_is_that_of_a_door_only_below_the_door() {
    for config in configs() {
        let percept = analyze(&frame(100, |_, _| None), config);
        for pixel in percept.pixels.iter().filter(|pixel| !pixel.kind.is_door_edge()) {
            let is_below_door = (LEFT..RIGHT).contains(&pixel.px.x);
            assert_eq!(pixel.kind == FeatureKind::DoorFoot, is_below_door, "{:?}", pixel.px);
        }
    }
}

#[test]
fn a_dark_bin_on_the_floor_is_no_wall() {
    let bin =
        |u: f64, v: f64| ((220.0..270.0).contains(&u) && (140.0..200.0).contains(&v)).then_some([52, 58, 62]);
    let percept = analyze(&frame(100, bin), OfficeAnalysisConfig::default());
    let on_bin = |u: f64, v: f64| (218.0..272.0).contains(&u) && v > FOOT + 3.0;
    assert!(percept.pixels.iter().all(|pixel| !on_bin(pixel.px.x, pixel.px.y)));
}

#[test]
fn every_filter_drops_what_it_is_for_and_can_be_switched_off() {
    // Above the horizon, a sign in the door's color.
    let sign = |u: f64, v: f64| ((250.0..290.0).contains(&u) && v < 60.0).then_some(DOOR);
    let frame = frame(100, sign);
    let all = OfficeFilters::default();
    let with = |filters| analyze(&frame, OfficeAnalysisConfig { filters, ..OfficeAnalysisConfig::default() });
    assert!(with(all).pixels.iter().all(|pixel| pixel.px.y > 85.0));
    let open = with(OfficeFilters { horizon: false, random_discard: false, ..all });
    assert!(open.pixels.iter().any(|pixel| pixel.px.x > 240.0 && pixel.px.y < 60.0));
    let few =
        OfficeAnalysisConfig { max_door_pixels: 4, max_floor_pixels: 5, ..OfficeAnalysisConfig::default() };
    let percept = analyze(&frame, few);
    assert_eq!(percept.pixels.len(), 9);
    assert!(percept.num_dropped(DropReason::RandomDiscard) > 0);
}

#[test]
fn strange_images_are_refused_or_empty() {
    let mut odd = frame(100, |_, _| None);
    odd.image = RgbImage::new(10, 10);
    let colors = OfficeColors { wall: [235, 234, 228], floor: [216, 181, 58], doors: Vec::new() };
    let mut rng = RngTree::new(1).stream("analysis", 0);
    let mut analyzer = OfficeAnalyzer::new(OfficeAnalysisConfig::default(), &colors).unwrap();
    assert!(analyzer.analyze(&odd, &mut rng).is_err());
    for size in [1, 3, 9] {
        let camera = Camera::pinhole((size, size), (10.0, 10.0), (0.5, 0.5)).unwrap();
        let tiny = Frame { image: RgbImage::new(size, size), camera, ..odd.clone() };
        for config in configs() {
            let mut analyzer = OfficeAnalyzer::new(config, &colors).unwrap();
            assert!(analyzer.analyze(&tiny, &mut rng).unwrap().pixels.is_empty());
        }
    }
}
