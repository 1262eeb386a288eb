//! What robots of a team tell each other, and what detectors tell them.

use visloc_core::{Timestamp, geom::PlanarPose};
use visloc_io::bag::messages::{from_cdr, to_cdr};
use visloc_locate::{
    Estimate,
    team::{
        Member, Sighting, SightingKind, TeamConfig, TeamFilter, WireHypothesis, WireSightings,
        WireTeamMessage, WireTime,
    },
};
use visloc_world::Map;

use super::{choice, chosen};

fn seen(at: Timestamp) -> Vec<Sighting> {
    [(SightingKind::Teammate, 0.3, 2.0), (SightingKind::Ball, -0.4, 1.5)]
        .map(|(kind, bearing, range)| Sighting::polar(at, kind, (bearing, 0.05), (range, 0.2)))
        .into()
}

pub fn seeds() -> Vec<Vec<u8>> {
    let at = Timestamp::from_secs(5.0);
    let sightings = WireSightings::new(at, &seen(at));
    let hypothesis =
        |id: u16, x: f32| WireHypothesis { id, probability: 0.5, pose: [x, 0.5, 0.2], covariance: [0.01; 6] };
    let message = WireTeamMessage {
        version: 1,
        number: 2,
        has_odometry: true,
        session: 8,
        sequence: 1,
        stamp: WireTime { sec: 5, nanosec: 0 },
        reliability: 0.9,
        has_half: true,
        half_id: 1,
        half_number: 3,
        team: "ours".into(),
        hypotheses: vec![hypothesis(0, 1.0), hypothesis(1, -1.0)],
        sightings: sightings.sightings.clone(),
        ..WireTeamMessage::default()
    };
    vec![chosen(0, to_cdr(&message).unwrap()), chosen(1, to_cdr(&sightings).unwrap())]
}

/// One robot hears the message, or its detector's, and goes on.
pub fn read(bytes: &[u8]) {
    let Some((form, rest)) = choice(bytes, 2) else { return };
    let member = Member { team: "ours".into(), number: 1, session: 1 };
    let map = Map::load("robocup-spl-2024").unwrap();
    let mut filter = TeamFilter::new(TeamConfig::default(), member, &map).unwrap();
    let at = Timestamp::from_secs(5.0);
    let mut sightings = seen(at);
    match form {
        0 => {
            let Ok(message) = from_cdr::<WireTeamMessage>(rest) else { return };
            let _ = filter.receive(&message.read(), at);
            let _ = filter.receive(&message.read(), at + 0.1);
        }
        _ => {
            let Ok(message) = from_cdr::<WireSightings>(rest) else { return };
            sightings.extend(message.read());
        }
    }
    for step in 0..3 {
        let at = at + 0.1 * f64::from(step);
        let answer = filter.step(at, &Estimate::unknown(), Some(PlanarPose::default()), &sightings);
        let total: f64 = answer.estimate.hypotheses.iter().map(|h| h.probability).sum();
        assert!(answer.estimate.hypotheses.is_empty() || (total - 1.0).abs() < 1e-6);
        assert!(answer.estimate.world_from_robot.is_finite());
        filter.message();
        filter.advice();
    }
}
