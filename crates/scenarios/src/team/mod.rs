//! Games of a team: recorded once with a camera and a localizer for each robot, then played with messages under any conditions.
//!
//! What a localizer says does not depend on the team ([`visloc_locate::team`]), so one recording serves for all conditions.

mod game;
mod network;
mod play;
mod score;

pub use game::{Game, GameSetup, Moment};
pub use play::{Conditions, Liar, Played, Restart, play};
pub use score::{Score, score};
