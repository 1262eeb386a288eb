//! Whether what was said of the start holds, once the robot is found.

use visloc_core::geom::PlanarPose;
use visloc_locate::{LOCALIZED_RELIABILITY, LiftConfig, LiftDetector, StartPrior};
use visloc_world::Map;

use super::{FrameView, Spectator};

/// Below this probability a start does not agree with what was found.
const DISAGREES: f64 = 0.05;
/// Odometry is off by so much of the way, and a place that was just found by so many meters.
const ODOMETRY_SHARE: f64 = 0.1;
const FOUND_M: f64 = 0.1;

/// Looks where the robot must have begun, by the first place that it was found at and the odometry until then.
pub struct StartCheck {
    start: StartPrior,
    lift: LiftDetector,
    is_point_symmetric: bool,
    first_odometry: Option<PlanarPose>,
    state: State,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Waiting,
    /// Nothing speaks against it.
    Agrees,
    Elsewhere(PlanarPose),
    /// Nothing was said, or nothing tells where it began: it was carried before it was found.
    Unknown,
}

impl StartCheck {
    /// Of a run that has not begun.
    pub fn new(start: &StartPrior, map: &Map, lift: LiftConfig) -> Self {
        let is_point_symmetric = matches!(map, Map::Field(field) if field.is_point_symmetric());
        let state = if start.is_uniform() { State::Unknown } else { State::Waiting };
        Self {
            start: start.clone(),
            lift: LiftDetector::new(lift),
            is_point_symmetric,
            first_odometry: None,
            state,
        }
    }

    /// What is to be said of the start, if anything is.
    pub fn line(&self) -> Option<String> {
        match self.state {
            State::Elsewhere(begun) => Some(format!(
                "--start does not hold: by the images the robot began at x {:.2} m, y {:.2} m, heading {:.0} deg, and that counts",
                begun.x_m,
                begun.y_m,
                begun.yaw_rad.to_degrees()
            )),
            State::Agrees if self.is_point_symmetric => Some(
                "the half is that of --start: the field looks the same from the other one, so the images do not confirm it"
                    .to_owned(),
            ),
            _ => None,
        }
    }
}

impl Spectator for StartCheck {
    fn after_frame(&mut self, view: &FrameView<'_>) {
        if self.state != State::Waiting {
            return;
        }
        let Some(runner) = view.runners.first() else { return };
        if self.lift.update(view.frame.at, view.frame.ground_contact.as_ref()) {
            self.state = State::Unknown;
            return;
        }
        let first = self.first_odometry.or(view.frame.odometry);
        self.first_odometry = first;
        let estimate = runner.pipeline().estimate();
        if estimate.reliability <= LOCALIZED_RELIABILITY {
            return;
        }
        self.state = State::Agrees;
        let is_odometry_right = runner.counters().odometry_jumps().is_none();
        if let Some((first, now)) = first.zip(view.frame.odometry).filter(|_| is_odometry_right) {
            let begun = estimate.world_from_robot.compose(&first.relative_to(&now));
            let spread_m = FOUND_M + ODOMETRY_SHARE * first.distance_m(&now);
            if self.start.agreement(&begun, spread_m) < DISAGREES {
                self.state = State::Elsewhere(begun);
            }
        }
    }
}
