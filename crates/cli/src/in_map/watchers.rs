//! Who looks on while a camera is found in a map: live topics, a bag, a recording, and pages.

use anyhow::{Result, bail};
use visloc_core::CameraTrajectory;
use visloc_io::{bag::ResultFrames, sources::SourceOptions};
use visloc_slam::SlamConfig;
use visloc_vmap::{MapLocalizer, VisualMap};

use super::{
    frames::{MapFrame, MapFrames},
    live::MapLive,
    results::result_sample,
};
use crate::{
    args::LocalizeArgs,
    run::{BagOutput, Saving},
    say,
    studio::{MapShow, Steering},
};

/// Frame of a camera that is on no robot, unless it has a name.
const CAMERA_FRAME: &str = "camera_optical";

/// Where a camera is to be looked for anew.
#[cfg_attr(not(feature = "ros2"), allow(dead_code, reason = "only services of ROS 2 ask for it"))]
pub enum MapWish {
    /// In the same map.
    Anew,
    /// In another one.
    In(Box<VisualMap>),
}

/// All who look on.
pub struct Watchers {
    live: Option<MapLive>,
    bag_out: Option<BagOutput>,
    show: Option<MapShow>,
}

impl Watchers {
    /// Opens what the user asks for; topics also if the source is one itself.
    pub fn open(
        args: &LocalizeArgs,
        steering: Option<&Steering>,
        options: &SourceOptions,
        (config, map): (&SlamConfig, &VisualMap),
        frames: &MapFrames,
    ) -> Result<Self> {
        let topics = options.topics.names();
        let camera = || topics.camera_frame.clone().unwrap_or_else(|| CAMERA_FRAME.to_owned());
        let base = if frames.has_robot() { topics.base_frame.clone() } else { camera() };
        let is_live = args.source.starts_with("ros2:") && !args.no_publish_ros;
        let is_asked_for = args.publish_ros || args.publish_map;
        let open_live = || {
            let named = (args.map.as_deref().unwrap_or_default(), args.publish_map.then_some(map));
            MapLive::open(options.domain_id(), ResultFrames { base, ..ResultFrames::default() }, named)
        };
        if args.bag_out.is_some() && !frames.has_robot() {
            bail!(
                "--bag-out: expected a source with a robot, found {}, which is a camera alone",
                args.source
            );
        }
        Ok(Self {
            live: (is_asked_for || is_live).then(open_live).transpose()?,
            bag_out: args.bag_out.as_deref().map(|path| BagOutput::create(path, &topics)).transpose()?,
            show: MapShow::open(&args.broadcast, steering, &args.source, config, args.seed.value())?,
        })
    }

    /// Takes in what they ask for.
    pub fn take_wishes(&mut self, config: &mut SlamConfig, seed: &mut u64) -> Option<MapWish> {
        let wish = self.live.as_mut().and_then(MapLive::take_wish);
        let Some(wished) = self.show.as_mut().and_then(MapShow::obey) else { return wish };
        (*config, *seed) = wished;
        wish.or(Some(MapWish::Anew))
    }

    /// Shows a frame to all of them.
    pub fn look(
        &mut self,
        (map, truth): (&VisualMap, Option<&CameraTrajectory>),
        localizer: &MapLocalizer,
        frame: &MapFrame,
        num_dropped: usize,
    ) {
        // First, so that a pose waits for nothing.
        if let Some(live) = &mut self.live {
            live.look(localizer, frame, num_dropped);
        }
        if let (Some(bag_out), Some((robot, truth))) = (&mut self.bag_out, &frame.robot) {
            let (estimate, hypotheses) = (localizer.estimate(), localizer.hypotheses());
            let sample = result_sample(frame, estimate, &hypotheses, num_dropped);
            bag_out.add(robot, truth.as_ref(), Some(&sample));
        }
        if let Some(show) = &mut self.show {
            show.look((map, truth), localizer, &frame.gray, &frame.camera);
        }
    }

    /// Says what did not arrive.
    pub fn print(&self) {
        let num_unsent = self.live.as_ref().map_or(0, MapLive::num_unsent);
        if num_unsent > 0 {
            say::line!("  {num_unsent} messages could not be sent: a subscriber is too slow");
        }
    }

    /// Completes what they write.
    pub fn finish(self, saving: &mut Saving) {
        saving.save_if(self.bag_out, BagOutput::finish);
        saving.save_if(self.show, MapShow::finish);
    }
}
