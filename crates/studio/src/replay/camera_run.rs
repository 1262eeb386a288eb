//! SLAM on a recording.

use visloc_core::{CameraPose, CameraTrajectory, Clock, geom::Camera};
use visloc_slam::{Slam, SlamFrame};

use crate::{
    StudioError, Update,
    recording::{CameraInput, RecordingIndex},
    slam::{SlamSettings, SlamViewer},
};

/// A system that runs through a recording.
pub(super) struct CameraRun {
    slam: Slam,
    viewer: SlamViewer,
}

impl CameraRun {
    /// A system for the camera of the first frame. The truth of all frames is read first, so that the map is shown in its frame as it was
    /// when it was recorded.
    pub fn start(
        index: &mut RecordingIndex,
        settings: &SlamSettings,
        seed: u64,
        clock: Clock,
    ) -> Result<Self, StudioError> {
        let camera = input(index, 0)?.camera;
        let mut truth = CameraTrajectory::new();
        for frame in 0..index.num_frames() {
            let CameraInput { at, world_from_camera, .. } = input(index, frame)?;
            if let Some(world_from_camera) = world_from_camera {
                // A second truth of the same time tells nothing new.
                let _ = truth.push(CameraPose { at, world_from_camera });
            }
        }
        let truth = (!truth.poses().is_empty()).then_some(truth);
        Ok(Self {
            slam: started(&camera, settings, seed, clock)?,
            viewer: SlamViewer::new(&camera, "", truth, serde_json::json!({})),
        })
    }

    /// Takes in a frame; what is to be seen of it but the picture.
    pub fn step(&mut self, index: &mut RecordingIndex, frame: usize) -> Result<Update, StudioError> {
        let at = input(index, frame)?.at;
        let image = index.camera_image(frame)?.ok_or_else(|| damaged(frame))?;
        let outcome = self
            .slam
            .add_frame(at, image.clone())
            .map_err(|error| StudioError::input("image of the recording", error))?;
        let frame = SlamFrame { at, image: &image, outcome: &outcome };
        self.viewer.follow(&self.slam, &frame);
        self.viewer.moment(&self.slam, &frame, &serde_json::json!({}))?.without_picture()
    }
}

fn started(camera: &Camera, settings: &SlamSettings, seed: u64, clock: Clock) -> Result<Slam, StudioError> {
    let mut slam =
        Slam::new(camera, settings.config(), seed).map_err(|error| StudioError::input("SLAM", error))?;
    slam.set_clock(clock);
    slam.set_packing(visloc_vmap::packing());
    Ok(slam)
}

fn input(index: &mut RecordingIndex, frame: usize) -> Result<CameraInput, StudioError> {
    index.camera_input(frame)?.ok_or_else(|| damaged(frame))
}

fn damaged(frame: usize) -> StudioError {
    StudioError::input("recording", format!("the input of frame {frame} is damaged"))
}
