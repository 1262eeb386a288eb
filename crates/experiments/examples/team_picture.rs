//! Draws a game of five robots of which one is told its half: who knows where it is, and since when.
//!
//! `cargo run --release -p visloc-experiments --example team_picture -- FOLDER [SEED]`

use std::path::Path;

use visloc_core::Clock;
use visloc_experiments::team::{Conditions, Game, GameSetup, Played, play};
use visloc_locate::{
    LOCALIZED_RELIABILITY,
    team::{Liar, TeamConfig},
};
use visloc_plot::{
    Color, FieldPath, FieldPicture, Panel, PathPoint, ReferenceLine, Series, TimeSeriesPicture,
    field_picture, time_series,
};
use visloc_world::Map;

type Failure = Box<dyn std::error::Error>;

const NUM_ROBOTS: usize = 5;

fn main() -> Result<(), Failure> {
    let mut args = std::env::args().skip(1);
    let folder = args.next().ok_or("FOLDER")?;
    let seed: u64 = args.next().map_or(Ok(7), |text| text.parse())?;
    let setup = GameSetup {
        num_robots: NUM_ROBOTS,
        secs: 20.0,
        images_per_sec: 10.0,
        one_knows: true,
        kidnap: None,
        seed,
    };
    let game = Game::record(&setup)?;
    let run = |liar| {
        let conditions = Conditions { liar, ..Conditions::default() };
        play(&game, &conditions, TeamConfig::default(), seed, &Clock::still())
    };
    let (team, lied_to) = (run(None)?, run(Some(Liar::WrongHalf))?);
    let folder = Path::new(&folder);
    let Map::Field(field) = &game.map else { return Err("a field".into()) };
    let estimates = (0..NUM_ROBOTS).map(|robot| path(robot, &team)).collect();
    field_picture(
        field,
        &FieldPicture {
            title: "Five robots, white goals: only robot 1 is told its half".to_owned(),
            subtitle: format!("answers over 20 s; faint until a robot knows its half; seed {seed}"),
            estimates,
            ..FieldPicture::default()
        },
    )
    .save(folder, "team-game")?;
    let panels = vec![
        panel("reliability, with the team", &game, |step, robot| team.answers[step][robot].reliability),
        panel("each by itself", &game, |step, robot| game.moments[step][robot].estimate.reliability),
        panel("robot 5 is sure of the wrong half", &game, |step, robot| {
            lied_to.answers[step][robot].reliability
        }),
    ];
    time_series(&TimeSeriesPicture {
        title: "Who knows where it is".to_owned(),
        panels,
        ..TimeSeriesPicture::default()
    })
    .save(folder, "team-reliability")?;
    Ok(())
}

fn name(robot: usize) -> String {
    format!("robot {}", robot + 1)
}

fn path(robot: usize, team: &Played) -> FieldPath {
    let points = team.answers.iter().map(|all| {
        let answer = &all[robot];
        match (answer.hypotheses.is_empty(), answer.is_localized()) {
            (true, _) => PathPoint::gap(),
            (_, true) => PathPoint::localized(&answer.world_from_robot),
            _ => PathPoint::not_localized(&answer.world_from_robot),
        }
    });
    FieldPath { label: name(robot), color: Color::series(robot), points: points.collect() }
}

fn panel(label: &str, game: &Game, value: impl Fn(usize, usize) -> f64) -> Panel {
    let series = (0..NUM_ROBOTS).map(|robot| {
        let points = (0..game.moments.len()).map(|step| (step as f64 * game.step_secs, value(step, robot)));
        Series::new(&name(robot), Color::series(robot), points.collect())
    });
    Panel {
        label: label.to_owned(),
        series: series.collect(),
        references: vec![ReferenceLine {
            value: LOCALIZED_RELIABILITY,
            label: "localized".to_owned(),
            color: Color::GRAY,
        }],
        ..Panel::default()
    }
}
