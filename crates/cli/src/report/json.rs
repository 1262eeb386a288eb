//! The numbers of a run. Keys are shared by all commands and stay; what is not known is `null`.

use std::{collections::BTreeMap, path::Path};

use anyhow::{Context, Result};
use serde::Serialize;
use visloc_core::eval::{
    ErrorSummary, Evaluation, EvaluationOptions, KidnapRecovery, TimingSummary, evaluate,
};
use visloc_locate::{CameraMisalignment, vision::DropReason};

use super::{FindingReport, SkippedReport, explain_localization};
use crate::run::{FrameRecord, LiveReport, PixelCounts, RunOutcome, Runner, write_text};

/// How well an algorithm did: the keys that every command shares.
#[derive(Debug, Clone, Serialize, Default)]
pub struct EvaluationReport {
    /// Frames that the algorithm worked on.
    pub frames: usize,
    /// Meters, from the first localization on.
    pub position_error_m: Option<ErrorSummary>,
    /// Degrees, of the same frames.
    pub heading_error_deg: Option<ErrorSummary>,
    /// Meters, of those frames in which the algorithm claims to know where the robot is.
    pub tracking_position_error_m: Option<ErrorSummary>,
    /// Share of the frames on the ground that are localized, 0 to 1.
    pub localized_share: Option<f64>,
    /// From the first frame to the first localization, seconds.
    pub time_to_localize_s: Option<f64>,
    /// What came of every kidnap.
    pub kidnaps: Option<Vec<KidnapRecovery>>,
    /// Image analysis and localizer together, milliseconds a frame.
    pub iteration_ms: Option<TimingSummary>,
    /// Image analysis alone, milliseconds a frame.
    pub analysis_ms: Option<TimingSummary>,
}

impl EvaluationReport {
    /// The report of a comparison.
    pub fn of(evaluation: &Evaluation) -> Self {
        Self {
            frames: evaluation.frames,
            position_error_m: Some(evaluation.position_error_m),
            heading_error_deg: Some(evaluation.heading_error_deg),
            tracking_position_error_m: Some(evaluation.tracking_position_error_m),
            localized_share: evaluation.localized_share,
            time_to_localize_s: evaluation.time_to_localize_s,
            kidnaps: Some(evaluation.kidnaps.clone()),
            iteration_ms: None,
            analysis_ms: None,
        }
    }
}

/// One algorithm on one run.
#[derive(Debug, Clone, Serialize)]
pub struct AlgorithmReport {
    /// Its name.
    pub algorithm: String,
    #[serde(flatten)]
    pub evaluation: EvaluationReport,
    /// Localizer alone, milliseconds a frame.
    pub localizer_ms: TimingSummary,
    /// Particles or exploiters that were weighed, an image.
    pub individuals: Option<IndividualsReport>,
    /// Pixels that looked like lines or goals, over all images.
    pub pixels: PixelReport,
    /// Why nothing, or almost nothing, was localized; empty if enough was.
    pub diagnosis: Vec<FindingReport>,
    /// The comparison in full, for pictures.
    #[serde(skip)]
    pub comparison: Option<Evaluation>,
}

impl AlgorithmReport {
    /// Sums up a runner after its run. Without any truth there is no comparison.
    pub fn new(runner: &Runner, outcome: &RunOutcome) -> Self {
        let records = runner.records();
        let comparison = (!outcome.truth.poses().is_empty()).then(|| {
            let samples: Vec<_> = records.iter().map(FrameRecord::sample).collect();
            evaluate(&outcome.truth, &samples, &EvaluationOptions::default())
        });
        let timing =
            |ms: fn(&FrameRecord) -> f64| TimingSummary::of_ms(&records.iter().map(ms).collect::<Vec<_>>());
        Self {
            algorithm: runner.name().to_owned(),
            evaluation: EvaluationReport {
                frames: records.num_seen(),
                iteration_ms: Some(timing(|record| record.analysis_ms + record.localizer_ms)),
                analysis_ms: Some(timing(|record| record.analysis_ms)),
                ..comparison.as_ref().map(EvaluationReport::of).unwrap_or_default()
            },
            localizer_ms: timing(|record| record.localizer_ms),
            individuals: IndividualsReport::of(records),
            pixels: PixelReport::of(runner.pixels()),
            diagnosis: explain_localization(&runner.counters().diagnosis(), runner.start()),
            comparison,
        }
    }
}

/// How many individuals were weighed, over the images in which there were any.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct IndividualsReport {
    /// In the first such image.
    pub first: usize,
    /// In the middle of all.
    pub median: usize,
    /// On average.
    pub mean: f64,
    /// At most.
    pub max: usize,
}

impl IndividualsReport {
    /// `None` if there never were any.
    pub fn of(records: &[FrameRecord]) -> Option<Self> {
        let mut counts: Vec<usize> = records.iter().map(|r| r.num_individuals).filter(|n| *n > 0).collect();
        let first = *counts.first()?;
        counts.sort_unstable();
        let mean = counts.iter().sum::<usize>() as f64 / counts.len() as f64;
        Some(Self { first, median: counts[counts.len() / 2], mean, max: counts[counts.len() - 1] })
    }
}

/// What became of the pixels.
#[derive(Debug, Clone, Serialize)]
pub struct PixelReport {
    /// Given to the localizer.
    pub kept: u64,
    /// Dropped, by reason.
    pub dropped: BTreeMap<&'static str, u64>,
}

impl PixelReport {
    /// The counts with their names.
    pub fn of(counts: &PixelCounts) -> Self {
        let named = DropReason::ALL.iter().map(|reason| reason.name()).zip(counts.num_dropped);
        Self { kept: counts.num_kept, dropped: named.collect() }
    }
}

/// What `visloc localize --json` writes.
#[derive(Debug, Serialize)]
pub struct LocalizeReport {
    /// The bag or scenario.
    pub source: String,
    /// Name of the map.
    pub map: String,
    /// Seed of everything random.
    pub seed: u64,
    #[serde(flatten)]
    pub algorithm: AlgorithmReport,
    /// From the first to the last frame, seconds.
    pub duration_s: f64,
    /// Frames a second, with reading and decoding.
    pub frames_per_s: f64,
    /// Most memory of the process, megabytes.
    pub peak_memory_mb: Option<f64>,
    /// Processor time of the process until now, seconds.
    pub process_cpu_s: f64,
    /// Images of a live source that came while others were worked on.
    pub dropped: usize,
    /// Live results, if they were published.
    pub live: Option<LiveReport>,
    /// The constant error of the camera's direction, as far as the run has shown it; of several, the first one's.
    pub camera_error: Option<CameraMisalignment>,
    /// The robot's cameras.
    pub cameras: Vec<CameraOfRobot>,
    /// What was left out.
    pub skipped: SkippedReport,
    /// Why the run ended early.
    pub error: Option<String>,
}

/// One of a robot's cameras.
#[derive(Debug, Serialize)]
pub struct CameraOfRobot {
    /// Which one, from 0.
    pub camera: usize,
    /// Images of it that were used.
    pub images: usize,
    /// The constant error of its direction, as far as the run has shown it.
    pub camera_error: Option<CameraMisalignment>,
}

impl CameraOfRobot {
    /// All that took an image.
    pub fn all(runner: &Runner) -> Vec<Self> {
        let error_of = |camera| runner.pipeline().localizer().camera_error_of(camera);
        let images = runner.images_of_camera().iter();
        images.map(|(&camera, &images)| Self { camera, images, camera_error: error_of(camera) }).collect()
    }
}

/// What `visloc demo` writes.
#[derive(Debug, Serialize)]
pub struct DemoReport {
    /// The scenario.
    pub scenario: String,
    /// Name of the map.
    pub map: String,
    /// Seed of everything random.
    pub seed: u64,
    /// From the first to the last frame, seconds.
    pub duration_s: f64,
    /// Time that the run took, seconds.
    pub wall_s: f64,
    /// Every algorithm on the same frames.
    pub algorithms: Vec<AlgorithmReport>,
}

/// What `visloc simulate --json` writes.
#[derive(Debug, Serialize)]
pub struct SimulateReport {
    /// The scenario.
    pub scenario: String,
    /// Name of the map.
    pub map: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Frames in the bag.
    pub frames: usize,
    /// From the first to the last frame, seconds.
    pub duration_s: f64,
    /// The bag.
    pub bag: String,
    /// The truth.
    pub truth: String,
}

/// Writes a report.
pub fn save_json(path: &Path, report: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(report).context("cannot write the numbers as JSON")?;
    write_text(path, &format!("{text}\n"))
}
