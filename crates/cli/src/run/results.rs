//! Results for other programs: beside the input in a bag, and as live topics.

use std::path::Path;

use anyhow::Result;
use visloc_core::{Frame, Truth};
use visloc_io::bag::{
    BagError, BagTopics, BagWriter, ResultFrames, ResultMessages, ResultSample, covariance_on_ground,
    on_ground,
};
use visloc_locate::{Estimate, LOCALIZED_RELIABILITY};

use super::{FrameView, Spectator};

/// What the first runner says after a frame.
fn result_sample(view: &FrameView<'_>) -> Option<ResultSample> {
    let estimate = view.runners.first()?.pipeline().localizer().estimate();
    Some(sample_of(view, estimate))
}

/// An estimate after a frame.
pub fn sample_of(view: &FrameView<'_>, estimate: &Estimate) -> ResultSample {
    ResultSample {
        at: view.frame.at,
        world_from_robot: on_ground(&estimate.world_from_robot),
        covariance: covariance_on_ground(&estimate.covariance),
        reliability: estimate.reliability,
        is_localized: estimate.reliability > LOCALIZED_RELIABILITY,
        likelihood: Some(estimate.likelihood),
        hypotheses: estimate.hypotheses.iter().map(|it| on_ground(&it.world_from_robot)).collect(),
        odometry: view.frame.odometry.as_ref().map(on_ground),
        num_dropped: view.num_dropped,
    }
}

/// Writes every frame and what became of it into a bag.
pub struct BagOutput {
    writer: BagWriter,
    results: ResultMessages,
    fault: Option<BagError>,
}

impl BagOutput {
    /// Starts the bag; topics and frames of the input keep their names.
    pub fn create(path: &Path, topics: &BagTopics) -> Result<Self> {
        let frames = ResultFrames { base: topics.base_frame.clone(), ..ResultFrames::default() };
        Ok(Self {
            writer: BagWriter::create(path, topics.clone())?,
            results: ResultMessages::new(frames, 0.0),
            fault: None,
        })
    }

    /// Completes the bag.
    pub fn finish(self) -> Result<()> {
        match self.fault {
            Some(fault) => Err(fault.into()),
            None => Ok(self.writer.finish()?),
        }
    }

    /// Writes a frame and what became of it; why that is not possible is told at the end.
    pub fn add(&mut self, frame: &Frame, truth: Option<&Truth>, sample: Option<&ResultSample>) {
        if self.fault.is_none() {
            self.fault = self.write(frame, truth, sample).err();
        }
    }

    fn write(
        &mut self,
        frame: &Frame,
        truth: Option<&Truth>,
        sample: Option<&ResultSample>,
    ) -> Result<(), BagError> {
        self.writer.write_frame(frame, truth)?;
        let Some(sample) = sample else { return Ok(()) };
        for message in self.results.step(sample) {
            self.writer.write_result(sample.at, &message)?;
        }
        Ok(())
    }
}

impl Spectator for BagOutput {
    fn after_frame(&mut self, view: &FrameView<'_>) {
        self.add(view.frame, view.truth.as_ref(), result_sample(view).as_ref());
    }
}
