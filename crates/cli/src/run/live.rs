//! Results as live ROS 2 topics, and orders from there.

use anyhow::Result;
use visloc_core::{Timestamp, eval::TimingSummary, geom::PlanarPose};
use visloc_io::{
    bag::{ResultFrames, ResultMessages},
    ros2::{NodeSettings, Order, ResultPublisher},
};
use visloc_locate::{PosePrior, StartPrior};

use super::{FrameView, LiveReport, Records, Runner, Spectator, results::result_sample};
use crate::host::host;

/// Transforms are stamped so far after their image: programs that steer ask for the pose of now.
const TF_AHEAD_SECS: f64 = 0.2;

/// Publishes what the first runner says, and does what other programs ask for.
pub struct LiveOutput {
    publisher: ResultPublisher,
    results: ResultMessages,
    /// From receiving an image to publishing its pose, and of that what the algorithm did not take; milliseconds.
    delays_ms: Records<f64>,
    overheads_ms: Records<f64>,
    num_dropped: usize,
}

impl LiveOutput {
    /// Joins the network.
    ///
    /// # Errors
    /// If there is none.
    pub fn open(domain_id: u16, base_frame: &str) -> Result<Self> {
        let frames = ResultFrames { base: base_frame.into(), ..ResultFrames::default() };
        Ok(Self {
            publisher: ResultPublisher::open(&node_settings(domain_id))?,
            results: ResultMessages::new(frames, TF_AHEAD_SECS),
            delays_ms: Records::new(Records::<f64>::most_of(true, false)),
            overheads_ms: Records::new(Records::<f64>::most_of(true, false)),
            num_dropped: 0,
        })
    }

    /// How long it took, in numbers.
    pub fn report(&self) -> LiveReport {
        LiveReport {
            dropped: self.num_dropped,
            unsent: self.publisher.num_failed(),
            delay_ms: TimingSummary::of_ms(&self.delays_ms),
            overhead_ms: TimingSummary::of_ms(&self.overheads_ms),
        }
    }

    fn measure(&mut self, view: &FrameView<'_>, received_at: Timestamp) {
        let Some(record) = view.runners.first().and_then(|runner| runner.records().latest()) else { return };
        let delay_ms = crate::host::now().secs_since(received_at) * 1e3;
        self.delays_ms.push(delay_ms);
        self.overheads_ms.push(delay_ms - record.analysis_ms - record.localizer_ms);
    }
}

/// The node that speaks.
pub fn node_settings(domain_id: u16) -> NodeSettings {
    NodeSettings { domain_id, name: format!("visloc_{}", std::process::id()) }
}

impl Spectator for LiveOutput {
    fn before_frame(&mut self, runners: &mut [Runner]) {
        for order in self.publisher.orders() {
            let prior = match order {
                Order::InitialPose(pose, spread) => {
                    host().notice(&format!("initial pose: {:.2}, {:.2} m", pose.x_m, pose.y_m));
                    near(pose, spread)
                }
                Order::Reset => {
                    host().notice("reset: the pose is forgotten");
                    StartPrior::Uniform
                }
                Order::SaveMap => {
                    host().notice("save_map: localization has no map of its own to save");
                    continue;
                }
            };
            self.results.reset();
            runners.iter_mut().for_each(|runner| runner.reset_to(&prior));
        }
    }

    fn after_frame(&mut self, view: &FrameView<'_>) {
        let Some(sample) = result_sample(view) else { return };
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
}

fn near(world_from_robot: PlanarPose, (position_spread_m, heading_spread_rad): (f64, f64)) -> StartPrior {
    StartPrior::Poses(vec![PosePrior {
        world_from_robot,
        position_spread_m,
        heading_spread_rad,
        weight: 1.0,
    }])
}
