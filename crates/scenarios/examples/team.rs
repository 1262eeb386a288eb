//! Games of a team on a field with white goals, of which one robot is told its half: how soon the others are right, and what liars, bad links,
//! restarts and clocks do to them.
//!
//! `cargo run --release -p visloc-scenarios --example team -- GAMES [FIRST_SEED [SECS [IMAGES_PER_SEC]]]`; games of 2, 3, 4 and 5 robots in
//! turns, 60 s with 5 images a second unless told otherwise. Every robot has a camera (320 x 240), its own localizer and odometry with
//! errors; sightings come from the simulator with its usual errors ([`visloc_sim::DetectorSetup`]).

#![allow(
    clippy::disallowed_methods,
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss
)]

use std::time::Instant;

use visloc_core::Clock;
use visloc_io::bag::messages::to_cdr;
use visloc_locate::team::{TeamConfig, TeamMessage, WireTeamMessage};
use visloc_scenarios::team::{Conditions, Game, GameSetup, Liar, Restart, Score, play, score};

type Failure = Box<dyn std::error::Error>;

/// All conditions, with the fewest robots that they make sense for.
fn conditions() -> Vec<(&'static str, usize, Conditions)> {
    let usual = Conditions::default();
    let bad_link = Conditions { loss: 0.3, delay_secs: 0.3, ..usual };
    let liar = |liar| Conditions { liar: Some(liar), ..usual };
    let restart = |robot| Conditions { restart: Some(Restart { robot, secs: 30.0 }), ..usual };
    vec![
        ("alone", 2, Conditions { has_network: false, ..usual }),
        ("team", 2, usual),
        ("loss 30 %, delay 0.3 s", 2, bad_link),
        ("clocks 0.2 s apart", 2, Conditions { clock_secs: 0.2, ..usual }),
        ("all three", 2, Conditions { clock_secs: 0.2, ..bad_link }),
        ("who knew restarts", 2, restart(0)),
        ("another one restarts", 2, restart(1)),
        ("liar: wrong half", 3, liar(Liar::WrongHalf)),
        ("liar: elsewhere", 3, liar(Liar::Elsewhere)),
        ("liar: inventing", 3, liar(Liar::Inventing)),
    ]
}

/// Sums over games.
#[derive(Default)]
struct Sums {
    scores: Vec<Score>,
    messages_per_sec: Vec<f64>,
    bytes_per_sec: Vec<f64>,
    ms_per_image: Vec<f64>,
}

fn main() -> Result<(), Failure> {
    let mut args = std::env::args().skip(1);
    let num_games: u64 = args.next().ok_or("GAMES")?.parse()?;
    let first_seed: u64 = args.next().map_or(Ok(1), |text| text.parse())?;
    let secs: f64 = args.next().map_or(Ok(60.0), |text| text.parse())?;
    let images_per_sec: f64 = args.next().map_or(Ok(5.0), |text| text.parse())?;
    let began = Instant::now();
    let clock = Clock::new(move || began.elapsed().as_secs_f64());
    let all = conditions();
    let mut sums: Vec<Sums> = all.iter().map(|_| Sums::default()).collect();
    for i in 0..num_games {
        let seed = first_seed + i;
        let num_robots = 2 + (i % 4) as usize;
        let setup = GameSetup { num_robots, secs, images_per_sec, one_knows: true, kidnap: None, seed };
        let game = Game::record(&setup)?;
        for ((name, least, conditions), sums) in all.iter().zip(&mut sums) {
            if num_robots < *least {
                continue;
            }
            let played = play(&game, conditions, TeamConfig::default(), seed, &clock)?;
            let score = score(&game, conditions, &played);
            if score.num_dragged > 0 {
                println!("game {seed}, {num_robots} robots, {name}: {} dragged", score.num_dragged);
            }
            let messages: usize = played.messages.iter().map(Vec::len).sum();
            sums.messages_per_sec.push(messages as f64 / num_robots as f64 / secs);
            let bytes: usize = played.messages.iter().flatten().map(size).sum();
            sums.bytes_per_sec.push(bytes as f64 / num_robots as f64 / secs);
            sums.ms_per_image.push(played.ms_per_image);
            sums.scores.push(score);
        }
        eprintln!("game {seed} after {:.0} s", began.elapsed().as_secs_f64());
    }
    println!(
        "{:<24} games | right after, median, 90 %, never, untied | dragged | right with team / alone | wrong claims with team / alone | messages/s, bytes/s a robot | ms an image",
        "condition"
    );
    for ((name, ..), sums) in all.iter().zip(&sums) {
        report(name, sums);
    }
    Ok(())
}

/// Bytes of a message in the encoding of ROS 2, without headers of the network.
fn size(message: &TeamMessage) -> usize {
    to_cdr(&WireTeamMessage::from(message)).map_or(0, |bytes| bytes.len())
}

fn report(name: &str, sums: &Sums) {
    let scores = &sums.scores;
    let num = scores.len().max(1) as f64;
    let mean = |value: &dyn Fn(&Score) -> f64| scores.iter().map(value).sum::<f64>() / num;
    let all: Vec<Option<f64>> = scores.iter().flat_map(|score| score.right_after_secs.clone()).collect();
    let mut right: Vec<f64> = all.iter().map(|secs| secs.unwrap_or(f64::INFINITY)).collect();
    right.sort_by(f64::total_cmp);
    let quantile = |share: f64| right.get((share * right.len() as f64) as usize).copied().unwrap_or(f64::NAN);
    println!(
        "{name:<24} {:5} | {:6.1} s {:6.1} s {:3} of {:3}, {:3} | {:3} robots in {:3} games | {:3.0} / {:3.0} % | {:4.1} / {:4.1} % | {:.1}, {:.0} | {:.4}",
        scores.len(),
        quantile(0.5),
        quantile(0.9),
        all.iter().filter(|secs| secs.is_none()).count(),
        all.len(),
        scores.iter().map(|score| score.num_untied).sum::<usize>(),
        scores.iter().map(|score| score.num_dragged).sum::<usize>(),
        scores.iter().filter(|score| score.num_dragged > 0).count(),
        100.0 * mean(&|score| score.right_share),
        100.0 * mean(&|score| score.alone_right_share),
        100.0 * mean(&|score| score.wrong_share),
        100.0 * mean(&|score| score.alone_wrong_share),
        sums.messages_per_sec.iter().sum::<f64>() / num,
        sums.bytes_per_sec.iter().sum::<f64>() / num,
        sums.ms_per_image.iter().sum::<f64>() / num,
    );
}
