//! The loop over the images.

use anyhow::Result;
use visloc_core::{
    CameraPose, CameraTrajectory, Clock, GrayImage, ImageSource, SkippedInput, Timestamp, geom::Camera,
};
use visloc_slam::{
    FrameOutcome, Schedule, Slam, SlamConfig, SlamFrame,
    diagnosis::{RunCounters, mean_brightness},
    map::{Map, MapId},
    odometry::MetricScale,
};
use visloc_vmap::{VisualMap, packing};

use super::{FramePictures, Pace, SlamHistory};
use crate::{host::host, run::Progress, stopwatch::thread_cpu_secs};

/// Most unusable images of which the reason is kept.
const MOST_REFUSED: usize = 10_000;

/// How to run.
#[derive(Debug, Clone, Copy, Default)]
pub struct RunOptions<'a> {
    /// Seed of everything random.
    pub seed: u64,
    /// When tracking and mapping run.
    pub schedule: Schedule,
    /// Whether frames come at their stamps, and those are dropped that wait too long for tracking.
    pub is_realtime: bool,
    /// Most frames that are remembered one by one; `None` remembers all.
    pub most_records: Option<usize>,
    /// Maps of an earlier run to go on in.
    pub maps: Option<&'a Map>,
    /// Whether they stay as they are.
    pub is_fixed: bool,
    /// Whether there is no bar that shows how far it is.
    pub is_quiet: bool,
}

impl Restart {
    fn maps(self) -> Option<Box<Map>> {
        match self {
            Self::Anew => None,
            Self::In(maps) => Some(maps),
        }
    }
}

/// A finished run.
pub struct SlamRun {
    /// The system with its map.
    pub slam: Slam,
    /// What became of each image that could be used.
    pub history: SlamHistory,
    /// What stood in the way of poses.
    pub counters: RunCounters,
    /// Final poses in the map that has most of them.
    pub trajectory: CameraTrajectory,
    /// Final poses of each map, the one with most of them first: those of different maps have nothing to do with each other.
    pub maps: Vec<MapWay>,
    /// The map that has most of the poses.
    pub map: Map,
    /// Where the camera really was, if the source said so with its images.
    pub truth: Option<CameraTrajectory>,
    /// Images of the sequence, unusable ones included.
    pub num_images: usize,
    /// Images that came while tracking was busy; 0 unless live or in real time.
    pub num_dropped: usize,
    /// What was left out.
    pub skipped: Vec<SkippedInput>,
    /// Why the source stopped early.
    pub error: Option<String>,
}

/// The camera's way in one map.
pub struct MapWay {
    /// The map.
    pub map: MapId,
    /// Final poses.
    pub trajectory: CameraTrajectory,
    /// How many of them were found afterwards.
    pub num_filled_in: usize,
    /// How many of them odometry carried on, since the image told nothing.
    pub num_carried: usize,
    /// Its unit of length by odometry: its lengths are meters.
    pub scale: Option<MetricScale>,
}

/// Somebody who looks on while SLAM runs.
pub trait SlamWatcher {
    /// Called after every image that could be used.
    fn after_frame(&mut self, at: Timestamp, outcome: &FrameOutcome, slam: &Slam);

    /// Whether to begin again before the next image, and how. Asking settles it.
    fn takes_restart(&mut self) -> Option<Restart>;

    /// What the last map began with, and how long its unit is, meters, if somebody has said it.
    fn finish(self: Box<Self>) -> (Option<VisualMap>, Option<(MapId, f64)>);
}

/// How a run begins again.
#[cfg_attr(not(feature = "ros2"), expect(dead_code, reason = "only services of ROS 2 ask for it"))]
pub enum Restart {
    /// As it began; what it has made is forgotten.
    Anew,
    /// In other maps.
    In(Box<Map>),
}

/// Those to whom a run is shown, and who may ask for other parameters.
pub trait SlamAudience {
    /// What they ask for; parameters and seed if the run is to begin anew.
    fn obey(&mut self, slam: &Slam) -> Option<(SlamConfig, u64)>;

    /// Shows a frame, if anybody wants to see it.
    fn look(&mut self, slam: &Slam, frame: &SlamFrame<'_>);

    /// Ends the recording.
    fn finish(self: Box<Self>) -> Result<()>;
}

/// All who look on while SLAM runs.
#[derive(Default)]
pub struct Lookers<'a> {
    /// Draws some of the images.
    pub pictures: Option<&'a mut FramePictures>,
    /// Publishes live topics.
    pub watcher: Option<&'a mut dyn SlamWatcher>,
    /// Records for the studio, or sends to it.
    pub show: Option<&'a mut dyn SlamAudience>,
}

impl Lookers<'_> {
    /// Shows an image, of which number and time are given, to all of them.
    fn look(
        &mut self,
        slam: &Slam,
        (number, at): (usize, Timestamp),
        image: Option<&GrayImage>,
        outcome: &FrameOutcome,
    ) {
        if let (Some(pictures), Some(image)) = (self.pictures.as_deref_mut(), image) {
            pictures.look(number, image, outcome);
        }
        if let (Some(show), Some(image)) = (self.show.as_deref_mut(), image) {
            show.look(slam, &SlamFrame { at, image, outcome });
        }
        if let Some(watcher) = self.watcher.as_deref_mut() {
            watcher.after_frame(at, outcome, slam);
        }
    }
}

/// Runs over all images of a source.
pub fn run(
    source: &mut dyn ImageSource,
    config: &SlamConfig,
    options: RunOptions<'_>,
    mut lookers: Lookers<'_>,
) -> Result<SlamRun> {
    let (mut config, mut seed) = (config.clone(), options.seed);
    let mut slam = start(source.camera(), &config, seed, &options)?;
    // Maps that somebody wants to go on in, and frames of maps that were forgotten on demand.
    let (mut loaded, mut num_before) = (None::<Box<Map>>, 0);
    let progress =
        if options.is_quiet { Progress::hidden() } else { Progress::new(source.status().num_items) };
    let mut history = SlamHistory::new(options.most_records);
    let (mut refused, mut error, mut num_dropped) = (Vec::new(), None, 0);
    let mut pace = options.is_realtime.then(Pace::start);
    let mut counters = RunCounters::default();
    let mut truth = CameraTrajectory::new();
    while let Some(next) = source.next_item() {
        let frame = match next {
            Ok(frame) => frame,
            Err(broken) => {
                error = Some(broken.to_string());
                break;
            }
        };
        if pace.as_mut().is_some_and(|pace| !pace.wait_for(frame.at)) {
            num_dropped += 1;
            continue;
        }
        let restart = lookers.watcher.as_deref_mut().and_then(SlamWatcher::takes_restart);
        let wished = lookers.show.as_deref_mut().and_then(|show| show.obey(&slam));
        let is_new = restart.is_some() || wished.is_some();
        // Somebody who watches has other parameters or another seed in mind.
        (config, seed) = wished.unwrap_or((config, seed));
        if is_new {
            loaded = restart.and_then(Restart::maps).or(loaded);
            let maps = loaded.as_deref().or(options.maps);
            history.add_mapped(num_before, &slam.finish());
            slam = start(source.camera(), &config, seed, &RunOptions { maps, ..options })?;
            num_before = history.records.num_seen();
        }
        let is_shown = lookers.pictures.is_some() || lookers.show.is_some();
        let kept = is_shown.then(|| frame.image.clone());
        let brightness = mean_brightness(&frame.image);
        if let Some(world_from_camera) = frame.truth {
            // Times that do not increase are refused below.
            let _ = truth.push(CameraPose { at: frame.at, world_from_camera });
        }
        match slam.add_frame_of_robot(frame.at, frame.image, frame.odom_from_camera) {
            Ok(outcome) => {
                counters.count(frame.at, brightness, &outcome);
                lookers.look(&slam, (history.records.num_seen(), frame.at), kept.as_ref(), &outcome);
                history.add(frame.at, &outcome);
                history.add_mapped(num_before, &outcome.mapped);
            }
            Err(reason) => {
                counters.count_unusable();
                if refused.len() < MOST_REFUSED {
                    let (at, origin) = (Some(frame.at), "images".to_owned());
                    refused.push(SkippedInput { at, origin, reason: reason.to_string() });
                }
            }
        }
        progress.advance();
    }
    progress.clear();
    history.add_mapped(num_before, &slam.complete());
    let maps = ways_by_map(&slam);
    let trajectory = maps.first().map(|way| way.trajectory.clone()).unwrap_or_default();
    let map = slam.map().with_active(maps.first().map_or(slam.map().active(), |way| way.map));
    let skipped: Vec<SkippedInput> = source.status().skipped.iter().cloned().chain(refused).collect();
    num_dropped += source.status().num_dropped;
    let num_came = history.records.num_seen() + num_images_of(&skipped) + num_dropped;
    // Of a run that was ended by hand only the images that came; those that were left out before the first one count, too.
    let num_items = source.status().num_items.filter(|_| !host().was_interrupted());
    let num_images = num_items.unwrap_or(num_came).max(num_came);
    let truth = (!truth.poses().is_empty()).then_some(truth);
    Ok(SlamRun {
        slam,
        history,
        counters,
        trajectory,
        maps,
        map,
        truth,
        num_images,
        num_dropped,
        skipped,
        error,
    })
}

/// How much of what was left out is images: what has no time is a line of a list that names none.
fn num_images_of(skipped: &[SkippedInput]) -> usize {
    skipped.iter().filter(|image| image.at.is_some()).count()
}

/// A system that is as the options say.
fn start(camera: &Camera, config: &SlamConfig, seed: u64, options: &RunOptions<'_>) -> Result<Slam> {
    let mut slam = match options.maps {
        Some(maps) if options.is_fixed => Slam::in_fixed_map(maps.clone(), camera, config, seed)?,
        Some(maps) => Slam::resume(maps.clone(), camera, config, seed, options.schedule)?,
        None => Slam::with_schedule(camera, config, seed, options.schedule)?,
    };
    slam.set_clock(Clock::new(thread_cpu_secs));
    slam.set_packing(packing());
    if let Some(most) = options.most_records {
        slam.remember_frames(most);
    }
    Ok(slam)
}

/// The final poses by map, most poses first.
fn ways_by_map(slam: &Slam) -> Vec<MapWay> {
    let mut ways: Vec<MapWay> = Vec::new();
    for pose in slam.trajectory() {
        let known = ways.iter().position(|way| way.map == pose.map);
        let index = known.unwrap_or(ways.len());
        if known.is_none() {
            ways.push(MapWay {
                map: pose.map,
                trajectory: CameraTrajectory::new(),
                num_filled_in: 0,
                num_carried: 0,
                scale: slam.metric_scale(pose.map),
            });
        }
        ways[index].num_filled_in += usize::from(pose.is_filled_in);
        ways[index].num_carried += usize::from(pose.is_carried);
        let pose = CameraPose { at: pose.at, world_from_camera: pose.world_from_camera };
        let _ = ways[index].trajectory.push(pose);
    }
    ways.sort_by_key(|way| (std::cmp::Reverse(way.trajectory.poses().len()), way.map));
    ways
}
