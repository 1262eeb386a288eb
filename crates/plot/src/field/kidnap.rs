//! Dashed arcs from where a robot was picked up to where it was put down.

use super::{GroundView, Kidnap};
use crate::{
    Color,
    svg::{Anchor, Canvas, Paint, Point, TextStyle, pair},
};

pub(super) const COLOR: Color = Color::rgb(0x6a, 0x1b, 0x7a);

const BADGE_PX: f64 = 9.0;
const BEND: f64 = 0.22;

/// Places on the arc where its number may stand, best first.
const BADGE_PLACES: [f64; 5] = [0.5, 0.38, 0.62, 0.26, 0.74];

pub(super) fn draw_kidnaps(canvas: &mut Canvas, view: &GroundView, kidnaps: &[Kidnap]) {
    // numbers hide neither each other nor the ends of the arcs
    let mut taken: Vec<Point> = Vec::new();
    for kidnap in kidnaps {
        taken.extend([kidnap.from, kidnap.to].map(|pose| view.px(pose.x_m, pose.y_m)));
    }
    for (i, kidnap) in kidnaps.iter().enumerate() {
        if !(kidnap.from.is_finite() && kidnap.to.is_finite()) {
            continue;
        }
        let arc = Arc::between(
            view.px(kidnap.from.x_m, kidnap.from.y_m),
            view.px(kidnap.to.x_m, kidnap.to.y_m),
            view,
        );
        arc.draw(canvas);
        let is_free =
            |at: &Point| taken.iter().all(|other| (other.0 - at.0).hypot(other.1 - at.1) > 2.5 * BADGE_PX);
        let places = BADGE_PLACES.map(|t| arc.at(t));
        let badge = places.into_iter().find(is_free).unwrap_or(places[0]);
        taken.push(badge);
        canvas.circle(badge, BADGE_PX, &Paint::fill(COLOR).outlined(Color::WHITE, 1.5));
        let style = TextStyle::new(12.0, Color::WHITE).bold().anchor(Anchor::Middle);
        canvas.text((badge.0, badge.1 + 4.3), &(i + 1).to_string(), &style);
    }
}

/// A parabola.
#[derive(Debug)]
struct Arc {
    start: Point,
    control: Point,
    end: Point,
}

impl Arc {
    /// Bends to the side on which it stays nearer to the middle of the ground, so that it remains visible.
    fn between(start: Point, end: Point, view: &GroundView) -> Self {
        let rect = view.rect();
        let center = (f64::midpoint(rect.left, rect.right), f64::midpoint(rect.top, rect.bottom));
        let middle = (f64::midpoint(start.0, end.0), f64::midpoint(start.1, end.1));
        let side = |sign: f64| {
            let bend = 2.0 * BEND * sign;
            (middle.0 - bend * (end.1 - start.1), middle.1 + bend * (end.0 - start.0))
        };
        let to_center = |point: Point| (point.0 - center.0).hypot(point.1 - center.1);
        let (one, other) = (side(1.0), side(-1.0));
        let control = if to_center(one) <= to_center(other) { one } else { other };
        Self { start, control, end }
    }

    fn at(&self, t: f64) -> Point {
        let mix = |a: f64, b: f64, c: f64| (1.0 - t).powi(2) * a + 2.0 * t * (1.0 - t) * b + t * t * c;
        (mix(self.start.0, self.control.0, self.end.0), mix(self.start.1, self.control.1, self.end.1))
    }

    fn draw(&self, canvas: &mut Canvas) {
        let (dx, dy) = (self.end.0 - self.control.0, self.end.1 - self.control.1);
        let length = dx.hypot(dy).max(1e-9);
        let (ux, uy) = (dx / length, dy / length);
        let neck = (self.end.0 - 10.0 * ux, self.end.1 - 10.0 * uy);
        let data = format!("M{}Q{} {}", pair(self.start), pair(self.control), pair(neck));
        canvas.path(&data, &Paint::stroke(Color::WHITE, 4.0).opacity(0.6));
        canvas.path(&data, &Paint::stroke(COLOR, 1.8).dashed());
        let base = (self.end.0 - 13.0 * ux, self.end.1 - 13.0 * uy);
        let corner = |side: f64| (base.0 - side * 6.0 * uy, base.1 + side * 6.0 * ux);
        let head = [self.end, corner(1.0), corner(-1.0)];
        canvas.polygon(&head, &Paint::fill(COLOR).outlined(Color::WHITE, 1.0));
        canvas.circle(self.start, 4.5, &Paint::fill(Color::WHITE).outlined(COLOR, 2.0));
    }
}
