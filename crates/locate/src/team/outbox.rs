//! What the robot tells next.

use visloc_core::Timestamp;

use super::{
    TeamConfig,
    belief::Track,
    mate::Mate,
    message::{MAX_SIGHTINGS, Member, Sighting, TEAM_MESSAGE_VERSION, TeamMessage, ToldHalf, ToldHypothesis},
    symmetry::{Symmetry, mirrored_covariance},
};

/// Two sightings of one kind nearer than this are of one thing, meters: two robots cannot be.
const SAME_THING_M: f64 = 0.4;
/// Sightings are told for so long after their image, seconds.
const TOLD_SECS: f64 = 1.0;

/// Collects what is seen between two messages.
#[derive(Debug, Clone, Default)]
pub(super) struct Outbox {
    /// In the frame of the robot at the newest image.
    sightings: Vec<Sighting>,
    /// When the last one was made.
    sent_at: Option<Timestamp>,
    sequence: u32,
}

impl Outbox {
    /// Takes in the sightings of an image, in the frame of the robot now; `moved` brings those before into it.
    pub fn collect(&mut self, at: Timestamp, seen: &[Sighting], moved: &visloc_core::geom::PlanarPose) {
        let back = moved.inverse();
        for sighting in &mut self.sightings {
            *sighting = turned(sighting, &back);
        }
        self.sightings.retain(|sighting| at.secs_since(sighting.at) <= TOLD_SECS);
        for new in seen {
            self.sightings.retain(|old| !is_same_thing(old, new) || old.at == new.at);
            if self.sightings.len() == MAX_SIGHTINGS {
                self.sightings.remove(0);
            }
            self.sightings.push(*new);
        }
    }

    /// The next message, if it is time for one.
    pub fn message(
        &mut self,
        own: &Mate,
        half: Option<ToldHalf>,
        member: &Member,
        symmetry: Symmetry,
        config: &TeamConfig,
    ) -> Option<TeamMessage> {
        let at = own.belief.at;
        // An image that comes a little too soon would else put off every message by one image.
        const EARLY: f64 = 0.9;
        let is_due = |sent: Timestamp| at.secs_since(sent) * config.messages_per_sec >= EARLY;
        if !self.sent_at.is_none_or(is_due) {
            return None;
        }
        self.sent_at = Some(at);
        self.sequence += 1;
        Some(TeamMessage {
            version: TEAM_MESSAGE_VERSION,
            team: member.team.clone(),
            number: member.number,
            session: member.session,
            sequence: self.sequence,
            at,
            odometry: own.belief.motion.last(),
            reliability: own.belief.reliability.clamp(0.0, 1.0),
            hypotheses: own.belief.tracks.iter().flat_map(|track| told(track, symmetry)).collect(),
            half,
            sightings: std::mem::take(&mut self.sightings),
        })
    }
}

/// Whether two sightings in one frame are of one thing.
pub(super) fn is_same_thing(old: &Sighting, new: &Sighting) -> bool {
    old.kind == new.kind && (old.in_robot - new.in_robot).norm() < SAME_THING_M
}

/// A sighting in another frame, given the pose of its own frame there.
pub(super) fn turned(sighting: &Sighting, pose: &visloc_core::geom::PlanarPose) -> Sighting {
    let (sin, cos) = pose.yaw_rad.sin_cos();
    let turn = nalgebra::Matrix2::new(cos, -sin, sin, cos);
    Sighting {
        in_robot: pose.transform(&sighting.in_robot),
        covariance: turn * sighting.covariance * turn.transpose(),
        ..*sighting
    }
}

/// Both hypotheses of a track, or the one that there is.
fn told(track: &Track, symmetry: Symmetry) -> impl Iterator<Item = ToldHypothesis> {
    let even = ToldHypothesis {
        id: track.id,
        world_from_robot: track.world_from_robot,
        covariance: track.covariance,
        probability: track.shares[0].clamp(0.0, 1.0),
    };
    let odd = symmetry.mirrored(&track.world_from_robot).map(|world_from_robot| ToldHypothesis {
        id: track.id + 1,
        world_from_robot,
        covariance: mirrored_covariance(&track.covariance),
        probability: track.shares[1].clamp(0.0, 1.0),
    });
    std::iter::once(even).chain(odd)
}
