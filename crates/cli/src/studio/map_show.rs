//! Shows a camera in a map of SLAM to a recording and to pages, and does what people there ask for.

use anyhow::Result;
use visloc_core::{CameraPose, CameraTrajectory, GrayFrame, geom::Camera};
use visloc_io::sequence::write_camera_trajectory;
use visloc_slam::SlamConfig;
use visloc_studio::{recording::Input, slam::MapViewer};
use visloc_vmap::{MapLocalizer, VisualMap};

use super::{
    broadcast::{Broadcast, new_saved_file},
    steered::{Asked, Steered},
    steering::Steering,
};
use crate::args::BroadcastArgs;

/// Shows each frame to others.
pub struct MapShow {
    broadcast: Broadcast,
    run: Steered,
    /// From the first frame on, with its camera.
    viewer: Option<(MapViewer, Camera)>,
    way: CameraTrajectory,
}

impl MapShow {
    /// Shows a run to whom the user asks for; `None` if to nobody.
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
            run: Steered::new(title, config, seed, true)?,
            viewer: None,
            way: CameraTrajectory::new(),
        }))
    }

    /// What people ask for; parameters and seed if the camera is to be looked for anew.
    pub fn obey(&mut self) -> Option<(SlamConfig, u64)> {
        let Self { broadcast, run, viewer, way } = self;
        run.obey(broadcast, |broadcast, asked| {
            match asked {
                Asked::Save => {
                    let path = new_saved_file("trajectory", "tum")?;
                    write_camera_trajectory(&path, way.poses(), false)?;
                    broadcast.tell(&format!("saved on the robot: {}", path.display()));
                }
                Asked::Anew(fields) => {
                    if let Some((viewer, _)) = viewer {
                        viewer.start_anew(fields);
                    }
                    broadcast.tell("the camera's place is forgotten");
                }
            }
            Ok(())
        })
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
            let viewer = MapViewer::new(camera, &self.run.title, map, truth.cloned(), self.run.fields()?);
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

    /// Ends the recording.
    pub fn finish(self) -> Result<()> {
        self.broadcast.finish()
    }
}
