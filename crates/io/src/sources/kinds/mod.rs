//! The kinds of sources. A new one is a file here and its line in [`KINDS`].

mod bag;
mod dataset;
mod live_camera;
mod looped;
mod ros2;
mod simulation;
mod video;

use std::path::Path;

pub use bag::notes_on_folder;
pub(crate) use simulation::simulated_names;
pub use simulation::simulated_scenario;

use crate::sources::{
    OpenFrames, OpenImages, OpenPictures, Purpose, SourceOption, SourceOptions, SourcesError, open::Request,
};

/// One kind of source.
pub struct SourceKind {
    /// For people.
    pub name: &'static str,
    /// Words before the colon.
    pub schemes: &'static [&'static str],
    /// How it is written.
    pub form: &'static str,
    /// Something to try.
    pub example: &'static str,
    /// What it is.
    pub summary: &'static str,
    /// Whether it goes on by itself: the newest image counts, and there is no end.
    pub is_live: bool,
    /// Whether what stands behind the colon is a robot with kinematics, not a camera alone.
    pub(crate) is_robot: fn(&str) -> bool,
    /// Why it cannot be used here; `None` if it can.
    pub problem: fn(&SourceOptions) -> Option<String>,
    /// Whether a file or folder that is named without a word is of this kind.
    pub(crate) claims: fn(&Path) -> bool,
    pub(crate) frames: Way<OpenFrames>,
    pub(crate) images: Way<OpenImages>,
    pub(crate) pictures: Way<OpenPictures>,
}

visloc_core::debug_shows!([] SourceKind { name, schemes, is_live });

/// How a source is opened for a purpose.
pub(crate) struct Way<T> {
    /// The options that make a difference, for what stands behind the colon. All others are refused.
    pub honors: fn(&str) -> Vec<SourceOption>,
    pub open: fn(&Request<'_>) -> Result<T, SourcesError>,
}

impl SourceKind {
    /// The options that make a difference for a purpose, for what stands behind the colon.
    pub fn honors(&self, purpose: Purpose, rest: &str) -> Vec<SourceOption> {
        match purpose {
            Purpose::Frames => (self.frames.honors)(rest),
            Purpose::Images => (self.images.honors)(rest),
            Purpose::Pictures => (self.pictures.honors)(rest),
        }
    }
}

/// All kinds, in the order in which they may claim a path.
pub static KINDS: [SourceKind; 7] =
    [simulation::KIND, bag::KIND, dataset::KIND, video::KIND, live_camera::KIND, looped::KIND, ros2::KIND];

/// No path is of this kind.
fn claims_nothing(_: &Path) -> bool {
    false
}

/// Nothing stands in the way.
fn always_usable(_: &SourceOptions) -> Option<String> {
    None
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    extension.is_some_and(|extension| extensions.contains(&extension.as_str()))
}
