//! From positions of joints to poses in the tree of frames.

use std::{collections::BTreeSet, sync::Arc};

use nalgebra::{Isometry3, Matrix3, Rotation3, Vector3};
use visloc_core::Timestamp;

use crate::{
    bag::{
        StampedTransform,
        history::Pushed,
        tf_tree::{Teller, TfTree},
    },
    urdf::{JointMotion, RobotDescription},
};

/// The frames of the feet on the ground and of the trunk, as REP 120 calls them.
const SOLES: [&str; 2] = ["l_sole", "r_sole"];
const TRUNK: &str = "base_link";
/// Most joints that an error lists.
const MAX_LISTED: usize = 8;

/// Puts what a robot's description and the positions of its joints say into the tree of frames.
#[derive(Debug, Clone, Default)]
pub(super) struct JointPoses {
    robot: Option<Arc<RobotDescription>>,
    /// Whether positions have come, of whatever joints.
    has_positions: bool,
}

/// What became of a message with positions.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Moved {
    pub pushed: Pushed,
    /// What could not be used of it, and why.
    pub unusable: Option<String>,
}

impl JointPoses {
    /// Takes a description in place of the one before. Which of its joints will have no pose, and why; nothing if it is the same again.
    pub(super) fn describe(&mut self, robot: Arc<RobotDescription>, tree: &mut TfTree) -> Vec<String> {
        if self.robot.as_ref() == Some(&robot) {
            return Vec::new();
        }
        tree.forget_joints();
        let mut without_pose = Vec::new();
        for joint in robot.joints() {
            match &joint.motion {
                JointMotion::Fixed => {
                    let fixed = transform(Timestamp::default(), (&joint.parent, &joint.child), joint.origin);
                    tree.add_fixed(&fixed, Teller::Joints);
                }
                JointMotion::Untold(kind) => without_pose.push(format!(
                    "joint '{}' is {kind}: its position does not say where '{}' is on '{}'; only transforms can",
                    joint.name, joint.child, joint.parent
                )),
                JointMotion::Turning(_) | JointMotion::Sliding(_) => {}
            }
        }
        self.robot = Some(robot);
        without_pose
    }

    /// Adds the poses of all links that joints at these positions (radians, meters) move, and of the robot on the ground.
    pub(super) fn push(
        &mut self,
        at: Timestamp,
        positions: &[(String, f64)],
        base_frame: &str,
        tree: &mut TfTree,
    ) -> Moved {
        self.has_positions = true;
        let mut all = Moved { pushed: Pushed::Accepted, unusable: None };
        let Some(robot) = &self.robot else { return all };
        let moved = robot.moved(positions.iter().map(|(name, position)| (name.as_str(), *position)));
        all.unusable = moved.unusable.map(|(joint, position)| {
            format!("joint '{}': expected a position in radians or meters, found {position}", joint.name)
        });
        let mut note = |pushed| match pushed {
            Pushed::Accepted => {}
            Pushed::Restarted => all.pushed = pushed,
            Pushed::Backward { .. } if all.pushed == Pushed::Accepted => all.pushed = pushed,
            Pushed::Backward { .. } => {}
        };
        for (joint, parent_from_child) in moved.poses {
            if tree.believes(Teller::Joints, &joint.child) {
                let moving = transform(at, (&joint.parent, &joint.child), parent_from_child);
                note(tree.add_moving(&moving, Teller::Joints));
            }
        }
        if robot.has_link(base_frame) {
            return all;
        }
        if tree.has_children(base_frame) {
            // Somebody tells the trunk on the ground.
            tree.forget_joint(base_frame);
        } else if let Some(standing) = footprint(robot, base_frame, at, tree) {
            note(tree.add_moving(&standing, Teller::Joints));
        }
        all
    }

    /// What more is to be said if no chain of transforms leads from one frame to the other.
    pub(super) fn explain(&self, base_frame: &str, camera_frame: &str, tree: &TfTree) -> Option<String> {
        let Some(robot) = &self.robot else {
            return self.has_positions.then(|| {
                "positions of joints come, but no description of the robot: give it with --urdf FILE"
                    .to_owned()
            });
        };
        let is_standing = !robot.has_link(base_frame) && has_soles(robot);
        let soles = SOLES.into_iter().filter(|_| is_standing);
        let ways = [base_frame, camera_frame].into_iter().chain(soles).flat_map(|link| robot.way_up(link));
        let untold: BTreeSet<String> = ways
            .filter(|joint| !tree.has_parent(&joint.child))
            .map(|joint| format!("'{}'", joint.name))
            .collect();
        if !untold.is_empty() {
            let shown = untold.iter().take(MAX_LISTED).cloned().collect::<Vec<_>>().join(", ");
            let more = if untold.len() > MAX_LISTED { " and others" } else { "" };
            return Some(format!("no positions have come of the joints {shown}{more}"));
        }
        let is_base_known =
            robot.has_link(base_frame) || tree.has_parent(base_frame) || tree.has_children(base_frame);
        (!is_base_known).then(|| {
            format!(
                "the robot's description begins with '{}' and has no soles (l_sole, r_sole) to stand on: name a frame on the ground with \
                 --base-frame, or say where the camera is: --camera-height METERS --camera-tilt DEGREES",
                robot.root()
            )
        })
    }
}

/// Where a robot with feet is on the ground: between its soles, level with the lower one, which stands flat, ahead as the trunk. `None`
/// if it has no such feet, or transforms say it anyway.
///
/// Source: REP 120, `base_footprint`. There the ground is where odometry says that it is level; here it is what the foot stands on.
fn footprint(
    robot: &RobotDescription,
    base_frame: &str,
    at: Timestamp,
    tree: &TfTree,
) -> Option<StampedTransform> {
    if !tree.believes(Teller::Joints, base_frame) || !has_soles(robot) {
        return None;
    }
    let trunk = if robot.has_link(TRUNK) { TRUNK } else { robot.root() };
    let [left, right] = SOLES.map(|sole| tree.lookup(trunk, sole, at).ok());
    let (left, right) = (left?.dst_from_src, right?.dst_from_src);
    let lower = if left.translation.z <= right.translation.z { left } else { right };
    let up = lower.rotation * Vector3::z();
    let on_ground = |point: Vector3<f64>| point - up * up.dot(&(point - lower.translation.vector));
    let origin = on_ground(0.5 * (left.translation.vector + right.translation.vector));
    let ahead = (Vector3::x() - up * up.x).try_normalize(1e-3)?;
    let axes = Matrix3::from_columns(&[ahead, up.cross(&ahead), up]);
    let rotation = Rotation3::from_matrix_unchecked(axes);
    Some(transform(at, (trunk, base_frame), Isometry3::from_parts(origin.into(), rotation.into())))
}

fn has_soles(robot: &RobotDescription) -> bool {
    SOLES.iter().all(|sole| robot.has_link(sole))
}

fn transform(
    at: Timestamp,
    (parent, child): (&str, &str),
    parent_from_child: Isometry3<f64>,
) -> StampedTransform {
    StampedTransform { at, parent: parent.to_owned(), child: child.to_owned(), parent_from_child }
}
