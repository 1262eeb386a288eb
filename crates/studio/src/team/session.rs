//! The team as something to watch.

use std::sync::Arc;

use serde_json::{Value, json};
use visloc_core::Clock;
use visloc_locate::vision::DropReason;
use visloc_sim::TEAM;

use super::{
    game::Game,
    robot::Robot,
    view::{contender, team},
};
use crate::{
    Command, MessageBuilder, MessageKind, Session, StudioError, Update,
    message::lay_over,
    playback::Playback,
    view::{LocalizationView, world_geometry},
};

/// Fewest and most robots: as many as there are lanes on the page.
const NUM_ROBOTS: (u32, u32) = (2, 5);
/// Robots until somebody chooses another number.
const FIRST_ROBOTS: u32 = 4;

/// A simulated team.
pub struct TeamSession {
    scenes: Value,
    game: Game,
    num_robots: u32,
    seed: u64,
    clock: Clock,
    playback: Playback,
    number: u64,
    /// Whose image is shown.
    look: usize,
    /// The message of that image; made anew when anything in it has changed.
    image: Option<Arc<[u8]>>,
    /// The message of the scene; made anew with each game.
    scene: Option<Arc<[u8]>>,
}

impl TeamSession {
    /// A team that walks around; `scenes` is told to the pages as what else can be opened.
    ///
    /// # Errors
    /// If the field cannot be built.
    pub fn new(seed: u64, clock: Clock, scenes: Value) -> Result<Self, StudioError> {
        Ok(Self {
            scenes,
            game: Game::new(FIRST_ROBOTS as usize, seed, &clock)?,
            num_robots: FIRST_ROBOTS,
            seed,
            clock,
            playback: Playback::default(),
            number: 0,
            look: 0,
            image: None,
            scene: None,
        })
    }

    /// Another game: everybody is honest and heard.
    fn restart(&mut self, num_robots: u32, seed: u64) -> Result<(), StudioError> {
        let (least, most) = NUM_ROBOTS;
        if !(least..=most).contains(&num_robots) {
            return Err(StudioError::command("robots", format!("{least} to {most} in a team"), num_robots));
        }
        self.game = Game::new(num_robots as usize, seed, &self.clock)?;
        (self.num_robots, self.seed, self.number) = (num_robots, seed, 0);
        self.look = self.look.min(num_robots as usize - 1);
        (self.image, self.scene) = (None, None);
        Ok(())
    }

    /// The place of a robot by its number.
    fn place(&self, number: u8) -> Result<usize, StudioError> {
        let found = self.game.robots().iter().position(|robot| robot.number() == number);
        found.ok_or_else(|| StudioError::command("robot", format!("1 to {}", self.num_robots), number))
    }

    fn robot_mut(&mut self, number: u8) -> Result<&mut Robot, StudioError> {
        let place = self.place(number)?;
        self.game.robot_mut(place).ok_or_else(|| StudioError::command("robot", "one of the team", number))
    }

    fn scene_message(&mut self) -> Result<Arc<[u8]>, StudioError> {
        if let Some(scene) = &self.scene {
            return Ok(Arc::clone(scene));
        }
        let header = json!({
            "mode": "team",
            "scene": format!("sim:{TEAM}"),
            "scenes": self.scenes,
            "world": world_geometry(self.game.map()),
            "step_secs": self.game.step_secs(),
            "drop_reasons": DropReason::ALL.map(DropReason::name),
            "seed": self.seed,
            "team": { "num_robots": self.num_robots },
        });
        let bytes: Arc<[u8]> = MessageBuilder::new(MessageKind::Scene, &header)?.finish().into();
        self.scene = Some(Arc::clone(&bytes));
        Ok(bytes)
    }
}

impl Session for TeamSession {
    fn handle(&mut self, command: &Command) -> Result<(), StudioError> {
        match *command {
            Command::Step {} => {
                self.playback.pause();
                self.step()?;
            }
            Command::Reset { seed } => self.restart(self.num_robots, seed)?,
            Command::Robots { count } => self.restart(count, self.seed)?,
            Command::Link { robot, is_on } => self.robot_mut(robot)?.is_linked = is_on,
            Command::Lie { robot, how } => self.robot_mut(robot)?.liar = how,
            Command::Kidnap { robot: Some(robot), x_m: None, y_m: None, yaw_rad: None } => {
                let place = self.place(robot)?;
                if !self.game.kidnap(place) {
                    return Err(StudioError::command("kidnap", "a free place", "none"));
                }
            }
            Command::Look { robot } => {
                self.look = self.place(robot)?;
                self.image = None;
            }
            _ if self.playback.handle(command)? => {}
            _ => return Err(StudioError::command("command", "one for a team", command.name())),
        }
        Ok(())
    }

    fn step_secs(&self) -> Option<f64> {
        self.playback.wait_secs(self.game.step_secs())
    }

    fn step(&mut self) -> Result<(), StudioError> {
        self.game.step()?;
        self.number += 1;
        self.image = None;
        Ok(())
    }

    fn update(&mut self, aside: Option<&Value>) -> Result<Update, StudioError> {
        let scene = self.scene_message()?;
        let robots = self.game.robots();
        let contenders: Vec<_> = robots.iter().map(contender).collect();
        let fields: Vec<Value> =
            contenders.iter().zip(robots).map(|(view, robot)| view.fields(robot.truth())).collect();
        let mut more = json!({
            "seed": self.seed,
            "contenders": fields,
            "team": team(&self.game, self.look),
            "render_ms": self.game.render_ms(),
        });
        lay_over(&mut more, &self.playback.fields());
        lay_over(&mut more, aside.unwrap_or(&Value::Null));
        let looking = &robots[self.look];
        let view = LocalizationView {
            map: self.game.map(),
            number: self.number,
            secs: self.number as f64 * self.game.step_secs(),
            frame: &looking.frame().frame,
            truth: looking.truth(),
            contenders: &contenders[self.look..=self.look],
        };
        let state = view.state(more, None)?;
        let image = match &self.image {
            Some(image) => Arc::clone(image),
            None => view.image()?.into(),
        };
        self.image = Some(Arc::clone(&image));
        Ok(Update { scene, state: state.into(), image: Some(image) })
    }
}
