//! The file itself.

#[cfg(feature = "sdk")]
mod archetypes;
#[cfg(feature = "sdk")]
mod blueprint;
#[cfg(not(feature = "sdk"))]
mod missing;
#[cfg(feature = "sdk")]
mod writer;

#[cfg(not(feature = "sdk"))]
pub use missing::RerunFile;
#[cfg(feature = "sdk")]
pub use writer::RerunFile;
