//! Likelihood maps of simulated views.

// Clippy knows test functions, but not their helpers.
#![allow(clippy::unwrap_used)]

use visloc_core::{RngTree, geom::PlanarPose};
use visloc_experiments::likelihood::{
    Eye, HeadingChoice, LikelihoodMap, SimulatedView, View, climb, heading_profile, map_csv,
};
use visloc_locate::PipelineConfig;
use visloc_sim::Label;

fn look(view: &View) -> (SimulatedView, Eye) {
    let image = SimulatedView::take(view, 1).unwrap();
    let mut eye = Eye::new(&image.map, &PipelineConfig::with_color_table(), RngTree::new(1)).unwrap();
    eye.look(&image.source.frame).unwrap();
    (image, eye)
}

fn view() -> View {
    View::new("robocup-spl-2010", PlanarPose::new(0.6, 1.3, -0.5))
}

#[test]
fn the_maximum_is_near_the_true_pose() {
    let (image, eye) = look(&view());
    let truth = image.source.truth.unwrap().world_from_robot;
    assert!(truth.distance_m(&view().world_from_robot) < 1e-9);
    for heading in [HeadingChoice::Best, HeadingChoice::Fixed(truth.yaw_rad)] {
        let map = LikelihoodMap::new(eye.model(), heading, 0.2);
        let (maximum, likelihood) = map.maximum();
        assert!(maximum.distance_m(&truth) < 0.35 && likelihood > 0.8, "{maximum:?} {likelihood}");
        assert_eq!(map_csv(&map).lines().count(), 1 + map.values.len());
        assert!(map.mean_around(&truth, 0.0, 0.5) > map.mean_around(&truth, 1.0, 2.0));
    }
    let profile = heading_profile(eye.model(), truth.x_m, truth.y_m);
    let best = profile.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a }).unwrap();
    assert!((best.0 - truth.yaw_rad).abs() < 0.06);
    let peak = climb(eye.model(), &truth);
    assert!(peak.likelihood >= eye.model().likelihood(&truth) && peak.pose.distance_m(&truth) < 0.3);
}

#[test]
fn what_stands_in_the_way_is_seen() {
    let free = SimulatedView::take(&view(), 1).unwrap();
    let robots = vec![PlanarPose::new(1.5, 0.8, 2.5)];
    let hidden = SimulatedView::take(&View { robots, ..view() }, 1).unwrap();
    assert_eq!(free.count(Label::Robot), 0);
    assert!(hidden.count(Label::Robot) > 1000);
    let aside = SimulatedView::take(&View { pan_deg: 90.0, ..view() }, 1).unwrap();
    assert!(free.count(Label::YellowGoal) > 1000 && aside.count(Label::YellowGoal) == 0);
}

#[test]
fn most_kept_pixels_are_right_by_the_labels() {
    let (image, eye) = look(&view());
    let is_near = |x: f64, y: f64, wanted: Label| {
        let (x, y) = (x.round() as i64, y.round() as i64);
        (-2..=2).any(|dy| (-2..=2).any(|dx| image.labels.get(x + dx, y + dy) == Some(wanted)))
    };
    let right = eye.percept().pixels.iter().filter(|pixel| {
        let label = if pixel.kind.is_goal() { Label::YellowGoal } else { Label::Line };
        is_near(pixel.px.x, pixel.px.y, label)
    });
    assert!(right.count() >= 17, "of {}", eye.percept().pixels.len());
}
