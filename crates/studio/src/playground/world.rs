//! What people change around the robot.

use visloc_sim::{Color, LightSetup, LiveSimulation, OdometrySetup, OtherRobot, Scenario};

use crate::StudioError;

/// Most other robots.
const MAX_ROBOTS: u32 = 8;
/// Jerseys of the other robots, in turn.
const JERSEYS: [u32; 2] = [0x20_40_c0, 0xc0_28_28];
/// Darkest and brightest, powers of two.
const EXPOSURE_STOPS: (f64, f64) = (-3.0, 2.0);
/// Largest errors of the odometry, as multiple of the scenario's.
const MAX_ODOMETRY_FACTOR: f64 = 5.0;

/// The world as people set it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WorldSettings {
    /// How much the lamps differ, 0 to 1.
    pub unevenness: f64,
    /// Errors of the odometry, as multiple of the scenario's.
    pub odometry_factor: f64,
    /// Other robots that walk around.
    pub num_robots: u32,
}

impl WorldSettings {
    /// As the scenario has it.
    pub fn of(scenario: &Scenario) -> Self {
        let num_robots = scenario.robots.iter().filter(|robot| robot.at.is_none()).count();
        Self {
            unevenness: f64::from(scenario.light.unevenness),
            odometry_factor: 1.0,
            num_robots: u32::try_from(num_robots).unwrap_or(MAX_ROBOTS),
        }
    }

    /// Brings a simulation to these settings; only what differs from `before` is touched.
    pub fn apply(
        &self,
        before: &Self,
        scenario: &Scenario,
        simulation: &mut LiveSimulation,
    ) -> Result<(), StudioError> {
        self.check()?;
        if self.unevenness != before.unevenness {
            let light = LightSetup { unevenness: self.unevenness as f32, ..scenario.light.clone() };
            simulation.set_light(light)?;
        }
        if self.num_robots != before.num_robots {
            let jersey = |i: u32| Color::from_hex(JERSEYS[i as usize % JERSEYS.len()]);
            let walking = (0..self.num_robots).map(|i| OtherRobot { jersey: jersey(i), at: None });
            let resting = scenario.robots.iter().filter(|robot| robot.at.is_some()).cloned();
            simulation.set_robots(resting.chain(walking).collect())?;
        }
        if self.odometry_factor != before.odometry_factor {
            simulation.set_odometry(scaled(&scenario.robot.odometry, self.odometry_factor));
        }
        Ok(())
    }

    fn check(&self) -> Result<(), StudioError> {
        if self.num_robots > MAX_ROBOTS {
            let expected = format!("at most {MAX_ROBOTS}");
            return Err(StudioError::command("other robots", expected, self.num_robots));
        }
        in_range("unevenness of the light", self.unevenness, 0.0, 1.0)?;
        in_range("odometry error", self.odometry_factor, 0.0, MAX_ODOMETRY_FACTOR)
    }
}

/// Refuses what is out of range.
pub(super) fn in_range(what: &str, value: f64, least: f64, most: f64) -> Result<(), StudioError> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(StudioError::command(what, format!("{least} to {most}"), value))
}

/// Refuses a brightness that no camera has.
pub(super) fn check_exposure(stops: f64) -> Result<(), StudioError> {
    in_range("brightness", stops, EXPOSURE_STOPS.0, EXPOSURE_STOPS.1)
}

fn scaled(setup: &OdometrySetup, factor: f64) -> OdometrySetup {
    OdometrySetup {
        scale_error: setup.scale_error.map(|error| (error * factor).min(0.9)),
        turn_bias_deg_per_m: setup.turn_bias_deg_per_m * factor,
        noise_m: setup.noise_m * factor,
        noise_deg: setup.noise_deg * factor,
    }
}
