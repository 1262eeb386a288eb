//! One run over one sequence.

use serde::{Deserialize, Serialize};
use visloc_base::{CameraPose, CameraTrajectory, GrayImage, ImageSource, Timestamp};
use visloc_eval::camera::{Alignment, absolute_error, associate, relative_error};
use visloc_slam::{Clock, FrameOutcome, Slam, SlamConfig, TrackingState, track::Quality};

/// Times that belong together differ by no more than this, seconds.
const TOLERANCE_SECS: f64 = 0.01;
/// Below this mean gray level the camera is covered.
const COVERED_LEVEL: f64 = 12.0;
/// Points of a path that are kept at most, for pictures.
const MAX_POINTS: usize = 400;

/// What one run found. Lengths in meters, angles in degrees, times of stages in milliseconds; `None` where there is no truth or
/// nothing of the kind happened.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SlamRunRecord {
    /// Images of the sequence.
    pub num_frames: usize,
    /// Share of the images with a pose.
    pub coverage: f64,
    /// Root mean square of the position error after alignment with scale.
    pub ate_rmse_m: Option<f64>,
    /// Largest position error.
    pub ate_max_m: Option<f64>,
    /// Largest change of the position error from one pose to the next: a jump.
    pub jump_m: Option<f64>,
    /// Rotation error from frame to frame, root mean square.
    pub rpe_rot_deg: Option<f64>,
    /// Time for an image that is tracked, mean.
    pub tracking_ms: Option<f64>,
    /// Time for the mapping of an image, keyframe or not, mean.
    pub mapping_ms: Option<f64>,
    /// Time for the mapping of a keyframe, mean and largest.
    pub keyframe_ms: Option<(f64, f64)>,
    /// Time for an attempt to find the place again, mean and largest.
    pub relocalization_ms: Option<(f64, f64)>,
    /// Stages of tracking and mapping, mean over the images in which they happened.
    pub stages_ms: Vec<(String, f64)>,
    /// How often the camera was lost.
    pub num_lost: usize,
    /// For each time it was covered: seconds from the first image that shows something until there was a pose again; `None`
    /// if there was none to the end.
    pub found_after_secs: Vec<Option<f64>>,
    /// Some poses, aligned with the truth: seconds from the first image, x, y, z and position error.
    pub path: Vec<[f64; 5]>,
    /// Some true positions.
    pub true_path: Vec<[f64; 3]>,
}

/// Follows the camera through a sequence.
pub(super) fn follow(
    source: &mut dyn ImageSource,
    truth: Option<&CameraTrajectory>,
    config: &SlamConfig,
    seed: u64,
    clock: Clock,
) -> Result<SlamRunRecord, String> {
    let mut slam = Slam::new(source.camera(), config, seed).map_err(|error| error.to_string())?;
    slam.set_clock(clock);
    let mut watch = Watch::default();
    while let Some(frame) = source.next_image() {
        let frame = frame.map_err(|error| error.to_string())?;
        let is_covered = mean_level(&frame.image) < COVERED_LEVEL;
        // A refused image counts as one without a pose.
        if let Ok(outcome) = slam.add_frame(frame.at, frame.image) {
            watch.look(frame.at, is_covered, &outcome);
        }
    }
    let mut trajectory = CameraTrajectory::new();
    for pose in slam.trajectory() {
        let _ = trajectory.push(CameraPose { at: pose.at, world_from_camera: pose.world_from_camera });
    }
    let num_frames = source.num_images().unwrap_or(slam.frames().len());
    let mut record = watch.record();
    record.num_frames = num_frames;
    record.coverage = trajectory.poses().len() as f64 / num_frames.max(1) as f64;
    if let Some(truth) = truth {
        compare(truth, &trajectory, slam.frames().first().map(|frame| frame.at), &mut record);
    }
    Ok(record)
}

fn mean_level(image: &GrayImage) -> f64 {
    let sum: u64 = image.data().iter().map(|level| u64::from(*level)).sum();
    sum as f64 / image.data().len().max(1) as f64
}

/// Errors against the truth.
fn compare(
    truth: &CameraTrajectory,
    estimate: &CameraTrajectory,
    start: Option<Timestamp>,
    record: &mut SlamRunRecord,
) {
    let start = start.unwrap_or_default();
    let thinned = |n: usize| n.div_ceil(MAX_POINTS).max(1);
    let place = |pose: &CameraPose| {
        let t = pose.world_from_camera.translation();
        [t.x, t.y, t.z]
    };
    record.true_path = truth.poses().iter().step_by(thinned(truth.poses().len())).map(place).collect();
    let pairs = associate(truth, estimate, TOLERANCE_SECS);
    let Some(error) = absolute_error(&pairs, Alignment::Similarity) else { return };
    let offset = |i: usize| {
        let moved = error.similarity.apply(pairs[i].estimate.world_from_camera.translation()).coords;
        moved - pairs[i].truth.world_from_camera.translation()
    };
    let jumps = (1..pairs.len()).map(|i| (offset(i) - offset(i - 1)).norm());
    record.ate_rmse_m = Some(error.rmse);
    record.ate_max_m = Some(error.max);
    record.jump_m = jumps.max_by(f64::total_cmp);
    let relative = relative_error(&pairs, 1, &error.similarity);
    record.rpe_rot_deg = relative.map(|relative| relative.rotation_rmse_rad.to_degrees());
    let kept = pairs.iter().zip(&error.each).step_by(thinned(pairs.len()));
    record.path = kept
        .map(|(pair, error_m)| {
            let p = error.similarity.apply(pair.estimate.world_from_camera.translation());
            [pair.estimate.at.secs_since(start), p.x, p.y, p.z, *error_m]
        })
        .collect();
}

/// What is noted frame by frame.
#[derive(Debug, Default)]
struct Watch {
    tracking_ms: Vec<f64>,
    mapping_ms: Vec<f64>,
    keyframe_ms: Vec<f64>,
    relocalization_ms: Vec<f64>,
    stages: Vec<(String, f64, f64)>,
    num_lost: usize,
    was_lost: bool,
    was_covered: bool,
    seeing_since: Option<Timestamp>,
    found_after_secs: Vec<Option<f64>>,
}

impl Watch {
    fn look(&mut self, at: Timestamp, is_covered: bool, outcome: &FrameOutcome) {
        let is_tracked = matches!(outcome.state, TrackingState::Tracking(q) if q != Quality::Bad);
        let is_lost = outcome.state == TrackingState::Lost;
        let mapping_ms = outcome.mapped.iter().map(|mapped| mapped.times.total_secs()).sum::<f64>() * 1e3;
        if is_tracked && !outcome.is_relocalized {
            self.tracking_ms.push(outcome.tracking.total_secs() * 1e3);
            self.mapping_ms.push(mapping_ms);
        }
        if outcome.mapped.iter().any(|mapped| mapped.report.keyframe.is_some()) {
            self.keyframe_ms.push(mapping_ms);
        }
        if is_lost || outcome.is_relocalized {
            self.relocalization_ms.push(outcome.tracking.total_secs() * 1e3);
        }
        let mapping = outcome.mapped.iter().flat_map(|mapped| mapped.times.stages());
        for (name, secs) in outcome.tracking.stages().iter().chain(mapping) {
            match self.stages.iter_mut().find(|stage| stage.0 == *name) {
                Some(stage) => (stage.1, stage.2) = (stage.1 + secs * 1e3, stage.2 + 1.0),
                None => self.stages.push(((*name).to_owned(), secs * 1e3, 1.0)),
            }
        }
        self.num_lost += usize::from(is_lost && !self.was_lost);
        self.was_lost = is_lost;
        if self.was_covered && !is_covered {
            self.seeing_since = Some(at);
        }
        if let Some(since) = self.seeing_since.filter(|_| is_tracked) {
            self.found_after_secs.push(Some(at.secs_since(since)));
            self.seeing_since = None;
        }
        self.was_covered = is_covered;
    }

    fn record(self) -> SlamRunRecord {
        let mut found_after_secs = self.found_after_secs;
        found_after_secs.extend(self.seeing_since.map(|_| None));
        SlamRunRecord {
            tracking_ms: mean(&self.tracking_ms),
            mapping_ms: mean(&self.mapping_ms),
            keyframe_ms: mean(&self.keyframe_ms).zip(max(&self.keyframe_ms)),
            relocalization_ms: mean(&self.relocalization_ms).zip(max(&self.relocalization_ms)),
            stages_ms: self.stages.into_iter().map(|(name, sum, count)| (name, sum / count)).collect(),
            num_lost: self.num_lost,
            found_after_secs,
            ..SlamRunRecord::default()
        }
    }
}

pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

pub(super) fn max(values: &[f64]) -> Option<f64> {
    values.iter().copied().max_by(f64::total_cmp)
}
