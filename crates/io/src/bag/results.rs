//! What a localizer says, as messages that other programs of ROS 2 read: for bags and for live topics.

use nalgebra::{Isometry3, Matrix3, Matrix6, Translation3, UnitQuaternion, Vector3};
use visloc_core::{
    Timestamp,
    geom::{PlanarPose, Rigid3},
};

use crate::bag::messages::{
    self, DiagnosticArray, DiagnosticStatus, Float64, Header, KeyValue, Path, Pose, PoseArray, PoseStamped,
    PoseWithCovariance, PoseWithCovarianceStamped, TfMessage, TransformStamped,
};

/// Most poses of a path; then every second one is dropped and the path grows on at half the density.
const MAX_PATH_POSES: usize = 500;
/// Time between paths, seconds.
const PATH_EVERY_SECS: f64 = 0.5;
/// A path gets a pose after so much way or turn, meters and radians.
const PATH_STEP: (f64, f64) = (0.05, 0.2);
/// Variance of what is not estimated because the robot stands on the ground: height, roll, pitch.
const ON_GROUND_VARIANCE: f64 = 1e-6;

/// What a localizer says after an image.
#[derive(Debug, Clone, PartialEq)]
pub struct ResultSample {
    /// Stamp of the image.
    pub at: Timestamp,
    /// Where the robot is.
    pub world_from_robot: Isometry3<f64>,
    /// Covariance over (x, y, z) and small turns about these axes, meters and radians.
    pub covariance: Matrix6<f64>,
    /// Trust in the pose, 0 to 1.
    pub reliability: f64,
    /// Whether that is enough for the pose to be used.
    pub is_localized: bool,
    /// Likelihood of the image at the pose, 0 to 1; `None` for who has no such thing.
    pub likelihood: Option<f64>,
    /// All places where the robot may be.
    pub hypotheses: Vec<Isometry3<f64>>,
    /// Odometry of the image, `odom_from_robot`.
    pub odometry: Option<Isometry3<f64>>,
    /// Images of a live source that were left out so far because others were being worked on.
    pub num_dropped: usize,
}

/// A pose on the ground, in space.
pub fn on_ground(pose: &PlanarPose) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), pose.yaw_rad);
    Isometry3::from_parts(Translation3::new(pose.x_m, pose.y_m, 0.0), turn)
}

/// The covariance of a pose on the ground, over (x, y, heading), in space.
pub fn covariance_on_ground(covariance: &Matrix3<f64>) -> Matrix6<f64> {
    let mut in_space = Matrix6::zeros();
    for (i, row) in [0, 1, 5].into_iter().enumerate() {
        for (j, column) in [0, 1, 5].into_iter().enumerate() {
            in_space[(row, column)] = covariance[(i, j)];
        }
    }
    [2, 3, 4].into_iter().for_each(|i| in_space[(i, i)] = ON_GROUND_VARIANCE);
    in_space
}

/// A pose in space, without the names of its frames.
pub fn in_space<Dst, Src>(pose: &Rigid3<Dst, Src>) -> Isometry3<f64> {
    let [x, y, z, w] = pose.quaternion_xyzw();
    let turn = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(*pose.translation()), turn)
}

visloc_core::with_defaults! {
    /// Names of the frames in results.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct ResultFrames {
        /// The map.
        pub map: String = "map".into(),
        /// Where odometry began to count.
        pub odom: String = "odom".into(),
        /// The robot on the ground.
        pub base: String = "base_footprint".into(),
    }
}

/// One message of a result.
// A message is moved once and written; boxes would cost an allocation each.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, PartialEq)]
pub enum ResultMessage {
    /// The pose, while the robot is localized.
    Pose(PoseWithCovarianceStamped),
    /// Where it was while it was localized.
    Path(Path),
    /// The map's pose above odometry, `map` -> `odom`; without odometry that of the robot, `map` -> `base`.
    Transform(TfMessage),
    /// All places where the robot may be.
    Hypotheses(PoseArray),
    /// Trust in the pose, 0 to 1.
    Reliability(Float64),
    /// The same for people and monitors.
    Diagnostics(DiagnosticArray),
}

impl ResultMessage {
    /// Name of its topic.
    pub fn topic(&self) -> &'static str {
        match self {
            Self::Pose(_) => "/visloc/pose",
            Self::Path(_) => "/visloc/path",
            Self::Transform(_) => "/tf",
            Self::Hypotheses(_) => "/visloc/hypotheses",
            Self::Reliability(_) => "/visloc/reliability",
            Self::Diagnostics(_) => "/diagnostics",
        }
    }

    /// Its type.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::Pose(_) => "geometry_msgs/msg/PoseWithCovarianceStamped",
            Self::Path(_) => "nav_msgs/msg/Path",
            Self::Transform(_) => "tf2_msgs/msg/TFMessage",
            Self::Hypotheses(_) => "geometry_msgs/msg/PoseArray",
            Self::Reliability(_) => "std_msgs/msg/Float64",
            Self::Diagnostics(_) => "diagnostic_msgs/msg/DiagnosticArray",
        }
    }
}

/// Makes messages of results. Remembers the path, and the map's pose above odometry for times when the robot is lost.
#[derive(Debug, Clone)]
pub struct ResultMessages {
    frames: ResultFrames,
    tf_ahead_secs: f64,
    map_from_odom: Option<Isometry3<f64>>,
    path: Vec<PoseStamped>,
    path_end: Option<Isometry3<f64>>,
    path_step: (f64, f64),
    path_sent_at: Option<Timestamp>,
}

impl ResultMessages {
    /// Nothing known yet. Stamps of transforms are `tf_ahead_secs` after that of the image, so that programs which ask for
    /// the pose at a time after the image, but before the next result, get one.
    pub fn new(frames: ResultFrames, tf_ahead_secs: f64) -> Self {
        Self {
            frames,
            tf_ahead_secs,
            map_from_odom: None,
            path: Vec::new(),
            path_end: None,
            path_step: PATH_STEP,
            path_sent_at: None,
        }
    }

    /// Forgets path and place.
    pub fn reset(&mut self) {
        *self = Self::new(self.frames.clone(), self.tf_ahead_secs);
    }

    /// The messages of a result. Pose, path and transform only after the robot was localized; the transform goes on
    /// with the last known place if it gets lost.
    pub fn step(&mut self, sample: &ResultSample) -> Vec<ResultMessage> {
        let mut messages = Vec::with_capacity(6);
        if sample.is_localized {
            messages.push(ResultMessage::Pose(self.pose(sample)));
        }
        messages.extend(self.transform(sample).map(ResultMessage::Transform));
        let poses = sample.hypotheses.iter().map(pose_message).collect();
        let header = Header::new(sample.at, &self.frames.map);
        messages.push(ResultMessage::Hypotheses(PoseArray { header, poses }));
        messages.push(ResultMessage::Reliability(Float64 { data: sample.reliability }));
        messages.push(ResultMessage::Diagnostics(diagnostics(sample)));
        messages.extend(self.path(sample).map(ResultMessage::Path));
        messages
    }

    fn pose(&self, sample: &ResultSample) -> PoseWithCovarianceStamped {
        let covariance = std::array::from_fn(|i| std::array::from_fn(|j| sample.covariance[(i, j)]));
        PoseWithCovarianceStamped {
            header: Header::new(sample.at, &self.frames.map),
            pose: PoseWithCovariance { pose: pose_message(&sample.world_from_robot), covariance },
        }
    }

    fn transform(&mut self, sample: &ResultSample) -> Option<TfMessage> {
        let (child, map_from_child) = match &sample.odometry {
            Some(odom_from_robot) => {
                if sample.is_localized {
                    let map_from_odom = sample.world_from_robot * odom_from_robot.inverse();
                    self.map_from_odom = Some(map_from_odom);
                }
                (&self.frames.odom, self.map_from_odom?)
            }
            None if sample.is_localized => (&self.frames.base, sample.world_from_robot),
            None => return None,
        };
        let at = Timestamp::from_nanos(sample.at.nanos() + Timestamp::from_secs(self.tf_ahead_secs).nanos());
        let transform = TransformStamped {
            header: Header::new(at, &self.frames.map),
            child_frame_id: child.clone(),
            transform: pose_message(&map_from_child),
        };
        Some(TfMessage { transforms: vec![transform] })
    }

    fn path(&mut self, sample: &ResultSample) -> Option<Path> {
        let pose = &sample.world_from_robot;
        let has_moved = self.path_end.is_none_or(|end| {
            (end.translation.vector - pose.translation.vector).norm() >= self.path_step.0
                || end.rotation.angle_to(&pose.rotation) >= self.path_step.1
        });
        let header = Header::new(sample.at, &self.frames.map);
        if sample.is_localized && has_moved {
            self.path_end = Some(*pose);
            self.path.push(PoseStamped { header: header.clone(), pose: pose_message(pose) });
            if self.path.len() > MAX_PATH_POSES {
                let mut number = 0;
                self.path.retain(|_| {
                    number += 1;
                    number % 2 == 1
                });
                self.path_step = (self.path_step.0 * 2.0, self.path_step.1 * 2.0);
            }
        }
        let is_due = self.path_sent_at.is_none_or(|sent| sample.at.secs_since(sent) >= PATH_EVERY_SECS);
        if self.path.is_empty() || !is_due {
            return None;
        }
        self.path_sent_at = Some(sample.at);
        Some(Path { header, poses: self.path.clone() })
    }
}

/// A status of visloc: all is well, or a warning.
pub fn diagnostics_message(
    at: Timestamp,
    part: &str,
    (is_well, message): (bool, &str),
    values: &[(&str, String)],
) -> DiagnosticArray {
    let values = values.iter().map(|(key, value)| KeyValue { key: (*key).into(), value: value.clone() });
    let status = DiagnosticStatus {
        level: u8::from(!is_well),
        name: format!("visloc: {part}"),
        message: message.into(),
        hardware_id: String::new(),
        values: values.collect(),
    };
    DiagnosticArray { header: Header::new(at, ""), status: vec![status] }
}

/// Reliability as a status: all is well, or a warning while the robot does not know where it is.
fn diagnostics(sample: &ResultSample) -> DiagnosticArray {
    let message = if sample.is_localized { "localized" } else { "not localized" };
    let mut values = vec![
        ("reliability", format!("{:.3}", sample.reliability)),
        ("hypotheses", sample.hypotheses.len().to_string()),
        ("dropped images", sample.num_dropped.to_string()),
    ];
    if let Some(likelihood) = sample.likelihood {
        values.insert(1, ("likelihood", format!("{likelihood:.3}")));
    }
    diagnostics_message(sample.at, "localization", (sample.is_localized, message), &values)
}

fn pose_message(pose: &Isometry3<f64>) -> Pose {
    let (t, q) = (&pose.translation, &pose.rotation);
    Pose {
        position: messages::Vector3 { x: t.x, y: t.y, z: t.z },
        orientation: messages::Quaternion { x: q.i, y: q.j, z: q.k, w: q.w },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bag::definition;

    fn sample(secs: f64, x_m: f64, is_localized: bool) -> ResultSample {
        ResultSample {
            at: Timestamp::from_secs(secs),
            world_from_robot: on_ground(&PlanarPose::new(x_m, 1.0, 0.5)),
            covariance: covariance_on_ground(&Matrix3::from_diagonal(&Vector3::new(0.1, 0.2, 0.3))),
            reliability: if is_localized { 0.9 } else { 0.1 },
            is_localized,
            likelihood: Some(0.8),
            hypotheses: [PlanarPose::new(x_m, 1.0, 0.5), PlanarPose::new(-x_m, -1.0, 3.0)]
                .iter()
                .map(on_ground)
                .collect(),
            odometry: Some(on_ground(&PlanarPose::new(x_m - 1.0, 0.0, 0.0))),
            num_dropped: 3,
        }
    }

    fn names(messages: &[ResultMessage]) -> Vec<&'static str> {
        messages.iter().map(ResultMessage::topic).collect()
    }

    #[test]
    fn a_pose_is_sent_only_while_it_can_be_used() {
        let mut results = ResultMessages::new(ResultFrames::default(), 0.2);
        let before = results.step(&sample(1.0, 2.0, false));
        assert_eq!(names(&before), ["/visloc/hypotheses", "/visloc/reliability", "/diagnostics"]);
        let found = results.step(&sample(1.1, 2.0, true));
        assert_eq!(names(&found).len(), 6);
        let lost = results.step(&sample(1.2, 7.0, false));
        let ResultMessage::Transform(tf) = &lost[0] else { panic!("{:?}", names(&lost)) };
        let ResultMessage::Transform(known) = &found[1] else { panic!("{:?}", names(&found)) };
        assert_eq!(tf.transforms[0].transform, known.transforms[0].transform);
        assert_eq!(tf.transforms[0].header.at(), Timestamp::from_secs(1.4));
    }

    #[test]
    fn map_from_odom_leads_to_the_pose() {
        let mut results = ResultMessages::new(ResultFrames::default(), 0.0);
        let sample = sample(1.0, 2.0, true);
        let messages = results.step(&sample);
        let ResultMessage::Transform(tf) = &messages[1] else { panic!() };
        let transform = &tf.transforms[0];
        assert_eq!((transform.header.frame_id.as_str(), transform.child_frame_id.as_str()), ("map", "odom"));
        let (p, q) = (transform.transform.position, transform.transform.orientation);
        let map_from_odom = on_ground(&PlanarPose::new(p.x, p.y, 2.0 * q.z.atan2(q.w)));
        let robot = map_from_odom * sample.odometry.unwrap();
        assert!((robot.translation.vector - sample.world_from_robot.translation.vector).norm() < 1e-12);
        let ResultMessage::Pose(pose) = &messages[0] else { panic!() };
        assert_eq!([0, 1, 5].map(|i| pose.pose.covariance[i][i]), [0.1, 0.2, 0.3]);
    }

    #[test]
    fn paths_are_bounded_and_every_type_has_a_definition() {
        let mut results = ResultMessages::new(ResultFrames::default(), 0.0);
        for i in 0..5000 {
            for message in results.step(&sample(f64::from(i), 0.06 * f64::from(i), true)) {
                assert!(definition(message.type_name()).is_some());
                let ResultMessage::Path(path) = message else { continue };
                assert!(path.poses.len() <= MAX_PATH_POSES);
            }
        }
    }
}
