//! One algorithm at work.

use std::{collections::BTreeMap, sync::Arc};

use anyhow::Result;
use visloc_core::{
    Clock, Frame, SkippedInput, Timestamp, eval::EstimateSample, geom::PlanarPose, settings::Overrides,
};
use visloc_locate::{
    LOCALIZED_RELIABILITY, Pipeline, PipelineConfig, StartPrior, algorithm_parameters,
    diagnosis::RunCounters,
    lineup::{Lineup, RunSettings},
    vision::{DropReason, Percept},
};
use visloc_world::Map;

use super::{OutputFiles, Records};
use crate::stopwatch::Stopwatch;

/// Most frames without an analysis that are kept; bounds memory of live sources.
const MAX_REJECTED: usize = 10_000;

/// What is kept of a frame. Small, so that an hour of frames fits into memory.
#[derive(Debug, Clone, Copy)]
pub struct FrameRecord {
    /// Stamp of the frame.
    pub at: Timestamp,
    /// Where the algorithm says that the robot is.
    pub world_from_robot: PlanarPose,
    /// How far it trusts that, 0 to 1.
    pub reliability: f64,
    /// Likelihood of the image at that pose, 0 to 1.
    pub likelihood: f64,
    /// Standard deviations of x and y, meters, and heading, radians.
    pub sigma: [f64; 3],
    /// Places where the robot may be.
    pub num_hypotheses: usize,
    /// Quality of the image, 0 to 1.
    pub quality: f64,
    /// Pixels that were weighed.
    pub num_pixels: usize,
    /// Particles or exploiters that were weighed.
    pub num_individuals: usize,
    /// Time for the image, milliseconds.
    pub analysis_ms: f64,
    /// Time for the pose, milliseconds.
    pub localizer_ms: f64,
}

impl FrameRecord {
    /// Whether the algorithm claims to know where the robot is.
    pub fn is_localized(&self) -> bool {
        self.reliability > LOCALIZED_RELIABILITY
    }

    /// For the comparison with the truth.
    pub fn sample(&self) -> EstimateSample {
        EstimateSample {
            at: self.at,
            world_from_robot: self.world_from_robot,
            reliability: Some(self.reliability),
        }
    }
}

/// What became of the pixels that looked like lines or goals, over all images.
#[derive(Debug, Clone, Copy, Default)]
pub struct PixelCounts {
    /// Given to the localizer.
    pub num_kept: u64,
    /// Dropped, in the order of [`DropReason::ALL`].
    pub num_dropped: [u64; DropReason::ALL.len()],
}

impl PixelCounts {
    fn count(&mut self, percept: &Percept) {
        self.num_kept += percept.pixels.len() as u64;
        for (count, reason) in self.num_dropped.iter_mut().zip(DropReason::ALL) {
            *count += percept.num_dropped(reason) as u64;
        }
    }
}

/// What a runner is made from.
pub struct RunnerSettings<'a> {
    /// Name of the algorithm.
    pub algorithm: &'a str,
    /// Parameters of the algorithm as TOML.
    pub algorithm_toml: Option<&'a str>,
    /// All other parameters.
    pub pipeline: PipelineConfig,
    /// What is known about the start.
    pub start: StartPrior,
    /// Seed of everything random.
    pub seed: u64,
}

/// An algorithm with its output files and records.
pub struct Runner {
    name: String,
    /// Of one algorithm.
    lineup: Lineup,
    start: StartPrior,
    files: OutputFiles,
    records: Records<FrameRecord>,
    rejected: Vec<SkippedInput>,
    pixels: PixelCounts,
    counters: RunCounters,
    images_of_camera: BTreeMap<usize, usize>,
}

impl Runner {
    /// An algorithm that knows nothing yet.
    pub fn new(map: &Map, settings: &RunnerSettings<'_>) -> Result<Self> {
        let RunnerSettings { algorithm, algorithm_toml, pipeline, start, seed } = settings;
        // A mistake is told with its line in the user's own text.
        algorithm_parameters(map, algorithm, pipeline.features, *algorithm_toml)?;
        let overrides = Overrides::from_toml(algorithm_toml.unwrap_or_default())?;
        let settings = RunSettings {
            map: Arc::new(map.clone()),
            seed: *seed,
            start: start.clone(),
            pipeline: *pipeline,
            algorithms: vec![((*algorithm).to_owned(), overrides)],
        };
        let watch = Stopwatch::start();
        let lineup = Lineup::new(settings, Clock::new(move || watch.secs()))?;
        Ok(Self {
            name: (*algorithm).to_owned(),
            lineup,
            start: start.clone(),
            files: OutputFiles::default(),
            records: Records::new(None),
            rejected: Vec::new(),
            pixels: PixelCounts::default(),
            counters: RunCounters::new(map, pipeline),
            images_of_camera: BTreeMap::new(),
        })
    }

    /// What was known about the start.
    pub fn start(&self) -> &StartPrior {
        &self.start
    }

    /// As this one, with files that take what is found.
    pub fn writing(self, files: OutputFiles) -> Self {
        Self { files, ..self }
    }

    /// Takes in a frame, measures, and writes the result.
    ///
    /// A frame that cannot be analyzed is left out and counted.
    pub fn step(&mut self, frame: &Frame) {
        let Some(contender) = self.lineup.contenders_mut().first_mut() else { return };
        if let Err(error) = contender.step(frame) {
            let (at, origin) = (Some(frame.at), "image analysis".to_owned());
            if self.rejected.len() < MAX_REJECTED {
                self.rejected.push(SkippedInput { at, origin, reason: error.to_string() });
            }
            self.counters.count_unusable(frame.at);
            return;
        }
        *self.images_of_camera.entry(frame.camera_index).or_default() += 1;
        let pipeline = contender.pipeline();
        let times = pipeline.times();
        let percept = pipeline.percept();
        self.pixels.count(percept);
        let estimate = pipeline.estimate();
        self.counters.count(frame, percept, estimate);
        let record = FrameRecord {
            at: frame.at,
            world_from_robot: estimate.world_from_robot,
            reliability: estimate.reliability,
            likelihood: estimate.likelihood,
            sigma: [0, 1, 2].map(|i| estimate.covariance[(i, i)].max(0.0).sqrt()),
            num_hypotheses: estimate.hypotheses.len(),
            quality: percept.quality,
            num_pixels: percept.pixels.len(),
            num_individuals: pipeline.localizer().num_weighed(),
            analysis_ms: times.analysis_ms,
            localizer_ms: times.localizer_ms,
        };
        self.records.push(record);
        self.files.append(&record);
    }

    /// Begins again with what is known about the pose.
    #[cfg_attr(not(feature = "ros2"), allow(dead_code))]
    pub fn reset_to(&mut self, prior: &StartPrior) {
        self.lineup.reset_to(prior);
    }

    /// The algorithm with its parameters.
    #[cfg_attr(not(feature = "studio"), allow(dead_code))]
    pub fn lineup(&self) -> &Lineup {
        &self.lineup
    }

    /// The algorithm with its parameters, to change them.
    #[cfg_attr(not(feature = "studio"), allow(dead_code))]
    pub fn lineup_mut(&mut self) -> &mut Lineup {
        &mut self.lineup
    }

    /// Completes the output files.
    pub fn finish(&mut self) -> Result<()> {
        self.files.finish()
    }

    /// Keeps at most so many records.
    #[must_use]
    pub fn keeping(mut self, most: Option<usize>) -> Self {
        self.records = Records::new(most);
        self
    }

    /// Another name, where the algorithm's own would not tell this one from the others.
    #[must_use]
    pub fn named(mut self, name: &str) -> Self {
        name.clone_into(&mut self.name);
        self
    }

    /// Name of the algorithm.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Image analysis and localizer, for pictures.
    pub fn pipeline(&self) -> &Pipeline {
        self.lineup.contenders()[0].pipeline()
    }

    /// All frames so far; of a live source evenly fewer.
    pub fn records(&self) -> &Records<FrameRecord> {
        &self.records
    }

    /// What became of the pixels of all images.
    pub fn pixels(&self) -> &PixelCounts {
        &self.pixels
    }

    /// What stood in the way of a place.
    pub fn counters(&self) -> &RunCounters {
        &self.counters
    }

    /// How many images of each camera were used.
    pub fn images_of_camera(&self) -> &BTreeMap<usize, usize> {
        &self.images_of_camera
    }

    /// Frames that could not be analyzed.
    pub fn rejected(&self) -> &[SkippedInput] {
        &self.rejected
    }
}
