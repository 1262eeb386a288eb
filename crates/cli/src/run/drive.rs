//! The loop over all frames.

use std::sync::Arc;

use anyhow::Result;
use visloc_core::{
    Frame, PlanarTrajectory, SkippedInput, Source, SourceError, SourceFrame, StampedPose, Timestamp, Truth,
};

use super::{LiveReport, Records, Runner};
use crate::stopwatch::Stopwatch;

/// What there is to see after a frame.
pub struct FrameView<'a> {
    /// What the robot sensed; whoever shows it elsewhere shares it.
    pub frame: &'a Arc<Frame>,
    /// Where it was.
    pub truth: Option<Truth>,
    /// The algorithms, after this frame.
    pub runners: &'a [Runner],
    /// Seconds since the first frame.
    pub secs: f64,
    /// Images of a live source that were left out so far.
    pub num_dropped: usize,
    /// When the image came, by the wall clock; live sources know.
    #[cfg_attr(not(feature = "ros2"), allow(dead_code))]
    pub received_at: Option<Timestamp>,
}

/// Somebody who watches.
pub trait Spectator {
    /// Called when there is a frame, before anything is done with it.
    fn before_frame(&mut self, _: &mut [Runner]) {}

    /// Called after every frame.
    fn after_frame(&mut self, view: &FrameView<'_>);

    /// What was counted on live topics.
    fn report(&self) -> Option<LiveReport> {
        None
    }

    /// Completes what is written.
    fn finish(self: Box<Self>) -> Result<()> {
        Ok(())
    }
}

/// What a run leaves behind besides the records of its runners.
pub struct RunOutcome {
    /// Where the robot was, as far as the source knows.
    pub truth: PlanarTrajectory,
    /// Frames that the source delivered.
    pub num_frames: usize,
    /// From the first to the last frame, seconds.
    pub duration_secs: f64,
    /// Images of a live source that came while others were worked on.
    pub num_dropped: usize,
    /// What the source left out.
    pub skipped: Vec<SkippedInput>,
    /// Why the source ended early.
    pub error: Option<SourceError>,
    /// Time that all this took, seconds, with reading or drawing the images.
    pub wall_secs: f64,
}

/// Feeds every frame to every runner, in order. Each runner gets the frame alone; the truth goes to the spectators and
/// into the outcome.
pub fn drive(
    source: &mut dyn Source<SourceFrame>,
    max_frames: Option<u32>,
    runners: &mut [Runner],
    spectators: &mut [&mut dyn Spectator],
) -> RunOutcome {
    let watch = Stopwatch::start();
    let max_frames = max_frames.map_or(usize::MAX, |frames| frames as usize);
    let mut outcome = RunOutcome {
        truth: PlanarTrajectory::new(),
        num_frames: 0,
        duration_secs: 0.0,
        num_dropped: 0,
        skipped: Vec::new(),
        error: None,
        wall_secs: 0.0,
    };
    let mut first_at = None;
    let mut truths = Records::new(runners.first().and_then(|runner| runner.records().most()));
    while outcome.num_frames < max_frames {
        let (frame, truth) = match source.next_item() {
            Some(Ok(next)) => (Arc::new(next.frame), next.truth),
            Some(Err(error)) => {
                outcome.error = Some(error);
                break;
            }
            None => break,
        };
        outcome.num_frames += 1;
        outcome.duration_secs = frame.at.secs_since(*first_at.get_or_insert(frame.at));
        if let Some(Truth { world_from_robot, height_m }) = truth {
            truths.push(StampedPose { at: frame.at, world_from_robot, height_m });
        }
        for spectator in spectators.iter_mut() {
            spectator.before_frame(runners);
        }
        for runner in runners.iter_mut() {
            runner.step(&frame);
        }
        let status = source.status();
        let view = FrameView {
            frame: &frame,
            truth,
            runners,
            secs: outcome.duration_secs,
            num_dropped: status.num_dropped,
            received_at: status.received_at,
        };
        for spectator in spectators.iter_mut() {
            spectator.after_frame(&view);
        }
    }
    for pose in truths.iter() {
        // A second truth of the same time tells nothing new.
        let _ = outcome.truth.push(*pose);
    }
    let status = source.status();
    outcome.num_dropped = status.num_dropped;
    outcome.skipped = status.skipped.to_vec();
    outcome.wall_secs = watch.secs();
    outcome
}
