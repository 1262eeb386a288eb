//! One run over one sequence.

use serde::{Deserialize, Serialize};
use visloc_core::{
    CameraPose, CameraTrajectory, Clock, GrayImage, ImageSource, Timestamp,
    eval::camera::{Alignment, Statistics, absolute_error, associate, relative_error},
};
use visloc_slam::{FrameOutcome, FramePose, Slam, SlamConfig, TrackingState, track::Quality};

use crate::mean;

/// Times that belong together differ by no more than this, seconds.
const TOLERANCE_SECS: f64 = 0.01;
/// Below this mean gray level the camera is covered.
const COVERED_LEVEL: f64 = 12.0;
/// Points of a path that are kept at most, for pictures.
const MAX_POINTS: usize = 400;
/// Parts of the thesis' stages. What is not here goes by its own name.
const STAGES: [(&str, &str); 7] = [
    ("pyramid", "start frame"),
    ("image alignment", "align image"),
    ("local map", "align points"),
    ("projection", "align points"),
    ("matching", "align points"),
    ("pose", "adjust pose"),
    ("link points", "update points"),
];

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
    /// The position errors in all.
    #[serde(default)]
    pub ate: Option<Statistics>,
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
    /// Tracking and mapping in all, over the images of `tracking_ms`.
    #[serde(default)]
    pub tracking: Option<Statistics>,
    /// See [`SlamRunRecord::tracking`].
    #[serde(default)]
    pub mapping: Option<Statistics>,
    /// Stages of tracking, and of the mapping of keyframes, over the images in which they happened.
    #[serde(default)]
    pub stages: Vec<(String, Statistics)>,
    /// Seconds from the first image, tracking and mapping of some images: of several in a row the longest.
    #[serde(default)]
    pub image_ms: Vec<[f64; 3]>,
    /// How often the camera was lost.
    pub num_lost: usize,
    /// For each time it was covered: seconds from the first image that shows something until there was a pose again; `None`
    /// if there was none to the end.
    pub found_after_secs: Vec<Option<f64>>,
    /// Some poses, aligned with the truth: seconds from the first image, x, y, z and position error. Without a truth in map units
    /// with the error 0.
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
    while let Some(frame) = source.next_item() {
        let frame = frame.map_err(|error| error.to_string())?;
        let is_covered = mean_level(&frame.image) < COVERED_LEVEL;
        // A refused image counts as one without a pose.
        if let Ok(outcome) = slam.add_frame(frame.at, frame.image) {
            watch.look(frame.at, is_covered, &outcome);
        }
    }
    slam.complete();
    let mut trajectory = CameraTrajectory::new();
    for pose in slam.trajectory() {
        let _ = trajectory.push(CameraPose { at: pose.at, world_from_camera: pose.world_from_camera });
    }
    let num_frames = source.status().num_items.unwrap_or(slam.frames().len());
    let mut record = watch.record();
    record.num_frames = num_frames;
    record.coverage = trajectory.poses().len() as f64 / num_frames.max(1) as f64;
    match truth {
        Some(truth) => compare(truth, &trajectory, slam.frames(), &mut record),
        None => record.path = path(&trajectory, slam.frames()),
    }
    Ok(record)
}

fn mean_level(image: &GrayImage) -> f64 {
    let sum: u64 = image.data().iter().map(|level| u64::from(*level)).sum();
    sum as f64 / image.data().len().max(1) as f64
}

/// Every how many of so many points are kept.
fn step(num: usize) -> usize {
    num.div_ceil(MAX_POINTS).max(1)
}

/// Whether an image's point is kept: the same images in all runs.
fn is_kept(at: Timestamp, frames: &[FramePose]) -> bool {
    frames.partition_point(|frame| frame.at < at) % step(frames.len()) == 0
}

fn place(pose: &CameraPose) -> [f64; 3] {
    let t = pose.world_from_camera.translation();
    [t.x, t.y, t.z]
}

/// The path where there is no truth.
fn path(trajectory: &CameraTrajectory, frames: &[FramePose]) -> Vec<[f64; 5]> {
    let start = frames.first().map(|frame| frame.at).unwrap_or_default();
    let kept = trajectory.poses().iter().filter(|pose| is_kept(pose.at, frames));
    kept.map(|pose| {
        let [x, y, z] = place(pose);
        [pose.at.secs_since(start), x, y, z, 0.0]
    })
    .collect()
}

/// Errors against the truth.
fn compare(
    truth: &CameraTrajectory,
    estimate: &CameraTrajectory,
    frames: &[FramePose],
    record: &mut SlamRunRecord,
) {
    let start = frames.first().map(|frame| frame.at).unwrap_or_default();
    record.true_path = truth.poses().iter().step_by(step(truth.poses().len())).map(place).collect();
    let pairs = associate(truth, estimate, TOLERANCE_SECS);
    let Some(error) = absolute_error(&pairs, Alignment::Similarity) else { return };
    let offset = |i: usize| {
        let moved = error.similarity.place(pairs[i].estimate.world_from_camera.translation()).coords;
        moved - pairs[i].truth.world_from_camera.translation()
    };
    let jumps = (1..pairs.len()).map(|i| (offset(i) - offset(i - 1)).norm());
    record.ate_rmse_m = Some(error.statistics.rmse);
    record.ate = Some(error.statistics);
    record.ate_max_m = Some(error.statistics.max);
    record.jump_m = jumps.max_by(f64::total_cmp);
    let relative = relative_error(&pairs, 1, &error.similarity);
    record.rpe_rot_deg = relative.map(|relative| relative.rotation_rmse_rad.to_degrees());
    let kept = pairs.iter().zip(&error.each).filter(|(pair, _)| is_kept(pair.estimate.at, frames));
    record.path = kept
        .map(|(pair, error_m)| {
            let p = error.similarity.place(pair.estimate.world_from_camera.translation());
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
    stages: Vec<(String, Vec<f64>)>,
    start: Option<Timestamp>,
    image_ms: Vec<[f64; 3]>,
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
        let tracking_ms = outcome.tracking.total_secs() * 1e3;
        let start = *self.start.get_or_insert(at);
        self.image_ms.push([at.secs_since(start), tracking_ms, mapping_ms]);
        if is_tracked && !outcome.is_relocalized {
            self.tracking_ms.push(tracking_ms);
            self.mapping_ms.push(mapping_ms);
            self.add_stages(outcome.tracking.stages(), "tracking in all");
        }
        for mapped in outcome.mapped.iter().filter(|mapped| mapped.report.keyframe.is_some()) {
            self.keyframe_ms.push(mapped.times.total_secs() * 1e3);
            self.add_stages(mapped.times.stages(), "keyframe in all");
        }
        if is_lost || outcome.is_relocalized {
            self.relocalization_ms.push(tracking_ms);
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

    /// Adds the stages of an image, and their sum.
    fn add_stages(&mut self, stages: &[(&'static str, f64)], sum: &'static str) {
        let total: f64 = stages.iter().map(|stage| stage.1).sum();
        let mut of_image: Vec<(&str, f64)> = Vec::new();
        for (part, secs) in stages {
            let name = STAGES.iter().find(|stage| stage.0 == *part).map_or(*part, |stage| stage.1);
            match of_image.iter_mut().find(|stage| stage.0 == name) {
                Some(stage) => stage.1 += secs,
                None => of_image.push((name, *secs)),
            }
        }
        for (name, secs) in of_image.into_iter().chain([(sum, total)]) {
            match self.stages.iter_mut().find(|stage| stage.0 == name) {
                Some(stage) => stage.1.push(secs * 1e3),
                None => self.stages.push((name.to_owned(), vec![secs * 1e3])),
            }
        }
    }

    fn record(self) -> SlamRunRecord {
        let mut found_after_secs = self.found_after_secs;
        found_after_secs.extend(self.seeing_since.map(|_| None));
        SlamRunRecord {
            tracking_ms: mean(&self.tracking_ms),
            mapping_ms: mean(&self.mapping_ms),
            keyframe_ms: mean(&self.keyframe_ms).zip(max(&self.keyframe_ms)),
            relocalization_ms: mean(&self.relocalization_ms).zip(max(&self.relocalization_ms)),
            tracking: Statistics::of(&self.tracking_ms),
            mapping: Statistics::of(&self.mapping_ms),
            stages: self
                .stages
                .into_iter()
                .filter_map(|(name, ms)| Some((name, Statistics::of(&ms)?)))
                .collect(),
            image_ms: thinned(&self.image_ms),
            num_lost: self.num_lost,
            found_after_secs,
            ..SlamRunRecord::default()
        }
    }
}

/// Of several images in a row the longest times.
fn thinned(image_ms: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let longest = |images: &[[f64; 3]]| {
        let of = |i: usize| images.iter().map(|image| image[i]).fold(0.0, f64::max);
        [images[0][0], of(1), of(2)]
    };
    image_ms.chunks(step(image_ms.len())).map(longest).collect()
}

pub(super) fn max(values: &[f64]) -> Option<f64> {
    values.iter().copied().max_by(f64::total_cmp)
}
