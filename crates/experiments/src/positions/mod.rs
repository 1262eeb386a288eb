//! A synthetic world: a square with a few positions at which everything that a robot could see is the same.
//!
//! Localizers run in it unchanged, through their trait, because they know a world only through its observation model.
//! Source: 2017 section 5.1.

mod census;
mod control;
mod scenario;
mod session;
mod world;

pub use census::{Census, NEAR_M};
pub use control::UniformControl;
pub use scenario::{Movement, Scenario, ScenarioShape};
pub use session::{Contender, Session};
pub use world::PositionsWorld;
