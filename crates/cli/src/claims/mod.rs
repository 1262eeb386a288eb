//! What a command reads and writes, compared before anything is created: outputs never harm inputs.
//!
//! The types of the arguments say what is read and what is written, so this holds for every command, a new one included.

mod check;
mod collect;
mod identity;
#[cfg(test)]
mod tests;

pub use collect::Claims;
pub use identity::Identity;
