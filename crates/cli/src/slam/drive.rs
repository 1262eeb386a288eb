//! The loop over the images.

use anyhow::Result;
use visloc_base::{CameraPose, CameraTrajectory, ImageSource, SkippedInput};
use visloc_slam::{Clock, Slam, SlamConfig};

use super::{FramePictures, SlamRecord};
use crate::{run::Progress, stopwatch::thread_cpu_secs};

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
    seed: u64,
    mut pictures: Option<&mut FramePictures>,
) -> Result<SlamRun> {
    let mut slam = Slam::new(source.camera(), config, seed)?;
    slam.set_clock(Clock::new(thread_cpu_secs));
    let progress = Progress::new(source.num_images());
    let (mut records, mut refused, mut error) = (Vec::new(), Vec::new(), None);
    while let Some(next) = source.next_image() {
        let frame = match next {
            Ok(frame) => frame,
            Err(broken) => {
                error = Some(broken.to_string());
                break;
            }
        };
        let kept = pictures.as_ref().map(|_| frame.image.clone());
        match slam.add_frame(frame.at, frame.image) {
            Ok(outcome) => {
                if let (Some(pictures), Some(image)) = (pictures.as_deref_mut(), kept) {
                    pictures.look(records.len(), &image, &outcome)?;
                }
                records.push(SlamRecord::new(frame.at, &outcome));
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
    let mut trajectory = CameraTrajectory::new();
    for pose in slam.trajectory() {
        let _ = trajectory.push(CameraPose { at: pose.at, world_from_camera: pose.world_from_camera });
    }
    let skipped: Vec<SkippedInput> = source.skipped().iter().cloned().chain(refused).collect();
    let num_images = source.num_images().unwrap_or(records.len() + skipped.len());
    Ok(SlamRun { slam, records, trajectory, num_images, skipped, error })
}
