//! Results for other programs, and their orders.

use ros2_client::{Publisher, Subscription};
use visloc_core::{Occupancy, Timestamp, geom::PlanarPose};

use crate::{
    bag::{
        ResultMessage,
        messages::{
            DiagnosticArray, Empty, Float64, Header, MapMetaData, NodeState, OccupancyGrid, Path,
            PointCloud2, PointField, Pose, PoseArray, PoseStamped, PoseWithCovarianceStamped, TfMessage,
        },
    },
    ros2::{
        Middleware, Network, Node, NodeSettings, Ros2Error,
        node::{Delivery, Watch},
        services::Services,
    },
};

/// What another program asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Order {
    /// The robot is near this pose (`/initialpose`, as RViz sends it): pose, and standard deviations in meters and radians.
    InitialPose(PlanarPose, (f64, f64)),
    /// Forget everything (`/visloc/reset`).
    Reset,
    /// Write the map of SLAM to a file of this name, or to its usual one if the name is empty (`/visloc/save_map`).
    SaveMap(String),
    /// Go on in the map of this name, or in the usual one if the name is empty (`/visloc/load_map`).
    LoadMap(String),
    /// The unit of the map of SLAM is so many meters, more than 0 (`/visloc/set_scale`).
    SetScale(f64),
}

/// How results are published.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PublishSettings {
    /// The node.
    pub node: NodeSettings,
    /// The program below ROS that asks for services.
    pub middleware: Middleware,
    /// Whether who comes later gets the last points: for a map that is sent once, not for one that grows.
    pub keeps_points: bool,
}

impl PublishSettings {
    /// The usual middleware, points that go on and on.
    #[must_use]
    pub fn new(node: NodeSettings) -> Self {
        Self { node, middleware: Middleware::default(), keeps_points: false }
    }
}

/// States of managed nodes: it waits for images, or works on them.
const INACTIVE: (u8, &str) = (2, "inactive");
const ACTIVE: (u8, &str) = (3, "active");

/// Publishes results and receives orders.
pub struct ResultPublisher {
    pose: Publisher<PoseWithCovarianceStamped>,
    path: Publisher<Path>,
    tf: Publisher<TfMessage>,
    hypotheses: Publisher<PoseArray>,
    reliability: Publisher<Float64>,
    diagnostics: Publisher<DiagnosticArray>,
    camera_pose: Publisher<PoseStamped>,
    points: Publisher<PointCloud2>,
    map: Option<(Publisher<OccupancyGrid>, OccupancyGrid)>,
    state: Publisher<NodeState>,
    is_active: bool,
    services: Services,
    initial_pose: Subscription<PoseWithCovarianceStamped>,
    reset: Subscription<Empty>,
    save_map: Subscription<Empty>,
    num_failed: usize,
    settings: PublishSettings,
    watch: Watch,
    /// Leaves the network last.
    node: Node,
}

visloc_core::debug_shows!([] ResultPublisher { settings, is_active, num_failed });

impl ResultPublisher {
    /// Advertises all topics and services.
    ///
    /// # Errors
    /// If there is no network.
    pub fn open(settings: &PublishSettings) -> Result<Self, Ros2Error> {
        Self::open_in(&Network::new(settings.node.domain_id), settings)
    }

    /// Where other nodes of this program may join as well.
    #[must_use]
    pub fn network(&self) -> &Network {
        self.node.network()
    }

    fn open_in(network: &Network, settings: &PublishSettings) -> Result<Self, Ros2Error> {
        let mut node = Node::join_in(network, &settings.node.name)?;
        let reliable = Delivery::Reliable;
        let points = if settings.keeps_points { Delivery::Kept } else { Delivery::Last };
        let state = node.advertise("/visloc/state", "lifecycle_msgs/msg/State", Delivery::Kept)?;
        let mut publisher = Self {
            pose: node.advertise("/visloc/pose", "geometry_msgs/msg/PoseWithCovarianceStamped", reliable)?,
            path: node.advertise("/visloc/path", "nav_msgs/msg/Path", Delivery::Last)?,
            tf: node.advertise("/tf", "tf2_msgs/msg/TFMessage", reliable)?,
            hypotheses: node.advertise("/visloc/hypotheses", "geometry_msgs/msg/PoseArray", reliable)?,
            reliability: node.advertise("/visloc/reliability", "std_msgs/msg/Float64", reliable)?,
            diagnostics: node.advertise("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", reliable)?,
            camera_pose: node.advertise("/visloc/camera_pose", "geometry_msgs/msg/PoseStamped", reliable)?,
            points: node.advertise("/visloc/points", "sensor_msgs/msg/PointCloud2", points)?,
            map: None,
            state,
            is_active: false,
            services: Services::open(&mut node, settings.middleware)?,
            initial_pose: node.subscribe(
                "/initialpose",
                "geometry_msgs/msg/PoseWithCovarianceStamped",
                Delivery::Newest,
            )?,
            reset: node.subscribe("/visloc/reset", "std_msgs/msg/Empty", Delivery::Newest)?,
            save_map: node.subscribe("/visloc/save_map", "std_msgs/msg/Empty", Delivery::Newest)?,
            num_failed: 0,
            settings: settings.clone(),
            watch: Watch::default(),
            node,
        };
        publisher.publish_state(INACTIVE);
        Ok(publisher)
    }

    /// Publishes a map on `/map`; who comes later gets it, too.
    ///
    /// # Errors
    /// If the topic cannot be published.
    pub fn publish_map(&mut self, map: OccupancyGrid) -> Result<(), Ros2Error> {
        let publisher = match self.map.take() {
            Some((publisher, _)) => publisher,
            None => self.node.advertise("/map", "nav_msgs/msg/OccupancyGrid", Delivery::Kept)?,
        };
        self.num_failed += usize::from(publisher.publish(map.clone()).is_err());
        self.map = Some((publisher, map));
        Ok(())
    }

    /// Advertises all anew if the network was left.
    fn keep_joined(&mut self) -> Result<(), Ros2Error> {
        if self.watch.sees_that_left(&self.node) {
            let mut anew = Self::open_in(self.node.network(), &self.settings)?;
            anew.num_failed = self.num_failed;
            if self.is_active {
                anew.note_image();
            }
            if let Some((_, map)) = self.map.take() {
                anew.publish_map(map)?;
            }
            *self = anew;
        }
        Ok(())
    }

    fn publish_state(&mut self, (id, label): (u8, &str)) {
        let state = NodeState { id, label: label.to_owned() };
        self.num_failed += usize::from(self.state.publish(state).is_err());
    }

    /// Says once that there are images.
    fn note_image(&mut self) {
        if !std::mem::replace(&mut self.is_active, true) {
            self.publish_state(ACTIVE);
        }
    }

    /// Sends a message of a result. What a subscriber is too slow for is not sent, and counted.
    pub fn publish(&mut self, result: ResultMessage) {
        self.note_image();
        let is_sent = match result {
            ResultMessage::Pose(message) => self.pose.publish(message).is_ok(),
            ResultMessage::Path(message) => self.path.publish(message).is_ok(),
            ResultMessage::Transform(message) => self.tf.publish(message).is_ok(),
            ResultMessage::Hypotheses(message) => self.hypotheses.publish(message).is_ok(),
            ResultMessage::Reliability(message) => self.reliability.publish(message).is_ok(),
            ResultMessage::Diagnostics(message) => self.diagnostics.publish(message).is_ok(),
        };
        self.num_failed += usize::from(!is_sent);
    }

    /// Sends a status.
    pub fn publish_diagnostics(&mut self, status: DiagnosticArray) {
        self.note_image();
        self.num_failed += usize::from(self.diagnostics.publish(status).is_err());
    }

    /// Sends the pose of a camera that SLAM follows.
    pub fn publish_camera(&mut self, pose: PoseStamped) {
        self.num_failed += usize::from(self.camera_pose.publish(pose).is_err());
    }

    /// Sends the map of SLAM.
    pub fn publish_points(&mut self, points: PointCloud2) {
        self.num_failed += usize::from(self.points.publish(points).is_err());
    }

    /// Messages that could not be sent.
    #[must_use]
    pub fn num_failed(&self) -> usize {
        self.num_failed
    }

    /// Has everything done that was asked for since the last time, and answers with what was done or why not. Nothing is waited for.
    pub fn obey(&mut self, mut act: impl FnMut(Order) -> Result<String, String>) {
        // Without a network it is tried again later.
        let _ = self.keep_joined();
        let mut orders = Vec::new();
        while let Ok(Some((message, _))) = self.initial_pose.take() {
            orders.extend(initial_pose(&message));
        }
        while let Ok(Some(_)) = self.reset.take() {
            orders.push(Order::Reset);
        }
        while let Ok(Some(_)) = self.save_map.take() {
            orders.push(Order::SaveMap(String::new()));
        }
        for order in orders {
            // Nobody waits for an answer to a topic.
            let _ = act(order);
        }
        self.services.obey(&mut act);
    }
}

/// The pose in a message, if its numbers are any; spreads of 0 become a usual one.
pub(super) fn initial_pose(message: &PoseWithCovarianceStamped) -> Option<Order> {
    let (p, q) = (message.pose.pose.position, message.pose.pose.orientation);
    let yaw_rad = (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z));
    let pose = PlanarPose::new(p.x, p.y, yaw_rad);
    let deviation = |i: usize, usual: f64| {
        let variance = message.pose.covariance[i][i];
        if variance.is_finite() && variance > 0.0 { variance.sqrt() } else { usual }
    };
    let spread = (deviation(0, 0.5).max(deviation(1, 0.5)), deviation(5, 0.3));
    pose.is_finite().then_some(Order::InitialPose(pose, spread))
}

/// Points as a cloud: x, y and z as floats of 32 bits.
#[must_use]
pub fn point_cloud(at: Timestamp, frame: &str, points: &[[f32; 3]]) -> PointCloud2 {
    let field =
        |(i, name): (u32, &str)| PointField { name: name.into(), offset: 4 * i, datatype: 7, count: 1 };
    let num_points = u32::try_from(points.len()).unwrap_or(u32::MAX);
    PointCloud2 {
        header: Header::new(at, frame),
        height: 1,
        width: num_points,
        fields: (0..).zip(["x", "y", "z"]).map(field).collect(),
        is_bigendian: false,
        point_step: 12,
        row_step: num_points.saturating_mul(12),
        data: points.iter().flatten().flat_map(|value| value.to_le_bytes()).collect(),
        is_dense: true,
    }
}

/// An occupancy grid as a map of Nav2.
#[must_use]
#[allow(clippy::cast_possible_truncation)]
pub fn occupancy_grid(at: Timestamp, frame: &str, grid: &visloc_core::OccupancyGrid) -> OccupancyGrid {
    let header = Header::new(at, frame);
    let num = |cells: usize| u32::try_from(cells).unwrap_or(u32::MAX);
    let (x, y) = grid.origin_m;
    let value = |cell: Occupancy| match cell {
        Occupancy::Occupied => 100,
        Occupancy::Unknown => -1,
        Occupancy::Free => 0,
    };
    OccupancyGrid {
        info: MapMetaData {
            map_load_time: header.stamp,
            resolution: grid.cell_m as f32,
            width: num(grid.size.0),
            height: num(grid.size.1),
            origin: Pose::planar(&PlanarPose::new(x, y, 0.0), 0.0),
        },
        header,
        data: grid.rows_up().map(value).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn initial_poses_and_clouds() {
        let mut message = PoseWithCovarianceStamped::default();
        message.pose.pose = Pose::planar(&PlanarPose::new(1.0, -2.0, 0.7), 0.0);
        message.pose.covariance[0][0] = 0.25;
        message.pose.covariance[5][5] = 0.04;
        let Some(Order::InitialPose(pose, spread)) = initial_pose(&message) else { panic!() };
        assert!(
            pose.distance_m(&PlanarPose::new(1.0, -2.0, 0.7)) < 1e-12 && (pose.yaw_rad - 0.7).abs() < 1e-12
        );
        assert!((spread.0 - 0.5).abs() < 1e-12 && (spread.1 - 0.2).abs() < 1e-12);
        message.pose.pose.position.x = f64::NAN;
        assert_eq!(initial_pose(&message), None);
        let cloud = point_cloud(Timestamp::from_secs(1.0), "map", &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        assert_eq!((cloud.width, cloud.data.len(), &cloud.data[20..]), (2, 24, &6.0_f32.to_le_bytes()[..]));
    }
}
