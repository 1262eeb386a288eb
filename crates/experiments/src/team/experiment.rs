//! Cells and runs.

use serde::{Deserialize, Serialize};
use visloc_core::{Clock, RngTree};
use visloc_io::bag::messages::to_cdr;
use visloc_locate::team::{Liar, TeamConfig, TeamMessage, WireTeamMessage};

use super::{Conditions, Game, GameSetup, Restart, Score, carried::play_carried, play, score};
use crate::{Cell, Experiment, ExperimentError};

/// What decides the records.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TeamSettings {
    /// How many robots play; a cell each.
    pub num_robots: Vec<usize>,
    /// Length of a game, seconds.
    pub secs: f64,
    /// Images a second of each robot.
    pub images_per_sec: f64,
}

impl Default for TeamSettings {
    /// Two to five robots, a minute, 5 images a second.
    fn default() -> Self {
        Self { num_robots: vec![2, 3, 4, 5], secs: 60.0, images_per_sec: 5.0 }
    }
}

/// A game under one of the conditions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConditionRecord {
    /// The conditions.
    pub name: String,
    /// What the team was good for.
    pub score: Score,
    /// Bytes a second that a robot sends, without headers of the network.
    pub bytes_per_sec: f64,
}

/// A game under all conditions that make sense for so many robots.
pub type TeamRecord = Vec<ConditionRecord>;

/// The team experiment.
#[derive(Debug, Clone)]
pub struct TeamExperiment {
    settings: TeamSettings,
    cells: Vec<Cell>,
}

impl TeamExperiment {
    /// The experiment with so many games for each number of robots.
    pub fn new(settings: TeamSettings, num_games: u64) -> Self {
        let cell = |robots: &usize| Cell { label: format!("{robots} robots"), num_runs: num_games };
        Self { cells: settings.num_robots.iter().map(cell).collect(), settings }
    }
}

/// All conditions, with the fewest robots that they make sense for.
pub(super) fn conditions() -> Vec<(&'static str, usize, Conditions)> {
    let usual = Conditions::default();
    let bad_link = Conditions { loss: 0.3, delay_secs: 0.3, ..usual };
    let liar = |liar| Conditions { liar: Some(liar), ..usual };
    let restart = |robot| Conditions { restart: Some(Restart { robot, secs: 30.0 }), ..usual };
    vec![
        ("alone", 2, Conditions { has_network: false, ..usual }),
        ("team", 2, usual),
        ("team, own detector", 2, Conditions { own_detector: true, ..usual }),
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

impl Experiment for TeamExperiment {
    type Settings = TeamSettings;
    type Record = TeamRecord;

    fn name(&self) -> &'static str {
        "team"
    }

    fn settings(&self) -> &TeamSettings {
        &self.settings
    }

    fn cells(&self) -> &[Cell] {
        &self.cells
    }

    fn runs_per_thread(&self) -> usize {
        1
    }

    fn run(&self, cell: usize, run: u64, seeds: &RngTree) -> Result<TeamRecord, ExperimentError> {
        let num_robots = self.settings.num_robots[cell];
        let TeamSettings { secs, images_per_sec, .. } = self.settings;
        let seed = seeds.subtree("games", num_robots as u64).stream_seed("game", run);
        let setup = GameSetup { num_robots, secs, images_per_sec, one_knows: true, kidnap: None, seed };
        let game = Game::record(&setup)?;
        let all = conditions().into_iter().filter(|(_, least, _)| num_robots >= *least);
        let of_condition = |(name, _, conditions): (&str, usize, Conditions)| {
            let played = play(&game, &conditions, TeamConfig::default(), seed, &Clock::still())?;
            Ok(ConditionRecord {
                name: name.to_owned(),
                score: score(&game, &conditions, &played),
                bytes_per_sec: bytes_per_sec(played.messages.iter().flatten(), &setup),
            })
        };
        let mut records = all.map(of_condition).collect::<Result<TeamRecord, ExperimentError>>()?;
        records.extend(play_carried(&setup)?);
        Ok(records)
    }
}

/// What a robot sends in a game with these messages, in the encoding of ROS 2, without headers of the network.
pub(super) fn bytes_per_sec<'a>(messages: impl Iterator<Item = &'a TeamMessage>, setup: &GameSetup) -> f64 {
    let size = |message| to_cdr(&WireTeamMessage::from(message)).map_or(0, |bytes| bytes.len());
    messages.map(size).sum::<usize>() as f64 / setup.num_robots as f64 / setup.secs
}
