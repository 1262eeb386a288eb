//! The tree of coordinate frames.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3};
use visloc_core::Timestamp;

use crate::bag::{
    StampedTransform,
    history::{History, Lookup, MAX_AGE_SECS, Pushed},
};

/// Longest chain of frames that is followed; longer ones are circles.
const MAX_DEPTH: usize = 64;

/// Most frames and most transforms that an error lists.
const MAX_LISTED: usize = 20;

/// Pose of a frame in its parent.
#[derive(Debug, Clone)]
struct Edge {
    parent: String,
    motion: Motion,
    teller: Teller,
}

/// Who says where a frame is. The greater one is believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Teller {
    /// The description of the robot, with positions of its joints.
    Joints,
    /// Messages with transforms.
    Transforms,
}

#[derive(Debug, Clone)]
enum Motion {
    Fixed(Isometry3<f64>),
    Moving(History<Isometry3<f64>>),
}

/// A pose that was looked up in the tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TreePose {
    pub dst_from_src: Isometry3<f64>,
    /// Whether a part of it is the last known value instead of one interpolated at the time.
    pub is_held: bool,
}

/// All frames by name.
#[derive(Debug, Clone, Default)]
pub(super) struct TfTree {
    edges: BTreeMap<String, Edge>,
}

impl TfTree {
    /// Adds the pose of a frame that moves. A frame that gets another parent, or is told by somebody greater, starts anew; what somebody
    /// less says of it is passed over.
    pub(super) fn add_moving(&mut self, transform: &StampedTransform, teller: Teller) -> Pushed {
        if !self.believes(teller, &transform.child) {
            return Pushed::Accepted;
        }
        let mut history = match self.edges.remove(&transform.child) {
            Some(Edge { parent, motion: Motion::Moving(history), teller: before })
                if parent == transform.parent && before == teller =>
            {
                history
            }
            _ => History::default(),
        };
        let pushed = history.push(transform.at, transform.parent_from_child);
        let edge = Edge { parent: transform.parent.clone(), motion: Motion::Moving(history), teller };
        self.edges.insert(transform.child.clone(), edge);
        pushed
    }

    /// Adds the pose of a frame that does not move, unless somebody greater tells it.
    pub(super) fn add_fixed(&mut self, transform: &StampedTransform, teller: Teller) {
        if self.believes(teller, &transform.child) {
            let motion = Motion::Fixed(transform.parent_from_child);
            self.edges
                .insert(transform.child.clone(), Edge { parent: transform.parent.clone(), motion, teller });
        }
    }

    /// Whether nobody greater says where a frame is.
    pub(super) fn believes(&self, teller: Teller, child: &str) -> bool {
        self.edges.get(child).is_none_or(|edge| edge.teller <= teller)
    }

    /// Whether it is known where a frame is in another one.
    pub(super) fn has_parent(&self, frame: &str) -> bool {
        self.edges.contains_key(frame)
    }

    /// Whether any frame is told in this one.
    pub(super) fn has_children(&self, frame: &str) -> bool {
        self.edges.values().any(|edge| edge.parent == frame)
    }

    /// Forgets where a frame is, if that is from joints.
    pub(super) fn forget_joint(&mut self, child: &str) {
        if self.edges.get(child).is_some_and(|edge| edge.teller == Teller::Joints) {
            self.edges.remove(child);
        }
    }

    /// Forgets everything that is from joints.
    pub(super) fn forget_joints(&mut self) {
        self.edges.retain(|_, edge| edge.teller != Teller::Joints);
    }

    /// The same tree without the parts that move.
    pub(super) fn fixed(&self) -> Self {
        let is_fixed = |edge: &Edge| matches!(edge.motion, Motion::Fixed(_));
        let edges = self.edges.iter().filter(|(_, edge)| is_fixed(edge));
        Self { edges: edges.map(|(child, edge)| (child.clone(), edge.clone())).collect() }
    }

    /// Whether every moving part between two frames is known at or after a time.
    pub(super) fn covers(&self, dst: &str, src: &str, at: Timestamp) -> bool {
        let Some((up_from_dst, up_from_src)) = self.branches(dst, src) else { return false };
        up_from_dst.iter().chain(&up_from_src).all(|child| {
            match self.edges.get(*child).map(|edge| &edge.motion) {
                Some(Motion::Moving(history)) => history.newest_at().is_some_and(|newest| newest >= at),
                Some(Motion::Fixed(_)) => true,
                None => false,
            }
        })
    }

    /// Pose of frame `src` in frame `dst`, or why it is not known.
    pub(super) fn lookup(&self, dst: &str, src: &str, at: Timestamp) -> Result<TreePose, String> {
        let Some((up_from_dst, up_from_src)) = self.branches(dst, src) else {
            return Err(self.why_not_connected(dst, src));
        };
        let (root_from_dst, is_dst_held) = self.compose(&up_from_dst, at)?;
        let (root_from_src, is_src_held) = self.compose(&up_from_src, at)?;
        Ok(TreePose {
            dst_from_src: root_from_dst.inverse() * root_from_src,
            is_held: is_dst_held || is_src_held,
        })
    }

    /// Which of the two frames is wrong, and what there is instead.
    fn why_not_connected(&self, dst: &str, src: &str) -> String {
        let parents = self.edges.values().map(|edge| edge.parent.as_str());
        let mut frames: Vec<&str> = self.edges.keys().map(String::as_str).chain(parents).collect();
        frames.sort_unstable();
        frames.dedup();
        if frames.is_empty() {
            return format!(
                "no transforms yet, expected some from '{dst}' to '{src}', positions of joints with a robot description (--urdf FILE), or \
                 --camera-height METERS --camera-tilt DEGREES"
            );
        }
        let edges = listed(self.edges.iter().map(|(child, edge)| format!("{} -> {child}", edge.parent)));
        for (frame, option, what) in
            [(dst, "--base-frame", "the robot on the ground"), (src, "--camera-frame", "the camera")]
        {
            if !frames.contains(&frame) {
                let known = listed(frames.iter().map(|frame| (*frame).to_owned()));
                return format!(
                    "there is no frame '{frame}' for {what}: set {option} to one of: {known} (transforms: {edges})"
                );
            }
        }
        format!(
            "expected a chain of transforms from '{dst}' (--base-frame) to '{src}' (--camera-frame), found only: {edges}"
        )
    }

    /// Drops what later times do not need.
    pub(super) fn forget_before(&mut self, at: Timestamp) {
        for edge in self.edges.values_mut() {
            if let Motion::Moving(history) = &mut edge.motion {
                history.forget_before(at);
            }
        }
    }

    /// The frames from each of the two up to below their nearest common ancestor.
    fn branches<'a>(&'a self, dst: &'a str, src: &'a str) -> Option<(Vec<&'a str>, Vec<&'a str>)> {
        let (mut from_dst, mut from_src) = (self.ancestors(dst), self.ancestors(src));
        let (num_dst, num_src) = from_dst
            .iter()
            .enumerate()
            .find_map(|(i, frame)| from_src.iter().position(|other| other == frame).map(|j| (i, j)))?;
        from_dst.truncate(num_dst);
        from_src.truncate(num_src);
        Some((from_dst, from_src))
    }

    /// A frame and everything above it.
    fn ancestors<'a>(&'a self, frame: &'a str) -> Vec<&'a str> {
        let mut chain = vec![frame];
        let mut last = frame;
        while let Some(edge) = self.edges.get(last).filter(|_| chain.len() < MAX_DEPTH) {
            last = &edge.parent;
            chain.push(last);
        }
        chain
    }

    /// Product of the poses of a branch, and whether one of them is held.
    fn compose(&self, branch: &[&str], at: Timestamp) -> Result<(Isometry3<f64>, bool), String> {
        let mut top_from_bottom = Isometry3::identity();
        let mut is_held = false;
        for child in branch {
            let Some(edge) = self.edges.get(*child) else { continue };
            let parent_from_child = match &edge.motion {
                Motion::Fixed(pose) => *pose,
                Motion::Moving(history) => match history.lookup(at) {
                    Some(Lookup::Between(a, b, fraction)) => interpolate(&a, &b, fraction),
                    Some(Lookup::Held(pose)) => {
                        is_held = true;
                        pose
                    }
                    None => {
                        return Err(format!(
                            "expected the transform {} -> {child} within {MAX_AGE_SECS} s of the image{}",
                            edge.parent,
                            apart(at, history.newest_at())
                        ));
                    }
                },
            };
            top_from_bottom = parent_from_child * top_from_bottom;
        }
        Ok((top_from_bottom, is_held))
    }
}

/// What is farther apart than this has not been late or silent, seconds.
const ANOTHER_CLOCK_SECS: f64 = 10.0;

/// How far the stamp of an image is off the last sample, as the end of a sentence: a driver may write none, or by another clock.
fn apart(image_at: Timestamp, newest: Option<Timestamp>) -> String {
    match newest {
        _ if image_at == Timestamp::default() => ", whose stamp is 0: its driver writes none".to_owned(),
        Some(newest) => {
            let secs = newest.secs_since(image_at);
            let side = if secs < 0.0 { "earlier" } else { "later" };
            let clock =
                if secs.abs() > ANOTHER_CLOCK_SECS { ": are both stamped by the same clock?" } else { "" };
            format!("; the last one is {:.1} s {side}{clock}", secs.abs())
        }
        None => String::new(),
    }
}

/// The first of them, and how many more there are.
fn listed(names: impl ExactSizeIterator<Item = String>) -> String {
    let num_more = names.len().saturating_sub(MAX_LISTED);
    let mut list = names.take(MAX_LISTED).collect::<Vec<_>>().join(", ");
    if num_more > 0 {
        list.push_str(&format!(" and {num_more} more"));
    }
    list
}

/// Straight line for the position, shortest turn for the rotation.
fn interpolate(a: &Isometry3<f64>, b: &Isometry3<f64>, fraction: f64) -> Isometry3<f64> {
    let translation = a.translation.vector.lerp(&b.translation.vector, fraction);
    // Half a turn between two samples has no shortest way; the earlier rotation stands for it.
    let rotation = a.rotation.try_slerp(&b.rotation, fraction, 1e-9).unwrap_or(a.rotation);
    Isometry3::from_parts(Translation3::from(translation), rotation)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;

    fn transform(secs: f64, parent: &str, child: &str, x_m: f64, yaw_rad: f64) -> StampedTransform {
        StampedTransform {
            at: Timestamp::from_secs(secs),
            parent: parent.into(),
            child: child.into(),
            parent_from_child: Isometry3::new(Vector3::new(x_m, 0.0, 0.0), Vector3::z() * yaw_rad),
        }
    }

    #[test]
    fn static_and_moving_frames_chain_through_the_common_ancestor() {
        let mut tree = TfTree::default();
        // base <- torso -> head -> camera
        tree.add_fixed(&transform(0.0, "torso", "base", 0.0, FRAC_PI_2), Teller::Transforms);
        tree.add_fixed(&transform(0.0, "head", "camera", 0.1, 0.0), Teller::Transforms);
        tree.add_moving(&transform(1.0, "torso", "head", 1.0, 0.0), Teller::Transforms);
        tree.add_moving(&transform(1.2, "torso", "head", 2.0, FRAC_PI_2), Teller::Transforms);
        let at = Timestamp::from_secs(1.1);
        assert!(
            tree.covers("base", "camera", at) && !tree.covers("base", "camera", Timestamp::from_secs(1.3))
        );
        let pose = tree.lookup("base", "camera", at).unwrap();
        assert!(!pose.is_held);
        // head at x = 1.5 turned by 45 degrees, camera 0.1 before it; seen from a base turned by 90 degrees
        let ahead = 0.1 * std::f64::consts::FRAC_1_SQRT_2;
        let expected = Vector3::new(ahead, -(1.5 + ahead), 0.0);
        assert!((pose.dst_from_src.translation.vector - expected).norm() < 1e-9, "{pose:?}");
        let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * -0.5 * FRAC_PI_2);
        assert!(pose.dst_from_src.rotation.angle_to(&turn) < 1e-9);
    }

    #[test]
    fn missing_chains_old_values_and_circles_are_reported() {
        let mut tree = TfTree::default();
        tree.add_moving(&transform(1.0, "base", "head", 1.0, 0.0), Teller::Transforms);
        let lookup = |tree: &TfTree, src, secs| tree.lookup("base", src, Timestamp::from_secs(secs));
        assert!(lookup(&tree, "head", 1.4).unwrap().is_held);
        let late = lookup(&tree, "head", 1.6).unwrap_err();
        assert!(late.contains("within 0.5 s") && late.contains("is 0.6 s earlier"), "{late}");
        assert!(lookup(&tree, "head", 1e3).unwrap_err().contains("999.0 s earlier: are both stamped"));
        assert!(lookup(&tree, "head", 0.0).unwrap_err().contains("whose stamp is 0"));
        assert_eq!(
            lookup(&tree, "camera", 1.0).unwrap_err(),
            "there is no frame 'camera' for the camera: set --camera-frame to one of: base, head (transforms: base -> head)"
        );
        tree.add_fixed(&transform(0.0, "tripod", "camera", 0.0, 0.0), Teller::Transforms);
        let apart = lookup(&tree, "camera", 1.0).unwrap_err();
        assert!(apart.contains("base -> head") && apart.contains("tripod -> camera"), "{apart}");
        tree.add_fixed(&transform(0.0, "head", "base", 0.0, 0.0), Teller::Transforms);
        assert!(lookup(&tree, "camera", 1.0).is_err());
    }

    #[test]
    fn another_parent_starts_anew() {
        let mut tree = TfTree::default();
        tree.add_moving(&transform(1.0, "base", "head", 1.0, 0.0), Teller::Transforms);
        tree.add_moving(&transform(1.1, "torso", "head", 5.0, 0.0), Teller::Transforms);
        assert!(tree.lookup("base", "head", Timestamp::from_secs(1.0)).is_err());
        assert!(tree.lookup("torso", "head", Timestamp::from_secs(1.1)).is_ok());
    }

    #[test]
    fn transforms_win_over_joints() {
        let at = Timestamp::from_secs(1.0);
        let x = |tree: &TfTree| tree.lookup("base", "head", at).unwrap().dst_from_src.translation.x;
        let mut tree = TfTree::default();
        tree.add_moving(&transform(1.0, "base", "head", 1.0, 0.0), Teller::Joints);
        assert_eq!(x(&tree), 1.0);
        tree.add_moving(&transform(1.0, "base", "head", 2.0, 0.0), Teller::Transforms);
        tree.add_moving(&transform(1.0, "base", "head", 3.0, 0.0), Teller::Joints);
        tree.add_fixed(&transform(0.0, "base", "head", 4.0, 0.0), Teller::Joints);
        assert_eq!(x(&tree), 2.0);
        tree.add_fixed(&transform(0.0, "base", "hand", 1.0, 0.0), Teller::Joints);
        tree.forget_joints();
        assert!(tree.has_parent("head") && !tree.has_parent("hand"));
    }

    #[test]
    fn long_lists_are_cut() {
        let mut tree = TfTree::default();
        for i in 0..500 {
            tree.add_fixed(&transform(0.0, "base", &format!("link {i}"), 0.0, 0.0), Teller::Joints);
        }
        let error = tree.lookup("base", "camera", Timestamp::default()).unwrap_err();
        assert!(error.len() < 800 && error.contains("and 481 more"), "{error}");
    }
}
