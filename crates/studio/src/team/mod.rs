//! A simulated team: robots on one field with white goals, each with a camera, a localizer and beliefs of its own, that tell each other what
//! they know. People cut links, make liars and kidnap.
//!
//! `session` is the whole, `game` moves the robots and carries what they tell, `robot` is one of them, `view` what pages are shown.

mod game;
mod robot;
mod session;
mod view;

pub use session::TeamSession;
