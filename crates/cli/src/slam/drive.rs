//! The loop over the images.

use anyhow::Result;
use visloc_base::{CameraPose, CameraTrajectory, ImageSource, SkippedInput};
use visloc_slam::{Clock, Schedule, Slam, SlamConfig};

use visloc_studio::slam::SlamFrame;

use super::{FramePictures, Pace, SlamRecord, SlamShow};
use crate::{run::Progress, stopwatch::thread_cpu_secs};

/// How to run.
#[derive(Debug, Clone, Copy, Default)]
pub struct RunOptions {
    /// Seed of everything random.
    pub seed: u64,
    /// When tracking and mapping run.
    pub schedule: Schedule,
    /// Whether frames come at their stamps, and those are dropped for which tracking has no time.
    pub is_realtime: bool,
}

/// A finished run.
pub struct SlamRun {
    /// The system with its map.
    pub slam: Slam,
    /// One entry for each image that could be used.
    pub records: Vec<SlamRecord>,
    /// Final poses.
    pub trajectory: CameraTrajectory,
    /// Images of the sequence, unusable ones included.
    pub num_images: usize,
    /// Images that came while tracking was busy; 0 unless in real time.
    pub num_dropped: usize,
    /// What was left out.
    pub skipped: Vec<SkippedInput>,
    /// Why the source stopped early.
    pub error: Option<String>,
}

/// Runs over all images of a source.
///
/// # Errors
/// If a parameter is out of range. What is wrong with the images is part of the result.
pub fn run(
    source: &mut dyn ImageSource,
    config: &SlamConfig,
    options: RunOptions,
    mut pictures: Option<&mut FramePictures>,
    mut show: Option<&mut SlamShow>,
) -> Result<SlamRun> {
    let mut slam = Slam::with_schedule(source.camera(), config, options.seed, options.schedule)?;
    slam.set_clock(Clock::new(thread_cpu_secs));
    let progress = Progress::new(source.num_images());
    let (mut records, mut refused, mut error) = (Vec::new(), Vec::new(), None);
    let mut pace = options.is_realtime.then(Pace::start);
    let mut num_dropped = 0;
    while let Some(next) = source.next_image() {
        let frame = match next {
            Ok(frame) => frame,
            Err(broken) => {
                error = Some(broken.to_string());
                break;
            }
        };
        if pace.as_mut().is_some_and(|pace| !pace.wait_for(frame.at)) {
            num_dropped += 1;
            continue;
        }
        let is_shown = pictures.is_some() || show.is_some();
        let kept = is_shown.then(|| frame.image.clone());
        match slam.add_frame(frame.at, frame.image) {
            Ok(outcome) => {
                if let (Some(pictures), Some(image)) = (pictures.as_deref_mut(), &kept) {
                    pictures.look(records.len(), image, &outcome)?;
                }
                if let (Some(show), Some(image)) = (show.as_deref_mut(), &kept) {
                    show.look(&slam, &SlamFrame { at: frame.at, image, outcome: &outcome });
                }
                records.push(SlamRecord::new(frame.at, &outcome));
                SlamRecord::add_mapped(&mut records, outcome.mapped);
            }
            Err(reason) => refused.push(SkippedInput {
                at: Some(frame.at),
                origin: "images".to_owned(),
                reason: reason.to_string(),
            }),
        }
        progress.advance();
    }
    progress.clear();
    SlamRecord::add_mapped(&mut records, slam.finish());
    let mut trajectory = CameraTrajectory::new();
    for pose in slam.trajectory() {
        let _ = trajectory.push(CameraPose { at: pose.at, world_from_camera: pose.world_from_camera });
    }
    let skipped: Vec<SkippedInput> = source.skipped().iter().cloned().chain(refused).collect();
    let num_images = source.num_images().unwrap_or(records.len() + skipped.len() + num_dropped);
    Ok(SlamRun { slam, records, trajectory, num_images, num_dropped, skipped, error })
}
