//! Shows a camera in a map of SLAM to a recording and to pages, and does what people there ask for.

use anyhow::Result;
use serde_json::json;
use visloc_core::{CameraPose, CameraTrajectory, GrayFrame, geom::Camera};
use visloc_io::sequence::write_camera_trajectory;
use visloc_slam::SlamConfig;
use visloc_studio::{
    Command, StudioError,
    recording::Input,
    slam::{MapViewer, SlamSettings},
};
use visloc_vmap::{MapLocalizer, VisualMap};

use super::{
    broadcast::{Broadcast, new_saved_file},
    steering::Steering,
};
use crate::args::BroadcastArgs;

/// Shows each frame to others.
pub struct MapShow {
    broadcast: Broadcast,
    title: String,
    settings: SlamSettings,
    seed: u64,
    /// From the first frame on, with its camera.
    viewer: Option<(MapViewer, Camera)>,
    way: CameraTrajectory,
}

impl MapShow {
    /// Shows a run to whom the user asks for; `None` if to nobody.
    ///
    /// # Errors
    /// If the file cannot be created or nobody can listen at the address.
    pub fn open(
        args: &BroadcastArgs,
        steering: Option<&Steering>,
        title: &str,
        config: &SlamConfig,
        seed: u64,
    ) -> Result<Option<Self>> {
        if args.record.is_none() && args.publish.is_none() {
            return Ok(None);
        }
        Ok(Some(Self {
            broadcast: Broadcast::open(args, steering)?,
            title: title.to_owned(),
            settings: SlamSettings::of(config)?,
            seed,
            viewer: None,
            way: CameraTrajectory::new(),
        }))
    }

    /// What people ask for; parameters and seed if the camera is to be looked for anew.
    pub fn obey(&mut self) -> Option<(SlamConfig, u64)> {
        let mut is_new = false;
        for command in self.broadcast.commands() {
            match self.take(&command) {
                Ok(is_restart) => is_new |= is_restart,
                Err(error) => self.broadcast.tell(&format!("{error:#}")),
            }
        }
        is_new.then(|| (self.settings.config().clone(), self.seed))
    }

    /// Whether the camera is to be looked for anew.
    fn take(&mut self, command: &Command) -> Result<bool> {
        match command {
            Command::Save {} => {
                let path = new_saved_file("trajectory", "tum")?;
                write_camera_trajectory(&path, self.way.poses())?;
                self.broadcast.tell(&format!("saved on the robot: {}", path.display()));
                return Ok(false);
            }
            Command::Reset { seed } => self.seed = *seed,
            Command::Forget {} => {}
            command => match self.settings.changed(command)? {
                Some(settings) => self.settings = settings,
                None => {
                    return Err(StudioError::Command {
                        what: "command".to_owned(),
                        expected: "one for a run: parameters, reset, save, pause".to_owned(),
                        found: command.name(),
                    }
                    .into());
                }
            },
        }
        let fields = self.fields()?;
        if let Some((viewer, _)) = &mut self.viewer {
            viewer.start_anew(fields);
        }
        self.broadcast.tell("the camera's place is forgotten");
        Ok(true)
    }

    /// Shows a frame, if anybody wants to see it.
    pub fn look(
        &mut self,
        (map, truth): (&VisualMap, Option<&CameraTrajectory>),
        localizer: &MapLocalizer,
        frame: &GrayFrame,
        camera: &Camera,
    ) {
        self.broadcast.rest();
        if let Err(error) = self.show((map, truth), localizer, frame, camera) {
            self.broadcast.fail(error);
        }
    }

    fn show(
        &mut self,
        (map, truth): (&VisualMap, Option<&CameraTrajectory>),
        localizer: &MapLocalizer,
        frame: &GrayFrame,
        camera: &Camera,
    ) -> Result<()> {
        if self.viewer.is_none() {
            let viewer = MapViewer::new(camera, &self.title, map, truth.cloned(), self.fields()?);
            self.viewer = Some((viewer, *camera));
        }
        let Some((viewer, camera)) = &mut self.viewer else { return Ok(()) };
        viewer.follow(localizer, frame);
        if let Some(estimate) = localizer.estimate().filter(|estimate| estimate.is_localized()) {
            let world_from_camera = estimate.world_from_camera;
            let _ = self.way.push(CameraPose { at: frame.at, world_from_camera });
        }
        let secs = viewer.secs(frame.at);
        self.broadcast.wait_for(secs);
        if !self.broadcast.is_wanted() {
            return Ok(());
        }
        let Some(moment) = viewer.moment(localizer, frame, &self.broadcast.aside())? else { return Ok(()) };
        let world_from_camera = viewer.world_from_camera(frame.at);
        let input = Input::Camera { at: frame.at, image: &frame.image, camera, world_from_camera };
        self.broadcast.send(secs, || moment.update(None), &input);
        Ok(())
    }

    /// What the scene message has besides.
    fn fields(&self) -> Result<serde_json::Value> {
        let mut fields = self.settings.scene_fields_in_map()?;
        let scenes = json!([{ "id": "run", "group": "Run", "label": self.title }]);
        let own = json!({ "mode": "watch", "scene": "run", "scenes": scenes, "seed": self.seed });
        if let (Some(fields), Some(own)) = (fields.as_object_mut(), own.as_object()) {
            fields.extend(own.clone());
        }
        Ok(fields)
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// If anything went wrong on the way.
    pub fn finish(self) -> Result<()> {
        self.broadcast.finish()
    }
}
