//! How long an iteration takes. Not part of the records, which are the same on every machine.

use visloc_core::{RngTree, Source, eval::TimingSummary, geom::PlanarPose};
use visloc_locate::{Pipeline, PipelineConfig};
use visloc_sim::Simulation;

use super::{RobocupExperiment, RobocupSet, RunLength, track::Contender};
use crate::{ExperimentError, likelihood::Eye};

/// Time of an algorithm for a frame, with the image analysis.
#[derive(Debug, Clone, PartialEq)]
pub struct AlgorithmTiming {
    /// Name of the contender.
    pub algorithm: String,
    /// Milliseconds.
    pub iteration_ms: TimingSummary,
}

/// Frames that are measured: 20 s.
const NUM_FRAMES: usize = 600;
/// Every frame is measured in so many equal passes, and the fastest counts: other programs only ever slow it down.
const NUM_PASSES: usize = 3;

/// Poses of which the likelihood is measured in each frame.
const NUM_POSES: u32 = 100;

/// Measures every contender on the first frames of a tour, one after the other on this thread. `clock_ms` tells the time
/// in milliseconds.
///
/// # Errors
/// If the tour cannot be simulated or there is no such algorithm.
pub fn measure(
    experiment: &RobocupExperiment,
    seed: u64,
    clock_ms: &mut dyn FnMut() -> f64,
) -> Result<Vec<AlgorithmTiming>, ExperimentError> {
    let contenders = experiment.contenders(RobocupSet::Tours);
    let mut fastest_ms = vec![vec![f64::INFINITY; NUM_FRAMES]; contenders.len()];
    for _ in 0..NUM_PASSES {
        pass(&contenders, seed, clock_ms, &mut fastest_ms)?;
    }
    let timing = |(contender, durations_ms): (&Contender, Vec<f64>)| AlgorithmTiming {
        algorithm: contender.label.clone(),
        iteration_ms: TimingSummary::of_ms(&durations_ms),
    };
    let mut timings: Vec<AlgorithmTiming> = contenders.iter().zip(fastest_ms).map(timing).collect();
    timings.extend(parts(seed, clock_ms)?);
    Ok(timings)
}

/// The image analysis, and the likelihood of one pose.
fn parts(seed: u64, clock_ms: &mut dyn FnMut() -> f64) -> Result<[AlgorithmTiming; 2], ExperimentError> {
    let (mut simulation, seeds) = tour(seed)?;
    let mut eye = Eye::new(simulation.map(), &PipelineConfig::with_color_table(), seeds.subtree("parts", 0))?;
    let (mut analysis_ms, mut pose_ms) = (Vec::new(), Vec::new());
    while let Some(next) = simulation.next_item() {
        let next = next.map_err(|error| failed(error.to_string()))?;
        let Some(truth) = next.truth else { continue };
        let start = clock_ms();
        eye.look(&next.frame)?;
        analysis_ms.push(clock_ms() - start);
        let start = clock_ms();
        let poses = (0..NUM_POSES).map(|i| PlanarPose { x_m: 0.01 * f64::from(i), ..truth.world_from_robot });
        let sum: f64 = poses.map(|pose| eye.model().likelihood(&pose)).sum();
        std::hint::black_box(sum);
        pose_ms.push((clock_ms() - start) / f64::from(NUM_POSES));
    }
    let timing = |name: &str, durations_ms: &[f64]| AlgorithmTiming {
        algorithm: name.to_owned(),
        iteration_ms: TimingSummary::of_ms(durations_ms),
    };
    Ok([timing("image analysis", &analysis_ms), timing("observation model, one pose", &pose_ms)])
}

fn failed(reason: String) -> ExperimentError {
    ExperimentError::Run { cell: "timing".to_owned(), run: 0, reason }
}

/// The first frames of a tour.
fn tour(seed: u64) -> Result<(Simulation, RngTree), ExperimentError> {
    let seeds = RngTree::new(seed);
    let simulation = RobocupSet::Tours.simulation(RunLength::FULL, 0, &seeds);
    let (simulation, _) = simulation.map_err(|error| failed(error.to_string()))?;
    Ok((simulation.with_num_frames(NUM_FRAMES), seeds))
}

/// One pass over all frames; keeps the smaller durations.
fn pass(
    contenders: &[Contender],
    seed: u64,
    clock_ms: &mut dyn FnMut() -> f64,
    fastest_ms: &mut [Vec<f64>],
) -> Result<(), ExperimentError> {
    let (mut simulation, seeds) = tour(seed)?;
    let rng = seeds.subtree("pipeline", 0);
    let mut pipelines = Vec::new();
    for contender in contenders {
        let config = PipelineConfig { features: contender.features, ..PipelineConfig::default() };
        let pipeline = Pipeline::builder(simulation.map())
            .named(&contender.algorithm, None)
            .config(config)
            .rng(rng)
            .build();
        pipelines.push(pipeline.map_err(|error| failed(error.to_string()))?);
    }
    for index in 0..NUM_FRAMES {
        let Some(next) = simulation.next_item() else { break };
        let frame = next.map_err(|error| failed(error.to_string()))?.frame;
        for (pipeline, fastest_ms) in pipelines.iter_mut().zip(&mut *fastest_ms) {
            let start = clock_ms();
            if pipeline.step(&frame).is_ok() {
                fastest_ms[index] = fastest_ms[index].min(clock_ms() - start);
            }
        }
    }
    Ok(())
}
