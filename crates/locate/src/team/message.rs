//! What robots tell each other.

use nalgebra::{Matrix2, Matrix3, Point2};
use visloc_core::{Timestamp, geom::PlanarPose};

use crate::vision::{DetectedObject, ObjectKind};

/// Version of [`TeamMessage`]; messages of another one are left out.
pub const TEAM_MESSAGE_VERSION: u16 = 1;
/// Most hypotheses in a message.
pub const MAX_HYPOTHESES: usize = 4;
/// Most sightings in a message.
pub const MAX_SIGHTINGS: usize = 12;
/// Numbers beyond this are no place on any map, meters.
const MAX_COORDINATE_M: f64 = 1e4;
/// Stamps of ROS are at most so far from the epoch, nanoseconds.
const MAX_NANOS: i64 = (1 << 31) * 1_000_000_000;
/// Nobody sees farther, meters.
const MAX_RANGE_M: f64 = 100.0;
/// A sighting older than this, when it is told, says nothing of now, seconds.
const MAX_AGE_SECS: f64 = 5.0;

/// A robot in a team.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// Name of the team.
    pub team: String,
    /// Number of the robot, which no other one of the team has.
    pub number: u8,
    /// Anything that is another one after each start, for instance the stamp of the first image.
    pub session: u32,
}

/// What was seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SightingKind {
    /// A robot of the own team, by its jersey.
    Teammate,
    /// A robot of another team.
    Opponent,
    /// A robot of which the team was not seen.
    Robot,
    /// The ball.
    Ball,
    /// The person whom the whole team knows, for instance the referee.
    Person,
}

impl SightingKind {
    /// What there is one of, so that two robots that see it see the same.
    pub const SINGLE: [Self; 2] = [Self::Ball, Self::Person];
}

/// Something that a robot sees, without its identity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// When the image was taken, by the clock of the robot that saw it.
    pub at: Timestamp,
    /// What it is.
    pub kind: SightingKind,
    /// Where it stands on the floor, in the frame of the robot at the time of the image; in a message at the time of the message. Meters.
    pub in_robot: Point2<f64>,
    /// Covariance of that, square meters.
    pub covariance: Matrix2<f64>,
}

impl Sighting {
    /// From bearing (radians, to the left of straight ahead) and range (meters) with their standard deviations.
    pub fn polar(
        at: Timestamp,
        kind: SightingKind,
        (bearing_rad, bearing_sigma_rad): (f64, f64),
        (range_m, range_sigma_m): (f64, f64),
    ) -> Self {
        let (sin, cos) = bearing_rad.sin_cos();
        let turn = Matrix2::new(cos, -sin, sin, cos);
        let across_m = range_m * bearing_sigma_rad;
        let own = Matrix2::new(range_sigma_m * range_sigma_m, 0.0, 0.0, across_m * across_m);
        Self {
            at,
            kind,
            in_robot: Point2::new(range_m * cos, range_m * sin),
            covariance: turn * own * turn.transpose(),
        }
    }

    /// What the detector of [`crate::vision`] has found in an image of this time. It does not know teams.
    pub fn of_object(at: Timestamp, object: &DetectedObject) -> Self {
        let kind = match object.kind {
            ObjectKind::Robot => SightingKind::Robot,
            ObjectKind::Ball => SightingKind::Ball,
        };
        Self { at, kind, in_robot: object.in_robot, covariance: object.covariance }
    }

    /// Whether its numbers can be any sighting's.
    pub fn is_valid(&self) -> bool {
        let c = &self.covariance;
        let is_finite = self.in_robot.coords.iter().chain(c.iter()).all(|value| value.is_finite());
        is_finite && self.in_robot.coords.norm() <= MAX_RANGE_M && c[(0, 0)] > 0.0 && c.determinant() > 0.0
    }
}

/// One place where a robot may be, by its own localizer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToldHypothesis {
    /// Stays the same while the hypothesis moves on with the robot's odometry. On a symmetric map an odd one is the mirror of the even one
    /// before it.
    pub id: u16,
    /// The pose on the map.
    pub world_from_robot: PlanarPose,
    /// Covariance over (x, y, heading), meters and radians.
    pub covariance: Matrix3<f64>,
    /// Share of the robot's belief, 0 to 1.
    pub probability: f64,
}

/// Who knew: a robot between two of its starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Root {
    /// Number of the robot.
    pub number: u8,
    /// Its session.
    pub session: u32,
}

/// A half that others have decided for the sender.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ToldHalf {
    /// The hypothesis of the sender that is the right one.
    pub id: u16,
    /// Who knew.
    pub root: Root,
}

/// What a robot tells its team, some times a second.
#[derive(Debug, Clone, PartialEq)]
pub struct TeamMessage {
    /// Version of this layout.
    pub version: u16,
    /// Name of the team: several may share a network.
    pub team: String,
    /// Number of the robot in its team.
    pub number: u8,
    /// Anything that is another one after each start of the robot.
    pub session: u32,
    /// Counts the messages of a session.
    pub sequence: u32,
    /// For when it holds, by the sender's clock.
    pub at: Timestamp,
    /// Accumulated odometry then, `odom_from_robot`; `None` without odometry.
    pub odometry: Option<PlanarPose>,
    /// How far its own localizer trusts the place, 0 to 1, mirrored poses taken as one.
    pub reliability: f64,
    /// Where it may be, by its own localizer alone.
    pub hypotheses: Vec<ToldHypothesis>,
    /// The half that others have decided for it.
    pub half: Option<ToldHalf>,
    /// What it saw since its last message.
    pub sightings: Vec<Sighting>,
}

impl TeamMessage {
    /// What is wrong with the numbers, as a sentence; `None` if nothing is.
    pub fn fault(&self) -> Option<&'static str> {
        let is_share = |value: f64| (0.0..=1.0).contains(&value);
        let is_place = |pose: &PlanarPose| {
            pose.is_finite() && pose.x_m.abs() <= MAX_COORDINATE_M && pose.y_m.abs() <= MAX_COORDINATE_M
        };
        let is_time = |at: Timestamp| (-MAX_NANOS..=MAX_NANOS).contains(&at.nanos());
        if !is_time(self.at) || !self.sightings.iter().all(|s| is_time(s.at)) {
            return Some("expected stamps that a header of ROS can have");
        }
        if self.hypotheses.len() > MAX_HYPOTHESES || self.sightings.len() > MAX_SIGHTINGS {
            return Some("more hypotheses or sightings than a message may have");
        }
        if !is_share(self.reliability) || self.odometry.is_some_and(|pose| !pose.is_finite()) {
            return Some("expected a reliability from 0 to 1 and a finite odometry");
        }
        let is_told = |h: &ToldHypothesis| {
            let c = &h.covariance;
            let is_covariance = c.iter().all(|value| value.is_finite()) && (0..3).all(|i| c[(i, i)] >= 0.0);
            is_place(&h.world_from_robot) && is_share(h.probability) && is_covariance
        };
        if !self.hypotheses.iter().all(is_told) {
            return Some("expected finite poses with covariances and probabilities from 0 to 1");
        }
        let is_recent = |s: &Sighting| (-0.1..=MAX_AGE_SECS).contains(&self.at.secs_since(s.at));
        if !self.sightings.iter().all(|s| s.is_valid() && is_recent(s)) {
            return Some("expected sightings of the last seconds with finite positions and covariances");
        }
        None
    }
}

/// Most teammates.
pub(super) const MAX_MATES: usize = 10;

/// Why a message was left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Ignored {
    /// Another version.
    #[error(
        "expected messages of version {TEAM_MESSAGE_VERSION}, found version {0}: the same visloc is needed on all robots"
    )]
    Version(u16),
    /// Another team on the same network.
    #[error("the message is of another team")]
    OtherTeam,
    /// The own number: of this robot, or another one has it as well.
    #[error("the message has this robot's own number")]
    OwnNumber,
    /// Two robots have this number: both go on sending, though only one is listened to.
    #[error("two robots have the number {0}")]
    SameNumber(u8),
    /// Told twice, or overtaken by a newer one.
    #[error("the message is not newer than the last one of the same robot")]
    Old,
    /// Numbers that cannot be.
    #[error("{0}")]
    Fault(&'static str),
    /// Too many messages of one robot, or too many robots.
    #[error("too many messages of one robot, or more than {MAX_MATES} robots")]
    TooMany,
}
