//! Shows a run to a recording and to pages.

use anyhow::Result;
use serde_json::json;
use visloc_base::CameraTrajectory;
use visloc_geom::Camera;
use visloc_slam::Slam;
use visloc_studio::{
    recording::Input,
    slam::{SlamFrame, SlamViewer},
};

use crate::broadcast::Broadcast;

/// Shows each frame to others.
pub struct SlamShow {
    broadcast: Broadcast,
    viewer: SlamViewer,
    camera: Camera,
}

impl SlamShow {
    /// Shows a run of a camera.
    pub fn new(broadcast: Broadcast, camera: &Camera, title: &str, truth: Option<CameraTrajectory>) -> Self {
        let scenes = json!([{ "id": "run", "group": "Run", "label": title }]);
        let more = json!({ "scene": "run", "scenes": scenes });
        Self { broadcast, viewer: SlamViewer::new(camera, title, truth, more), camera: *camera }
    }

    /// Takes in a frame, and shows it if anybody wants to see it.
    pub fn look(&mut self, slam: &Slam, frame: &SlamFrame<'_>) {
        self.viewer.follow(slam, frame);
        if !self.broadcast.is_wanted() {
            return;
        }
        let secs = self.viewer.secs(frame.at);
        let update = self.viewer.update(slam, frame, &self.broadcast.aside());
        let input = Input::Camera { at: frame.at, image: frame.image, camera: &self.camera };
        self.broadcast.send(update.map(|update| (update, secs)), &input);
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// If anything went wrong on the way.
    pub fn finish(self) -> Result<()> {
        self.broadcast.finish()
    }
}
