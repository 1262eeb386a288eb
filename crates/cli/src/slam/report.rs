//! The numbers of a run. Keys stay as they are; what is not known is `null`.

use serde::Serialize;
use visloc_core::{
    CameraTrajectory,
    eval::camera::{AbsoluteError, Alignment, absolute_error, associate, relative_error},
    mean, quantile,
};

use super::{MapWay, SlamHistory, SlamRun, StageSums};
use crate::{
    report::{FindingReport, explain_tracking},
    stopwatch::{peak_memory_mb, process_cpu_secs},
};

/// Largest difference of stamps that belong together, seconds.
pub const POSE_TOLERANCE_SECS: f64 = 0.01;

/// All numbers of a run.
#[derive(Debug, Clone, Serialize)]
pub struct SlamReport {
    /// Images of the sequence.
    pub frames: usize,
    /// Poses in the final trajectory that an image told.
    pub tracked: usize,
    /// Poses beside that odometry carried on.
    pub carried: usize,
    /// Share of the frames with a pose, 0 to 1.
    pub coverage: f64,
    /// From the first image to the first map, seconds.
    pub initialized_at_s: Option<f64>,
    /// How often the camera was lost.
    pub lost_spells: usize,
    /// How often it was found again.
    pub relocalizations: usize,
    /// Keyframes in the map at the end.
    pub keyframes: usize,
    /// Landmarks in the map at the end.
    pub points: usize,
    /// What the map adds to the first radial coefficient of the calibration.
    pub lens_change: f64,
    /// From the exposure of the left border of an image to that of the right one, and from the upper to the lower, seconds, as the map tells it.
    pub readout_s: [f64; 2],
    /// Loops that were closed.
    pub loops: usize,
    /// Maps that were joined to others.
    pub joins: usize,
    /// The maps at the end, the one with most poses first.
    pub maps: Vec<MapReport>,
    /// Absolute trajectory error after alignment with scale, meters; of the map with most poses.
    pub ate_m: Option<AteReport>,
    /// Rotation error from frame to frame, root mean square, degrees.
    pub rpe_rot_deg: Option<f64>,
    /// Translation error from frame to frame, root mean square, meters.
    pub rpe_trans_m: Option<f64>,
    /// Tracking, milliseconds of processor time a frame.
    pub tracking_ms: TimesReport,
    /// Mapping, milliseconds of processor time a keyframe.
    pub mapping_ms: TimesReport,
    /// Most memory of the process, megabytes.
    pub peak_memory_mb: Option<f64>,
    /// Processor time of the process until now, seconds.
    pub process_cpu_s: f64,
    /// Inputs that were left out.
    pub skipped: usize,
    /// Images that came while tracking was busy; only in real time.
    pub dropped: usize,
    /// Tracked frames that mapping had no time for; only with threads.
    pub unmapped: usize,
    /// Why too little was tracked; empty if enough was.
    pub diagnosis: Vec<FindingReport>,
}

/// One map.
#[derive(Debug, Clone, Serialize)]
pub struct MapReport {
    /// Its number, in order of the starts.
    pub map: usize,
    /// Poses in it.
    pub poses: usize,
    /// Of those, found afterwards: by the start of the map.
    pub filled_in: usize,
    /// Of those, carried on by odometry.
    pub carried: usize,
    /// Where its unit of length comes from; `null`: it is not known.
    pub scale: Option<ScaleReport>,
    /// Root of the mean square of the trajectory error after alignment with scale, meters.
    pub ate_rmse_m: Option<f64>,
}

/// Where the unit of length of a map comes from. Its lengths are meters then.
#[derive(Debug, Clone, Serialize)]
pub struct ScaleReport {
    /// `odometry`.
    pub source: &'static str,
    /// Way that was compared, meters.
    pub way_m: f64,
    /// Relative standard deviation; an error that the odometry has all the time comes on top of it.
    pub deviation: f64,
}

impl MapReport {
    fn new(way: &MapWay, truth: Option<&CameraTrajectory>) -> Self {
        let pairs = truth.map(|truth| associate(truth, &way.trajectory, POSE_TOLERANCE_SECS));
        let error = pairs.and_then(|pairs| absolute_error(&pairs, Alignment::Similarity));
        Self {
            map: way.map.index(),
            poses: way.trajectory.poses().len(),
            filled_in: way.num_filled_in,
            carried: way.num_carried,
            scale: way.scale.map(|scale| ScaleReport {
                source: "odometry",
                way_m: scale.way_m,
                deviation: scale.deviation,
            }),
            ate_rmse_m: error.map(|error| error.statistics.rmse),
        }
    }
}

/// Absolute trajectory error, meters.
#[derive(Debug, Clone, Serialize)]
pub struct AteReport {
    /// Root of the mean square.
    pub rmse: f64,
    /// Mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// Largest.
    pub max: f64,
    /// Meters for each map unit.
    pub scale: f64,
}

/// Times, milliseconds.
#[derive(Debug, Clone, Default, Serialize)]
pub struct TimesReport {
    /// Mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// Value below which 95 % lie.
    pub p95: f64,
    /// Largest.
    pub max: f64,
    /// Mean of each stage over all these frames.
    pub stages: Vec<(String, f64)>,
}

impl SlamReport {
    /// Of a run, compared with the truth if that is known.
    pub fn new(run: &SlamRun, truth: Option<&CameraTrajectory>) -> (Self, Option<AbsoluteError>) {
        let pairs =
            truth.map(|truth| associate(truth, &run.trajectory, POSE_TOLERANCE_SECS)).unwrap_or_default();
        let error = absolute_error(&pairs, Alignment::Similarity);
        let relative = error.as_ref().and_then(|error| relative_error(&pairs, 1, &error.similarity));
        let SlamHistory { records, tracking, mapping, .. } = &run.history;
        let carried = run.maps.iter().map(|way| way.num_carried).sum();
        let tracked = if run.slam.has_forgotten_frames() {
            run.history.num_tracked
        } else {
            run.maps.iter().map(|way| way.trajectory.poses().len()).sum::<usize>() - carried
        };
        let start = records.first().map(|record| record.at);
        let first = run.history.first_tracked_at;
        let map = &run.map;
        let keyframe_secs = records.iter().filter(|r| r.is_keyframe).map(|r| r.mapping_secs);
        let tracking_secs = records.iter().filter(|r| r.is_tracked()).map(|r| r.tracking_secs);
        let coverage = tracked as f64 / run.num_images.max(1) as f64;
        let report = Self {
            frames: run.num_images,
            tracked,
            carried,
            coverage,
            initialized_at_s: start.zip(first).map(|(start, first)| first.secs_since(start)),
            // Who was never found was not lost either.
            lost_spells: first.map_or(0, |_| run.history.num_lost_spells),
            relocalizations: run.history.num_relocalized,
            keyframes: map.keyframes().count(),
            lens_change: run.slam.lens_change(),
            readout_s: run.slam.readout().0.into(),
            points: map.landmarks().filter(|(_, landmark)| landmark.is_converged()).count(),
            loops: run.history.num_loops,
            joins: run.history.num_joins,
            maps: run.maps.iter().map(|way| MapReport::new(way, truth)).collect(),
            ate_m: error.as_ref().map(|error| AteReport {
                rmse: error.statistics.rmse,
                mean: error.statistics.mean,
                median: error.statistics.median,
                max: error.statistics.max,
                scale: error.similarity.scale,
            }),
            rpe_rot_deg: relative.map(|r| r.rotation_rmse_rad.to_degrees()),
            rpe_trans_m: relative.map(|r| r.translation_rmse),
            tracking_ms: TimesReport::new(tracking_secs, tracking),
            mapping_ms: TimesReport::new(keyframe_secs, mapping),
            peak_memory_mb: peak_memory_mb(),
            process_cpu_s: process_cpu_secs(),
            skipped: run.skipped.len(),
            dropped: run.num_dropped,
            unmapped: run.slam.num_left_out(),
            diagnosis: explain_tracking(&run.counters.diagnosis(coverage)),
        };
        (report, error)
    }
}

impl TimesReport {
    fn new(secs: impl Iterator<Item = f64>, stages: &StageSums) -> Self {
        let mut totals: Vec<f64> = secs.map(|secs| secs * 1e3).collect();
        totals.sort_by(f64::total_cmp);
        let Some(max) = totals.last().copied() else { return Self::default() };
        let [median, p95] = [0.5, 0.95].map(|share| quantile(&totals, share).unwrap_or(max));
        Self { mean: mean(&totals).unwrap_or(max), median, p95, max, stages: stages.means_ms() }
    }
}
