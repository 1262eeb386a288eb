//! Runs of a whole localization, from source to evaluation, for end-to-end tests.

// Robots, steps and images are few.

mod detection_score;

pub use detection_score::{DetectionScore, DetectionScores};
use visloc_core::{
    PlanarTrajectory, Source, SourceError, SourceFrame, StampedPose,
    eval::{EstimateSample, Evaluation, EvaluationOptions, evaluate},
};
use visloc_locate::{ConfigError, FeatureChoice, Pipeline, PipelineConfig};
use visloc_world::Map;

/// A run that could not be carried out.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A parameter is wrong.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The simulation could not be built.
    #[error(transparent)]
    Simulation(#[from] visloc_sim::ScenarioError),
    /// The source broke.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A frame could not be analyzed.
    #[error(transparent)]
    Analysis(#[from] visloc_locate::vision::AnalysisError),
}

/// What a run left behind.
#[derive(Debug)]
pub struct Run {
    /// Comparison with the truth.
    pub evaluation: Evaluation,
    /// Every estimate.
    pub estimates: Vec<EstimateSample>,
}

/// Runs an algorithm over all frames of a source that knows the truth. The algorithm sees the frames only.
///
/// # Errors
/// If the algorithm is unknown, or the source breaks.
pub fn run(
    source: &mut dyn Source<SourceFrame>,
    map: &Map,
    algorithm: &str,
    features: FeatureChoice,
    seed: u64,
) -> Result<Run, RunError> {
    let config = PipelineConfig { features, ..PipelineConfig::default() };
    let mut pipeline = Pipeline::builder(map).named(algorithm, None).config(config).seed(seed).build()?;
    let mut truth = PlanarTrajectory::new();
    let mut estimates = Vec::new();
    while let Some(source_frame) = source.next_item() {
        let source_frame = source_frame?;
        let frame = &source_frame.frame;
        let estimate = pipeline.step(frame)?;
        estimates.push(EstimateSample {
            at: frame.at,
            world_from_robot: estimate.world_from_robot,
            reliability: Some(estimate.reliability),
        });
        if let Some(t) = source_frame.truth {
            let pose =
                StampedPose { at: frame.at, world_from_robot: t.world_from_robot, height_m: t.height_m };
            // A source delivers frames in order of time; one that does not has no truth to compare with.
            truth.push(pose).ok();
        }
    }
    let evaluation = evaluate(&truth, &estimates, &EvaluationOptions::default());
    Ok(Run { evaluation, estimates })
}

/// All frames of a source, to run several algorithms over the same ones.
///
/// # Errors
/// If the source breaks.
pub fn collect(source: &mut dyn Source<SourceFrame>) -> Result<Vec<SourceFrame>, SourceError> {
    std::iter::from_fn(|| source.next_item()).collect()
}

/// Frames from memory.
pub struct Replay<'a>(std::slice::Iter<'a, SourceFrame>);

impl<'a> Replay<'a> {
    /// Plays the frames from the first one.
    pub fn new(frames: &'a [SourceFrame]) -> Self {
        Self(frames.iter())
    }
}

impl Source<SourceFrame> for Replay<'_> {
    fn next_item(&mut self) -> Option<Result<SourceFrame, SourceError>> {
        self.0.next().cloned().map(Ok)
    }
}
