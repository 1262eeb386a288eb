//! Each filter has something to drop, drops it, says so, and lets it pass when it is switched off.

use nalgebra::Point2;
use visloc_core::{RgbImage, RngTree};
use visloc_locate::vision::{
    DropReason, FeatureKind, Percept,
    color::ColorConfig,
    field::{FieldAnalysisConfig, FieldAnalyzer, FilterSwitches},
};

use crate::painter::{BLUE, GRAY, GREEN, Painter, WHITE, YELLOW, carpet, carpet_with_line, fill};

const NO_FILTERS: FilterSwitches = FilterSwitches {
    beside_carpet: false,
    too_thin: false,
    post_or_bar: false,
    isolated: false,
    horizon: false,
    own_body: false,
    field_end: false,
    goal_blobs: false,
    obstacles: false,
    random_discard: false,
};

fn analyze(painter: &Painter, image: &RgbImage, filters: FilterSwitches) -> Percept {
    let config = FieldAnalysisConfig { filters, ..FieldAnalysisConfig::default() };
    let mut analyzer = FieldAnalyzer::new(config).unwrap();
    let mut rng = RngTree::new(1).stream("analysis", 0);
    analyzer.analyze(&painter.frame(image.clone()), &mut rng).unwrap().clone()
}

/// With only this filter on, it drops some pixels and all of them in `area`; with it off, they are kept.
fn expect_drops(
    painter: &Painter,
    image: &RgbImage,
    filters: FilterSwitches,
    reason: DropReason,
    area: impl Fn(&Point2<f64>) -> bool,
) {
    let on = analyze(painter, image, filters);
    let dropped: Vec<_> = on.dropped.iter().filter(|pixel| pixel.reason == reason).collect();
    assert!(!dropped.is_empty(), "{reason:?} dropped nothing");
    assert_eq!(dropped.len(), on.num_dropped(reason));
    for pixel in &dropped {
        assert!(area(&pixel.px), "{reason:?} dropped {}, outside of the area", pixel.px);
    }
    let kept_in_area = |percept: &Percept| percept.pixels.iter().filter(|pixel| area(&pixel.px)).count();
    assert_eq!(kept_in_area(&on), 0, "{reason:?} left something");
    let off = analyze(painter, image, NO_FILTERS);
    assert_eq!(off.num_dropped(reason), 0);
    assert!(kept_in_area(&off) > 0, "switched off, {reason:?} lets pixels pass");
}

#[test]
fn white_without_carpet_on_both_sides() {
    let painter = Painter::new(10.0);
    // The line at 1.5 m is good; the carpet's own border at 3 m is white floor beyond green.
    let image = painter.paint(|p| if p.x > 3.0 { [200, 200, 198] } else { carpet_with_line(p) });
    let border = painter.pixel(3.0, 0.0, 0.0).y;
    let filters = FilterSwitches { beside_carpet: true, ..NO_FILTERS };
    expect_drops(&painter, &image, filters, DropReason::NotBesideCarpet, |px| px.y < border + 3.0);
    let line = painter.pixel(1.5, 0.0, 0.0).y;
    let kept = analyze(&painter, &image, filters).pixels;
    assert!(kept.iter().filter(|pixel| (pixel.px.y - line).abs() < 6.0).count() > 20);
}

#[test]
fn white_too_thin_for_its_distance() {
    let painter = Painter::new(20.0);
    let mut image = painter.paint(carpet_with_line);
    fill(&mut image, 0..320, 200..202, WHITE); // a scratch close to the robot
    let filters = FilterSwitches { too_thin: true, ..NO_FILTERS };
    expect_drops(&painter, &image, filters, DropReason::TooThin, |px| px.y > 195.0);
}

#[test]
fn goal_colors_that_lie_on_the_ground() {
    let painter = Painter::new(5.0);
    let mut image = painter.paint(carpet);
    fill(&mut image, 60..72, 20..200, YELLOW);
    for y in 150..200 {
        fill(&mut image, 150 + 2 * (200 - y)..190 + 2 * (200 - y), y..y + 1, YELLOW); // the base, running away
    }
    let filters = FilterSwitches { post_or_bar: true, ..NO_FILTERS };
    let on_base = |px: &Point2<f64>| px.x > 140.0;
    let percept = analyze(&painter, &image, filters);
    let dropped: Vec<_> = percept.dropped.iter().filter(|p| p.reason == DropReason::NotPostOrBar).collect();
    assert!(dropped.iter().filter(|p| on_base(&p.px)).count() >= 10);
    assert!(
        percept.pixels.iter().filter(|p| p.kind == FeatureKind::YellowGoal && on_base(&p.px)).count() <= 2
    );
    let post_sides =
        percept.pixels.iter().filter(|p| (p.px.x - 59.5).abs() < 1.0 || (p.px.x - 71.5).abs() < 1.0);
    assert!(post_sides.count() >= 20, "the post's sides stay");
}

#[test]
fn isolated_pixels() {
    let painter = Painter::new(20.0);
    let mut image = painter.paint(carpet_with_line);
    for x in (2..320).step_by(4) {
        image.set(x, 180, WHITE); // specks
    }
    let filters = FilterSwitches { isolated: true, ..NO_FILTERS };
    expect_drops(&painter, &image, filters, DropReason::Isolated, |px| (178.0..184.0).contains(&px.y));
}

#[test]
fn lines_beyond_the_horizon() {
    let painter = Painter::new(0.0);
    let far_line = |p: &Point2<f64>| if (p.x - 7.0).abs() < 0.4 { WHITE } else { GREEN };
    let image = painter.paint(far_line);
    let border = painter.pixel(6.0, 0.0, 0.0).y;
    let filters = FilterSwitches { horizon: true, ..NO_FILTERS };
    let percept = analyze(&painter, &image, filters);
    assert!(percept.num_dropped(DropReason::BeyondHorizon) > 20);
    assert!(percept.pixels.iter().all(|pixel| pixel.px.y > border - 1.0));
    let off = analyze(&painter, &image, NO_FILTERS);
    assert!(off.pixels.iter().any(|pixel| pixel.px.y < border), "switched off, far lines pass");
}

#[test]
fn the_robots_own_body() {
    // The lower camera looks at the feet.
    let mut painter = Painter::new(0.0);
    let head = visloc_core::geom::nao::HeadAngles { yaw_rad: 0.0, pitch_rad: 0.51 };
    let torso = visloc_core::geom::nao::Torso::upright();
    let camera = visloc_core::geom::nao::NaoCamera::BottomV3;
    painter.robot_from_camera = visloc_core::geom::nao::robot_from_camera(&torso, &head, camera);
    let image = painter.paint(|p| if p.x < 0.12 || (p.x - 0.4).abs() < 0.025 { WHITE } else { GREEN });
    let filters = FilterSwitches { own_body: true, ..NO_FILTERS };
    let is_near = |px: &Point2<f64>| painter.ground(px.x, px.y).unwrap().coords.norm() < 0.15;
    expect_drops(&painter, &image, filters, DropReason::OwnBody, is_near);
}

#[test]
fn white_beyond_the_end_of_the_field() {
    let painter = Painter::new(10.0);
    let mut image = painter.paint(carpet_with_line);
    // A green poster with a white stripe stands on the floor beyond the carpet.
    let end = painter.pixel(3.0, 0.0, 0.0).y as u32;
    let floor = end - 18;
    fill(&mut image, 100..180, 0..floor, GREEN);
    fill(&mut image, 100..180, floor - 10..floor - 6, WHITE);
    let filters = FilterSwitches { field_end: true, ..NO_FILTERS };
    let percept = analyze(&painter, &image, filters);
    let above = |px: &Point2<f64>| px.y < f64::from(floor);
    let lines_above = |p: &Percept| p.pixels.iter().filter(|pixel| above(&pixel.px)).count();
    assert!(
        percept.num_dropped(DropReason::BeyondFieldEnd) + percept.num_dropped(DropReason::BeyondHorizon) > 10
    );
    assert_eq!(lines_above(&percept), 0);
    assert!(percept.pixels.len() > 20, "the line on the carpet stays");
}

#[test]
fn goal_colors_outside_of_goal_blobs() {
    let painter = Painter::new(5.0);
    let mut image = painter.paint(carpet);
    let foot = painter.pixel(2.5, 0.0, 0.0).y as u32;
    fill(&mut image, 40..52, 10..foot, BLUE); // a post that stands on the carpet
    fill(&mut image, 150..260, 20..60, BLUE); // a board on the wall
    fill(&mut image, 280..283, 120..124, BLUE); // a small thing
    let filters = FilterSwitches { goal_blobs: true, ..NO_FILTERS };
    expect_drops(&painter, &image, filters, DropReason::NotInGoalBlob, |px| px.x > 140.0);
    let kept = analyze(&painter, &image, filters).pixels;
    assert!(kept.iter().filter(|pixel| pixel.kind == FeatureKind::BlueGoal).count() > 20);
}

#[test]
fn things_in_goal_colors_that_are_no_posts() {
    let painter = Painter::new(5.0);
    let foot_px = |x_m: f64| painter.pixel(x_m, 0.0, 0.0).y as u32;
    let mut image = painter.paint(carpet);
    fill(&mut image, 40..54, 0..foot_px(2.5), BLUE); // a post
    fill(&mut image, 100..160, 10..foot_px(2.5), BLUE); // a person, four times as wide
    fill(&mut image, 200..230, foot_px(1.3) - 27..foot_px(1.3), BLUE); // a piece of a waistband, as wide as a post
    fill(&mut image, 280..282, 20..foot_px(1.5), BLUE); // a stick
    let filters = FilterSwitches { goal_blobs: true, ..NO_FILTERS };
    expect_drops(&painter, &image, filters, DropReason::NotInGoalBlob, |px| px.x > 60.0);
    let kept = analyze(&painter, &image, filters).pixels;
    assert!(kept.iter().filter(|pixel| pixel.kind == FeatureKind::BlueGoal).count() > 20, "the post stays");
}

#[test]
fn the_field_ends_at_boards_in_another_green() {
    let painter = Painter::new(10.0);
    let mut image = painter.paint(carpet_with_line);
    let end = painter.pixel(3.0, 0.0, 0.0).y as u32;
    // A board stands right behind the carpet; its letters are bright.
    let board = [28, 128, 45];
    fill(&mut image, 0..320, 0..end, board);
    for column in (20..300).step_by(25) {
        fill(&mut image, column..column + 5, end - 25..end - 5, WHITE);
    }
    let filters = FilterSwitches { beside_carpet: true, field_end: true, ..NO_FILTERS };
    let percept = analyze(&painter, &image, filters);
    assert_eq!(percept.pixels.iter().filter(|pixel| pixel.px.y < f64::from(end) - 2.0).count(), 0);
    assert!(percept.pixels.len() > 20, "the line on the carpet stays");
    // What every green takes for carpet has letters for lines.
    let mut config = FieldAnalysisConfig { filters, ..FieldAnalysisConfig::default() };
    config.colors = ColorConfig { carpet_tolerance: 1.0, ..ColorConfig::table() };
    let mut analyzer = FieldAnalyzer::new(config).unwrap();
    let percept =
        analyzer.analyze(&painter.frame(image), &mut RngTree::new(1).stream("analysis", 0)).unwrap();
    assert!(percept.pixels.iter().filter(|pixel| pixel.px.y < f64::from(end) - 2.0).count() > 20);
}

#[test]
fn white_of_obstacles() {
    let painter = Painter::new(8.0);
    let mut image = painter.paint(carpet_with_line);
    let foot = painter.pixel(1.2, 0.0, 0.0).y as u32;
    fill(&mut image, 120..175, foot - 120..foot, WHITE); // a robot at 1.2 m, 18 cm wide
    let filters = FilterSwitches { obstacles: true, ..NO_FILTERS };
    let on_robot = |px: &Point2<f64>| (110.0..185.0).contains(&px.x) && px.y < f64::from(foot) + 3.0;
    expect_drops(&painter, &image, filters, DropReason::InObstacle, on_robot);
    let kept = analyze(&painter, &image, filters).pixels;
    assert!(kept.iter().filter(|pixel| !on_robot(&pixel.px)).count() > 20, "the line beside it stays");
}

#[test]
fn a_line_that_runs_away_is_no_obstacle() {
    let painter = Painter::new(15.0);
    for slope in [0.0, 0.3, 0.8] {
        let image =
            painter.paint(|p| if (p.y - slope * (p.x - 1.0)).abs() < 0.025 { WHITE } else { carpet(p) });
        let percept = analyze(&painter, &image, FilterSwitches { obstacles: true, ..NO_FILTERS });
        assert_eq!(percept.num_dropped(DropReason::InObstacle), 0, "slope {slope}");
    }
}

#[test]
fn random_discard_bounds_the_number() {
    let painter = Painter::new(8.0);
    let mut image = painter.paint(carpet_with_line);
    let foot = painter.pixel(2.5, 0.0, 0.0).y as u32;
    fill(&mut image, 40..52, 0..foot, YELLOW);
    fill(&mut image, 0..40, 0..5, GRAY);
    let all = analyze(&painter, &image, NO_FILTERS);
    let some = analyze(&painter, &image, FilterSwitches { random_discard: true, ..NO_FILTERS });
    let count =
        |p: &Percept, is_goal: bool| p.pixels.iter().filter(|pixel| pixel.kind.is_goal() == is_goal).count();
    assert!(count(&all, false) > 12 && count(&all, true) > 8);
    assert_eq!((count(&some, false), count(&some, true)), (12, 8));
    assert_eq!(some.num_dropped(DropReason::RandomDiscard), all.pixels.len() - 20);
    assert!(some.pixels.iter().all(|pixel| all.pixels.contains(pixel)), "a subset");
}
