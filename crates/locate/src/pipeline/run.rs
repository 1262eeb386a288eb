//! From frames to estimates.

use std::fmt;

use visloc_core::{Clock, Frame, Rng, RngTree};
use visloc_world::Map;

use super::{ImageAnalyzer, PipelineBuilder, PipelineConfig, world_parts::WorldParts};
use crate::{
    ConfigError, Estimate, LiftDetector, Localizer, ObservationModel, StartPrior, StepInput,
    per_camera::OtherCameras,
    refine::Refined,
    vision::{AnalysisError, Percept},
};

/// From frames to estimates: image analysis, lift detector and localizer of one robot with any number of cameras, whose frames come one after the
/// other: see [`Frame::camera_index`].
pub struct Pipeline {
    /// That of the last frame's camera.
    analyzer: ImageAnalyzer,
    camera_index: usize,
    other_analyzers: OtherCameras<ImageAnalyzer>,
    lift: LiftDetector,
    localizer: Box<dyn Localizer>,
    analysis_rng: Rng,
    localizer_rng: Rng,
    clock: Clock,
    times: StepTimes,
}

/// How long the last step took, by the clock of the pipeline.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StepTimes {
    /// Image analysis, milliseconds.
    pub analysis_ms: f64,
    /// Lift detector and localizer, milliseconds.
    pub localizer_ms: f64,
}

impl fmt::Debug for Pipeline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pipeline")
            .field("estimate", self.estimate())
            .field("times", &self.times)
            .finish_non_exhaustive()
    }
}

impl Pipeline {
    /// Settings of a pipeline for a map. By default: the evolutionary algorithm, which knows nothing of the pose, with seed 1.
    pub fn builder(map: &Map) -> PipelineBuilder<'_> {
        PipelineBuilder::new(map)
    }

    pub(crate) fn new(
        map: &Map,
        localizer_for: impl FnOnce(Box<dyn ObservationModel>) -> Result<Box<dyn Localizer>, ConfigError>,
        config: &PipelineConfig,
        rng: RngTree,
        clock: Clock,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        let parts = WorldParts::new(map, config)?;
        let mut localizer = localizer_for(parts.model)?;
        if let Some(rich) = parts.rich {
            localizer = Box::new(Refined::new(rich.config, localizer, rich.features, rich.pixels)?);
        }
        Ok(Self {
            analyzer: ImageAnalyzer::new(map, config)?,
            camera_index: 0,
            other_analyzers: OtherCameras::none(),
            lift: LiftDetector::new(config.lift),
            localizer,
            analysis_rng: rng.stream("analysis", 0),
            localizer_rng: rng.stream("localizer", 0),
            clock,
            times: StepTimes::default(),
        })
    }

    /// Takes in the next frame: looks at its image, and at the robot's pose.
    ///
    /// # Errors
    /// If the image does not belong to its calibration, or the camera's pose on the robot is not finite. The frame is left out then, and the
    /// run can go on. Odometry that is not finite counts as none, and a stamp before that of the last frame as no time gone by.
    pub fn step(&mut self, frame: &Frame) -> Result<&Estimate, AnalysisError> {
        let start = self.clock.secs();
        let cameras = (self.camera_index, frame.camera_index);
        self.other_analyzers.look_through(&mut self.analyzer, cameras, ImageAnalyzer::anew);
        self.camera_index = frame.camera_index;
        self.analyzer.analyze(frame, &mut self.analysis_rng)?;
        let analyzed = self.clock.secs();
        let is_lifted = self.lift.update(frame.at, frame.ground_contact.as_ref());
        let input = StepInput { percept: self.analyzer.percept(), odometry: frame.odometry, is_lifted };
        self.localizer.step(&input, &mut self.localizer_rng);
        let end = self.clock.secs();
        self.times =
            StepTimes { analysis_ms: (analyzed - start) * 1e3, localizer_ms: (end - analyzed) * 1e3 };
        Ok(self.localizer.estimate())
    }

    /// What the last step found in the image.
    pub fn percept(&self) -> &Percept {
        self.analyzer.percept()
    }

    /// The answer after the last step.
    pub fn estimate(&self) -> &Estimate {
        self.localizer.estimate()
    }

    /// How long the last step took.
    pub fn times(&self) -> StepTimes {
        self.times
    }

    /// Begins again with what is known about the pose, for instance the half in which the robot is put down.
    ///
    /// # Panics
    /// Perhaps, now or in a later step, if [`StartPrior::check`] refuses it.
    pub fn reset_to(&mut self, prior: &StartPrior) {
        self.localizer.reset_to(prior);
    }

    /// The image analysis, for pictures of what it found.
    pub fn analyzer(&self) -> &ImageAnalyzer {
        &self.analyzer
    }

    /// The localizer, for pictures of its particles.
    pub fn localizer(&self) -> &dyn Localizer {
        self.localizer.as_ref()
    }
}
