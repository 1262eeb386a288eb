//! The borders of lines on the ground as the image analysis sees them.

use std::f64::consts::TAU;

use nalgebra::Point2;
use visloc_world::field::{Field, Segment};

/// A piece of an outline on the ground, in the world's (x, y), meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Outline {
    Segment {
        start: Point2<f64>,
        along: nalgebra::Vector2<f64>,
        inverse_length2: f64,
    },
    /// A circle around the origin.
    Circle {
        radius_m: f64,
    },
}

impl Outline {
    fn segment(segment: &Segment) -> Self {
        let along = segment.end - segment.start;
        Self::Segment { start: segment.start, along, inverse_length2: 1.0 / along.norm_squared() }
    }

    /// The nearest point of the outline.
    #[inline]
    pub fn nearest_point(&self, point: &Point2<f64>) -> Point2<f64> {
        match self {
            Self::Segment { start, along, inverse_length2 } => {
                let t = (point - start).dot(along) * inverse_length2;
                start + along * t.clamp(0.0, 1.0)
            }
            Self::Circle { radius_m } => {
                let distance = point.coords.norm();
                if distance < 1e-9 { Point2::new(*radius_m, 0.0) } else { point * (radius_m / distance) }
            }
        }
    }

    /// Points on the outline at most `step_m` apart.
    pub fn sample(&self, step_m: f64, mut visit: impl FnMut(Point2<f64>)) {
        let length_m = match self {
            Self::Segment { along, .. } => along.norm(),
            Self::Circle { radius_m } => TAU * radius_m,
        };
        let count = (length_m / step_m).ceil().max(1.0);
        let mut i = 0.0;
        while i <= count {
            let t = i / count;
            visit(match self {
                Self::Segment { start, along, .. } => start + along * t,
                Self::Circle { radius_m } => Point2::new((t * TAU).cos(), (t * TAU).sin()) * *radius_m,
            });
            i += 1.0;
        }
    }
}

/// Both borders of every line, circle and mark on the ground.
pub(super) fn ground_outlines(field: &Field) -> Vec<Outline> {
    let half = field.dimensions().line_width_m / 2.0;
    let mut outlines = Vec::new();
    for line in field.lines().iter().chain(field.marks()) {
        let along = (line.end - line.start).normalize();
        let across = nalgebra::Vector2::new(-along.y, along.x) * half;
        // Long lines end in the middle of the line that they meet, marks end where they end.
        let is_mark = field.marks().contains(line);
        let extend = if is_mark { 0.0 } else { half };
        let (start, end) = (line.start - along * extend, line.end + along * extend);
        for side in [across, -across] {
            outlines.push(Outline::segment(&Segment { start: start + side, end: end + side }));
        }
        if is_mark {
            for tip in [start, end] {
                outlines.push(Outline::segment(&Segment { start: tip + across, end: tip - across }));
            }
        }
    }
    for radius_m in [field.circle_radius_m() - half, field.circle_radius_m() + half] {
        outlines.push(Outline::Circle { radius_m });
    }
    outlines
}
