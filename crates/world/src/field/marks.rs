//! The field as geometry: line segments, circle, marks and goals in the world frame.

use nalgebra::Point2;

use super::{FieldDimensions, FieldJunction, GoalColor, dimensions::lacking, junctions};
use crate::{MapError, error::syntax_error};

/// A straight line on the ground between two points of the world frame, meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// One end.
    pub start: Point2<f64>,
    /// The other end.
    pub end: Point2<f64>,
}

impl Segment {
    /// From coordinates (x, y) of both ends, meters.
    pub fn new(start: (f64, f64), end: (f64, f64)) -> Self {
        Self { start: Point2::new(start.0, start.1), end: Point2::new(end.0, end.1) }
    }

    /// The point of the segment that is nearest to `point`.
    #[inline]
    pub fn nearest_point(&self, point: &Point2<f64>) -> Point2<f64> {
        let along = self.end - self.start;
        let t = (point - self.start).dot(&along) / along.norm_squared();
        self.start + along * t.clamp(0.0, 1.0)
    }
}

/// A goal: two posts and a crossbar in the vertical plane of its goal line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Its color.
    pub color: GoalColor,
    /// The plane of the goal: x of the goal line, meters.
    pub x_m: f64,
    /// Distance of the axes of the posts from the middle of the goal, meters: they stand at y = +-this.
    pub post_y_m: f64,
    /// Radius of posts and crossbar, meters.
    pub post_radius_m: f64,
    /// Height of the crossbar's axis, meters.
    pub crossbar_z_m: f64,
}

/// A RoboCup field.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    dimensions: FieldDimensions,
    lines: Vec<Segment>,
    marks: Vec<Segment>,
    goals: [Goal; 2],
}

impl Field {
    /// Reads and checks the text of a field file.
    pub(crate) fn parse(name: &str, text: &str) -> Result<Self, MapError> {
        let dimensions: FieldDimensions = toml::from_str(text).map_err(|error| match lacking(text) {
            Some(reason) if error.message().starts_with("missing field") => {
                MapError::Syntax { name: name.to_owned(), line: None, reason }
            }
            _ => syntax_error(name, text, &error),
        })?;
        Self::new(name, dimensions)
    }

    /// A field of the given dimensions; `name` is used in errors.
    ///
    /// ```
    /// use visloc_world::{Map, field::{Field, FieldDimensions}};
    ///
    /// let Map::Field(like) = Map::built_in("robocup-spl-2010")? else { unreachable!() };
    /// let dimensions = FieldDimensions { name: "mine".to_owned(), length_m: 7.5, ..like.dimensions().clone() };
    /// let map = Map::Field(Field::new("mine", dimensions)?);
    /// assert_eq!(map.name(), "mine");
    /// # Ok::<(), visloc_world::MapError>(())
    /// ```
    ///
    /// # Errors
    /// If the kind is not that of a field, a dimension is not positive or a part does not fit inside the field.
    pub fn new(name: &str, dimensions: FieldDimensions) -> Result<Self, MapError> {
        dimensions.check(name)?;
        Ok(Self {
            lines: lines(&dimensions),
            marks: marks(&dimensions),
            goals: goals(&dimensions),
            dimensions,
        })
    }

    /// What the file says.
    pub fn dimensions(&self) -> &FieldDimensions {
        &self.dimensions
    }

    /// Center lines of all long straight lines: border, halfway line, boxes.
    pub fn lines(&self) -> &[Segment] {
        &self.lines
    }

    /// Center lines of the bars of penalty marks and center mark.
    pub fn marks(&self) -> &[Segment] {
        &self.marks
    }

    /// Places where the long lines meet each other, or the halfway line meets the circle.
    pub fn junctions(&self) -> Vec<FieldJunction> {
        junctions::junctions(self)
    }

    /// Radius of the center circle's center line, meters. Its center is the origin.
    pub fn circle_radius_m(&self) -> f64 {
        self.dimensions.center_circle_diameter_m / 2.0
    }

    /// The goal at +x and the goal at -x.
    pub fn goals(&self) -> &[Goal; 2] {
        &self.goals
    }

    /// Half the carpet's size along x and y, meters: no robot stands beyond it.
    pub fn half_carpet_m(&self) -> (f64, f64) {
        let d = &self.dimensions;
        (d.length_m / 2.0 + d.border_m, d.width_m / 2.0 + d.border_m)
    }

    /// Whether the field looks the same turned by 180 degrees.
    pub fn is_point_symmetric(&self) -> bool {
        self.goals[0].color == self.goals[1].color
    }
}

fn lines(d: &FieldDimensions) -> Vec<Segment> {
    let (x, y) = (d.length_m / 2.0, d.width_m / 2.0);
    let mut lines = vec![
        Segment::new((-x, -y), (x, -y)),
        Segment::new((-x, y), (x, y)),
        Segment::new((-x, -y), (-x, y)),
        Segment::new((x, -y), (x, y)),
        Segment::new((0.0, -y), (0.0, y)),
    ];
    for side in [1.0, -1.0] {
        for area in &d.boxes {
            let (outer, inner, half) = (side * x, side * (x - area.depth_m), area.width_m / 2.0);
            lines.push(Segment::new((outer, -half), (inner, -half)));
            lines.push(Segment::new((outer, half), (inner, half)));
            lines.push(Segment::new((inner, -half), (inner, half)));
        }
    }
    lines
}

fn marks(d: &FieldDimensions) -> Vec<Segment> {
    let half = d.penalty_mark_size_m / 2.0;
    let mut marks = Vec::new();
    for side in [1.0, -1.0] {
        let x = side * (d.length_m / 2.0 - d.penalty_mark_from_goal_line_m);
        marks.push(Segment::new((x - half, 0.0), (x + half, 0.0)));
        marks.push(Segment::new((x, -half), (x, half)));
    }
    let half = d.center_mark_size_m / 2.0;
    marks.push(Segment::new((-half, 0.0), (half, 0.0)));
    marks
}

fn goals(d: &FieldDimensions) -> [Goal; 2] {
    let radius = d.goals.post_diameter_m / 2.0;
    let goal = |side: f64, color| Goal {
        color,
        x_m: side * d.length_m / 2.0,
        post_y_m: d.goals.inner_width_m / 2.0 + radius,
        post_radius_m: radius,
        crossbar_z_m: d.goals.inner_height_m + radius,
    };
    [goal(1.0, d.goals.colors[0]), goal(-1.0, d.goals.colors[1])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Map;

    fn field(name: &str) -> Field {
        let Map::Field(field) = Map::built_in(name).unwrap() else { panic!("a field") };
        field
    }

    #[test]
    fn field_of_2010_has_its_published_geometry() {
        let field = field("robocup-spl-2010");
        assert_eq!(field.lines().len(), 11);
        assert!(field.lines().contains(&Segment::new((2.4, -1.1), (2.4, 1.1))));
        let [yellow, blue] = field.goals();
        assert_eq!((yellow.color, yellow.x_m), (GoalColor::Yellow, 3.0));
        assert_eq!((blue.color, blue.x_m), (GoalColor::Blue, -3.0));
        // post axes 1.5 m apart leave 1.4 m free
        assert!((yellow.post_y_m - 0.75).abs() < 1e-12 && (yellow.crossbar_z_m - 0.85).abs() < 1e-12);
        assert!(!field.is_point_symmetric());
    }

    #[test]
    fn field_of_2024_is_point_symmetric() {
        let field = field("robocup-spl-2024");
        assert_eq!(field.lines().len(), 17);
        assert!(field.is_point_symmetric());
        for line in field.lines() {
            let turned = Segment { start: -line.start, end: -line.end };
            let swapped = Segment { start: turned.end, end: turned.start };
            assert!(field.lines().iter().any(|l| *l == turned || *l == swapped), "{line:?}");
        }
    }

    #[test]
    fn nearest_point_is_clamped_to_the_ends() {
        let segment = Segment::new((0.0, 0.0), (2.0, 0.0));
        assert_eq!(segment.nearest_point(&Point2::new(1.0, 5.0)), Point2::new(1.0, 0.0));
        assert_eq!(segment.nearest_point(&Point2::new(-1.0, 1.0)), Point2::new(0.0, 0.0));
    }
}
