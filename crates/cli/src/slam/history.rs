//! What is known of all frames of a run.

use visloc_core::Timestamp;
use visloc_slam::{FrameOutcome, Mapped, StageTimes, TrackingState, atlas::Meeting};

use super::SlamRecord;
use crate::run::Records;

/// Records of the frames, evenly fewer of a live run, and what is counted over all of them.
#[derive(Debug)]
pub struct SlamHistory {
    /// The records, in order.
    pub records: Records<SlamRecord>,
    /// Frames that had a pose when they were taken.
    pub num_tracked: usize,
    /// How often the camera was lost.
    pub num_lost_spells: usize,
    /// How often it was found again.
    pub num_relocalized: usize,
    /// Loops that were closed.
    pub num_loops: usize,
    /// Maps that were joined to others.
    pub num_joins: usize,
    /// When the first frame had a pose.
    pub first_tracked_at: Option<Timestamp>,
    /// Time by stage, over all frames that had a pose.
    pub tracking: StageSums,
    /// Time by stage, over all keyframes.
    pub mapping: StageSums,
    was_lost: bool,
}

impl SlamHistory {
    /// Keeps at most so many records; `None` keeps all.
    pub fn new(most: Option<usize>) -> Self {
        Self {
            records: Records::new(most),
            num_tracked: 0,
            num_lost_spells: 0,
            num_relocalized: 0,
            num_loops: 0,
            num_joins: 0,
            first_tracked_at: None,
            tracking: StageSums::default(),
            mapping: StageSums::default(),
            was_lost: false,
        }
    }

    /// Notes the next frame.
    pub fn add(&mut self, at: Timestamp, outcome: &FrameOutcome) {
        let record = SlamRecord::new(self.records.num_seen(), at, outcome);
        let is_lost = record.state == TrackingState::Lost;
        self.num_lost_spells += usize::from(is_lost && !self.was_lost);
        self.was_lost = is_lost;
        self.num_relocalized += usize::from(record.is_relocalized);
        if record.is_tracked() {
            self.num_tracked += 1;
            self.first_tracked_at.get_or_insert(at);
            self.tracking.add(&outcome.tracking);
        }
        self.records.push(record);
    }

    /// Notes what the mapper has finished. It counts frames from the start of its map, which was this frame of the run.
    pub fn add_mapped(&mut self, first_of_map: usize, mapped: &[Mapped]) {
        for Mapped { frame, report, meeting, times } in mapped {
            let is_keyframe = report.keyframe.is_some();
            if is_keyframe {
                self.mapping.add(times);
            }
            match meeting {
                Some(Meeting::Joined { .. }) => self.num_joins += 1,
                Some(Meeting::Closed { .. } | Meeting::Followed { .. }) => self.num_loops += 1,
                _ => {}
            }
            let number = first_of_map.saturating_add(*frame);
            if let Ok(index) = self.records.binary_search_by_key(&number, |record| record.number) {
                self.records[index].is_keyframe = is_keyframe;
                self.records[index].meeting = *meeting;
                self.records[index].mapping_secs = times.total_secs();
            }
        }
    }
}

/// Times of many frames, summed by stage.
#[derive(Debug, Default)]
pub struct StageSums {
    sums: StageTimes,
    num: usize,
}

impl StageSums {
    fn add(&mut self, times: &StageTimes) {
        times.stages().iter().for_each(|(stage, secs)| self.sums.add(stage, *secs));
        self.num += 1;
    }

    /// Mean of each stage, milliseconds.
    pub fn means_ms(&self) -> Vec<(String, f64)> {
        let mean = |(stage, secs): &(&'static str, f64)| ((*stage).to_owned(), secs * 1e3 / self.num as f64);
        self.sums.stages().iter().map(mean).collect()
    }
}
