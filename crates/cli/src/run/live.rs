//! Results as live ROS 2 topics, and orders from there.

use anyhow::Result;
use visloc_core::{OccupancyGrid, Timestamp, eval::TimingSummary, geom::PlanarPose};
use visloc_io::{
    bag::{ResultFrames, ResultMessages},
    ros2::{Middleware, NodeSettings, Order, PublishSettings, ResultPublisher, occupancy_grid},
    sources::SourceOptions,
};
use visloc_locate::{PosePrior, StartPrior};
use visloc_world::Map;

use super::{FrameView, LiveReport, Records, Runner, Spectator, TeamOutput, results::sample_of};
use crate::{
    args::LocalizeArgs,
    host::{host, now},
};

/// Transforms are stamped so far after their image: programs that steer ask for the pose of now.
pub const TF_AHEAD_SECS: f64 = 0.2;

/// Publishes what the first runner says, and does what other programs ask for.
struct LiveOutput {
    publisher: ResultPublisher,
    results: ResultMessages,
    /// With a team its help is in what is published.
    team: Option<TeamOutput>,
    /// From receiving an image to publishing its pose, and of that what the algorithm did not take; milliseconds.
    delays_ms: Records<f64>,
    overheads_ms: Records<f64>,
    num_dropped: usize,
}

/// Joins the network and, if it is asked for, the robot's team, and publishes the floor if it is given.
pub fn open_live(
    args: &LocalizeArgs,
    options: &SourceOptions,
    map: &Map,
    floor: Option<&OccupancyGrid>,
) -> Result<Box<dyn Spectator>> {
    let domain_id = options.domain_id();
    let frames = ResultFrames { base: options.topics.names().base_frame, ..ResultFrames::default() };
    let mut publisher = ResultPublisher::open(&publish_settings(domain_id, false))?;
    if let Some(floor) = floor {
        publisher.publish_map(occupancy_grid(now(), &frames.map, floor))?;
    }
    let team = args.team.as_deref().zip(args.number);
    let team = team.map(|(name, number)| TeamOutput::open(publisher.network(), name, number, map));
    Ok(Box::new(LiveOutput {
        team: team.transpose()?,
        publisher,
        results: ResultMessages::new(frames, TF_AHEAD_SECS),
        delays_ms: Records::new(Records::<f64>::most_of(true, false)),
        overheads_ms: Records::new(Records::<f64>::most_of(true, false)),
        num_dropped: 0,
    }))
}

impl LiveOutput {
    fn measure(&mut self, view: &FrameView<'_>, received_at: Timestamp) {
        let Some(record) = view.runners.first().and_then(|runner| runner.records().latest()) else { return };
        let delay_ms = now().secs_since(received_at) * 1e3;
        self.delays_ms.push(delay_ms);
        self.overheads_ms.push(delay_ms - record.analysis_ms - record.localizer_ms);
    }
}

/// The node that speaks.
pub fn node_settings(domain_id: u16) -> NodeSettings {
    NodeSettings { domain_id, name: node_name() }
}

/// Another one for each process.
pub fn node_name() -> String {
    format!("visloc_{}", std::process::id())
}

/// How results are published: services as the program below ROS expects them that `RMW_IMPLEMENTATION` names, as for programs of ROS.
pub fn publish_settings(domain_id: u16, keeps_points: bool) -> PublishSettings {
    let implementation = std::env::var("RMW_IMPLEMENTATION").unwrap_or_default();
    let middleware = Middleware::of_rmw(&implementation);
    PublishSettings { middleware, keeps_points, ..PublishSettings::new(node_settings(domain_id)) }
}

/// Says to the user as well what was done, or why it was not.
pub fn obeyed(outcome: Result<String, String>) -> Result<String, String> {
    let (Ok(told) | Err(told)) = &outcome;
    host().notice(told);
    outcome
}

impl Spectator for LiveOutput {
    fn before_frame(&mut self, runners: &mut [Runner]) {
        if let Some(prior) = self.team.as_mut().and_then(TeamOutput::advice) {
            runners.iter_mut().for_each(|runner| runner.reset_to(&prior));
        }
        let results = &mut self.results;
        self.publisher.obey(|order| {
            let (prior, told) = match order {
                Order::InitialPose(pose, spread) => {
                    (near(pose, spread), format!("initial pose: {:.2}, {:.2} m", pose.x_m, pose.y_m))
                }
                Order::Reset => (StartPrior::Uniform, "reset: the pose is forgotten".to_owned()),
                order => return obeyed(Err(why_not(&order))),
            };
            results.reset();
            runners.iter_mut().for_each(|runner| runner.reset_to(&prior));
            obeyed(Ok(told))
        });
    }

    fn after_frame(&mut self, view: &FrameView<'_>) {
        let Some(alone) = view.runners.first().map(|runner| runner.pipeline().estimate()) else { return };
        let together = self.team.as_mut().and_then(|team| team.step(view));
        let sample = sample_of(view, together.unwrap_or(alone));
        let messages = self.results.step(&sample);
        for (i, message) in messages.into_iter().enumerate() {
            self.publisher.publish(message);
            // The first is the pose; the others are of less hurry.
            if let (0, Some(received_at)) = (i, view.received_at) {
                self.measure(view, received_at);
            }
        }
        self.num_dropped = view.num_dropped;
    }

    fn report(&self) -> Option<LiveReport> {
        Some(LiveReport {
            dropped: self.num_dropped,
            unsent: self.publisher.num_failed(),
            delay_ms: TimingSummary::of_ms(&self.delays_ms),
            overhead_ms: TimingSummary::of_ms(&self.overheads_ms),
            team: self.team.as_ref().map(TeamOutput::report),
        })
    }
}

/// Why nothing is done where the map is known.
fn why_not(order: &Order) -> String {
    match order {
        Order::SaveMap(_) => "save_map: localization has no map of its own to save".into(),
        Order::LoadMap(_) => "load_map: the map is that of --map; start again with another one".into(),
        _ => "set_scale: the map is in meters already".into(),
    }
}

fn near(world_from_robot: PlanarPose, (position_spread_m, heading_spread_rad): (f64, f64)) -> StartPrior {
    StartPrior::Poses(vec![PosePrior {
        world_from_robot,
        position_spread_m,
        heading_spread_rad,
        weight: 1.0,
    }])
}
