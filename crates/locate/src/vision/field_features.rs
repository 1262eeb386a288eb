//! Composite features of a field image: lines, their junctions, the center circle, penalty marks, goal posts.
//!
//! Places are (x, y) on the ground seen from the robot, meters, x ahead and y to the left, as the reported pose of the
//! camera has it: half a degree of error there moves a point 3 m away by 0.15 m. Pixels are free of lens distortion.

use nalgebra::Point2;
use visloc_world::field::GoalColor;

/// All composite features of one image.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FieldFeatures {
    /// Straight lines, the longest in the image first.
    pub lines: Vec<LineSegment>,
    /// Where two lines meet.
    pub junctions: Vec<Junction>,
    /// The center circle, if enough of it is seen.
    pub circle: Option<CenterCircle>,
    /// Penalty marks.
    pub marks: Vec<PenaltyMark>,
    /// Goal posts.
    pub posts: Vec<GoalPost>,
}

impl FieldFeatures {
    /// Takes over what another holds, in its own memory.
    pub fn copy_from(&mut self, other: &Self) {
        self.clear();
        self.lines.extend_from_slice(&other.lines);
        self.junctions.extend_from_slice(&other.junctions);
        self.circle = other.circle;
        self.marks.extend_from_slice(&other.marks);
        self.posts.extend_from_slice(&other.posts);
    }

    /// Forgets everything, keeps the memory.
    pub fn clear(&mut self) {
        self.lines.clear();
        self.junctions.clear();
        self.circle = None;
        self.marks.clear();
        self.posts.clear();
    }
}

/// A visible piece of a straight white line: its center line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineSegment {
    /// Ends on the ground.
    pub ends_in_robot: [Point2<f64>; 2],
    /// The same ends in the image, pixels.
    pub ends_px: [Point2<f64>; 2],
    /// How many crossings of scan lines support it.
    pub num_crossings: usize,
}

impl LineSegment {
    /// Length on the ground, meters.
    pub fn length_m(&self) -> f64 {
        (self.ends_in_robot[1] - self.ends_in_robot[0]).norm()
    }

    /// Direction on the ground, radians from ahead to the left; the opposite direction is the same line.
    pub fn direction_rad(&self) -> f64 {
        let along = self.ends_in_robot[1] - self.ends_in_robot[0];
        along.y.atan2(along.x)
    }
}

/// How two lines meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum JunctionKind {
    /// Both end here: a corner.
    L,
    /// One ends on the other.
    T,
    /// Both go on.
    X,
}

impl JunctionKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::L, Self::T, Self::X];

    /// In how many directions lines leave from it.
    pub fn num_arms(self) -> usize {
        match self {
            Self::L => 2,
            Self::T => 3,
            Self::X => 4,
        }
    }
}

/// A place where two lines meet at a right angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Junction {
    /// How they meet.
    pub kind: JunctionKind,
    /// Where the center lines cross.
    pub at_in_robot: Point2<f64>,
    /// The same in the image, pixels.
    pub at_px: Point2<f64>,
    /// Direction on the ground, radians from ahead to the left. L: from the corner between the two lines, 45 degrees from
    /// either. T: from the crossing along the line that ends. X: along one of the lines; every quarter turn is the same.
    pub direction_rad: f64,
}

/// The center circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CenterCircle {
    /// Its center.
    pub center_in_robot: Point2<f64>,
    /// Share of the circle that was looked at and found white, 0 to 1.
    pub visible_share: f64,
    /// Direction of the halfway line, radians from ahead to the left, if it is seen; half a turn more is the same.
    pub halfway_rad: Option<f64>,
}

/// A small white cross that no line touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PenaltyMark {
    /// Its middle.
    pub at_in_robot: Point2<f64>,
    /// The same in the image, pixels.
    pub at_px: Point2<f64>,
}

/// Which post of its goal, for somebody who looks at the goal from the field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PostSide {
    /// The crossbar goes on to the right.
    Left,
    /// The crossbar goes on to the left.
    Right,
}

/// An upright post.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GoalPost {
    /// Of which goal.
    pub color: GoalColor,
    /// Direction of its axis, radians from ahead to the left.
    pub bearing_rad: f64,
    /// Where its axis meets the ground, if its foot is in the image.
    pub base_in_robot: Option<Point2<f64>>,
    /// The lowest point of the axis in the image, pixels.
    pub foot_px: Point2<f64>,
    /// Which post it is, if the crossbar is in the image.
    pub side: Option<PostSide>,
}
