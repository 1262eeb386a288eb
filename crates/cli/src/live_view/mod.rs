//! What happens while the demo runs: a picture of characters on a terminal, a few plain lines in a pipe.
//!
//! `events` notices what is worth a line, `dots` is a canvas of braille dots, `field` and `camera` draw on it,
//! `screen` puts everything side by side and `terminal` shows it at a pace for people.

mod camera;
mod dots;
mod events;
mod field;
mod panel;
mod plain;
mod screen;
mod terminal;

pub use events::{Event, EventLog};
pub use plain::PlainLog;
pub use terminal::{LiveView, is_live_terminal};
