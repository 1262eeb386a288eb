//! Who moves the robot: keys, a target, itself, or hands.

use std::f64::consts::PI;

use nalgebra::Point2;
use visloc_core::geom::{PlanarPose, angle, nao::HeadAngles};
use visloc_sim::{LiveControls, LiveMotion, LiveSimulation};

/// Fastest walk ahead and to the side, meters per second, and turn, radians per second.
const MAX_SPEEDS: [f64; 3] = [0.3, 0.15, 0.9];
/// Speed on the way to a target, meters per second.
const WALK_M_PER_S: f64 = 0.25;
/// So near to a target the robot is there, meters.
const ARRIVED_M: f64 = 0.08;
/// How high hands lift the robot, meters.
const LIFT_M: f64 = 0.35;
/// Time to carry the robot elsewhere.
const KIDNAP_SECS: f64 = 1.2;

/// Where hands are.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Hands {
    Away,
    /// They hold the robot.
    Holding(PlanarPose),
    /// They carry it, done to a share.
    Carrying {
        from: PlanarPose,
        to: PlanarPose,
        done: f64,
    },
}

visloc_core::with_defaults! {
    /// Decides about each frame.
    #[derive(Debug, Clone)]
    pub(super) struct Driver {
        speeds: [f64; 3] = [0.0; 3],
        target: Option<Point2<f64>> = None,
        /// Whether the robot chooses targets itself.
        pub is_autopilot: bool = true,
        /// Whether the feet notice hands.
        pub is_felt: bool = true,
        /// Whether a hand covers the camera.
        pub is_covered: bool = false,
        /// Brightness, powers of two.
        pub exposure_stops: f64 = 0.0,
        /// Where the head looks, unless by itself.
        pub head: Option<HeadAngles> = None,
        hands: Hands = Hands::Away,
        num_choices: u64 = 0,
    }
}

impl Driver {
    /// From the beginning; what people set about hands, light and camera stays.
    pub fn anew(&self) -> Self {
        Self { is_felt: self.is_felt, exposure_stops: self.exposure_stops, ..Self::default() }
    }

    /// Somebody drives; shares of the greatest speeds.
    pub fn drive(&mut self, shares: [f64; 3]) {
        self.speeds = std::array::from_fn(|i| shares[i].clamp(-1.0, 1.0) * MAX_SPEEDS[i]);
        self.target = None;
        self.is_autopilot = false;
    }

    /// Somebody shows a place.
    pub fn walk_to(&mut self, target: Point2<f64>) {
        self.drive([0.0; 3]);
        self.target = Some(target);
    }

    /// Whether the robot goes where it likes.
    pub fn set_autopilot(&mut self, is_on: bool) {
        self.drive([0.0; 3]);
        self.is_autopilot = is_on;
    }

    /// Hands hold the robot over a pose.
    pub fn hold(&mut self, world_from_robot: PlanarPose) {
        self.hands = Hands::Holding(world_from_robot);
        self.target = None;
    }

    /// Hands let go.
    pub fn release(&mut self) {
        self.hands = Hands::Away;
    }

    /// Hands carry the robot from one pose to another.
    pub fn kidnap(&mut self, from: PlanarPose, to: PlanarPose) {
        self.target = None;
        self.hands = Hands::Carrying { from, to, done: 0.0 };
    }

    /// A number for the next random choice.
    pub fn next_choice(&mut self) -> u64 {
        self.num_choices += 1;
        self.num_choices
    }

    /// Where the robot goes.
    pub fn target(&self) -> Option<Point2<f64>> {
        self.target
    }

    /// Whether hands hold the robot.
    pub fn is_held(&self) -> bool {
        self.hands != Hands::Away
    }

    /// What happens until the next frame.
    pub fn controls(&mut self, simulation: &LiveSimulation) -> LiveControls {
        let motion = match self.hands {
            Hands::Away => self.walk(simulation),
            Hands::Holding(pose) => self.held(pose, LIFT_M),
            Hands::Carrying { from, to, done } => self.carry(from, to, done, simulation.step_secs()),
        };
        LiveControls {
            motion,
            head: self.head,
            is_covered: self.is_covered,
            exposure_stops: self.exposure_stops,
        }
    }

    fn held(&self, world_from_robot: PlanarPose, height_m: f64) -> LiveMotion {
        LiveMotion::Held { world_from_robot, height_m, is_felt: self.is_felt }
    }

    fn carry(&mut self, from: PlanarPose, to: PlanarPose, done: f64, step_secs: f64) -> LiveMotion {
        let done = done + step_secs / KIDNAP_SECS;
        if done >= 1.0 {
            self.hands = Hands::Away;
            return self.held(to, 0.0);
        }
        self.hands = Hands::Carrying { from, to, done };
        let moved = 0.5 - 0.5 * (PI * done).cos();
        let turn_rad = angle::difference(to.yaw_rad, from.yaw_rad) * moved;
        let position = from.position() + (to.position() - from.position()) * moved;
        let pose = PlanarPose::new(position.x, position.y, from.yaw_rad + turn_rad);
        self.held(pose, LIFT_M * (PI * done).sin())
    }

    fn walk(&mut self, simulation: &LiveSimulation) -> LiveMotion {
        let pose = simulation.truth().world_from_robot;
        if self.target.is_none() && self.is_autopilot {
            let choice = self.next_choice();
            self.target = simulation.random_target(choice);
        }
        let speeds = self.target.map_or(self.speeds, |target| toward(&pose, &target));
        if self.target.is_some_and(|target| (target - pose.position()).norm() < ARRIVED_M) {
            self.target = None;
        }
        let [forward_m_per_s, left_m_per_s, turn_rad_per_s] = speeds;
        LiveMotion::Walk { forward_m_per_s, left_m_per_s, turn_rad_per_s }
    }
}

/// Speeds that lead to a place: turn first, then walk.
fn toward(pose: &PlanarPose, target: &Point2<f64>) -> [f64; 3] {
    let way = target - pose.position();
    let off_rad = angle::difference(way.y.atan2(way.x), pose.yaw_rad);
    let turn = (2.0 * off_rad).clamp(-MAX_SPEEDS[2], MAX_SPEEDS[2]);
    let forward = WALK_M_PER_S * off_rad.cos().max(0.0).powi(3);
    [forward, 0.0, turn]
}

#[cfg(test)]
mod tests {
    use visloc_sim::Scenario;

    use super::*;

    fn simulation() -> LiveSimulation {
        LiveSimulation::new(&Scenario::load("tour").unwrap(), 1).unwrap()
    }

    #[test]
    fn a_shown_place_is_reached() {
        let (mut simulation, mut driver) = (simulation(), Driver::default());
        let target = Point2::new(0.5, -0.4);
        driver.walk_to(target);
        for _ in 0..1500 {
            if driver.target().is_none() {
                break;
            }
            let controls = LiveControls { is_covered: true, ..driver.controls(&simulation) };
            simulation.step(&controls);
        }
        assert!((simulation.truth().world_from_robot.position() - target).norm() < 2.0 * ARRIVED_M);
    }

    #[test]
    fn a_kidnap_ends_at_its_place_on_the_floor() {
        let (mut simulation, mut driver) = (simulation(), Driver::default());
        driver.set_autopilot(false);
        let there = PlanarPose::new(-1.5, 1.0, 2.0);
        driver.kidnap(simulation.truth().world_from_robot, there);
        let mut highest_m: f64 = 0.0;
        while driver.is_held() {
            highest_m = highest_m.max(simulation.step(&driver.controls(&simulation)).truth.unwrap().height_m);
        }
        simulation.step(&driver.controls(&simulation));
        let truth = simulation.truth();
        assert!(truth.world_from_robot.distance_m(&there) < 1e-9 && truth.height_m == 0.0);
        assert!(highest_m > 0.3);
    }
}
