//! Composite features on painted images.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use nalgebra::Point2;
use rand::RngExt;
use visloc_core::{RgbImage, RngTree, geom::angle};
use visloc_locate::vision::{
    FieldFeatures, JunctionKind, PostSide,
    field::{FeatureDetectionConfig, FieldAnalysisConfig, FieldAnalyzer},
};
use visloc_world::field::GoalColor;

use crate::painter::{BLUE, GRAY, GREEN, Painter, WHITE, carpet, carpet_with_line, fill};

fn detect_with(painter: &Painter, image: RgbImage, composite: FeatureDetectionConfig) -> FieldFeatures {
    let config = FieldAnalysisConfig { composite, ..FieldAnalysisConfig::default() };
    let mut analyzer = FieldAnalyzer::new(config).unwrap();
    let mut rng = RngTree::new(1).stream("analysis", 0);
    analyzer.analyze(&painter.frame(image), &mut rng).unwrap().features.clone()
}

fn detect(painter: &Painter, image: RgbImage) -> FieldFeatures {
    detect_with(painter, image, FeatureDetectionConfig::default())
}

/// Lines of the ground as (x from, x to, y from, y to) of their center lines, drawn 5 cm wide on carpet.
fn paint_lines(painter: &Painter, lines: &[[f64; 4]]) -> RgbImage {
    painter.paint(|p| {
        let is_on = |[x0, x1, y0, y1]: &[f64; 4]| {
            (x0 - 0.025..x1 + 0.025).contains(&p.x) && (y0 - 0.025..y1 + 0.025).contains(&p.y)
        };
        if lines.iter().any(is_on) { WHITE } else { carpet(p) }
    })
}

#[test]
fn a_line_is_found_with_its_ends() {
    let painter = Painter::new(15.0);
    let features = detect(&painter, paint_lines(&painter, &[[1.6, 1.6, -0.4, 0.3]]));
    let [line] = features.lines[..] else { panic!("{features:?}") };
    let [left, right] = line.ends_in_robot;
    assert!((line.length_m() - 0.75).abs() < 0.05, "{line:?}");
    assert!((left.x - 1.6).abs() < 0.02 && (right.x - 1.6).abs() < 0.02, "{line:?}");
    assert!(features.junctions.is_empty() && features.circle.is_none() && features.marks.is_empty());
}

#[test]
fn something_before_a_line_does_not_cut_it_but_a_gap_does() {
    let painter = Painter::new(10.0);
    let at_line = painter.pixel(1.5, 0.0, 0.0).y as u32;
    for (color, expected) in [(GRAY, 1), (GREEN, 2)] {
        let mut image = painter.paint(carpet_with_line);
        fill(&mut image, 120..190, at_line - 60..at_line + 8, color);
        assert_eq!(detect(&painter, image).lines.len(), expected, "{color:?}");
    }
}

#[test]
fn what_is_thinner_or_broader_than_a_line_is_none() {
    let painter = Painter::new(15.0);
    for half_m in [0.006, 0.08] {
        let image = painter.paint(|p| if (p.x - 1.2).abs() < half_m { WHITE } else { carpet(p) });
        assert!(detect(&painter, image).lines.is_empty(), "{half_m}");
    }
}

#[test]
fn junctions_have_their_kind_place_and_direction() {
    let painter = Painter::new(15.0);
    let at = Point2::new(1.5, 0.1);
    let across = [1.5, 1.5, -3.0, 3.0];
    let cases = [
        (JunctionKind::L, [[1.5, 1.5, 0.1, 3.0], [0.5, 1.5, 0.1, 0.1]], 3.0 * FRAC_PI_4),
        (JunctionKind::T, [across, [1.5, 3.0, 0.1, 0.1]], 0.0),
        (JunctionKind::T, [across, [0.5, 1.5, 0.1, 0.1]], 2.0 * FRAC_PI_2),
        (JunctionKind::X, [across, [0.5, 3.0, 0.1, 0.1]], 0.0),
    ];
    for (kind, lines, direction_rad) in cases {
        let features = detect(&painter, paint_lines(&painter, &lines));
        let [junction] = features.junctions[..] else { panic!("{kind:?}: {features:?}") };
        assert_eq!(junction.kind, kind);
        assert!((junction.at_in_robot - at).norm() < 0.03, "{kind:?}: {junction:?}");
        let turn = angle::difference(junction.direction_rad, direction_rad);
        let turn = if kind == JunctionKind::X { turn - (turn / FRAC_PI_2).round() * FRAC_PI_2 } else { turn };
        assert!(turn.abs() < 0.05, "{kind:?}: {junction:?}");
    }
}

/// A circle of this center, and a line through the center along x if wanted.
fn paint_circle(painter: &Painter, center: Point2<f64>, has_line: bool) -> RgbImage {
    painter.paint(|p| {
        let on_circle = ((p - center).norm() - 0.6).abs() < 0.025;
        let on_line = has_line && (p.y - center.y).abs() < 0.025;
        if on_circle || on_line { WHITE } else { carpet(p) }
    })
}

#[test]
fn the_circle_is_found_whole_and_in_parts() {
    let painter = Painter::new(12.0);
    for (x, y) in [(2.0, 0.0), (1.6, 0.5), (2.2, -0.7), (0.9, 0.1)] {
        let center = Point2::new(x, y);
        let features = detect(&painter, paint_circle(&painter, center, false));
        let circle = features.circle.unwrap();
        assert!((circle.center_in_robot - center).norm() < 0.05, "{center}: {circle:?}");
        assert!(circle.halfway_rad.is_none() && features.lines.is_empty(), "{features:?}");
    }
}

#[test]
fn the_halfway_line_belongs_to_the_circle() {
    let painter = Painter::new(12.0);
    let features = detect(&painter, paint_circle(&painter, Point2::new(2.0, 0.1), true));
    let circle = features.circle.unwrap();
    let direction_rad = circle.halfway_rad.unwrap();
    assert!(angle::difference(2.0 * direction_rad, 0.0).abs() < 0.06, "{circle:?}");
    assert_eq!(features.lines.len(), 1);
}

#[test]
fn a_small_cross_is_a_mark_and_a_large_patch_is_none() {
    let painter = Painter::new(15.0);
    for (half_length_m, expected) in [(0.05, 1), (0.12, 0)] {
        let image = painter.paint(|p| {
            let (dx, dy) = ((p.x - 1.4).abs(), (p.y - 0.2).abs());
            let is_cross = dx.max(dy) < half_length_m && dx.min(dy) < half_length_m / 2.0;
            if is_cross { WHITE } else { carpet(p) }
        });
        let features = detect(&painter, image);
        assert_eq!(features.marks.len(), expected, "{features:?}");
        for mark in &features.marks {
            assert!((mark.at_in_robot - Point2::new(1.4, 0.2)).norm() < 0.03, "{mark:?}");
        }
    }
}

/// A post at (2, y) drawn as a rectangle up to the top of the image, and its foot's row.
fn draw_post(painter: &Painter, image: &mut RgbImage, y: f64, color: [u8; 3]) -> u32 {
    let foot = painter.pixel(1.95, y, 0.0);
    let [left, right] = [0.05, -0.05].map(|dy| painter.pixel(2.0, y + dy, 0.0).x.round() as u32);
    fill(image, left..right, 0..foot.y as u32, color);
    foot.y as u32
}

#[test]
fn posts_stand_where_they_are_and_the_bar_tells_the_side() {
    let painter = Painter::new(5.0);
    let mut image = painter.paint(carpet);
    draw_post(&painter, &mut image, 0.4, BLUE);
    let [left, right] = [0.45, -1.0].map(|y| painter.pixel(2.0, y, 0.0).x.clamp(0.0, 319.0) as u32);
    fill(&mut image, left..right, 0..12, BLUE);
    let features = detect(&painter, image);
    let [post] = features.posts[..] else { panic!("{features:?}") };
    assert_eq!((post.color, post.side), (GoalColor::Blue, Some(PostSide::Left)));
    let base = post.base_in_robot.unwrap();
    assert!((base - Point2::new(2.0, 0.4)).norm() < 0.1, "{post:?}");
    assert!((post.bearing_rad - base.y.atan2(base.x)).abs() < 0.02);
}

#[test]
fn white_posts_are_looked_for_on_fields_that_have_them() {
    let painter = Painter::new(5.0);
    let mut image = painter.paint(carpet);
    draw_post(&painter, &mut image, 0.4, WHITE);
    assert!(detect(&painter, image.clone()).posts.is_empty());
    let config = FeatureDetectionConfig { has_white_goals: true, ..FeatureDetectionConfig::default() };
    let features = detect_with(&painter, image, config);
    let [post] = features.posts[..] else { panic!("{features:?}") };
    assert_eq!(post.color, GoalColor::White);
}

#[test]
fn a_board_of_the_goals_color_is_no_post() {
    let painter = Painter::new(5.0);
    let mut image = painter.paint(carpet);
    let foot = painter.pixel(2.0, 0.0, 0.0).y as u32;
    fill(&mut image, 100..160, foot - 120..foot, BLUE);
    assert!(detect(&painter, image).posts.is_empty());
}

#[test]
fn nothing_comes_of_nothing() {
    let painter = Painter::new(10.0);
    let mut one_pixel = painter.paint(carpet);
    one_pixel.set(160, 180, WHITE);
    let mut white = RgbImage::new(320, 240);
    white.data_mut().fill(255);
    for image in [painter.paint(carpet), one_pixel, white, RgbImage::new(320, 240)] {
        assert_eq!(detect(&painter, image), FieldFeatures::default());
    }
}

#[test]
fn switched_off_nothing_is_found() {
    let painter = Painter::new(10.0);
    let config = FeatureDetectionConfig { is_on: false, ..FeatureDetectionConfig::default() };
    assert_eq!(detect_with(&painter, painter.paint(carpet_with_line), config), FieldFeatures::default());
}

/// Patches of all colors in all sizes: whatever is found, places are numbers.
#[test]
fn chaos_does_no_harm() {
    let painter = Painter::new(10.0);
    let mut rng = RngTree::new(3).stream("chaos", 0);
    for _ in 0..40 {
        let mut image = painter.paint(carpet);
        for _ in 0..rng.random_range(1..200) {
            let (x, y) = (rng.random_range(0..319), rng.random_range(0..239));
            let (w, h) = (rng.random_range(1..40), rng.random_range(1..40));
            let color = [WHITE, BLUE, GREEN, GRAY][rng.random_range(0..4_usize)];
            fill(&mut image, x..(x + w).min(320), y..(y + h).min(240), color);
        }
        let config = FeatureDetectionConfig { has_white_goals: true, ..FeatureDetectionConfig::default() };
        let features = detect_with(&painter, image, config);
        let places = features.lines.iter().flat_map(|line| line.ends_in_robot);
        let places = places.chain(features.junctions.iter().map(|junction| junction.at_in_robot));
        let places = places.chain(features.circle.map(|circle| circle.center_in_robot));
        let places = places.chain(features.posts.iter().filter_map(|post| post.base_in_robot));
        assert!(places.into_iter().all(|at| at.x.is_finite() && at.y.is_finite()));
    }
}
