//! Robots that help each other to know where they are.
//!
//! Each robot tells the others what it knows *by itself*: the hypotheses of its own localizer, and where it sees other robots and the ball
//! ([`TeamMessage`]). A [`TeamFilter`] joins what all have told: which hypotheses of all robots together explain who sees whom. White goals
//! make a field point-symmetric, so that one robot alone never knows its half; sightings tie the halves of the robots to each other, and one
//! that knows its own decides those of all.
//!
//! What keeps it honest:
//! * A message never contains what the sender has from others, so nothing comes back to where it began and nothing counts twice. Only a
//!   half that was decided is told on, with the name of who knew it ([`ToldHalf`]).
//! * Sightings made one after the other resemble each other: those of one second together count as one ([`TeamConfig`]).
//! * Every robot may be elsewhere than it says. A claim needs more robots that agree than others that contradict it or that nobody has seen
//!   yet, so one that lies decides nothing against one that knows.
//! * The filter changes the answer only, never the localizer: nobody's own tracks are moved by others. Without messages the estimate is that
//!   of the localizer, bit for bit.
//!
//! Sources: joint association of measurements after Fortmann, Bar-Shalom and Scheffe, "Sonar tracking of multiple targets using joint
//! probabilistic data association", 1983; robots that see each other after Fox, Burgard, Kruppa and Thrun, "A probabilistic approach to
//! collaborative multi-robot localization", 2000; fusion with unknown correlation after Julier and Uhlmann, "A non-divergent estimation
//! algorithm in the presence of unknown correlations", 1997.
//!
//! No files, threads, clocks or network: messages come in with the time of arrival, and go out for whoever sends them.

mod answer;
mod belief;
mod clock;
mod config;
mod decision;
mod evidence;
mod filter;
mod fusion;
mod joint;
mod liar;
mod mate;
mod message;
mod names;
mod outbox;
mod placement;
mod symmetry;
#[cfg(test)]
mod tests;
mod wire;

pub use answer::{Help, MateView, TeamEstimate};
pub use config::TeamConfig;
pub use filter::TeamFilter;
pub use fusion::covariance_intersection;
pub use liar::Liar;
pub use message::{
    Ignored, MAX_HYPOTHESES, MAX_SIGHTINGS, Member, Root, Sighting, SightingKind, TEAM_MESSAGE_VERSION,
    TeamMessage, ToldHalf, ToldHypothesis,
};
pub use symmetry::Symmetry;
pub use wire::{WireHypothesis, WireSighting, WireSightings, WireTeamMessage, WireTime};
