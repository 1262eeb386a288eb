//! `visloc study`.

use clap::{Args, ValueEnum};
use visloc_experiments::studies::Study;

use super::{JsonArg, OutputFolder, SeedArg};

/// Arguments of `visloc study`.
#[derive(Debug, Args)]
#[command(
    arg_required_else_help = true,
    long_about = "Studies of what an image tells about the pose, on simulated images, with what the document says beside what comes \
                  out. Each takes seconds to a minute.",
    after_long_help = "Examples:\n  \
                       visloc study occlusion --out out/occlusion\n  \
                       visloc study random-discard --seed 7 --json numbers.json\n\n\
                       One image of your own: visloc likelihood"
)]
pub struct StudyArgs {
    /// Which study
    #[arg(value_name = "NAME", value_enum)]
    pub study: StudyName,
    /// Folder for tables and pictures
    #[arg(long, value_name = "DIR")]
    pub out: Option<OutputFolder>,
    #[command(flatten)]
    pub seed: SeedArg,
    #[command(flatten)]
    pub json: JsonArg,
}

/// All studies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum StudyName {
    /// Does the likelihood grow gradually towards the true pose?
    Discrimination,
    /// Where else could the image have been taken?
    Symmetry,
    /// What if other robots hide a part?
    Occlusion,
    /// What if something looks like a goal post?
    FalsePositive,
    /// How many pixels does it take?
    RandomDiscard,
    /// Which pixels do the filters drop, and rightly so?
    Filters,
    /// In a building: which borders do the detectors of straight edges find, in light that changes?
    Segments,
}

impl From<StudyName> for Study {
    fn from(name: StudyName) -> Self {
        match name {
            StudyName::Discrimination => Self::Discrimination,
            StudyName::Symmetry => Self::Symmetry,
            StudyName::Occlusion => Self::Occlusion,
            StudyName::FalsePositive => Self::FalsePositive,
            StudyName::RandomDiscard => Self::RandomDiscard,
            StudyName::Filters => Self::Filters,
            StudyName::Segments => Self::Segments,
        }
    }
}
