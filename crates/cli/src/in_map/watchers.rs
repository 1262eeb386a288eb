//! Who looks on while a camera is found in a map: live topics, a bag, a recording, and pages.

use anyhow::{Result, bail};
use visloc_io::{bag::ResultFrames, sources::SourceOptions};
use visloc_slam::SlamConfig;
use visloc_vmap::VisualMap;

use super::{frames::MapFrames, live::open_map_live, results::result_sample};
use crate::{
    args::LocalizeArgs,
    run::{BagOutput, Saving},
    say,
    slam::{MapView, MapWatcher, MapWish},
    studio::{Steering, open_map_show},
};

/// Frame of a camera that is on no robot, unless it has a name.
const CAMERA_FRAME: &str = "camera_optical";

impl MapWatcher for BagOutput {
    fn look(&mut self, view: &MapView<'_>) {
        let Some((robot, truth)) = &view.frame.robot else { return };
        let (estimate, hypotheses) = (view.localizer.estimate(), view.localizer.hypotheses());
        let sample = result_sample(view.frame, estimate, &hypotheses, view.num_dropped);
        self.add(robot, truth.as_ref(), Some(&sample));
    }

    fn finish(self: Box<Self>) -> Result<()> {
        Self::finish(*self)
    }
}

/// All who look on, live topics first, so that a pose waits for nothing.
pub struct Watchers(Vec<Box<dyn MapWatcher>>);

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
        if args.bag_out.is_some() && !frames.has_robot() {
            bail!(
                "--bag-out: expected a source with a robot, found {}, which is a camera alone",
                args.source
            );
        }
        let mut all = Vec::new();
        if args.publish_ros || args.publish_map || is_live {
            let named = (args.map.as_deref().unwrap_or_default(), args.publish_map.then_some(map));
            let frames = ResultFrames { base, ..ResultFrames::default() };
            all.push(open_map_live(options.domain_id(), frames, named)?);
        }
        if let Some(path) = args.bag_out.as_deref() {
            all.push(Box::new(BagOutput::create(path, &topics)?));
        }
        all.extend(open_map_show(args, steering, config)?);
        Ok(Self(all))
    }

    /// Takes in what they ask for; the first wish counts.
    pub fn take_wishes(&mut self, config: &mut SlamConfig, seed: &mut u64) -> Option<MapWish> {
        let mut wish = None;
        for watcher in &mut self.0 {
            let own = watcher.take_wish(config, seed);
            wish = wish.or(own);
        }
        wish
    }

    /// Shows a frame to all of them.
    pub fn look(&mut self, view: &MapView<'_>) {
        self.0.iter_mut().for_each(|watcher| watcher.look(view));
    }

    /// Says what did not arrive.
    pub fn print(&self) {
        let num_unsent: usize = self.0.iter().map(|watcher| watcher.num_unsent()).sum();
        if num_unsent > 0 {
            say::line!("  {num_unsent} messages could not be sent: a subscriber is too slow");
        }
    }

    /// Completes what they write.
    pub fn finish(self, saving: &mut Saving) {
        self.0.into_iter().for_each(|watcher| saving.save(watcher.finish()));
    }
}
