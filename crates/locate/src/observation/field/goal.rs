//! The silhouette of a goal: the borders of its posts and of its crossbar as they are seen from one point.
//!
//! The documents take a goal for a drawing on the vertical plane of its goal line and look up the nearest point in a
//! table. From a place near that plane the posts' thickness then leads far astray, so here each post is an upright
//! cylinder: a ray that grazes it passes its axis at exactly its radius. A goal has three parts, so an exact search is
//! as fast as a table.

use nalgebra::{Point2, Point3, Vector2, Vector3};
use visloc_world::field::{Goal, GoalColor};

use crate::{observation::Landmark, vision::FeatureKind};

/// A goal as an observation model needs it.
#[derive(Debug, Clone, Copy)]
pub(super) struct GoalSilhouette {
    color: GoalColor,
    x_m: f64,
    post_y_m: f64,
    radius_m: f64,
    under_m: f64,
    over_m: f64,
}

impl GoalSilhouette {
    pub fn new(goal: &Goal) -> Self {
        Self {
            color: goal.color,
            x_m: goal.x_m,
            post_y_m: goal.post_y_m,
            radius_m: goal.post_radius_m,
            under_m: goal.crossbar_z_m - goal.post_radius_m,
            over_m: goal.crossbar_z_m + goal.post_radius_m,
        }
    }

    /// Whether a pixel of this kind can be part of the goal.
    #[inline]
    pub fn matches(&self, kind: FeatureKind) -> bool {
        matches!(
            (kind, self.color),
            (FeatureKind::YellowGoal, GoalColor::Yellow)
                | (FeatureKind::BlueGoal, GoalColor::Blue)
                | (FeatureKind::WhiteGoal, GoalColor::White)
        )
    }

    /// The goal as a landmark, if its color tells it from the rest.
    pub fn landmark(&self) -> Option<Landmark> {
        let kind = match self.color {
            GoalColor::Yellow => FeatureKind::YellowGoal,
            GoalColor::Blue => FeatureKind::BlueGoal,
            GoalColor::White => return None,
        };
        let height_m = f64::midpoint(self.under_m, self.over_m);
        Some(Landmark { kind, ends: self.posts(), height_m, radius_m: self.radius_m })
    }

    /// Axes of the two posts, (x, y) of the world, meters.
    pub fn posts(&self) -> [Point2<f64>; 2] {
        [Point2::new(self.x_m, self.post_y_m), Point2::new(self.x_m, -self.post_y_m)]
    }

    /// For each part of the goal that lies ahead, the point of its silhouette that is nearest to the ray. The ray goes
    /// from the eye along the ground direction `ahead`, a unit vector, and rises by `rise` meters per meter.
    #[inline]
    pub fn nearest_points(
        &self,
        eye: &Point3<f64>,
        ahead: &Vector2<f64>,
        rise: f64,
        mut visit: impl FnMut(Point3<f64>),
    ) {
        for post in self.posts() {
            let to_post = post - Point2::new(eye.x, eye.y);
            let distance = to_post.dot(ahead);
            if distance > self.radius_m {
                // How far to the left of the axis the ray passes, and how high.
                let offset = ahead.x * -to_post.y + ahead.y * to_post.x;
                let (offset, z) = self.nearest_on_post(offset, eye.z + rise * distance);
                visit(Point3::new(post.x - ahead.y * offset, post.y + ahead.x * offset, z));
            }
        }
        let s = (self.x_m - eye.x) / ahead.x;
        if s > 0.0 && s.is_finite() {
            let z = eye.z + rise * s;
            let half = self.post_y_m + self.radius_m;
            let y = (eye.y + ahead.y * s).clamp(-half, half);
            let is_lower = (z - self.under_m).abs() < (z - self.over_m).abs();
            visit(Point3::new(self.x_m, y, if is_lower { self.under_m } else { self.over_m }));
        }
    }

    /// The edges of the goal that a border pixel can show: the sides of the posts for a border that is crossed sideways,
    /// the crossbar for one that is crossed up- or downwards. The ray goes from the eye through the pixel, `inward` points
    /// from the pixel to the goal's color. Each edge is given by a point near the ray and its direction.
    pub fn visit_edges(
        &self,
        eye: &Point3<f64>,
        ray: &Vector3<f64>,
        inward: &Vector2<f64>,
        tolerance_m: f64,
        mut visit: impl FnMut(Point3<f64>, Vector3<f64>),
    ) {
        if inward.y != 0.0 {
            let z = if inward.y > 0.0 { self.over_m } else { self.under_m };
            let s = (self.x_m - eye.x) / ray.x;
            let y = eye.y + ray.y * s;
            if s > 0.0 && s.is_finite() && y.abs() < self.post_y_m + self.radius_m + tolerance_m {
                visit(Point3::new(self.x_m, y, z), Vector3::y());
            }
            return;
        }
        let length = ray.xy().norm();
        let (ahead, rise) = (ray.xy() / length, ray.z / length);
        // The left border of a post has its color to the right.
        let side = self.radius_m.copysign(inward.x);
        for post in self.posts() {
            let to_post = post - eye.xy();
            let distance = to_post.dot(&ahead);
            let z = eye.z + rise * distance;
            if distance > self.radius_m && (-tolerance_m..self.over_m + tolerance_m).contains(&z) {
                visit(Point3::new(post.x - ahead.y * side, post.y + ahead.x * side, z), Vector3::z());
            }
        }
    }

    /// The nearest point on the outline of a post, as (offset from the axis, height): one of its sides or its foot.
    #[inline]
    fn nearest_on_post(&self, offset: f64, z: f64) -> (f64, f64) {
        let side = (self.radius_m.copysign(offset), z.clamp(0.0, self.over_m));
        let foot = (offset.clamp(-self.radius_m, self.radius_m), 0.0);
        let distance2 = |p: (f64, f64)| (p.0 - offset).powi(2) + (p.1 - z).powi(2);
        if distance2(foot) < distance2(side) { foot } else { side }
    }

    /// Points of the silhouette seen from an eye, at most `step_m` apart.
    pub fn sample(&self, eye: &Point3<f64>, step_m: f64, mut visit: impl FnMut(Point3<f64>)) {
        for post in self.posts() {
            let to_post = post - Point2::new(eye.x, eye.y);
            let distance = to_post.norm();
            if distance <= self.radius_m {
                continue;
            }
            // The tangent touches the cylinder a little on the near side of the axis.
            let sine = self.radius_m / distance;
            let cosine = (1.0 - sine * sine).sqrt();
            let ahead = to_post / distance;
            let across = Vector2::new(-ahead.y, ahead.x);
            let touch =
                |side: f64| post - ahead * (self.radius_m * sine) + across * (side * self.radius_m * cosine);
            for side in [1.0, -1.0] {
                let p = touch(side);
                steps(0.0, self.over_m, step_m, |z| visit(Point3::new(p.x, p.y, z)));
            }
            let (from, to) = (touch(1.0), touch(-1.0));
            steps(0.0, 1.0, step_m / (2.0 * self.radius_m), |t| {
                let p = from + (to - from) * t;
                visit(Point3::new(p.x, p.y, 0.0));
            });
        }
        let half = self.post_y_m + self.radius_m;
        for z in [self.under_m, self.over_m] {
            steps(-half, half, step_m, |y| visit(Point3::new(self.x_m, y, z)));
        }
    }
}

fn steps(from: f64, to: f64, step: f64, mut visit: impl FnMut(f64)) {
    let count = ((to - from) / step).ceil().max(1.0);
    let mut i = 0.0;
    while i <= count {
        visit(from + (to - from) * i / count);
        i += 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn goal() -> GoalSilhouette {
        GoalSilhouette::new(&Goal {
            color: GoalColor::Yellow,
            x_m: 3.0,
            post_y_m: 0.75,
            post_radius_m: 0.05,
            crossbar_z_m: 0.85,
        })
    }

    /// Smallest angle between a ray and the nearest points, radians.
    fn miss(eye: Point3<f64>, direction: Vector3<f64>) -> f64 {
        let mut smallest = f64::INFINITY;
        let ground = Vector2::new(direction.x, direction.y);
        let rise = direction.z / ground.norm();
        goal().nearest_points(&eye, &ground.normalize(), rise, |p| {
            smallest = smallest.min((p - eye).angle(&direction));
        });
        smallest
    }

    #[test]
    fn every_drawn_point_is_on_the_silhouette() {
        for eye in [Point3::new(0.0, 0.0, 0.5), Point3::new(2.5, -1.0, 0.45), Point3::new(2.95, 1.4, 0.5)] {
            goal().sample(&eye, 0.01, |p| {
                // The foot is drawn as a chord, which is off by a few milliradians close to the post.
                assert!(miss(eye, p - eye) < 5e-3, "{eye} {p}: {}", miss(eye, p - eye));
            });
        }
    }

    #[test]
    fn a_ray_beside_a_post_is_off_by_its_distance() {
        let eye = Point3::new(0.0, 0.75, 0.4);
        // aimed 0.15 m beside the axis at 3 m: 0.10 m beside the side
        let off = miss(eye, Vector3::new(3.0, 0.15, 0.0));
        assert!((off - 0.1 / 3.0).abs() < 1e-3, "{off}");
    }

    #[test]
    fn nothing_behind_the_eye() {
        assert!(miss(Point3::new(0.0, 0.0, 0.5), Vector3::new(-1.0, 0.0, 0.0)).is_infinite());
    }
}
