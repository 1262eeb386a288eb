//! Where the paint of a field lies.

use nalgebra::{Point2, Unit, Vector2};
use visloc_world::field::{Field, Segment};

/// A painted shape on the floor, meters.
#[derive(Debug, Clone, Copy)]
pub(crate) enum GroundMark {
    /// A rectangle around its middle, with its axis along the line.
    Bar { middle: Point2<f64>, axis: Unit<Vector2<f64>>, half_length_m: f64, half_width_m: f64 },
    /// A circle around the field's middle.
    Ring { radius_m: f64, half_width_m: f64 },
}

impl GroundMark {
    /// All paint of a field: lines, marks, circle.
    pub(crate) fn of_field(field: &Field) -> Vec<Self> {
        let half_width_m = field.dimensions().line_width_m / 2.0;
        let lines = field.lines().iter().map(|line| Self::bar(line, half_width_m, half_width_m));
        let marks = field.marks().iter().map(|mark| Self::bar(mark, half_width_m, 0.0));
        let ring = Self::Ring { radius_m: field.circle_radius_m(), half_width_m };
        lines.chain(marks).chain([ring]).collect()
    }

    fn bar(line: &Segment, half_width_m: f64, extend_m: f64) -> Self {
        let along = line.end - line.start;
        Self::Bar {
            middle: nalgebra::center(&line.start, &line.end),
            axis: Unit::new_normalize(along),
            half_length_m: along.norm() / 2.0 + extend_m,
            half_width_m,
        }
    }

    /// Signed distance from the edge of the paint, negative on it, meters.
    pub(crate) fn distance_m(&self, point: &Point2<f64>) -> f64 {
        match self {
            Self::Bar { middle, axis, half_length_m, half_width_m } => {
                let from_middle = point - middle;
                let lengthwise = from_middle.dot(axis).abs() - half_length_m;
                let sideways = (from_middle.x * axis.y - from_middle.y * axis.x).abs() - half_width_m;
                lengthwise.max(sideways)
            }
            Self::Ring { radius_m, half_width_m } => (point.coords.norm() - radius_m).abs() - half_width_m,
        }
    }

    /// Middle and half sizes of the rectangle around it, meters.
    pub(crate) fn bounds(&self) -> (Point2<f64>, (f64, f64)) {
        match self {
            Self::Bar { middle, axis, half_length_m, half_width_m } => {
                let half = (
                    half_length_m * axis.x.abs() + half_width_m * axis.y.abs(),
                    half_length_m * axis.y.abs() + half_width_m * axis.x.abs(),
                );
                (*middle, half)
            }
            Self::Ring { radius_m, half_width_m } => {
                let reach = radius_m + half_width_m;
                (Point2::origin(), (reach, reach))
            }
        }
    }
}
