//! What the robot does in the runs: scenarios made from the built-in ones.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};
use visloc_core::RngTree;
use visloc_sim::{Carry, Motion, Scenario, ScenarioError, Simulation, Stand, Wander};

/// One kind of runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RobocupSet {
    /// A walk over the field with colored goals.
    Tours,
    /// The same without odometry.
    NoOdometry,
    /// A walk among other robots, with spectators, boards and uneven light.
    Crowd,
    /// Kidnaps that the feet notice.
    Kidnaps,
    /// Kidnaps that only the camera can notice.
    Unfelt,
    /// Kidnaps on the field with white goals, where every place has a mirror image.
    White,
}

/// How long the runs are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RunLength {
    /// Length of a walk without kidnaps, seconds.
    pub walk_secs: f64,
    /// Kidnaps in a run.
    pub num_kidnaps: u32,
}

impl RunLength {
    /// Two minutes, or ten kidnaps.
    pub const FULL: Self = Self { walk_secs: 120.0, num_kidnaps: 10 };
    /// For a first look.
    pub const QUICK: Self = Self { walk_secs: 40.0, num_kidnaps: 3 };
}

/// Time from one kidnap to the next, seconds.
const PERIOD_SECS: f64 = 20.0;
/// Time of standing after a kidnap, seconds.
const STAND_SECS: f64 = 0.6;
/// A way that cannot be found with one seed is looked for with the next ones.
const MAX_TRIES: u64 = 8;

impl RobocupSet {
    /// All sets.
    pub const ALL: [Self; 6] =
        [Self::Tours, Self::NoOdometry, Self::Crowd, Self::Kidnaps, Self::Unfelt, Self::White];

    /// Name of the set.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tours => "tours",
            Self::NoOdometry => "no-odometry",
            Self::Crowd => "crowd",
            Self::Kidnaps => "kidnaps",
            Self::Unfelt => "unfelt",
            Self::White => "white",
        }
    }

    /// The set in words, for titles.
    pub fn title(self) -> &'static str {
        match self {
            Self::Tours => "Tour",
            Self::NoOdometry => "Tour without odometry",
            Self::Crowd => "Among other robots",
            Self::Kidnaps => "Kidnaps, lift felt",
            Self::Unfelt => "Kidnaps, lift not felt",
            Self::White => "Kidnaps, white goals",
        }
    }

    /// Whether the robot is kidnapped.
    pub fn has_kidnaps(self) -> bool {
        matches!(self, Self::Kidnaps | Self::Unfelt | Self::White)
    }

    /// Whether the algorithms are given the odometry.
    pub fn has_odometry(self) -> bool {
        self != Self::NoOdometry
    }

    /// Whether every place has a mirror image that looks the same.
    pub fn is_mirrored(self) -> bool {
        self == Self::White
    }

    fn base(self) -> &'static str {
        match self {
            Self::Tours | Self::NoOdometry => "tour",
            Self::Crowd => "crowd",
            Self::Kidnaps => "kidnaps",
            Self::Unfelt => "kidnaps-unsensed",
            Self::White => "tour-2024",
        }
    }

    /// The scenario of all runs. Each run has a seed of its own, which decides the way, where the robot is put down, the
    /// textures, the light, the errors of odometry and kinematics, and the noise of the images.
    ///
    /// # Errors
    /// If the built-in scenario cannot be read.
    pub fn scenario(self, length: RunLength) -> Result<Scenario, ScenarioError> {
        let mut scenario = Scenario::load(self.base())?;
        let wander = usual_wander(&scenario);
        if self.has_kidnaps() {
            scenario.motion = kidnaps(&wander, self != Self::Unfelt, length.num_kidnaps);
            scenario.duration_secs = (f64::from(length.num_kidnaps) + 1.0) * PERIOD_SECS;
        } else {
            let walk = Wander { secs: length.walk_secs - 3.0, ..wander };
            scenario.motion = vec![Motion::Stand(Stand { secs: 3.0 }), Motion::Wander(walk)];
            scenario.duration_secs = length.walk_secs;
        }
        Ok(scenario)
    }

    /// The simulation of a run, and its seed.
    ///
    /// # Errors
    /// If there is no free way for the robot with any of several seeds.
    pub fn simulation(
        self,
        length: RunLength,
        run: u64,
        seeds: &RngTree,
    ) -> Result<(Simulation, u64), ScenarioError> {
        let scenario = self.scenario(length)?;
        let tree = seeds.subtree(self.base(), run);
        let mut attempt = 0;
        loop {
            let seed = tree.stream_seed("simulation", attempt);
            match Simulation::new(&scenario, seed) {
                Ok(simulation) => return Ok((simulation, seed)),
                Err(ScenarioError::NoSpace { .. }) if attempt + 1 < MAX_TRIES => attempt += 1,
                Err(error) => return Err(error),
            }
        }
    }
}

/// How the robot walks in a scenario.
fn usual_wander(scenario: &Scenario) -> Wander {
    let wander = |motion: &Motion| match motion {
        Motion::Wander(wander) => Some(wander.clone()),
        _ => None,
    };
    scenario.motion.iter().find_map(wander).unwrap_or_default()
}

fn kidnaps(wander: &Wander, is_felt: bool, num_kidnaps: u32) -> Vec<Motion> {
    let carry_secs = if is_felt { 2.0 } else { 1.4 };
    let lift_m = if is_felt { 0.35 } else { 0.25 };
    let walk_secs = PERIOD_SECS - carry_secs - STAND_SECS;
    let walk = Motion::Wander(Wander { secs: walk_secs, ..wander.clone() });
    let mut motion = vec![Motion::Stand(Stand { secs: 2.0 }), walk.clone()];
    for _ in 0..num_kidnaps {
        motion.push(Motion::Carry(Carry { secs: carry_secs, to: None, lift_m, has_foot_signal: is_felt }));
        motion.push(Motion::Stand(Stand { secs: STAND_SECS }));
        motion.push(walk.clone());
    }
    motion
}

impl fmt::Display for RobocupSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for RobocupSet {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = || Self::ALL.map(Self::name).join(", ");
        let found = Self::ALL.into_iter().find(|set| set.name() == text);
        found.ok_or_else(|| format!("expected one of {}, found {text:?}", known()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kidnaps_fit_into_the_duration_and_are_as_many_as_asked_for() {
        for set in RobocupSet::ALL {
            let scenario = set.scenario(RunLength::FULL).unwrap();
            let carried = scenario.motion.iter().filter(|motion| matches!(motion, Motion::Carry(_))).count();
            assert_eq!(carried, if set.has_kidnaps() { 10 } else { 0 }, "{set}");
            let secs: f64 = scenario
                .motion
                .iter()
                .map(|motion| match motion {
                    Motion::Stand(stand) => stand.secs,
                    Motion::Wander(wander) => wander.secs,
                    Motion::Carry(carry) => carry.secs,
                    _ => 0.0,
                })
                .sum();
            assert!((secs - scenario.duration_secs).abs() < 3.0, "{set}: {secs}");
        }
    }

    #[test]
    fn names_are_read_back() {
        for set in RobocupSet::ALL {
            assert_eq!(set.name().parse(), Ok(set));
        }
        assert!("tour".parse::<RobocupSet>().unwrap_err().contains("tours"));
    }
}
