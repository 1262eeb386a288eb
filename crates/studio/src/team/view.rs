//! What pages are shown of a team.

use serde_json::{Value, json};
use visloc_locate::{
    LOCALIZED_RELIABILITY,
    team::{Help, SightingKind, TeamEstimate},
};

use super::{game::Game, robot::Robot};
use crate::view::{ContenderView, triple};

/// Robots are shown as algorithms are: each in a lane of its own, with what it answers with the team.
pub(super) fn contender(robot: &Robot) -> ContenderView {
    let view = ContenderView::new(&format!("robot {}", robot.number()), robot.pipeline());
    ContenderView { estimate: robot.answer().estimate.clone(), individuals: Vec::new(), ..view }
}

/// `team` of a state message: the ball, who is looked at, and of each robot what is not among what its contender says.
pub(super) fn team(game: &Game, look: usize) -> Value {
    let ball = game.ball();
    json!({
        "ball": [ball.x, ball.y],
        "look": look,
        "robots": game.robots().iter().map(fields).collect::<Vec<_>>(),
    })
}

fn fields(robot: &Robot) -> Value {
    let answer = robot.answer();
    let covariance = &answer.estimate.covariance;
    let (knows, by) = knowledge(answer);
    let truth = robot.truth();
    let at = robot.frame().frame.at;
    let seen = robot.sightings().iter().filter_map(|sighting| {
        let place = truth?.world_from_robot.transform(&sighting.in_robot);
        Some(json!([place.x, place.y, u8::from(sighting.kind == SightingKind::Ball)]))
    });
    let mates = robot.filter().mates().map(|mate| {
        json!({
            "number": mate.number,
            "pose": mate.world_from_robot.as_ref().map(triple),
            "trust": mate.trust,
            "heard_secs": at.secs_since(mate.heard_at).max(0.0),
        })
    });
    json!({
        "number": robot.number(),
        "truth": truth.map(|truth| triple(&truth.world_from_robot)),
        "height_m": truth.map(|truth| truth.height_m),
        "covariance": [covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]],
        "knows": knows,
        "by": by,
        "is_linked": robot.is_linked,
        "lie": robot.liar,
        "seen": seen.collect::<Vec<_>>(),
        "mates": mates.collect::<Vec<_>>(),
        "bytes_per_sec": robot.bytes_per_sec(),
    })
}

/// What a robot knows of its place, and who has helped: `half`, `mirror` (the place up to the symmetry), `placed` (where another one sees it)
/// or `lost`.
fn knowledge(answer: &TeamEstimate) -> (&'static str, Option<u8>) {
    let estimate = &answer.estimate;
    match answer.help {
        Help::Placed { by, .. } => ("placed", Some(by)),
        Help::Half { root, .. } if estimate.is_localized() => ("half", Some(root.number)),
        _ if estimate.is_localized() => ("half", None),
        _ if estimate.reliability_up_to_symmetry > LOCALIZED_RELIABILITY => ("mirror", None),
        _ => ("lost", None),
    }
}
