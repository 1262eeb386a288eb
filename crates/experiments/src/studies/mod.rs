//! Studies of the observation: what one image tells about the pose, what disturbs it, how many pixels it takes, and what
//! each filter of the image analysis is worth.
//!
//! All images are simulated, so the truth is known to the pixel. Source: 2010 sections 4.2 to 4.4.

mod discrimination;
mod facts;
mod false_positive;
mod filters;
mod occlusion;
mod random_discard;
mod segments;
mod symmetry;
mod truth;

use std::path::Path;

use visloc_core::files;

use crate::{ExperimentError, Report};

/// A study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Study {
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

/// What a study shows.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StudyOutcome {
    /// Tables and pictures.
    pub report: Report,
    /// Further tables for programs: name of the file and text.
    pub files: Vec<(String, String)>,
}

impl Study {
    /// Does the study.
    ///
    /// # Errors
    /// If a simulation or the analysis of an image is impossible.
    pub fn conduct(self, seed: u64) -> Result<StudyOutcome, ExperimentError> {
        match self {
            Self::Discrimination => discrimination::conduct(seed),
            Self::Symmetry => symmetry::conduct(seed),
            Self::Occlusion => occlusion::conduct(seed),
            Self::FalsePositive => false_positive::conduct(seed),
            Self::RandomDiscard => random_discard::conduct(seed),
            Self::Filters => filters::conduct(seed),
            Self::Segments => segments::conduct(seed),
        }
    }
}

impl StudyOutcome {
    /// Writes everything into a folder.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn save(&self, folder: &Path) -> Result<(), ExperimentError> {
        self.report.save(folder)?;
        for (name, text) in &self.files {
            let path = folder.join(name);
            files::write(&path, text).map_err(ExperimentError::file(&path))?;
        }
        Ok(())
    }
}
