//! Results for other programs, and their orders.

use ros2_client::{Publisher, Subscription};
use visloc_core::{Timestamp, geom::PlanarPose};

use crate::{
    bag::{
        ResultMessage,
        messages::{
            DiagnosticArray, Empty, Float64, Header, Path, PointCloud2, PointField, PoseArray, PoseStamped,
            PoseWithCovarianceStamped, TfMessage,
        },
    },
    ros2::{Node, NodeSettings, Ros2Error, node::Delivery},
};

/// What another program asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Order {
    /// The robot is near this pose (`/initialpose`, as RViz sends it): pose, and standard deviations in meters and radians.
    InitialPose(PlanarPose, (f64, f64)),
    /// Forget everything (`/visloc/reset`).
    Reset,
    /// Write the map of SLAM to its file (`/visloc/save_map`).
    SaveMap,
}

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
    initial_pose: Subscription<PoseWithCovarianceStamped>,
    reset: Subscription<Empty>,
    save_map: Subscription<Empty>,
    num_failed: usize,
    /// Leaves the network last.
    _node: Node,
}

impl ResultPublisher {
    /// Advertises all topics.
    ///
    /// # Errors
    /// If there is no network.
    pub fn open(settings: &NodeSettings) -> Result<Self, Ros2Error> {
        let mut node = Node::join(settings)?;
        let reliable = Delivery::Reliable;
        Ok(Self {
            pose: node.advertise("/visloc/pose", "geometry_msgs/msg/PoseWithCovarianceStamped", reliable)?,
            path: node.advertise("/visloc/path", "nav_msgs/msg/Path", Delivery::Last)?,
            tf: node.advertise("/tf", "tf2_msgs/msg/TFMessage", reliable)?,
            hypotheses: node.advertise("/visloc/hypotheses", "geometry_msgs/msg/PoseArray", reliable)?,
            reliability: node.advertise("/visloc/reliability", "std_msgs/msg/Float64", reliable)?,
            diagnostics: node.advertise("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", reliable)?,
            camera_pose: node.advertise("/visloc/camera_pose", "geometry_msgs/msg/PoseStamped", reliable)?,
            points: node.advertise("/visloc/points", "sensor_msgs/msg/PointCloud2", Delivery::Last)?,
            initial_pose: node.subscribe(
                "/initialpose",
                "geometry_msgs/msg/PoseWithCovarianceStamped",
                Delivery::Newest,
            )?,
            reset: node.subscribe("/visloc/reset", "std_msgs/msg/Empty", Delivery::Newest)?,
            save_map: node.subscribe("/visloc/save_map", "std_msgs/msg/Empty", Delivery::Newest)?,
            num_failed: 0,
            _node: node,
        })
    }

    /// Sends a message of a result. What a subscriber is too slow for is not sent, and counted.
    pub fn publish(&mut self, result: ResultMessage) {
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

    /// What was asked for since the last time. Nothing is waited for.
    pub fn orders(&self) -> Vec<Order> {
        let mut orders = Vec::new();
        while let Ok(Some((message, _))) = self.initial_pose.take() {
            orders.extend(initial_pose(&message));
        }
        while let Ok(Some(_)) = self.reset.take() {
            orders.push(Order::Reset);
        }
        while let Ok(Some(_)) = self.save_map.take() {
            orders.push(Order::SaveMap);
        }
        orders
    }
}

/// The pose in a message, if its numbers are any; spreads of 0 become a usual one.
fn initial_pose(message: &PoseWithCovarianceStamped) -> Option<Order> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bag::messages::Pose;

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
