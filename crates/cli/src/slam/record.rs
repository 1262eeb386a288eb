//! What is kept of every frame.

use std::{io::Write, path::Path};

use anyhow::{Context, Result};
use visloc_core::{Timestamp, files::NewFile};
use visloc_slam::{FrameOutcome, TrackingState, atlas::Meeting, map::MapId, recognize::Refusal};

/// One frame.
#[derive(Debug, Clone, Copy)]
pub struct SlamRecord {
    /// Its number, from 0.
    pub number: usize,
    /// When it was taken.
    pub at: Timestamp,
    /// What the system knew after it.
    pub state: TrackingState,
    /// Places searched and landmarks found.
    pub matches: (usize, usize),
    /// The map that its pose was in.
    pub map: Option<MapId>,
    /// Of a lost frame: why the keyframe that looks most like it is another place.
    pub refusal: Option<Refusal>,
    /// What came of a place that looks like one that was seen before.
    pub meeting: Option<Meeting>,
    /// Whether it became a keyframe.
    pub is_keyframe: bool,
    /// Whether a lost camera was found in it.
    pub is_relocalized: bool,
    /// Time of tracking, seconds.
    pub tracking_secs: f64,
    /// Time of mapping, seconds.
    pub mapping_secs: f64,
}

impl SlamRecord {
    /// Of an outcome; what the mapper does with it comes by [`super::SlamHistory::add_mapped`].
    pub fn new(number: usize, at: Timestamp, outcome: &FrameOutcome) -> Self {
        Self {
            number,
            at,
            state: outcome.state,
            matches: outcome.matches,
            map: outcome.map,
            refusal: outcome.refusal,
            meeting: None,
            is_keyframe: false,
            is_relocalized: outcome.is_relocalized,
            tracking_secs: outcome.tracking.total_secs(),
            mapping_secs: 0.0,
        }
    }

    /// The state in a word: starting, the quality of tracking, or supposed, carried or lost.
    pub fn state_name(&self) -> &'static str {
        match self.state {
            TrackingState::Tracking(quality) => quality.name(),
            state => state.name(),
        }
    }

    /// Whether the frame has a pose at the time it is taken.
    pub fn is_tracked(&self) -> bool {
        matches!(self.state, TrackingState::Tracking(quality) if quality != visloc_slam::track::Quality::Bad)
    }
}

/// Writes one line for each frame.
pub fn write_log(path: &Path, records: &[SlamRecord]) -> Result<()> {
    let write = || -> std::io::Result<()> {
        let mut out = NewFile::create(path)?;
        writeln!(out, "t,state,searched,found,keyframe,relocalized,tracking_ms,mapping_ms,reason,map")?;
        for record in records {
            let state = record.state_name();
            let reason = match record.state {
                TrackingState::Starting(wait) => wait.to_string(),
                _ => match (&record.refusal, &record.meeting) {
                    (Some(refusal), _) => refusal.to_string(),
                    (None, Some(meeting)) => meeting.to_string(),
                    (None, None) => String::new(),
                },
            };
            let map = record.map.map(|map| map.index().to_string()).unwrap_or_default();
            writeln!(
                out,
                "{},{state},{},{},{},{},{:.3},{:.3},\"{reason}\",{map}",
                record.at,
                record.matches.0,
                record.matches.1,
                u8::from(record.is_keyframe),
                u8::from(record.is_relocalized),
                record.tracking_secs * 1e3,
                record.mapping_secs * 1e3
            )?;
        }
        out.finish()
    };
    write().with_context(|| path.display().to_string())
}
