//! Games of a team on a field with white goals, of which one robot is told its half: how soon the others are right, and what liars, bad links,
//! restarts and clocks do to them.
//!
//! A game is recorded once with a camera and a localizer for each robot, then played with messages under all conditions. What a localizer says
//! does not depend on the team ([`visloc_locate::team`]), so one recording serves for all of them.

mod carried;
mod experiment;
mod game;
mod network;
mod play;
mod report;
mod score;

pub use experiment::{ConditionRecord, TeamExperiment, TeamRecord, TeamSettings};
pub use game::{Game, GameSetup, Moment};
pub use play::{Conditions, Played, Restart, play};
pub use score::{Score, score};
