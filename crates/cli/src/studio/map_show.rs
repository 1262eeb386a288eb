//! Shows a camera in a map of SLAM to a recording and to pages, and does what people there ask for.

use anyhow::Result;
use visloc_core::{CameraPose, CameraTrajectory, geom::Camera};
use visloc_io::sequence::write_camera_trajectory;
use visloc_slam::SlamConfig;
use visloc_studio::{recording::Input, slam::MapViewer};

use super::{
    broadcast::{Broadcast, new_saved_file},
    steered::{Asked, Steered},
    steering::Steering,
};
use crate::{
    args::LocalizeArgs,
    slam::{MapFrame, MapView, MapWatcher, MapWish},
};

/// Shows each frame to others.
struct MapShow {
    broadcast: Broadcast,
    run: Steered,
    /// From the first frame on, with its camera.
    viewer: Option<(MapViewer, Camera)>,
    way: CameraTrajectory,
}

/// Shows a run to whom the user asks for; `None` if to nobody.
pub fn open_map_show(
    args: &LocalizeArgs,
    steering: Option<&Steering>,
    config: &SlamConfig,
) -> Result<Option<Box<dyn MapWatcher>>> {
    let Some(broadcast) = Broadcast::open(&args.broadcast, steering)? else { return Ok(None) };
    let run = Steered::new(&args.source, config, args.seed.value(), true)?;
    Ok(Some(Box::new(MapShow { broadcast, run, viewer: None, way: CameraTrajectory::new() })))
}

impl MapWatcher for MapShow {
    fn take_wish(&mut self, config: &mut SlamConfig, seed: &mut u64) -> Option<MapWish> {
        let Self { broadcast, run, viewer, way } = self;
        let wished = run.obey(broadcast, |broadcast, asked| {
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
        });
        (*config, *seed) = wished?;
        Some(MapWish::Anew)
    }

    fn look(&mut self, view: &MapView<'_>) {
        self.broadcast.rest();
        if let Err(error) = self.show(view) {
            self.broadcast.fail(error);
        }
    }

    fn finish(self: Box<Self>) -> Result<()> {
        self.broadcast.finish()
    }
}

impl MapShow {
    /// Shows a frame, if anybody wants to see it.
    fn show(&mut self, view: &MapView<'_>) -> Result<()> {
        let &MapView { map, truth, localizer, frame: MapFrame { gray: frame, camera, .. }, .. } = view;
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
}
