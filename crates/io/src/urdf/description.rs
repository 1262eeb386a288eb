//! The joints of a robot.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

/// Longest chain of joints that mimic each other; a longer one is a circle, or senseless.
const MAX_MIMICKED: usize = 16;
/// Largest position of a joint that makes sense, radians or meters.
const MAX_POSITION: f64 = 1e6;

/// The joints of a robot, as its description has them. They form one tree of links.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotDescription {
    root: String,
    joints: Vec<Joint>,
    by_name: BTreeMap<String, usize>,
    by_child: BTreeMap<String, usize>,
}

/// What connects two links.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Its name, which messages have too.
    pub name: String,
    /// The link that it is on; the frame of that name.
    pub parent: String,
    /// The link that it moves; the frame of that name.
    pub child: String,
    /// Pose of the child in the parent while the joint's position is 0, meters.
    pub origin: Isometry3<f64>,
    /// How it moves.
    pub motion: JointMotion,
    /// The joint that it follows, if it does not move by itself.
    pub mimic: Option<Mimic>,
}

/// How a joint moves its child. Axes are in the child's frame.
#[derive(Debug, Clone, PartialEq)]
pub enum JointMotion {
    /// Not at all.
    Fixed,
    /// About an axis, by radians: revolute and continuous joints.
    Turning(Unit<Vector3<f64>>),
    /// Along an axis, by meters: prismatic joints.
    Sliding(Unit<Vector3<f64>>),
    /// In a way that one number does not tell: floating and planar joints, and those without an axis. What it is.
    Untold(String),
}

/// A joint that follows another one.
#[derive(Debug, Clone, PartialEq)]
pub struct Mimic {
    /// Name of the joint that moves by itself.
    pub joint: String,
    /// What its position is multiplied by.
    pub multiplier: f64,
    /// What is added, radians or meters.
    pub offset: f64,
}

/// Where joints put their links.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MovedLinks<'a> {
    /// Joints, and the pose of the child of each in its parent, meters.
    pub poses: Vec<(&'a Joint, Isometry3<f64>)>,
    /// The first joint whose position is no number of a sensible size, and that position.
    pub unusable: Option<(&'a Joint, f64)>,
}

impl RobotDescription {
    /// A robot of these joints.
    ///
    /// # Errors
    /// If they do not make one tree of links, a name comes twice, or joints mimic in a circle or what is not there.
    pub fn new(joints: Vec<Joint>) -> Result<Self, String> {
        let mut by_name = BTreeMap::new();
        let mut children: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        let mut by_child = BTreeMap::new();
        for (i, joint) in joints.iter().enumerate() {
            if by_name.insert(joint.name.clone(), i).is_some() {
                return Err(format!(
                    "expected joints with different names, found two called '{}'",
                    joint.name
                ));
            }
            if by_child.insert(joint.child.clone(), i).is_some() {
                return Err(format!(
                    "expected one joint that moves the link '{}', found a second: '{}'",
                    joint.child, joint.name
                ));
            }
            children.entry(&joint.parent).or_default().push(&joint.child);
        }
        let mut roots = children.keys().filter(|link| !by_child.contains_key(**link));
        let root = match (roots.next(), roots.next()) {
            (Some(root), None) => (*root).to_owned(),
            (None, _) if joints.is_empty() => {
                return Err("expected a robot with joints, found none".to_owned());
            }
            (None, _) => return Err("expected a tree of links, found joints in a circle".to_owned()),
            (Some(a), Some(b)) => {
                return Err(format!("expected one tree of links, found two: below '{a}' and below '{b}'"));
            }
        };
        let mut num_reached = 0;
        let mut waiting = vec![root.as_str()];
        while let Some(link) = waiting.pop() {
            let below = children.get(link).map_or(&[][..], Vec::as_slice);
            num_reached += below.len();
            waiting.extend(below);
        }
        if num_reached < joints.len() {
            return Err(format!(
                "expected one tree of links below '{root}', found joints in a circle beside it"
            ));
        }
        let mut robot = Self { root, joints, by_name, by_child };
        robot.resolve_mimics()?;
        Ok(robot)
    }

    /// Has every joint that follows another one follow one that moves by itself.
    fn resolve_mimics(&mut self) -> Result<(), String> {
        for i in 0..self.joints.len() {
            let Some(mut resolved) = self.joints[i].mimic.clone() else { continue };
            let mut num_followed = 1;
            loop {
                let Some(followed) = self.joint(&resolved.joint) else {
                    let name = &self.joints[i].name;
                    return Err(format!("joint '{name}' mimics '{}', which is no joint", resolved.joint));
                };
                let Some(next) = &followed.mimic else { break };
                resolved = Mimic {
                    joint: next.joint.clone(),
                    multiplier: resolved.multiplier * next.multiplier,
                    offset: resolved.multiplier * next.offset + resolved.offset,
                };
                num_followed += 1;
                if num_followed > MAX_MIMICKED {
                    return Err(format!("joint '{}' mimics others in a circle", self.joints[i].name));
                }
            }
            self.joints[i].mimic = Some(resolved);
        }
        Ok(())
    }

    /// The link that no joint moves.
    pub fn root(&self) -> &str {
        &self.root
    }

    /// All joints, in the order of the description. One that mimics names a joint that moves by itself.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The joint with a name.
    pub fn joint(&self, name: &str) -> Option<&Joint> {
        self.by_name.get(name).map(|i| &self.joints[*i])
    }

    /// Whether there is a link with a name.
    pub fn has_link(&self, name: &str) -> bool {
        name == self.root || self.by_child.contains_key(name)
    }

    /// The joints from a link up to the root; none if there is no such link.
    pub fn way_up(&self, link: &str) -> impl Iterator<Item = &Joint> {
        let above = |link: &str| self.by_child.get(link).map(|i| &self.joints[*i]);
        std::iter::successors(above(link), move |joint| above(&joint.parent))
    }

    /// Where joints at these positions (radians, meters) put their links, those included that mimic them. Positions of unknown and of fixed
    /// joints are passed over. Of two for one joint the last counts.
    pub fn moved<'a>(&self, positions: impl IntoIterator<Item = (&'a str, f64)>) -> MovedLinks<'_> {
        let mut told = vec![None; self.joints.len()];
        for (name, position) in positions {
            if let Some(i) = self.by_name.get(name) {
                told[*i] = Some(position);
            }
        }
        let mut moved = MovedLinks::default();
        for (joint, own) in self.joints.iter().zip(&told) {
            let followed = || {
                let mimic = joint.mimic.as_ref()?;
                let position = (*told.get(*self.by_name.get(&mimic.joint)?)?)?;
                Some(mimic.multiplier * position + mimic.offset)
            };
            let Some(position) = own.or_else(followed) else { continue };
            let is_movable = matches!(joint.motion, JointMotion::Turning(_) | JointMotion::Sliding(_));
            match joint.parent_from_child(position) {
                Some(parent_from_child) => moved.poses.push((joint, parent_from_child)),
                None if is_movable => drop(moved.unusable.get_or_insert((joint, position))),
                None => {}
            }
        }
        moved
    }
}

impl Joint {
    /// Pose of the child in the parent at a position in radians or meters. `None` if the joint does not move, in a way that one number
    /// does not tell, or the position is no number of a sensible size.
    pub fn parent_from_child(&self, position: f64) -> Option<Isometry3<f64>> {
        if !(-MAX_POSITION..=MAX_POSITION).contains(&position) {
            return None;
        }
        match &self.motion {
            JointMotion::Turning(axis) => Some(self.origin * UnitQuaternion::from_axis_angle(axis, position)),
            JointMotion::Sliding(axis) => {
                Some(self.origin * Translation3::from(axis.into_inner() * position))
            }
            JointMotion::Fixed | JointMotion::Untold(_) => None,
        }
    }
}
