//! Robots of a team on a field with white goals, each with a camera and a localizer of its own. Seeds on which nothing was chosen.

#![allow(clippy::unwrap_used)] // a test may stop

use visloc_core::{Clock, RngTree};
use visloc_experiments::{
    Experiment,
    team::{Conditions, Game, GameSetup, Restart, Score, TeamExperiment, TeamSettings, play, score},
};
use visloc_locate::team::{Liar, TeamConfig};

const SETUP: GameSetup =
    GameSetup { num_robots: 3, secs: 20.0, images_per_sec: 5.0, one_knows: true, kidnap: None, seed: 71 };

fn played(game: &Game, conditions: &Conditions) -> Score {
    let played = play(game, conditions, TeamConfig::default(), 3, &Clock::still()).unwrap();
    score(game, conditions, &played)
}

/// Two games of three robots: who was tied to the one that knows is right soon, over bad links and with clocks apart too, and nobody claims
/// a wrong place; without messages nobody ever knows its half.
#[test]
fn one_that_knows_its_half_is_enough() {
    for seed in [71, 72] {
        let game = Game::record(&GameSetup { seed, ..SETUP }).unwrap();
        let alone = played(&game, &Conditions { has_network: false, ..Conditions::default() });
        assert!(alone.right_after_secs.iter().all(Option::is_none) && alone.right_share == 0.0, "{alone:?}");
        let usual = Conditions::default();
        let bad_link = Conditions { loss: 0.3, delay_secs: 0.3, clock_secs: 0.2, ..usual };
        let restart = Conditions { restart: Some(Restart { robot: 1, secs: 10.0 }), ..usual };
        for conditions in [usual, bad_link, restart] {
            let score = played(&game, &conditions);
            assert!(score.num_dragged == 0 && score.wrong_share <= score.alone_wrong_share, "{score:?}");
            assert!(!score.right_after_secs.is_empty(), "seed {seed}: they met");
            assert!(
                score.right_after_secs.iter().all(|secs| secs.is_some_and(|secs| secs < 5.0)),
                "{score:?}"
            );
        }
    }
}

#[test]
fn liars_drag_nobody() {
    let game = Game::record(&SETUP).unwrap();
    for liar in [Liar::WrongHalf, Liar::Elsewhere, Liar::Inventing] {
        let score = played(&game, &Conditions { liar: Some(liar), ..Conditions::default() });
        assert!(score.num_dragged == 0 && score.wrong_share <= score.alone_wrong_share, "{liar:?} {score:?}");
    }
}

/// The same recording and seed give the same answers, and a robot that hears nobody answers with its localizer's estimates, bit for bit.
#[test]
fn the_same_bits_and_alone_the_localizers() {
    let game = Game::record(&GameSetup { secs: 5.0, ..SETUP }).unwrap();
    let run = |conditions| play(&game, &conditions, TeamConfig::default(), 3, &Clock::still()).unwrap();
    let lossy = Conditions { loss: 0.3, ..Conditions::default() };
    assert!(run(lossy).answers == run(lossy).answers);
    let alone = run(Conditions { has_network: false, ..Conditions::default() });
    for (answers, moments) in alone.answers.iter().zip(&game.moments) {
        assert!(answers.iter().zip(moments).all(|(answer, moment)| *answer == moment.estimate));
    }
}

/// A run is a game under all conditions, and one in which a robot is carried off; two robots have no liar among them, and the same seeds give the
/// same record.
#[test]
fn the_experiment_plays_each_game_under_all_conditions() {
    let settings = TeamSettings { num_robots: vec![2, 3], secs: 12.0, images_per_sec: 5.0 };
    let experiment = TeamExperiment::new(settings, 1);
    let seeds = RngTree::new(5);
    let [two, three] = [0, 1].map(|cell| experiment.run(cell, 0, &seeds).unwrap());
    assert_eq!((two.len(), three.len()), (11, 14));
    assert!(two.iter().all(|game| !game.name.starts_with("liar")));
    assert_eq!(two[0].score.right_share, 0.0, "alone nobody knows its half");
    assert!(two[1].bytes_per_sec > 100.0 && two[1].bytes_per_sec < 10_000.0);
    let found = three[11..].iter().flat_map(|game| &game.score.right_after_secs);
    assert!(found.take(2).all(|secs| secs.is_some_and(|secs| secs < 3.0)), "{:?}", &three[11..]);
    assert_eq!(experiment.run(0, 0, &seeds).unwrap(), two);
}
