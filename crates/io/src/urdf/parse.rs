//! From XML to joints.

use std::path::Path;

use nalgebra::{Isometry3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};
use roxmltree::{Document, Node, ParsingOptions};
use visloc_core::files;

use super::{Joint, JointMotion, Mimic, RobotDescription};
use crate::FileError;

/// Most bytes of a description; those of humanoids with hands have some hundred thousand.
const MAX_BYTES: usize = 8 << 20;
/// Most elements, texts and comments.
const MAX_NODES: u32 = 500_000;
/// Most attributes of an element, and most declarations of name spaces: what they cost grows with their square.
const MAX_ATTRIBUTES: usize = 500;
const MAX_NAMESPACES: usize = 100;
/// Most joints, and most of them that move: each keeps its last poses.
const MAX_JOINTS: usize = 4000;
const MAX_MOVING: usize = 500;
/// Longest name, bytes.
const MAX_NAME_BYTES: usize = 200;
/// Largest number in an origin, meters or radians, or of a mimicked joint.
const MAX_NUMBER: f64 = 1e4;

/// Reads a robot description: a file of URDF, which xacro has been run on if need be.
///
/// # Errors
/// If the file cannot be read, or its text is no robot description: see [`RobotDescription::parse`].
pub fn read_robot_description(path: &Path) -> Result<RobotDescription, FileError> {
    let bytes = files::read(path, MAX_BYTES as u64).map_err(FileError::io(path))?;
    let text = std::str::from_utf8(files::without_mark(&bytes))
        .map_err(|_| FileError::form(path, "expected text in UTF-8"))?;
    RobotDescription::parse(text).map_err(|reason| FileError::form(path, reason))
}

impl RobotDescription {
    /// Reads URDF, as the topic `/robot_description` has it.
    ///
    /// # Errors
    /// If it is no XML, too large, no description of a robot, or the joints make no robot: see [`RobotDescription::new`]. What was expected,
    /// what was found, and in which line.
    pub fn parse(text: &str) -> Result<Self, String> {
        check_size(text)?;
        let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
        let document = Document::parse_with_options(text, options)
            .map_err(|error| format!("expected a robot description (URDF): {}", shown(&error.to_string())))?;
        let robot = document.root_element();
        if robot.tag_name().name() != "robot" {
            let found = shown(robot.tag_name().name());
            return Err(format!(
                "expected a robot description (URDF) with <robot> around it, found <{found}>"
            ));
        }
        let (mut joints, mut num_moving) = (Vec::new(), 0);
        // Below the root there are others called so, of controllers and transmissions.
        for node in robot.children().filter(Node::is_element) {
            if node.tag_name().namespace().is_some_and(|space| space.contains("xacro")) {
                let name = shown(node.tag_name().name());
                return Err(format!(
                    "expected a robot description (URDF), found its source, <xacro:{name}>: run xacro on it first"
                ));
            }
            if node.tag_name().name() == "joint" {
                let joint = joint(node).map_err(|reason| {
                    let line = document.text_pos_at(node.range().start).row;
                    format!("line {line}: {reason}")
                })?;
                num_moving += usize::from(joint.motion != JointMotion::Fixed);
                joints.push(joint);
            }
            if joints.len() > MAX_JOINTS || num_moving > MAX_MOVING {
                return Err(format!(
                    "expected at most {MAX_JOINTS} joints, {MAX_MOVING} of them moving, found more"
                ));
            }
        }
        Self::new(joints)
    }
}

/// Refuses what would take long.
fn check_size(text: &str) -> Result<(), String> {
    if text.len() > MAX_BYTES {
        return Err(format!(
            "expected a robot description of at most {MAX_BYTES} bytes, found {}",
            text.len()
        ));
    }
    let is_tag = |part: &&str| !part.starts_with(['!', '?']);
    let num_attributes = |tag: &str| tag.bytes().filter(|byte| *byte == b'=').count();
    if text.split('<').filter(is_tag).any(|tag| num_attributes(tag) > MAX_ATTRIBUTES) {
        return Err(format!("expected at most {MAX_ATTRIBUTES} attributes of an element, found more"));
    }
    if text.matches("xmlns").count() > MAX_NAMESPACES {
        return Err(format!("expected at most {MAX_NAMESPACES} name spaces (xmlns), found more"));
    }
    Ok(())
}

fn joint(node: Node<'_, '_>) -> Result<Joint, String> {
    let name = name(node, "name").map_err(|reason| format!("joint: {reason}"))?;
    let told = |reason: String| format!("joint '{name}': {reason}");
    let link = |element: &str| {
        let node = child(node, element).ok_or_else(|| told(format!("expected <{element} link=...>")))?;
        let link = self::name(node, "link").map_err(|reason| told(format!("<{element}>: {reason}")))?;
        Ok::<_, String>(link.strip_prefix('/').unwrap_or(&link).to_owned())
    };
    let (parent, child_link) = (link("parent")?, link("child")?);
    let origin = child(node, "origin").map_or(Ok(Isometry3::identity()), origin);
    let motion = motion(node).map_err(told)?;
    Ok(Joint {
        parent,
        child: child_link,
        origin: origin.map_err(|reason| told(format!("<origin>: {reason}")))?,
        motion,
        mimic: child(node, "mimic").map(mimic).transpose().map_err(told)?,
        name,
    })
}

fn motion(node: Node<'_, '_>) -> Result<JointMotion, String> {
    let kind = node.attribute("type").ok_or("expected type=...")?;
    let is_turning = match kind {
        "fixed" => return Ok(JointMotion::Fixed),
        "floating" | "planar" => return Ok(JointMotion::Untold(kind.to_owned())),
        "revolute" | "continuous" => true,
        "prismatic" => false,
        other => {
            return Err(format!(
                "expected the type fixed, revolute, continuous, prismatic, floating or planar, found '{}'",
                shown(other)
            ));
        }
    };
    let axis = match child(node, "axis").and_then(|axis| axis.attribute("xyz")) {
        Some(text) => numbers::<3>("xyz", text).map_err(|reason| format!("<axis>: {reason}"))?,
        None => [1.0, 0.0, 0.0],
    };
    Ok(match Unit::try_new(Vector3::from(axis), 1e-6) {
        Some(axis) if is_turning => JointMotion::Turning(axis),
        Some(axis) => JointMotion::Sliding(axis),
        None => JointMotion::Untold(format!("{kind} without an axis")),
    })
}

/// The rotation is that of fixed axes: roll about x, then pitch about y, then yaw about z.
fn origin(node: Node<'_, '_>) -> Result<Isometry3<f64>, String> {
    let xyz = node.attribute("xyz").map_or(Ok([0.0; 3]), |text| numbers("xyz", text))?;
    let rotation = match (node.attribute("rpy"), node.attribute("quat_xyzw")) {
        (Some(_), Some(_)) => return Err("expected rpy or quat_xyzw, found both".to_owned()),
        (None, None) => UnitQuaternion::identity(),
        (Some(text), None) => {
            let [roll, pitch, yaw] = numbers("rpy", text)?;
            UnitQuaternion::from_euler_angles(roll, pitch, yaw)
        }
        (None, Some(text)) => {
            let [x, y, z, w] = numbers("quat_xyzw", text)?;
            UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-6)
                .ok_or("quat_xyzw: expected a rotation, found zeros")?
        }
    };
    Ok(Isometry3::from_parts(Translation3::from(Vector3::from(xyz)), rotation))
}

fn mimic(node: Node<'_, '_>) -> Result<Mimic, String> {
    let told = |reason: String| format!("<mimic>: {reason}");
    let number = |key: &str, otherwise: f64| match node.attribute(key) {
        Some(text) => numbers::<1>(key, text).map(|[number]| number).map_err(told),
        None => Ok(otherwise),
    };
    Ok(Mimic {
        joint: name(node, "joint").map_err(told)?,
        multiplier: number("multiplier", 1.0)?,
        offset: number("offset", 0.0)?,
    })
}

fn child<'a, 'd>(node: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
    node.children().find(|child| child.has_tag_name(name))
}

fn name(node: Node<'_, '_>, key: &str) -> Result<String, String> {
    match node.attribute(key) {
        None | Some("") => Err(format!("expected {key}=\"...\"")),
        Some(name) if name.len() > MAX_NAME_BYTES => {
            Err(format!("{key}: expected a name of at most {MAX_NAME_BYTES} bytes, found {}", name.len()))
        }
        Some(name) => Ok(name.to_owned()),
    }
}

fn numbers<const N: usize>(key: &str, text: &str) -> Result<[f64; N], String> {
    let expected =
        || format!("{key}: expected {N} numbers from -{MAX_NUMBER} to {MAX_NUMBER}, found '{}'", shown(text));
    let mut words = text.split_whitespace();
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        let word = words.next().ok_or_else(expected)?;
        *number = word.parse().ok().filter(|n: &f64| n.abs() <= MAX_NUMBER).ok_or_else(expected)?;
    }
    if words.next().is_some() { Err(expected()) } else { Ok(numbers) }
}

/// The beginning of a text that may be long.
fn shown(text: &str) -> String {
    const MAX_CHARS: usize = 80;
    let mut start: String = text.chars().take(MAX_CHARS).collect();
    if start.len() < text.len() {
        start.push_str("...");
    }
    start
}
