//! Shows a run to a recording and to pages, and does what people there ask for.

use anyhow::Result;
use visloc_core::{CameraPose, CameraTrajectory, geom::Camera};
use visloc_io::sequence::write_camera_trajectory;
use visloc_slam::{Slam, SlamConfig, SlamFrame};
use visloc_studio::{recording::Input, slam::SlamViewer};

use super::{
    broadcast::{Broadcast, new_saved_file},
    steered::{Asked, Steered},
    steering::Steering,
};
use crate::{
    args::SlamArgs,
    slam::{SlamAudience, write_ply},
};

/// Shows each frame to others.
struct SlamShow {
    broadcast: Broadcast,
    viewer: SlamViewer,
    camera: Camera,
    truth: Option<CameraTrajectory>,
    run: Steered,
}

/// Shows a run of a camera, with the truth if that is known, to whom the user asks for; `None` if to nobody.
pub fn open_slam_show(
    args: &SlamArgs,
    steering: Option<&Steering>,
    config: &SlamConfig,
    camera: &Camera,
    truth: Option<&CameraTrajectory>,
) -> Result<Option<Box<dyn SlamAudience>>> {
    let Some(broadcast) = Broadcast::open(&args.broadcast, steering)? else { return Ok(None) };
    let run = Steered::new(&args.source, config, args.seed.value(), false)?;
    let viewer = SlamViewer::new(camera, &args.source, truth.cloned(), run.fields()?);
    Ok(Some(Box::new(SlamShow { broadcast, viewer, camera: *camera, truth: truth.cloned(), run })))
}

impl SlamAudience for SlamShow {
    fn look(&mut self, slam: &Slam, frame: &SlamFrame<'_>) {
        self.broadcast.rest();
        self.viewer.follow(slam, frame);
        let secs = self.viewer.secs(frame.at);
        self.broadcast.wait_for(secs);
        if !self.broadcast.is_wanted() {
            return;
        }
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
        let Self { broadcast, viewer, truth, run, .. } = self;
        run.obey(broadcast, |broadcast, asked| {
            match asked {
                Asked::Save => broadcast.tell(&save(slam)?),
                Asked::Anew(fields) => {
                    // Numbers of frames go on, so that a recording has one course.
                    viewer.start_anew(truth.clone(), fields);
                    broadcast.tell("the run begins anew: the map is forgotten");
                }
            }
            Ok(())
        })
    }

    fn finish(self: Box<Self>) -> Result<()> {
        self.broadcast.finish()
    }
}

/// Saves map and way; what to tell of it.
fn save(slam: &Slam) -> Result<String> {
    let (map, way) = (new_saved_file("map", "ply")?, new_saved_file("trajectory", "tum")?);
    write_ply(&map, slam.map(), slam.camera(), "map units")?;
    let mut trajectory = CameraTrajectory::new();
    for pose in slam.trajectory() {
        let _ = trajectory.push(CameraPose { at: pose.at, world_from_camera: pose.world_from_camera });
    }
    write_camera_trajectory(&way, trajectory.poses(), false)?;
    Ok(format!("saved on the robot: {}, {}", map.display(), way.display()))
}
