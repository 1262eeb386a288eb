//! `visloc study`.

use clap::Args;
use visloc_experiments::studies::Study;

use super::{JsonArg, OutputFolder, SeedArg, named::named};

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
    #[arg(value_name = "NAME", value_parser = named(STUDIES))]
    pub study: Study,
    /// Folder for tables and pictures
    #[arg(long, value_name = "DIR")]
    pub out: Option<OutputFolder>,
    #[command(flatten)]
    pub seed: SeedArg,
    #[command(flatten)]
    pub json: JsonArg,
}

/// All studies.
const STUDIES: &[(&str, Study, &str)] = &[
    ("discrimination", Study::Discrimination, "Does the likelihood grow gradually towards the true pose?"),
    ("symmetry", Study::Symmetry, "Where else could the image have been taken?"),
    ("occlusion", Study::Occlusion, "What if other robots hide a part?"),
    ("false-positive", Study::FalsePositive, "What if something looks like a goal post?"),
    ("random-discard", Study::RandomDiscard, "How many pixels does it take?"),
    ("filters", Study::Filters, "Which pixels do the filters drop, and rightly so?"),
    (
        "segments",
        Study::Segments,
        "In a building: which borders do the detectors of straight edges find, in light that changes?",
    ),
];
