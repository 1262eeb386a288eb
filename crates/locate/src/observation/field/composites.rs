//! Poses that composite features suggest.
//!
//! A junction laid on one of its kind leaves one pose; so do the circle with its halfway line (and the mirrored one), two
//! posts of a goal, and a post, a mark or the circle together with the direction of any line, since all lines run along
//! the field or across it. A wrong detection or a wrong counterpart costs one suggestion: whoever asked for it compares
//! the pose with all that is seen.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Point2, Rotation2, Vector2};
use rand::RngExt;
use visloc_core::{Rng, geom::PlanarPose};
use visloc_world::field::{Field, GoalColor};

use crate::vision::{CenterCircle, FieldFeatures, GoalPost, Junction, JunctionKind, PostSide};

/// How often the seen side of a post is believed.
const SIDE_IS_RIGHT: f64 = 0.9;
/// Two posts of one goal are seen this much nearer or farther apart than they are, as a share.
const POST_GAP_TOLERANCE: f64 = 0.35;

/// A post of the map.
#[derive(Debug, Clone, Copy)]
struct MapPost {
    color: GoalColor,
    at: Point2<f64>,
    /// Seen from the field.
    side: PostSide,
}

/// What of the map composite features are compared with.
#[derive(Debug, Clone)]
pub(super) struct CompositePlaces {
    /// Place and heading of each junction, by the number of its arms.
    junctions: Vec<(usize, Point2<f64>, f64)>,
    marks: [Point2<f64>; 2],
    posts: Vec<MapPost>,
}

impl CompositePlaces {
    pub fn new(field: &Field) -> Self {
        let d = field.dimensions();
        let mark_x = d.length_m / 2.0 - d.penalty_mark_from_goal_line_m;
        let junctions = field.junctions();
        let posts = field.goals().iter().flat_map(|goal| {
            // Who looks from the field towards +x has +y on the left.
            let left_y = goal.post_y_m.copysign(goal.x_m);
            [(left_y, PostSide::Left), (-left_y, PostSide::Right)].map(|(y, side)| MapPost {
                color: goal.color,
                at: Point2::new(goal.x_m, y),
                side,
            })
        });
        Self {
            junctions: junctions.iter().map(|j| (j.arms.len(), j.at, heading(&j.direction()))).collect(),
            marks: [Point2::new(mark_x, 0.0), Point2::new(-mark_x, 0.0)],
            posts: posts.collect(),
        }
    }

    /// A pose at which one of the features, taken at random, lies on a counterpart; `None` if there are no features, or the
    /// one taken has no counterpart.
    pub fn suggest(&self, features: &FieldFeatures, rng: &mut Rng) -> Option<PlanarPose> {
        let num_circles = usize::from(features.circle.is_some());
        let total = features.junctions.len() + num_circles + features.marks.len() + features.posts.len();
        if total == 0 {
            return None;
        }
        let mut index = rng.random_range(0..total);
        if let Some(junction) = features.junctions.get(index) {
            return self.lay_junction(junction, rng);
        }
        index -= features.junctions.len();
        if let Some(mark) = features.marks.get(index) {
            let yaw_rad = yaw_from_lines(features, rng);
            return Some(align(&mark.at_in_robot, &self.marks[rng.random_range(0..2)], yaw_rad));
        }
        index -= features.marks.len();
        match (features.posts.get(index), &features.circle) {
            (Some(post), _) => self.lay_post(post, features, rng),
            (None, Some(circle)) => Some(lay_circle(circle, features, rng)),
            (None, None) => None,
        }
    }

    fn lay_junction(&self, seen: &Junction, rng: &mut Rng) -> Option<PlanarPose> {
        let same = |(num_arms, ..): &&(usize, Point2<f64>, f64)| *num_arms == seen.kind.num_arms();
        let count = self.junctions.iter().filter(same).count();
        if count == 0 {
            return None;
        }
        let (_, at, heading_rad) = self.junctions.iter().filter(same).nth(rng.random_range(0..count))?;
        let turn = if seen.kind == JunctionKind::X { quarter_turns(rng) } else { 0.0 };
        Some(align(&seen.at_in_robot, at, heading_rad + turn - seen.direction_rad))
    }

    fn lay_post(&self, seen: &GoalPost, features: &FieldFeatures, rng: &mut Rng) -> Option<PlanarPose> {
        // A foot that is out of the image is near, about a meter away.
        let base = seen.base_in_robot.unwrap_or_else(|| {
            let range_m = -rng.random_range(f64::EPSILON..1.0).ln();
            Rotation2::new(seen.bearing_rad) * Point2::new(range_m, 0.0)
        });
        let trusts_side = rng.random_bool(SIDE_IS_RIGHT);
        let can_be = |post: &&MapPost| {
            post.color == seen.color && (!trusts_side || seen.side.is_none_or(|side| side == post.side))
        };
        let count = self.posts.iter().filter(can_be).count();
        if count == 0 {
            return None;
        }
        let post = self.posts.iter().filter(can_be).nth(rng.random_range(0..count))?;
        let yaw_rad = self.yaw_from_other_post(seen, &base, post, features);
        let yaw_rad = yaw_rad.unwrap_or_else(|| yaw_from_lines(features, rng));
        Some(align(&base, &post.at, yaw_rad))
    }

    /// The heading at which another post that is seen is the other one of the goal.
    fn yaw_from_other_post(
        &self,
        seen: &GoalPost,
        base: &Point2<f64>,
        post: &MapPost,
        features: &FieldFeatures,
    ) -> Option<f64> {
        let other = self.posts.iter().find(|p| p.at.x == post.at.x && p.at.y != post.at.y)?;
        let gap = other.at - post.at;
        let seen_gap = features.posts.iter().filter(|p| p.color == seen.color).find_map(|p| {
            let seen_gap = p.base_in_robot? - base;
            let ratio = seen_gap.norm() / gap.norm();
            ((ratio - 1.0).abs() < POST_GAP_TOLERANCE).then_some(seen_gap)
        })?;
        Some(heading(&gap) - heading(&seen_gap))
    }
}

fn lay_circle(circle: &CenterCircle, features: &FieldFeatures, rng: &mut Rng) -> PlanarPose {
    let yaw_rad = match circle.halfway_rad {
        Some(halfway_rad) => FRAC_PI_2 - halfway_rad + if rng.random_bool(0.5) { PI } else { 0.0 },
        None => yaw_from_lines(features, rng),
    };
    align(&circle.center_in_robot, &Point2::origin(), yaw_rad)
}

/// The pose with this heading that takes a place seen from the robot to a place of the world.
pub(super) fn align(in_robot: &Point2<f64>, in_world: &Point2<f64>, yaw_rad: f64) -> PlanarPose {
    let offset = Rotation2::new(yaw_rad) * in_robot.coords;
    PlanarPose::new(in_world.x - offset.x, in_world.y - offset.y, yaw_rad)
}

/// A heading at which the longest line runs along the field or across it; any heading without lines.
fn yaw_from_lines(features: &FieldFeatures, rng: &mut Rng) -> f64 {
    let longest = features.lines.iter().max_by(|a, b| a.length_m().total_cmp(&b.length_m()));
    match longest {
        Some(line) => quarter_turns(rng) - line.direction_rad(),
        None => rng.random_range(-PI..PI),
    }
}

pub(super) fn quarter_turns(rng: &mut Rng) -> f64 {
    f64::from(rng.random_range(0..4_u8)) * FRAC_PI_2
}

pub(super) fn heading(direction: &Vector2<f64>) -> f64 {
    direction.y.atan2(direction.x)
}

#[cfg(test)]
mod tests {
    use visloc_core::RngTree;
    use visloc_world::Map;

    use super::*;
    use crate::vision::{LineSegment, PenaltyMark};

    fn field() -> Field {
        let Ok(Map::Field(field)) = Map::load("robocup-spl-2010") else { panic!("built-in map") };
        field
    }

    /// The best of 400 suggestions is near the truth, and none is lost.
    fn expect_found(features: &FieldFeatures, truth: &PlanarPose) {
        let (places, mut rng) = (CompositePlaces::new(&field()), RngTree::new(1).stream("suggest", 0));
        let is_found = (0..400).any(|_| {
            let pose = places.suggest(features, &mut rng);
            pose.is_some_and(|pose| {
                pose.distance_m(truth) < 1e-6 && pose.heading_difference_rad(truth) < 1e-6
            })
        });
        assert!(is_found, "{features:?}");
    }

    fn line(truth: &PlanarPose) -> LineSegment {
        let ends_in_robot =
            [Point2::new(0.0, -1.0), Point2::new(0.0, 1.0)].map(|p| truth.inverse().transform(&p));
        LineSegment { ends_in_robot, ends_px: [Point2::origin(); 2], num_crossings: 9 }
    }

    #[test]
    fn every_feature_leads_to_the_true_pose() {
        let field = field();
        let truth = PlanarPose::new(0.7, -0.4, 2.1);
        let seen = |at: &Point2<f64>| truth.inverse().transform(at);
        for junction in field.junctions() {
            let kind =
                JunctionKind::ALL.into_iter().find(|kind| kind.num_arms() == junction.arms.len()).unwrap();
            let direction_rad = heading(&junction.direction()) - truth.yaw_rad;
            let at_px = Point2::origin();
            let junction = Junction { kind, at_in_robot: seen(&junction.at), at_px, direction_rad };
            expect_found(&FieldFeatures { junctions: vec![junction], ..FieldFeatures::default() }, &truth);
        }
        let (center_in_robot, halfway_rad) = (seen(&Point2::origin()), Some(FRAC_PI_2 - truth.yaw_rad));
        let circle = Some(CenterCircle { center_in_robot, visible_share: 1.0, halfway_rad });
        expect_found(&FieldFeatures { circle, ..FieldFeatures::default() }, &truth);
        let mark = PenaltyMark { at_in_robot: seen(&Point2::new(-1.2, 0.0)), at_px: Point2::origin() };
        let (marks, lines) = (vec![mark], vec![line(&truth)]);
        expect_found(&FieldFeatures { marks, lines, ..FieldFeatures::default() }, &truth);
        let base = |y: f64| GoalPost {
            color: GoalColor::Blue,
            bearing_rad: 0.0,
            base_in_robot: Some(seen(&Point2::new(-3.0, y))),
            foot_px: Point2::origin(),
            side: None,
        };
        let (posts, lines) = (vec![base(0.75)], vec![line(&truth)]);
        expect_found(&FieldFeatures { posts, lines, ..FieldFeatures::default() }, &truth);
        let posts = vec![base(0.75), base(-0.75)];
        expect_found(&FieldFeatures { posts, ..FieldFeatures::default() }, &truth);
    }

    /// Before a goal, its near post in the image but for the foot.
    #[test]
    fn a_post_without_its_foot_and_a_line_lead_near_the_true_pose() {
        let truth = PlanarPose::new(-2.1, -1.0, 3.4);
        let post = truth.inverse().transform(&Point2::new(-3.0, -0.75));
        let posts = vec![GoalPost {
            color: GoalColor::Blue,
            bearing_rad: post.y.atan2(post.x),
            base_in_robot: None,
            foot_px: Point2::origin(),
            side: None,
        }];
        let features = FieldFeatures { posts, lines: vec![line(&truth)], ..FieldFeatures::default() };
        let (places, mut rng) = (CompositePlaces::new(&field()), RngTree::new(3).stream("suggest", 0));
        let is_near =
            |pose: &PlanarPose| pose.distance_m(&truth) < 0.2 && pose.heading_difference_rad(&truth) < 1e-6;
        let hits = (0..1000).filter_map(|_| places.suggest(&features, &mut rng)).filter(is_near).count();
        assert!(hits >= 5, "{hits}");
    }

    #[test]
    fn features_that_the_map_does_not_have_suggest_nothing() {
        let (places, mut rng) = (CompositePlaces::new(&field()), RngTree::new(2).stream("suggest", 0));
        assert_eq!(places.suggest(&FieldFeatures::default(), &mut rng), None);
        let post = GoalPost {
            color: GoalColor::White,
            bearing_rad: 0.0,
            base_in_robot: Some(Point2::new(1.0, 0.0)),
            foot_px: Point2::origin(),
            side: Some(PostSide::Left),
        };
        let features = FieldFeatures { posts: vec![post], ..FieldFeatures::default() };
        assert_eq!(places.suggest(&features, &mut rng), None);
    }
}
