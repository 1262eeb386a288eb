use std::f64::consts::PI;

use nalgebra::{Matrix3, Point2};
use rand::RngExt as _;
use visloc_core::{RngTree, Timestamp, geom::PlanarPose};
use visloc_world::Map;

use super::*;
use crate::{Estimate, Hypothesis, StartPrior};

/// Time between two images, seconds.
const STEP_SECS: f64 = 0.1;

fn mirrored(pose: &PlanarPose) -> PlanarPose {
    PlanarPose::new(-pose.x_m, -pose.y_m, pose.yaw_rad + PI)
}

/// What a localizer says that is sure of its place: its own side has this probability.
fn believes(pose: &PlanarPose, share: f64) -> Estimate {
    let covariance = Matrix3::from_diagonal(&nalgebra::Vector3::new(4e-4, 4e-4, 1e-4));
    let hypothesis = |world_from_robot, probability| Hypothesis { world_from_robot, covariance, probability };
    let answer = if share < 0.5 { mirrored(pose) } else { *pose };
    let mut estimate = Estimate {
        world_from_robot: answer,
        covariance,
        reliability: 0.9 * (2.0 * share.max(1.0 - share) - 1.0),
        reliability_up_to_symmetry: 0.9,
        likelihood: 0.9,
        hypotheses: vec![hypothesis(*pose, share), hypothesis(mirrored(pose), 1.0 - share)],
    };
    estimate.normalize_hypotheses();
    estimate
}

/// One robot of a game without cameras.
struct Player {
    filter: TeamFilter,
    truth: PlanarPose,
    /// What its localizer says.
    estimate: Estimate,
    sees: bool,
}

impl Player {
    fn new(number: u8, truth: PlanarPose, share: f64) -> Self {
        Self { filter: filter(number, 1), truth, estimate: believes(&truth, share), sees: true }
    }
}

fn filter(number: u8, session: u32) -> TeamFilter {
    let member = Member { team: "ours".into(), number, session };
    TeamFilter::new(TeamConfig::default(), member, &Map::load("robocup-spl-2024").unwrap()).unwrap()
}

/// Everybody who looks that way sees who is within 3 m, exactly.
fn sightings(players: &[Player], me: usize, at: Timestamp) -> Vec<Sighting> {
    let here = players[me].truth;
    let see = |truth: &PlanarPose| {
        let point = here.inverse().transform(&truth.position());
        let (range_m, bearing_rad) = (point.coords.norm(), point.y.atan2(point.x));
        (range_m < 3.0 && bearing_rad.abs() < 1.0).then(|| {
            Sighting::polar(at, SightingKind::Teammate, (bearing_rad, 0.05), (range_m, 0.1 * range_m))
        })
    };
    let others = players.iter().enumerate().filter(|(i, _)| *i != me);
    if players[me].sees { others.filter_map(|(_, player)| see(&player.truth)).collect() } else { Vec::new() }
}

/// Plays on; `cut` says whose messages to whom are lost.
fn play(players: &mut [Player], from_secs: f64, secs: f64, cut: impl Fn(usize, usize) -> bool) {
    let num_steps = (secs / STEP_SECS).round() as u32;
    for step in 0..num_steps {
        let at = Timestamp::from_secs(from_secs + f64::from(step) * STEP_SECS);
        let mut messages = Vec::new();
        for me in 0..players.len() {
            let seen = sightings(players, me, at);
            let player = &mut players[me];
            let estimate = player.estimate.clone();
            player.filter.step(at, &estimate, Some(PlanarPose::default()), &seen);
            messages.extend(player.filter.message().map(|message| (me, message)));
        }
        for (from, message) in messages {
            for to in (0..players.len()).filter(|to| *to != from && !cut(from, *to)) {
                players[to].filter.receive(&message, at + 0.02).unwrap();
            }
        }
    }
}

/// Plays on with robots that stand elsewhere each second: two looks at one that stands still say no more than one.
fn play_walking(players: &mut [Player], from_secs: f64, secs: u32) {
    for second in 0..secs {
        for (i, player) in players.iter_mut().enumerate() {
            let side = if second.is_multiple_of(2) { 1.0 } else { -1.0 };
            let step_m = 0.5 * side * (i as f64 - 1.0);
            player.truth.y_m += step_m;
            player.estimate.world_from_robot.y_m += step_m;
            for hypothesis in &mut player.estimate.hypotheses {
                let pose = &mut hypothesis.world_from_robot;
                let is_own = (pose.yaw_rad - player.truth.yaw_rad).abs() < 1.0;
                pose.y_m += if is_own { step_m } else { -step_m };
            }
        }
        play(players, from_secs + f64::from(second), 1.0, nobody);
    }
}

fn is_right(player: &Player) -> bool {
    let estimate = &player.filter.answer().estimate;
    estimate.is_localized() && estimate.world_from_robot.distance_m(&player.truth) < 0.3
}

fn nobody(_: usize, _: usize) -> bool {
    false
}

/// Three in a row: the first sees the second, and that one the third.
fn row(shares: [f64; 3]) -> Vec<Player> {
    let poses = [(-2.0, 0.6, 0.0), (0.0, 0.6, 0.3), (2.0, 1.2, 0.5)];
    let all = (1..).zip(poses).zip(shares);
    all.map(|((number, (x, y, yaw)), share)| Player::new(number, PlanarPose::new(x, y, yaw), share)).collect()
}

#[test]
fn alone_it_is_the_localizers_estimate_bit_for_bit() {
    let mut players = row([0.5, 0.99, 0.3]);
    players.truncate(1);
    play(&mut players, 0.0, 2.0, nobody);
    let answer = players[0].filter.answer();
    assert!(answer.help == Help::Alone && answer.estimate == players[0].estimate);
}

/// One that knows decides for who sees it and for who is seen by it, also by way of another one, whichever side they follow.
#[test]
fn one_that_knows_decides_for_all() {
    for known in 0..3 {
        for flips in 0..4 {
            let mut shares = [0.5 - 1e-6, 0.5 - 1e-6, 0.5 - 1e-6];
            (0..2).filter(|i| flips >> i & 1 == 1).for_each(|i| shares[i] = 0.5 + 1e-6);
            shares[known] = 0.99;
            let mut players = row(shares);
            play(&mut players, 0.0, 4.0, nobody);
            assert!(players.iter().all(is_right), "{known} {flips}");
            let root = players[known].filter.own_root();
            for (i, player) in players.iter().enumerate().filter(|(i, _)| *i != known) {
                let Help::Half { root: by, probability } = player.filter.answer().help else { panic!("{i}") };
                assert!(by == root && probability > 0.9);
                let sum: f64 = player.filter.answer().estimate.hypotheses.iter().map(|h| h.probability).sum();
                assert!((sum - 1.0).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn without_sightings_or_knowledge_nothing_is_decided() {
    let mut players = row([0.5; 3]);
    play(&mut players, 0.0, 4.0, nobody);
    assert!(players.iter().all(|player| player.filter.answer().help == Help::Alone));
    let mut players = row([0.99, 0.5, 0.5]);
    players.iter_mut().for_each(|player| player.sees = false);
    play(&mut players, 0.0, 4.0, nobody);
    assert!(players[1..].iter().all(|player| player.filter.answer().estimate == player.estimate));
}

/// One that is sure of the wrong half drags nobody while one that knows is there, seen or not.
#[test]
fn one_that_lies_drags_nobody() {
    for liar in [0, 2] {
        let mut shares = [0.5; 3];
        (shares[liar], shares[2 - liar]) = (0.01, 0.99);
        for is_seen in [true, false] {
            let mut players = row(shares);
            if !is_seen {
                players[2 - liar].truth = PlanarPose::new(-3.0, -2.5, 3.0);
                players[2 - liar].estimate = believes(&players[2 - liar].truth.clone(), 0.99);
            }
            play(&mut players, 0.0, 6.0, nobody);
            let answer = players[1].filter.answer();
            assert!(!answer.estimate.is_localized(), "{liar} {is_seen} {answer:?}");
            assert!(is_right(&players[2 - liar]), "who knows keeps its place");
        }
    }
    // Two that know outvote it, and correct it.
    let mut players = row([0.99, 0.99, 0.01]);
    play_walking(&mut players, 0.0, 8);
    assert!(players.iter().all(is_right));
}

/// One that knows its half has not found its place yet, and one that lies has: nobody is dragged meanwhile.
#[test]
fn who_still_looks_for_its_place_has_a_say() {
    let mut players = row([0.99, 0.5, 0.01]);
    players[0].estimate.reliability_up_to_symmetry = 0.0;
    play(&mut players, 0.0, 6.0, nobody);
    assert!(!players[1].filter.answer().estimate.is_localized(), "{:?}", players[1].filter.answer());
    players[0].estimate = believes(&players[0].truth.clone(), 0.99);
    play(&mut players, 6.0, 4.0, nobody);
    assert!(!players[1].filter.answer().estimate.is_localized() && is_right(&players[0]));
    // One that never finds it holds up nobody for ever.
    let mut players = row([0.99, 0.5, 0.99]);
    players[0].estimate.reliability_up_to_symmetry = 0.0;
    play(&mut players, 0.0, 15.0, nobody);
    assert!(is_right(&players[1]), "{:?}", players[1].filter.answer());
}

/// Something is seen once where the mirrored robot would be: nobody is tied by it, and the robot itself, seen for a second, is.
#[test]
fn one_false_sighting_ties_nobody() {
    let mut players = row([0.99, 0.5 - 1e-6, 0.5]);
    players.truncate(2);
    players.iter_mut().for_each(|player| player.sees = false);
    play(&mut players, 0.0, 3.0, nobody);
    let truth = players[1].truth;
    (players[0].sees, players[1].truth) = (true, mirrored(&truth));
    play(&mut players, 3.0, STEP_SECS, nobody);
    (players[0].sees, players[1].truth) = (false, truth);
    for second in 0..10 {
        play(&mut players, 3.1 + f64::from(second), 1.0, nobody);
        assert_eq!(players[1].filter.answer().help, Help::Alone, "{second}");
    }
    players[0].sees = true;
    play(&mut players, 13.1, 1.0, nobody);
    assert!(is_right(&players[1]), "{:?}", players[1].filter.answer());
}

/// One that sees robots and balls everywhere and is sure of the wrong half: nobody believes it, and it ties nobody to anybody.
#[test]
fn an_inventor_ties_nobody() {
    let mut players = row([0.99, 0.5, 0.01]);
    players[..2].iter_mut().for_each(|player| player.sees = false);
    let mut rng = RngTree::new(5).stream("inventor", 0);
    for step in 0..300 {
        let at = Timestamp::from_secs(f64::from(step) * STEP_SECS);
        let invented: Vec<Sighting> = (0..4)
            .map(|i| {
                let kind = if i == 0 { SightingKind::Ball } else { SightingKind::Teammate };
                let (bearing_rad, range_m) = (rng.random_range(-1.0..1.0), rng.random_range(0.5..4.0));
                Sighting::polar(at, kind, (bearing_rad, 0.02), (range_m, 0.05 * range_m))
            })
            .collect();
        for me in 0..3 {
            let (seen, estimate) = (if me == 2 { &invented[..] } else { &[] }, players[me].estimate.clone());
            players[me].filter.step(at, &estimate, Some(PlanarPose::default()), seen);
            let Some(message) = players[me].filter.message() else { continue };
            for to in (0..3).filter(|to| *to != me) {
                players[to].filter.receive(&message, at + 0.02).unwrap();
            }
        }
        let answer = players[1].filter.answer();
        assert!(answer.help == Help::Alone, "{step}: {answer:?}");
    }
    let trust = |number: u8| players[1].filter.mates().find(|mate| mate.number == number).unwrap().trust;
    assert!(trust(3) < 0.1 && trust(1) > 0.7, "{} {}", trust(3), trust(1));
}

#[test]
fn one_that_stands_elsewhere_than_it_says_loses_trust() {
    let mut players = row([0.99, 0.99, 0.5]);
    // The first sees both: the second where it says that it is, the third where nobody is.
    players[2].truth = PlanarPose::new(0.6, 1.2, 0.5);
    players[2].estimate = believes(&PlanarPose::new(0.5, -2.0, 0.5), 1.0);
    play_walking(&mut players, 0.0, 8);
    let trust = |number: u8| players[1].filter.mates().find(|mate| mate.number == number).unwrap().trust;
    assert!(trust(1) > 0.9 && trust(3) < 0.2, "{} {}", trust(1), trust(3));
    assert!(is_right(&players[0]) && is_right(&players[1]));
}

#[test]
fn one_that_knows_nothing_is_placed_by_who_sees_it() {
    let mut players = row([0.99, 0.5, 0.5]);
    players.truncate(2);
    players[1].truth = PlanarPose::new(0.0, 0.6, 2.9);
    players[1].estimate = Estimate::unknown();
    play(&mut players, 0.0, 2.0, nobody);
    assert!(players[1].filter.advice().is_none(), "the localizer has to look for itself first");
    play(&mut players, 2.0, 2.0, nobody);
    let truth = players[1].truth;
    let answer = players[1].filter.answer().clone();
    assert!(matches!(answer.help, Help::Placed { by: 1, .. }), "{answer:?}");
    let found = answer.estimate.world_from_robot;
    assert!(found.distance_m(&truth) < 0.3 && found.heading_difference_rad(&truth) < 0.3, "{found:?}");
    assert!(!answer.estimate.is_localized(), "a hint is no claim");
    let Some(StartPrior::Poses(poses)) = players[1].filter.advice() else { panic!() };
    assert_eq!(poses.len(), 2, "both halves: which one it is stays open for the localizer");
    assert!(players[1].filter.advice().is_none(), "once is enough");
}

#[test]
fn what_is_told_twice_counts_once_and_wrong_messages_not_at_all() {
    let mut players = row([0.99, 0.5, 0.5]);
    play(&mut players, 0.0, 0.1, nobody);
    let at = Timestamp::from_secs(0.5);
    let seen = sightings(&players, 0, at);
    let (first, rest) = players.split_first_mut().unwrap();
    first.filter.step(at, &first.estimate.clone(), None, &seen);
    let good = first.filter.message().unwrap();
    let hearer = &mut rest[0].filter;
    assert_eq!(hearer.receive(&good, at), Ok(()));
    assert_eq!(hearer.receive(&good, at), Err(Ignored::Old));
    let newer = TeamMessage { sequence: 90, at: at + 0.5, ..good };
    let refused =
        |hearer: &mut TeamFilter, message: TeamMessage| hearer.receive(&message, at + 0.5).unwrap_err();
    assert_eq!(refused(hearer, TeamMessage { version: 7, ..newer.clone() }), Ignored::Version(7));
    assert_eq!(refused(hearer, TeamMessage { team: "theirs".into(), ..newer.clone() }), Ignored::OtherTeam);
    assert_eq!(refused(hearer, TeamMessage { number: 2, ..newer.clone() }), Ignored::OwnNumber);
    for damage in 0..6 {
        let mut bad = newer.clone();
        match damage {
            0 => bad.reliability = f64::NAN,
            1 => bad.hypotheses[0].world_from_robot.x_m = f64::INFINITY,
            2 => bad.hypotheses[0].probability = -1.0,
            3 => bad.at = Timestamp::from_nanos(i64::MAX),
            4 => bad.sightings[0].covariance[(0, 0)] = 0.0,
            _ => bad.sightings[0].at = at + 99.0,
        }
        assert!(matches!(refused(hearer, bad), Ignored::Fault(_)), "{damage}");
    }
    let flood = (91..200).map(|sequence| {
        let message = TeamMessage { sequence, at: at + 0.5 + f64::from(sequence) * 1e-6, ..newer.clone() };
        hearer.receive(&message, at + 0.5)
    });
    assert!(flood.filter(|result| *result == Err(Ignored::TooMany)).count() > 80);
}

#[test]
fn two_robots_of_one_number_are_told_from_one_that_starts_anew() {
    let mut players = row([0.99, 0.5, 0.5]);
    play(&mut players, 0.0, 0.1, nobody);
    let at = Timestamp::from_secs(0.5);
    let estimate = players[0].estimate.clone();
    players[0].filter.step(at, &estimate, None, &[]);
    let first = players[0].filter.message().unwrap();
    let anew = TeamMessage { session: first.session + 1, ..first.clone() };
    let later = |secs: f64| (TeamMessage { sequence: 90, at: at + secs, ..first.clone() }, at + secs);
    let hearer = &mut players[1].filter;
    assert_eq!(hearer.receive(&first, at), Ok(()));
    assert_eq!(hearer.receive(&anew, at + 0.1), Ok(()));
    let (late, arrived) = later(0.2);
    assert_eq!(hearer.receive(&late, arrived), Err(Ignored::Old), "on its way while the robot started anew");
    let (twin, arrived) = later(3.0);
    assert_eq!(hearer.receive(&twin, arrived), Err(Ignored::SameNumber(first.number)));
}

/// The one that knew leaves, and comes back as one that knows nothing: what it knew has stayed with the others, and no longer.
#[test]
fn a_half_outlives_who_knew_it() {
    let mut players = row([0.99, 0.5, 0.5]);
    play(&mut players, 0.0, 4.0, nobody);
    players[0].filter = filter(1, 2);
    let truth = players[0].truth;
    players[0].estimate = believes(&truth, 0.5 - 1e-6);
    play(&mut players, 4.0, 5.0, nobody);
    assert!(players.iter().all(is_right));
    // Nobody who begins anew hears of it if no sighting ties it to the others.
    players[0].filter = filter(1, 3);
    players.iter_mut().for_each(|player| player.sees = false);
    play(&mut players, 9.0, 5.0, nobody);
    assert!(!is_right(&players[0]) && is_right(&players[1]));
    // With nobody left the half stays while the track is followed.
    play(&mut players, 14.0, 5.0, |_, _| true);
    assert!(is_right(&players[1]));
}

/// Two that know nothing tell each other for long: nothing is decided by an echo.
#[test]
fn nothing_grows_by_being_repeated() {
    let mut players = row([0.6, 0.5, 0.45]);
    play(&mut players, 0.0, 20.0, nobody);
    for player in &players {
        assert!(!player.filter.answer().estimate.is_localized(), "{:?}", player.filter.answer());
    }
}

#[test]
fn the_ball_ties_robots_that_do_not_see_each_other() {
    assert_single_ties(SightingKind::Ball);
}

#[test]
fn a_person_whom_all_know_ties_robots_that_do_not_see_each_other() {
    assert_single_ties(SightingKind::Person);
}

fn assert_single_ties(kind: SightingKind) {
    let (a, b) = (PlanarPose::new(-2.5, 0.5, 0.0), PlanarPose::new(2.5, 1.0, PI));
    let mut players = [Player::new(1, a, 0.99), Player::new(2, b, 0.5 - 1e-6)];
    let single = Point2::new(-0.5, 1.4);
    for step in 0..40 {
        let at = Timestamp::from_secs(f64::from(step) * STEP_SECS);
        for me in 0..2 {
            let point = players[me].truth.inverse().transform(&single);
            let (range_m, bearing_rad) = (point.coords.norm(), point.y.atan2(point.x));
            let seen = Sighting::polar(at, kind, (bearing_rad, 0.03), (range_m, 0.1 * range_m));
            let estimate = players[me].estimate.clone();
            players[me].filter.step(at, &estimate, None, &[seen]);
            if let Some(message) = players[me].filter.message() {
                players[1 - me].filter.receive(&message, at + 0.01).unwrap();
            }
        }
    }
    assert!(is_right(&players[1]), "{:?}", players[1].filter.answer());
}
