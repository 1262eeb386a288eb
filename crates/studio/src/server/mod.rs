//! The page and its socket. Everything that is served is part of the program.

mod access;
mod assets;
pub mod hub;
mod link;
mod listen;
mod remote;
mod routes;
mod smaller;
mod socket;

pub use listen::{Server, ServerError};
pub use remote::Remote;
