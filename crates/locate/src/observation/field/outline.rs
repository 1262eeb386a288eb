//! The borders of lines on the ground as the image analysis sees them.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};
use visloc_world::field::{Field, Segment};

/// A piece of an outline on the ground, in the world's (x, y), meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Outline {
    Segment {
        start: Point2<f64>,
        along: Vector2<f64>,
        /// The direction of `along`.
        unit: Vector2<f64>,
        inverse_length2: f64,
        /// Unit vector towards the white.
        inward: Vector2<f64>,
    },
    /// A circle around the origin.
    Circle {
        radius_m: f64,
        /// Whether the white is towards the center.
        is_outer: bool,
    },
}

impl Outline {
    /// A segment with the white on the side that `inward` points to.
    fn segment(segment: &Segment, inward: Vector2<f64>) -> Self {
        let along = segment.end - segment.start;
        let inverse_length2 = 1.0 / along.norm_squared();
        Self::Segment {
            start: segment.start,
            along,
            unit: along.normalize(),
            inverse_length2,
            inward: inward.normalize(),
        }
    }

    /// Unit vector from the outline at a point on it towards the white.
    #[inline]
    pub fn inward(&self, point: &Point2<f64>) -> Vector2<f64> {
        match self {
            Self::Segment { inward, .. } => *inward,
            Self::Circle { radius_m, is_outer } => {
                point.coords / if *is_outer { -radius_m } else { *radius_m }
            }
        }
    }

    /// The nearest point of the outline, and the outline's direction there; zero at the end of a segment, beyond which
    /// there is nothing.
    #[inline]
    pub fn nearest_point(&self, point: &Point2<f64>) -> (Point2<f64>, Vector2<f64>) {
        match self {
            Self::Segment { start, along, inverse_length2, .. } => {
                let t = (point - start).dot(along) * inverse_length2;
                let clamped = t.clamp(0.0, 1.0);
                let is_inside = f64::from(u8::from(t == clamped));
                (start + along * clamped, along * is_inside)
            }
            Self::Circle { radius_m, .. } => {
                let distance = point.coords.norm().max(1e-9);
                let nearest = point * (radius_m / distance);
                (nearest, Vector2::new(-nearest.y, nearest.x))
            }
        }
    }

    /// Points on the outline at most `step_m` apart.
    pub fn sample(&self, step_m: f64, mut visit: impl FnMut(Point2<f64>)) {
        let length_m = match self {
            Self::Segment { along, .. } => along.norm(),
            Self::Circle { radius_m, .. } => TAU * radius_m,
        };
        let count = (length_m / step_m).ceil().max(1.0);
        let mut i = 0.0;
        while i <= count {
            let t = i / count;
            visit(match self {
                Self::Segment { start, along, .. } => start + along * t,
                Self::Circle { radius_m, .. } => Point2::new((t * TAU).cos(), (t * TAU).sin()) * *radius_m,
            });
            i += 1.0;
        }
    }
}

/// Both borders of every line, circle and mark on the ground, one group for each. Opposite borders come in pairs.
pub(super) fn ground_outlines(field: &Field) -> Vec<Vec<Outline>> {
    let half = field.dimensions().line_width_m / 2.0;
    // Long lines go on to the outer border of the line that they meet; marks end where they end.
    let lines = field.lines().iter().map(|line| strip(line, half, half));
    let marks = field.marks().iter().map(|mark| {
        let mut outlines = strip(mark, half, 0.0);
        let across = across(mark) * half;
        for (tip, other) in [(mark.start, mark.end), (mark.end, mark.start)] {
            outlines.push(Outline::segment(&Segment { start: tip + across, end: tip - across }, other - tip));
        }
        outlines
    });
    let radius_m = field.circle_radius_m();
    let circle = [(radius_m - half, false), (radius_m + half, true)]
        .map(|(radius_m, is_outer)| Outline::Circle { radius_m, is_outer })
        .to_vec();
    lines.chain(marks).chain([circle]).collect()
}

/// Both long borders of a strip around a segment that is lengthened at both ends.
fn strip(segment: &Segment, half_width: f64, lengthened: f64) -> Vec<Outline> {
    let longer = (segment.end - segment.start).normalize() * lengthened;
    let across = across(segment) * half_width;
    [across, -across]
        .map(|side| {
            let start = segment.start - longer + side;
            Outline::segment(&Segment { start, end: segment.end + longer + side }, -side)
        })
        .to_vec()
}

/// Unit vector across a segment.
fn across(segment: &Segment) -> Vector2<f64> {
    let along = (segment.end - segment.start).normalize();
    Vector2::new(-along.y, along.x)
}
