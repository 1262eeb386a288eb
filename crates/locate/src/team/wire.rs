//! Team messages and sightings as ROS 2 messages: plain fields in the order in which CDR writes them.
//!
//! Positions and covariances are single precision: a micrometer on a field, and half the bytes.

use nalgebra::{Matrix2, Matrix3, Point2};
use serde::{Deserialize, Serialize};
use visloc_core::{Timestamp, geom::PlanarPose};

use super::message::{
    MAX_HYPOTHESES, MAX_SIGHTINGS, Root, Sighting, SightingKind, TeamMessage, ToldHalf, ToldHypothesis,
};

/// A moment, `builtin_interfaces/msg/Time`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct WireTime {
    /// Whole seconds.
    pub sec: i32,
    /// The rest.
    pub nanosec: u32,
}

/// `visloc_msgs/msg/TeamHypothesis`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct WireHypothesis {
    /// As [`ToldHypothesis::id`].
    pub id: u16,
    /// Share of the belief, 0 to 1.
    pub probability: f32,
    /// x and y on the map, meters, and heading, radians.
    pub pose: [f32; 3],
    /// xx, xy, x heading, yy, y heading, heading heading.
    pub covariance: [f32; 6],
}

/// `visloc_msgs/msg/Sighting`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct WireSighting {
    /// 0 teammate, 1 opponent, 2 robot of an unknown team, 3 ball, 4 the person whom all know.
    pub kind: u8,
    /// From the image to the stamp of the message, milliseconds.
    pub age_ms: u16,
    /// Ahead of and to the left of the robot on the floor, meters.
    pub position: [f32; 2],
    /// xx, xy, yy, square meters.
    pub covariance: [f32; 3],
}

/// `visloc_msgs/msg/Sightings`: what a detector tells its robot.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct WireSightings {
    /// When the image was taken.
    pub stamp: WireTime,
    /// What is in it.
    pub sightings: Vec<WireSighting>,
}

/// `visloc_msgs/msg/TeamMessage`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct WireTeamMessage {
    /// Of the layout; first, so that others can be told.
    pub version: u16,
    /// Number of the robot.
    pub number: u8,
    /// Whether `odometry` is any.
    pub has_odometry: bool,
    /// As [`TeamMessage::session`].
    pub session: u32,
    /// As [`TeamMessage::sequence`].
    pub sequence: u32,
    /// For when it holds.
    pub stamp: WireTime,
    /// x, y, heading.
    pub odometry: [f32; 3],
    /// Up to the symmetry, 0 to 1.
    pub reliability: f32,
    /// Whether the three fields after it say anything.
    pub has_half: bool,
    /// The right hypothesis.
    pub half_id: u16,
    /// Who knew it.
    pub half_number: u8,
    /// Its session.
    pub half_session: u32,
    /// Name of the team.
    pub team: String,
    /// Where the robot may be.
    pub hypotheses: Vec<WireHypothesis>,
    /// What it sees.
    pub sightings: Vec<WireSighting>,
}

impl From<Timestamp> for WireTime {
    fn from(at: Timestamp) -> Self {
        let sec = at.nanos().div_euclid(1_000_000_000);
        let nanosec = at.nanos().rem_euclid(1_000_000_000);
        Self { sec: i32::try_from(sec).unwrap_or(i32::MAX), nanosec: u32::try_from(nanosec).unwrap_or(0) }
    }
}

impl From<WireTime> for Timestamp {
    fn from(time: WireTime) -> Self {
        Self::from_ros(time.sec, time.nanosec)
    }
}

fn kind_of(number: u8) -> Option<SightingKind> {
    match number {
        0 => Some(SightingKind::Teammate),
        1 => Some(SightingKind::Opponent),
        2 => Some(SightingKind::Robot),
        3 => Some(SightingKind::Ball),
        4 => Some(SightingKind::Person),
        _ => None,
    }
}

/// Single precision on the wire.
fn short(value: f64) -> f32 {
    value as f32
}

impl WireSighting {
    fn new(sighting: &Sighting, stamp: Timestamp) -> Self {
        let c = &sighting.covariance;
        let age_ms = (stamp.secs_since(sighting.at) * 1e3).round().clamp(0.0, f64::from(u16::MAX)) as u16;
        Self {
            kind: match sighting.kind {
                SightingKind::Teammate => 0,
                SightingKind::Opponent => 1,
                SightingKind::Robot => 2,
                SightingKind::Ball => 3,
                SightingKind::Person => 4,
            },
            age_ms,
            position: [short(sighting.in_robot.x), short(sighting.in_robot.y)],
            covariance: [short(c[(0, 0)]), short(c[(0, 1)]), short(c[(1, 1)])],
        }
    }

    /// What it says; `None` if it is of a kind that is not known, or its numbers are none.
    pub fn read(&self, stamp: Timestamp) -> Option<Sighting> {
        let [xx, xy, yy] = self.covariance.map(f64::from);
        let sighting = Sighting {
            at: stamp + -1e-3 * f64::from(self.age_ms),
            kind: kind_of(self.kind)?,
            in_robot: Point2::new(f64::from(self.position[0]), f64::from(self.position[1])),
            covariance: Matrix2::new(xx, xy, xy, yy),
        };
        sighting.is_valid().then_some(sighting)
    }
}

impl WireSightings {
    /// All of one image.
    pub fn new(stamp: Timestamp, sightings: &[Sighting]) -> Self {
        let sightings = sightings.iter().map(|sighting| WireSighting::new(sighting, stamp)).collect();
        Self { stamp: stamp.into(), sightings }
    }

    /// Those that can be used.
    pub fn read(&self) -> impl Iterator<Item = Sighting> + '_ {
        let stamp = self.stamp.into();
        self.sightings.iter().filter_map(move |sighting| sighting.read(stamp))
    }
}

impl From<&TeamMessage> for WireTeamMessage {
    fn from(message: &TeamMessage) -> Self {
        let pose = |pose: &PlanarPose| [pose.x_m, pose.y_m, pose.yaw_rad].map(short);
        let hypothesis = |h: &ToldHypothesis| {
            let c = &h.covariance;
            let covariance = [c[(0, 0)], c[(0, 1)], c[(0, 2)], c[(1, 1)], c[(1, 2)], c[(2, 2)]].map(short);
            let (id, probability) = (h.id, short(h.probability));
            WireHypothesis { id, probability, pose: pose(&h.world_from_robot), covariance }
        };
        let root = message.half.map(|half| half.root);
        Self {
            version: message.version,
            number: message.number,
            has_odometry: message.odometry.is_some(),
            session: message.session,
            sequence: message.sequence,
            stamp: message.at.into(),
            odometry: message.odometry.as_ref().map_or([0.0; 3], pose),
            reliability: short(message.reliability),
            has_half: message.half.is_some(),
            half_id: message.half.map_or(0, |half| half.id),
            half_number: root.map_or(0, |root| root.number),
            half_session: root.map_or(0, |root| root.session),
            team: message.team.clone(),
            hypotheses: message.hypotheses.iter().map(hypothesis).collect(),
            sightings: message.sightings.iter().map(|s| WireSighting::new(s, message.at)).collect(),
        }
    }
}

impl WireTeamMessage {
    /// The message. Sightings of kinds that are not known are left out; everything else is judged by who receives it
    /// ([`super::TeamFilter::receive`]).
    pub fn read(&self) -> TeamMessage {
        let pose = |[x, y, yaw]: [f32; 3]| PlanarPose::new(f64::from(x), f64::from(y), f64::from(yaw));
        let hypothesis = |h: &WireHypothesis| {
            let [xx, xy, xt, yy, yt, tt] = h.covariance.map(f64::from);
            ToldHypothesis {
                id: h.id,
                world_from_robot: pose(h.pose),
                covariance: Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt),
                probability: f64::from(h.probability),
            }
        };
        let at = Timestamp::from(self.stamp);
        let root = Root { number: self.half_number, session: self.half_session };
        // One too many is enough to be refused.
        let sightings = self.sightings.iter().take(MAX_SIGHTINGS + 1);
        TeamMessage {
            version: self.version,
            team: self.team.clone(),
            number: self.number,
            session: self.session,
            sequence: self.sequence,
            at,
            odometry: self.has_odometry.then(|| pose(self.odometry)),
            reliability: f64::from(self.reliability),
            hypotheses: self.hypotheses.iter().take(MAX_HYPOTHESES + 1).map(hypothesis).collect(),
            half: self.has_half.then_some(ToldHalf { id: self.half_id, root }),
            sightings: sightings.filter_map(|sighting| sighting.read(at)).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_survives_the_wire() {
        use SightingKind::{Ball, Opponent, Person, Robot, Teammate};
        let at = Timestamp::from_secs(1.0);
        for kind in [Teammate, Opponent, Robot, Ball, Person] {
            let sighting = Sighting::polar(at, kind, (0.3, 0.05), (2.0, 0.2));
            assert_eq!(WireSighting::new(&sighting, at).read(at).map(|read| read.kind), Some(kind));
        }
    }

    #[test]
    fn messages_survive_the_wire() {
        let at = Timestamp::from_nanos(1_700_000_000_250_000_000);
        let sighting = Sighting::polar(at + -0.05, SightingKind::Ball, (0.3, 0.05), (2.0, 0.2));
        let hypothesis = ToldHypothesis {
            id: 6,
            world_from_robot: PlanarPose::new(1.25, -2.5, 0.75),
            covariance: Matrix3::new(0.04, 0.01, 0.0, 0.01, 0.09, 0.02, 0.0, 0.02, 0.01),
            probability: 0.5,
        };
        let message = TeamMessage {
            version: 1,
            team: "ours".into(),
            number: 3,
            session: 77,
            sequence: 9,
            at,
            odometry: Some(PlanarPose::new(0.5, 0.25, -0.125)),
            reliability: 0.75,
            hypotheses: vec![hypothesis],
            half: Some(ToldHalf { id: 6, root: Root { number: 1, session: 5 } }),
            sightings: vec![sighting],
        };
        let read = WireTeamMessage::from(&message).read();
        assert_eq!(read.fault(), None);
        assert_eq!(
            (read.at, &read.team, read.half, read.odometry),
            (at, &message.team, message.half, message.odometry)
        );
        assert!((read.hypotheses[0].covariance - hypothesis.covariance).norm() < 1e-6);
        assert_eq!(read.hypotheses[0].world_from_robot, hypothesis.world_from_robot);
        let (seen, told) = (read.sightings[0], sighting);
        assert!((seen.in_robot - told.in_robot).norm() < 1e-6 && seen.at.secs_since(told.at).abs() < 1e-3);
        assert!((seen.covariance - told.covariance).norm() < 1e-6 && seen.kind == told.kind);
    }

    #[test]
    fn what_is_not_known_is_left_out_and_nonsense_stays_refusable() {
        let strange = WireSighting { kind: 9, covariance: [0.1, 0.0, 0.1], ..WireSighting::default() };
        let message = WireSightings { stamp: WireTime { sec: 4, nanosec: 0 }, sightings: vec![strange] };
        assert_eq!(message.read().count(), 0);
        let mut message = WireTeamMessage { version: 1, ..WireTeamMessage::default() };
        message.hypotheses = vec![WireHypothesis { pose: [f32::NAN; 3], ..WireHypothesis::default() }];
        assert!(message.read().fault().is_some());
        message.hypotheses = vec![WireHypothesis::default(); 99];
        assert!(message.read().fault().is_some());
    }
}
