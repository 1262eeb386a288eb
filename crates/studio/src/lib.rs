//! The studio: a page in the browser to watch a robot, drive it, kidnap it, change every parameter and replay what was
//! recorded.
//!
//! Data flow: a [`Session`] (`playground`, `team`, `replay`, `slam`, ...) takes in a [`Command`] or a tick and answers with an
//! [`Update`], which is bytes already (`message`). The `engine` runs one session on a thread of its own and hands updates to
//! the [`Hub`]; `server` gives each page the latest one when that page is ready for it. Sessions know nothing of the web, and
//! the server nothing of robots.
//!
//! No clock is read here: who starts the studio passes one in ([`Clock`](visloc_core::Clock)).

mod command;
mod engine;
mod error;
mod message;
mod new_file;
mod playback;
pub mod playground;
pub mod recording;
pub mod replay;
mod scenes;
pub mod server;
mod session;
pub mod slam;
pub mod source;
pub mod team;
pub mod tuning;
mod update;
pub mod view;

pub use command::Command;
pub use engine::{NOTICE_SECS, run_engine};
pub use error::StudioError;
pub use message::{Message, MessageBuilder, MessageError, MessageKind};
pub use new_file::new_file;
pub use scenes::{FileOpener, GivenFile, NamedSource, Scenes, SourceOpener};
pub use server::hub::Hub;
pub use session::Session;
pub use update::Update;
