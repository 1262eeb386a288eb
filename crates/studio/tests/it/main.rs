//! The studio from outside: sessions, recordings, and the server over real connections.

// Helpers of tests may fail like tests.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod driving;
mod playground;
mod recording;
mod remote;
mod server;
mod slam;
mod source;
mod support;
mod team;
