//! Shows a run to a recording and to pages, and does what people there ask for.

use anyhow::Result;
use serde_json::json;
use visloc_core::{CameraPose, CameraTrajectory, geom::Camera};
use visloc_io::sequence::write_camera_trajectory;
use visloc_slam::{Slam, SlamConfig, SlamFrame};
use visloc_studio::{
    Command, StudioError,
    recording::Input,
    slam::{SlamSettings, SlamViewer},
};

use super::{
    broadcast::{Broadcast, new_saved_file},
    steering::Steering,
};
use crate::{
    args::BroadcastArgs,
    slam::{SlamAudience, write_ply},
};

/// What is shown of a run.
pub struct Shown<'a> {
    /// Name of the source.
    pub title: &'a str,
    /// The camera.
    pub camera: &'a Camera,
    /// Where the camera was, if that is known.
    pub truth: Option<&'a CameraTrajectory>,
    /// Parameters.
    pub config: &'a SlamConfig,
    /// Seed of everything random.
    pub seed: u64,
}

/// Shows each frame to others.
pub struct SlamShow {
    broadcast: Broadcast,
    viewer: SlamViewer,
    camera: Camera,
    title: String,
    truth: Option<CameraTrajectory>,
    settings: SlamSettings,
    seed: u64,
}

impl SlamShow {
    /// Shows a run of a camera to whom the user asks for; `None` if to nobody.
    ///
    /// # Errors
    /// If the file cannot be created or nobody can listen at the address.
    pub fn open(
        args: &BroadcastArgs,
        steering: Option<&Steering>,
        shown: &Shown<'_>,
    ) -> Result<Option<Self>> {
        if args.record.is_none() && args.publish.is_none() {
            return Ok(None);
        }
        let broadcast = Broadcast::open(args, steering)?;
        let Shown { title, camera, truth, config, seed } = *shown;
        let settings = SlamSettings::of(config)?;
        let viewer = viewer(title, camera, truth, &settings, seed)?;
        Ok(Some(Self {
            broadcast,
            viewer,
            camera: *camera,
            title: title.to_owned(),
            truth: truth.cloned(),
            settings,
            seed,
        }))
    }

    /// Whether the run is to begin anew.
    fn take(&mut self, command: &Command, slam: &Slam) -> Result<bool> {
        match command {
            Command::Save {} => {
                self.save(slam)?;
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
        // Numbers of frames go on, so that a recording has one course.
        let fields = fields(&self.title, &self.settings, self.seed)?;
        self.viewer.start_anew(self.truth.clone(), fields);
        self.broadcast.tell("the run begins anew: the map is forgotten");
        Ok(true)
    }

    fn save(&mut self, slam: &Slam) -> Result<()> {
        let (map, way) = (new_saved_file("map", "ply")?, new_saved_file("trajectory", "tum")?);
        write_ply(&map, slam.map(), slam.camera())?;
        let mut trajectory = CameraTrajectory::new();
        for pose in slam.trajectory() {
            let _ = trajectory.push(CameraPose { at: pose.at, world_from_camera: pose.world_from_camera });
        }
        write_camera_trajectory(&way, trajectory.poses())?;
        self.broadcast.tell(&format!("saved on the robot: {}, {}", map.display(), way.display()));
        Ok(())
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// If anything went wrong on the way.
    pub fn finish(self) -> Result<()> {
        self.broadcast.finish()
    }
}

impl SlamAudience for SlamShow {
    fn look(&mut self, slam: &Slam, frame: &SlamFrame<'_>) {
        self.broadcast.rest();
        self.viewer.follow(slam, frame);
        if !self.broadcast.is_wanted() {
            return;
        }
        let secs = self.viewer.secs(frame.at);
        let world_from_camera = self.viewer.world_from_camera(frame.at).copied();
        let input = Input::Camera {
            at: frame.at,
            image: frame.image,
            camera: &self.camera,
            world_from_camera: world_from_camera.as_ref(),
        };
        match self.viewer.moment(slam, frame, &self.broadcast.aside()) {
            Ok(moment) => self.broadcast.send(secs, || moment.update(None), &input),
            Err(error) => self.broadcast.fail(error.into()),
        }
    }

    fn obey(&mut self, slam: &Slam) -> Option<(SlamConfig, u64)> {
        let mut is_new = false;
        for command in self.broadcast.commands() {
            match self.take(&command, slam) {
                Ok(is_restart) => is_new |= is_restart,
                Err(error) => self.broadcast.tell(&format!("{error:#}")),
            }
        }
        is_new.then(|| (self.settings.config().clone(), self.seed))
    }
}

fn viewer(
    title: &str,
    camera: &Camera,
    truth: Option<&CameraTrajectory>,
    settings: &SlamSettings,
    seed: u64,
) -> Result<SlamViewer> {
    Ok(SlamViewer::new(camera, title, truth.cloned(), fields(title, settings, seed)?))
}

/// What the scene message has besides.
fn fields(title: &str, settings: &SlamSettings, seed: u64) -> Result<serde_json::Value> {
    let mut fields = settings.scene_fields()?;
    let scenes = json!([{ "id": "run", "group": "Run", "label": title }]);
    let own = json!({ "mode": "watch", "scene": "run", "scenes": scenes, "seed": seed });
    if let (Some(fields), Some(own)) = (fields.as_object_mut(), own.as_object()) {
        fields.extend(own.clone());
    }
    Ok(fields)
}
