//! Reading a scenario by name or from a file.

use std::path::Path;

use serde::Deserialize;
use thiserror::Error;
use visloc_core::{Timestamp, files};
use visloc_world::{BUILT_IN_MAPS, Map, MapError};

use super::{
    Ball, BoxPiece, CameraSetup, Factor, FurniturePiece, FurtherCamera, LightSetup, Motion, OtherRobot,
    Panel, PersonSetup, PlacedPose, RobotSetup, check::Check,
};
use crate::scene::{FieldLook, Lamp, Room};

/// Most frames of a simulation, which are planned before the first is drawn: eleven hours at 30 a second.
pub const MAX_FRAMES: usize = 1_200_000;
/// Stamp of the first frame: real recordings do not start at zero either.
pub(crate) const FIRST_STAMP: Timestamp = Timestamp::from_nanos(1_700_000_000_000_000_000);
/// Most cameras beside the first.
const MAX_FURTHER_CAMERAS: usize = 7;
/// Most entries of each list.
const MAX_THINGS: usize = 1000;

/// Scenarios that are part of the program: name and text.
pub const BUILT_IN_SCENARIOS: [(&str, &str); 12] = [
    ("demo", include_str!("../../../../scenarios/demo.toml")),
    ("tour", include_str!("../../../../scenarios/tour.toml")),
    ("kidnaps", include_str!("../../../../scenarios/kidnaps.toml")),
    ("kidnaps-unsensed", include_str!("../../../../scenarios/kidnaps-unsensed.toml")),
    ("crowd", include_str!("../../../../scenarios/crowd.toml")),
    ("tour-2024", include_str!("../../../../scenarios/tour-2024.toml")),
    ("office", include_str!("../../../../scenarios/office.toml")),
    ("office-light", include_str!("../../../../scenarios/office-light.toml")),
    ("office-walk", include_str!("../../../../scenarios/office-walk.toml")),
    ("office-large", include_str!("../../../../scenarios/office-large.toml")),
    ("office-repeated", include_str!("../../../../scenarios/office-repeated.toml")),
    ("still", include_str!("../../../../scenarios/still.toml")),
];

/// A scenario that cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// The file cannot be read, and it is not the name of a built-in scenario either.
    #[error("scenario {name}: {source}; expected a file or one of: {}", built_in_names())]
    Unreadable {
        /// What the user wrote.
        name: String,
        /// Why.
        source: std::io::Error,
    },
    /// Behind the name stands a factor that does not exist.
    #[error("scenario {name}: there is no factor {found:?}; expected some of: {}, real", Factor::ALL.map(|known| known.0).join(", "))]
    Factor {
        /// What the user wrote.
        name: String,
        /// The part that is unknown.
        found: String,
    },
    /// The text is not TOML, or a key is missing, unknown or of the wrong type.
    #[error("scenario {name}{}: {reason}", in_line(line))]
    Syntax {
        /// File or name.
        name: String,
        /// Line of the text, from 1.
        line: Option<usize>,
        /// What was expected and found.
        reason: String,
    },
    /// A value that makes no sense.
    #[error("scenario {name}{}: {key}: expected {expected}, found {found}", in_line(line))]
    Value {
        /// File or name.
        name: String,
        /// Line of the text, from 1.
        line: Option<usize>,
        /// The key.
        key: String,
        /// What is allowed.
        expected: String,
        /// What the file says.
        found: String,
    },
    /// The map that the scenario names.
    #[error("scenario {name}: {source}")]
    Map {
        /// File or name.
        name: String,
        /// What is wrong with the map.
        source: MapError,
    },
    /// There is no room for what the scenario asks for.
    #[error(
        "scenario {name}: found no free {what} after {tries} tries; remove obstacles or use another seed"
    )]
    NoSpace {
        /// File or name.
        name: String,
        /// What was looked for.
        what: &'static str,
        /// How often.
        tries: usize,
    },
}

fn in_line(line: &Option<usize>) -> String {
    line.map(|line| format!(", line {line}")).unwrap_or_default()
}

fn built_in_names() -> String {
    BUILT_IN_SCENARIOS.map(|(name, _)| name).join(", ")
}

/// A map's path as a file of a scenario means it: from its folder, or, if there is nothing, from the working directory.
fn map_beside(scenario: &Path, map: &str) -> String {
    let beside = scenario.parent().unwrap_or(Path::new("")).join(map);
    let is_built_in = BUILT_IN_MAPS.iter().any(|(name, _)| *name == map);
    if is_built_in || (!beside.exists() && Path::new(map).exists()) {
        return map.to_owned();
    }
    beside.to_str().map_or_else(|| map.to_owned(), str::to_owned)
}

visloc_core::with_defaults! {
    /// Everything about one simulation except its seed.
    /// By default an empty 2010 field, the robot standing.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct Scenario {
        /// File or name; not part of the file.
        #[serde(skip)]
        pub name: String = String::new(),
        /// One line for people.
        pub summary: String = String::new(),
        /// Name or file of the map; in a file, its path from the file's folder, or else from the working directory.
        pub map: String = "robocup-spl-2010".to_owned(),
        /// Length of the simulation.
        pub duration_secs: f64 = 60.0,
        /// Frames per second.
        pub frames_per_sec: f64 = 30.0,
        /// The camera.
        pub camera: CameraSetup = CameraSetup::default(),
        /// Further cameras of the robot.
        pub more_cameras: Vec<FurtherCamera> = Vec::new(),
        /// The robot.
        pub robot: RobotSetup = RobotSetup::default(),
        /// Where the robot starts; a random place if absent.
        pub start: Option<PlacedPose> = None,
        /// What happens, one after the other; then the robot stands.
        pub motion: Vec<Motion> = Vec::new(),
        /// The room around; none if absent.
        pub room: Option<Room> = None,
        /// The light.
        pub light: LightSetup = LightSetup::default(),
        /// Lamps at given places, instead of the regular ones.
        pub lamps: Vec<Lamp> = Vec::new(),
        /// The ball.
        pub ball: Ball = Ball::default(),
        /// Furniture.
        pub furniture: Vec<FurniturePiece> = Vec::new(),
        /// Flat upright things.
        pub panels: Vec<Panel> = Vec::new(),
        /// Boxes.
        pub boxes: Vec<BoxPiece> = Vec::new(),
        /// Spectators.
        pub people: Vec<PersonSetup> = Vec::new(),
        /// Other robots.
        pub robots: Vec<OtherRobot> = Vec::new(),
        /// The carpet of a field.
        pub carpet: FieldLook = FieldLook::default(),
        /// What makes a field as hard as real ones; drawn by the seed.
        pub factors: Vec<Factor> = Vec::new(),
    }
}

impl Scenario {
    /// A built-in scenario by name, or else a file. Factors may follow, as in `tour-2024+sun+turf`.
    ///
    /// # Errors
    /// If there is no such scenario, or it has mistakes; the error names the file, the line and the key.
    pub fn load(name: &str) -> Result<Self, ScenarioError> {
        let (name_or_path, factors) =
            name.split_once('+').filter(|_| !Path::new(name).exists()).unwrap_or((name, ""));
        let mut scenario = Self::load_plain(name_or_path)?;
        if !factors.is_empty() {
            scenario.name = name.to_owned();
            let added = Factor::of_list(factors);
            scenario
                .factors
                .extend(added.map_err(|found| ScenarioError::Factor { name: name.to_owned(), found })?);
        }
        scenario.check_factors()?;
        Ok(scenario)
    }

    /// Refuses factors that change nothing, or not what they are for, in a building.
    fn check_factors(&self) -> Result<(), ScenarioError> {
        let name_of =
            |factor: &Factor| Factor::ALL.iter().find(|known| known.1 == *factor && factor.needs_field());
        let Some((found, _)) = self.factors.iter().find_map(name_of) else { return Ok(()) };
        // A map that cannot be loaded is told when the world is built.
        if !matches!(Map::load(&self.map), Ok(Map::Office(_))) {
            return Ok(());
        }
        let known = Factor::ALL.iter().filter(|known| !known.1.needs_field()).map(|known| known.0);
        Err(ScenarioError::Value {
            name: self.name.clone(),
            line: None,
            key: "factors".into(),
            expected: format!("in a building some of {}", known.collect::<Vec<_>>().join(", ")),
            found: (*found).to_owned(),
        })
    }

    fn load_plain(name_or_path: &str) -> Result<Self, ScenarioError> {
        if let Some((name, text)) = BUILT_IN_SCENARIOS.iter().find(|(name, _)| *name == name_or_path) {
            return Self::parse(name, text);
        }
        let path = Path::new(name_or_path);
        let text = files::read_text(path)
            .map_err(|source| ScenarioError::Unreadable { name: name_or_path.to_owned(), source })?;
        let mut scenario = Self::parse(name_or_path, &text)?;
        scenario.map = map_beside(path, &scenario.map);
        Ok(scenario)
    }

    /// A scenario from its text; `name` is used in errors.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn parse(name: &str, text: &str) -> Result<Self, ScenarioError> {
        let mut scenario: Self = toml::from_str(text).map_err(|error| ScenarioError::Syntax {
            name: name.to_owned(),
            line: error.span().map(|span| text[..span.start.min(text.len())].matches('\n').count() + 1),
            reason: error.message().to_owned(),
        })?;
        scenario.name = name.to_owned();
        scenario.check(&Check { name, text })?;
        Ok(scenario)
    }

    /// Number of frames of the whole scenario.
    pub fn num_frames(&self) -> usize {
        (self.duration_secs * self.frames_per_sec).round() as usize
    }

    /// The same as one of its further cameras sees it.
    pub(crate) fn seen_by(&self, further: &FurtherCamera) -> Self {
        let mut scenario = Self { camera: further.camera.clone(), more_cameras: Vec::new(), ..self.clone() };
        (scenario.robot.mount, scenario.robot.kinematics.mount_deg) = (further.mount, further.mount_deg);
        scenario
    }

    fn check(&self, check: &Check<'_>) -> Result<(), ScenarioError> {
        check.range("duration_secs", self.duration_secs, 0.0..=36_000.0)?;
        check.range("frames_per_sec", self.frames_per_sec, 1.0..=1000.0)?;
        let expected = format!("at most {MAX_FRAMES} frames in all (with frames_per_sec)");
        check.that(self.num_frames() <= MAX_FRAMES, "duration_secs", &expected, self.num_frames())?;
        for (key, number) in self.numbers_of_things() {
            check.that(number <= MAX_THINGS, key, &format!("at most {MAX_THINGS} entries"), number)?;
        }
        self.camera.check(check)?;
        let num_cameras = self.more_cameras.len();
        check.that(num_cameras <= MAX_FURTHER_CAMERAS, "more_cameras", "at most 7", num_cameras)?;
        self.more_cameras.iter().try_for_each(|camera| camera.check(check))?;
        self.robot.check(check)?;
        if let Some(start) = &self.start {
            start.check(check, "start")?;
        }
        for (i, motion) in self.motion.iter().enumerate() {
            motion.check(check, &format!("motion[{i}]"))?;
        }
        let planned_secs: f64 = self.motion.iter().map(Motion::planned_secs).sum();
        check.that(planned_secs <= 36_000.0, "motion", "at most 36000 seconds in all", planned_secs)?;
        check.range("light.unevenness", f64::from(self.light.unevenness), 0.0..=1.0)?;
        check.range("light.ambient", f64::from(self.light.ambient), 0.0..=100.0)?;
        for part in self.light.color {
            check.range("light.color", f64::from(part), 0.01..=10.0)?;
        }
        if let Some(fade) = &self.light.fade {
            check.range("light.fade.share", f64::from(fade.share), 0.01..=100.0)?;
            check.range("light.fade.period_secs", fade.period_secs, 0.1..=1e6)?;
            for part in fade.color {
                check.range("light.fade.color", f64::from(part), 0.01..=10.0)?;
            }
        }
        for (key, value, most) in [
            ("carpet.grain", self.carpet.grain, 1.0),
            ("carpet.wear", self.carpet.wear, 1.0),
            ("carpet.sun", self.carpet.sun, 20.0),
        ] {
            check.range(key, f64::from(value), 0.0..=most)?;
        }
        for count in self.light.lamps {
            check.that(count <= 20, "light.lamps", "at most 20 along each side", count)?;
        }
        self.check_world(check)
    }

    /// Lengths of the lists.
    fn numbers_of_things(&self) -> [(&'static str, usize); 7] {
        [
            ("motion", self.motion.len()),
            ("lamps", self.lamps.len()),
            ("furniture", self.furniture.len()),
            ("panels", self.panels.len()),
            ("boxes", self.boxes.len()),
            ("people", self.people.len()),
            ("robots", self.robots.len()),
        ]
    }

    fn check_world(&self, check: &Check<'_>) -> Result<(), ScenarioError> {
        if let Some(room) = &self.room {
            check.range("room.length_m", f64::from(room.length_m), 0.5..=200.0)?;
            check.range("room.width_m", f64::from(room.width_m), 0.5..=200.0)?;
            check.range("room.height_m", f64::from(room.height_m), 0.5..=50.0)?;
            check.that(
                room.posters_per_wall <= 50,
                "room.posters_per_wall",
                "at most 50",
                room.posters_per_wall,
            )?;
        }
        for value in self.ball.at_m.iter().flatten() {
            check.range("ball.at_m", *value, -100.0..=100.0)?;
        }
        for (i, lamp) in self.lamps.iter().enumerate() {
            check.range(&format!("lamps[{i}].z_m"), f64::from(lamp.z_m), 0.1..=50.0)?;
            check.range(&format!("lamps[{i}].power"), f64::from(lamp.power), 0.0..=1e6)?;
        }
        for (i, panel) in self.panels.iter().enumerate() {
            let [dx, dy] = [0, 1].map(|axis| f64::from(panel.to_m[axis] - panel.from_m[axis]));
            check.range(&format!("panels[{i}].height_m"), f64::from(panel.height_m), 0.001..=50.0)?;
            check.that(
                (0.001..=500.0).contains(&dx.hypot(dy)),
                &format!("panels[{i}].to_m"),
                "an end apart from from_m",
                format!("a distance of {} m", dx.hypot(dy)),
            )?;
        }
        for (i, piece) in self.boxes.iter().enumerate() {
            for side in piece.size_m {
                check.range(&format!("boxes[{i}].size_m"), f64::from(side), 0.001..=100.0)?;
            }
        }
        for (i, person) in self.people.iter().enumerate() {
            check.range(&format!("people[{i}].height_m"), f64::from(person.height_m), 0.2..=3.0)?;
        }
        Ok(())
    }
}
