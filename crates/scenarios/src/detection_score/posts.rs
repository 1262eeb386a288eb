//! Scores of goal posts.

use nalgebra::Point2;
use visloc_core::geom::angle;
use visloc_locate::vision::{GoalPost, PostSide};
use visloc_world::field::Goal;

use super::{TOLERANCE_PX, counts::DetectionScore, scene::Scene};

/// Largest error of a right post's bearing, radians.
const TOLERANCE_RAD: f64 = 0.05;

impl Scene<'_> {
    fn posts(&self) -> impl Iterator<Item = (Goal, Point2<f64>)> + '_ {
        let goals = self.field.goals().iter().copied();
        goals.flat_map(|goal| [1.0, -1.0].map(|side| (goal, Point2::new(goal.x_m, side * goal.post_y_m))))
    }

    fn is_post(&self, post: &GoalPost, goal: &Goal, at: &Point2<f64>) -> bool {
        let in_robot = self.truth.inverse().transform(at);
        let bearing_rad = in_robot.y.atan2(in_robot.x);
        let is_near = |base: &Point2<f64>| {
            let px = self.reported_px(base);
            px.is_some_and(|px| self.off_px(&px, at) < TOLERANCE_PX)
        };
        goal.color == post.color
            && angle::difference(post.bearing_rad, bearing_rad).abs() < TOLERANCE_RAD
            && post.base_in_robot.as_ref().is_none_or(is_near)
    }

    pub fn score_posts(&self, score: &mut DetectionScore) {
        for post in &self.percept.features.posts {
            score.num_found += 1;
            if let Some((_, at)) = self.posts().find(|(goal, at)| self.is_post(post, goal, at)) {
                score.num_right += 1;
                let px = post.base_in_robot.and_then(|base| self.reported_px(&base));
                score.errors_m.extend(px.and_then(|px| self.error_m(&px, &at)));
            }
        }
        for (goal, at) in self.posts() {
            if self.is_visible(&at) {
                score.num_visible += 1;
                let found = self.percept.features.posts.iter().any(|post| self.is_post(post, &goal, &at));
                score.num_recalled += usize::from(found);
            }
        }
    }

    /// Of the right posts with a side.
    pub fn score_sides(&self, score: &mut DetectionScore) {
        for post in &self.percept.features.posts {
            let Some((goal, at)) = self.posts().find(|(goal, at)| self.is_post(post, goal, at)) else {
                continue;
            };
            let Some(side) = post.side else { continue };
            // From the field the left post of the goal at +x is the one at +y.
            let is_left = (at.y * goal.x_m > 0.0) == (goal.x_m.abs() > (self.truth.x_m * goal.x_m.signum()));
            score.num_found += 1;
            score.num_right += usize::from(is_left == (side == PostSide::Left));
        }
    }
}
