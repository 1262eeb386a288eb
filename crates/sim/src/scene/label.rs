//! What a surface is, for the truth about pixels.

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Label {
    /// Room, furniture, boards, people, or nothing at all.
    #[default]
    Other,
    /// The field's carpet without its lines.
    Carpet,
    /// A white line or mark on the carpet.
    Line,
    /// Post or crossbar of a yellow goal.
    YellowGoal,
    /// Post or crossbar of a blue goal.
    BlueGoal,
    /// Post or crossbar of a white goal.
    WhiteGoal,
    /// The part of a goal behind its posts: base and stays, of any color.
    GoalBack,
    /// The ball.
    Ball,
    /// Another robot.
    Robot,
    /// The floor of a building.
    Floor,
    /// A wall of a building, its baseboard included.
    Wall,
    /// A closed door.
    Door,
}

impl Label {
    /// Whether it is a post or a crossbar.
    pub fn is_goal(self) -> bool {
        matches!(self, Self::YellowGoal | Self::BlueGoal | Self::WhiteGoal)
    }
}
