//! What the studio shows, as files of the [Rerun](https://rerun.io) viewer: image with overlays, world, trajectories,
//! hypotheses, plots and events, with a layout.
//!
//! Data flow: a [`Converter`] turns each [`visloc_studio::Update`] into [`Entry`]s, plain shapes at paths; a [`RerunFile`]
//! writes them. The same updates go to pages and to recordings of the studio, so a file shows what a page would show, and
//! nothing that computes knows of Rerun.
//!
//! Only the feature `sdk` compiles Rerun. Without it everything but the writing is there, and [`RerunFile::create`] says what to
//! build.
//!
//! | path | what |
//! |---|---|
//! | `world/map` | field, building or floor |
//! | `world/truth` | the robot, what its camera sees, its way |
//! | `world/NAME` | an algorithm's ring (the surer, the smaller), way, hypotheses, particles |
//! | `world/slam` | landmarks, candidates, keyframes and links, camera, way |
//! | `camera/image` | image; below it kept and dropped pixels, the map as expected, the horizon, or features |
//! | `plots`, `events`, `numbers` | curves, what happened, all numbers as a table |

mod color;
mod convert;
mod entry;
mod error;
mod file;
mod layout;

pub use color::Color;
pub use convert::{Converter, Moment};
pub use entry::{Entry, Shape};
pub use error::RerunError;
pub use file::RerunFile;
pub use layout::{Layout, ViewKind};
