//! What other programs ask for and get an answer to.

use ros2_client::{Message, Server};
use serde::{Deserialize, Serialize};

use crate::{
    bag::messages::{Empty, PoseWithCovarianceStamped},
    ros2::{Node, Order, Ros2Error, publish::initial_pose},
};

/// Most requests of a kind that are answered at a time.
const MAX_ANSWERED: usize = 16;

/// The program below ROS 2: each packs the number of a request differently, and those of one kind do not understand the others.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Middleware {
    /// Fast DDS, the usual one.
    #[default]
    FastDds,
    /// Cyclone DDS.
    CycloneDds,
}

impl Middleware {
    /// By the word that programs of ROS take from `RMW_IMPLEMENTATION`.
    #[must_use]
    pub fn of_rmw(implementation: &str) -> Self {
        if implementation.contains("cyclone") { Self::CycloneDds } else { Self::FastDds }
    }
}

/// A message without content.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct NoRequest(Empty);

/// `visloc_msgs/srv/SetPose`.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct SetPose {
    pose: PoseWithCovarianceStamped,
}

/// `visloc_msgs/srv/MapFile`.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct MapFile {
    name: String,
}

/// `visloc_msgs/srv/SetScale`.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct SetScale {
    meters_per_unit: f64,
}

/// What every service answers, that of `std_srvs/srv/Trigger`.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Answer {
    success: bool,
    message: String,
}

impl Message for NoRequest {}
impl Message for SetPose {}
impl Message for MapFile {}
impl Message for SetScale {}
impl Message for Answer {}

/// All services.
pub(super) struct Services {
    reset: Server<NoRequest, Answer>,
    set_pose: Server<SetPose, Answer>,
    save_map: Server<MapFile, Answer>,
    load_map: Server<MapFile, Answer>,
    set_scale: Server<SetScale, Answer>,
}

impl Services {
    pub(super) fn open(node: &mut Node, middleware: Middleware) -> Result<Self, Ros2Error> {
        Ok(Self {
            reset: node.serve("/visloc/reset", "std_srvs/srv/Trigger", middleware)?,
            set_pose: node.serve("/visloc/set_pose", "visloc_msgs/srv/SetPose", middleware)?,
            save_map: node.serve("/visloc/save_map", "visloc_msgs/srv/MapFile", middleware)?,
            load_map: node.serve("/visloc/load_map", "visloc_msgs/srv/MapFile", middleware)?,
            set_scale: node.serve("/visloc/set_scale", "visloc_msgs/srv/SetScale", middleware)?,
        })
    }

    /// Has everything done that was asked for, and answers. Nothing is waited for.
    pub(super) fn obey(&self, act: &mut dyn FnMut(Order) -> Result<String, String>) {
        answer(&self.reset, |_| Ok(Order::Reset), act);
        answer(&self.set_pose, |request| pose_order(&request.pose), act);
        answer(&self.save_map, |request| Ok(Order::SaveMap(request.name)), act);
        answer(&self.load_map, |request| Ok(Order::LoadMap(request.name)), act);
        answer(&self.set_scale, |request| scale_order(request.meters_per_unit), act);
    }
}

fn pose_order(pose: &PoseWithCovarianceStamped) -> Result<Order, String> {
    initial_pose(pose).ok_or_else(|| "pose: expected numbers, found some that are none".to_owned())
}

fn scale_order(meters_per_unit: f64) -> Result<Order, String> {
    let is_length = meters_per_unit.is_finite() && meters_per_unit > 0.0;
    let expected = || format!("meters_per_unit: expected more than 0, found {meters_per_unit}");
    is_length.then_some(Order::SetScale(meters_per_unit)).ok_or_else(expected)
}

fn answer<Request: Message + 'static>(
    server: &Server<Request, Answer>,
    order: impl Fn(Request) -> Result<Order, String>,
    act: &mut dyn FnMut(Order) -> Result<String, String>,
) {
    for _ in 0..MAX_ANSWERED {
        // What cannot be read is nobody's request.
        let Ok(Some((id, request))) = server.receive_request() else { return };
        let outcome = order(request).and_then(&mut *act);
        let success = outcome.is_ok();
        let (Ok(message) | Err(message)) = outcome;
        // Who has left in the meantime gets no answer.
        let _ = server.send_response(id, Answer { success, message });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn middleware_by_its_name() {
        assert_eq!(Middleware::of_rmw("rmw_cyclonedds_cpp"), Middleware::CycloneDds);
        assert_eq!(Middleware::of_rmw("rmw_fastrtps_cpp"), Middleware::FastDds);
        assert_eq!(Middleware::of_rmw(""), Middleware::default());
    }

    #[test]
    fn senseless_requests_are_refused() {
        assert_eq!(scale_order(0.25), Ok(Order::SetScale(0.25)));
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(scale_order(value).unwrap_err().contains("expected more than 0"));
        }
        let mut pose = PoseWithCovarianceStamped::default();
        pose.pose.pose.position.y = f64::INFINITY;
        assert!(pose_order(&pose).is_err());
    }
}
