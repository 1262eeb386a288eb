//! What is kept of every frame.

use std::{
    fs::File,
    io::{BufWriter, Write},
    path::Path,
};

use anyhow::{Context, Result};
use visloc_base::Timestamp;
use visloc_slam::{FrameOutcome, Mapped, StageTimes, TrackingState};

/// One frame.
#[derive(Debug, Clone)]
pub struct SlamRecord {
    /// When it was taken.
    pub at: Timestamp,
    /// What the system knew after it.
    pub state: TrackingState,
    /// Places searched and landmarks found.
    pub matches: (usize, usize),
    /// Whether it became a keyframe.
    pub is_keyframe: bool,
    /// Whether a lost camera was found in it.
    pub is_relocalized: bool,
    /// Time of tracking by stage.
    pub tracking: StageTimes,
    /// Time of mapping by stage.
    pub mapping: StageTimes,
}

impl SlamRecord {
    /// Of an outcome; what the mapper does with it comes by [`SlamRecord::add_mapped`].
    pub fn new(at: Timestamp, outcome: &FrameOutcome) -> Self {
        Self {
            at,
            state: outcome.state,
            matches: outcome.matches,
            is_keyframe: false,
            is_relocalized: outcome.is_relocalized,
            tracking: outcome.tracking.clone(),
            mapping: StageTimes::default(),
        }
    }

    /// Notes what the mapper has finished.
    pub fn add_mapped(records: &mut [Self], mapped: Vec<Mapped>) {
        for Mapped { frame, report, times } in mapped {
            if let Some(record) = records.get_mut(frame) {
                record.is_keyframe = report.keyframe.is_some();
                record.mapping = times;
            }
        }
    }

    /// The state in a word: starting, the quality of tracking, or lost.
    pub fn state_name(&self) -> String {
        match self.state {
            TrackingState::Starting(_) => "starting".to_owned(),
            TrackingState::Tracking(quality) => format!("{quality:?}").to_lowercase(),
            TrackingState::Lost => "lost".to_owned(),
        }
    }

    /// Whether the frame has a pose at the time it is taken.
    pub fn is_tracked(&self) -> bool {
        matches!(self.state, TrackingState::Tracking(quality) if quality != visloc_slam::track::Quality::Bad)
    }
}

/// Writes one line for each frame.
///
/// # Errors
/// If the file cannot be written.
pub fn write_log(path: &Path, records: &[SlamRecord]) -> Result<()> {
    let write = || -> std::io::Result<()> {
        let mut out = BufWriter::new(File::create(path)?);
        writeln!(out, "t,state,searched,found,keyframe,relocalized,tracking_ms,mapping_ms,reason")?;
        for record in records {
            let state = record.state_name();
            let reason = match record.state {
                TrackingState::Starting(wait) => wait.to_string(),
                _ => String::new(),
            };
            writeln!(
                out,
                "{},{state},{},{},{},{},{:.3},{:.3},\"{reason}\"",
                record.at,
                record.matches.0,
                record.matches.1,
                u8::from(record.is_keyframe),
                u8::from(record.is_relocalized),
                record.tracking.total_secs() * 1e3,
                record.mapping.total_secs() * 1e3
            )?;
        }
        out.flush()
    };
    write().with_context(|| path.display().to_string())
}
