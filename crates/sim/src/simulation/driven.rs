//! A simulated robot that somebody drives, as a source of frames.

use visloc_core::{Source, SourceError, SourceFrame};

use super::live::{LiveControls, LiveSimulation};

/// Frames of a robot that is steered from outside; without an end. It goes by what `controls` says when a frame is asked for.
pub struct DrivenSimulation<F> {
    simulation: LiveSimulation,
    controls: F,
}

visloc_core::debug_shows!([F] DrivenSimulation<F> { simulation });

impl<F: FnMut() -> LiveControls> DrivenSimulation<F> {
    /// Steers a simulation.
    pub fn new(simulation: LiveSimulation, controls: F) -> Self {
        Self { simulation, controls }
    }
}

impl<F: FnMut() -> LiveControls> Source<SourceFrame> for DrivenSimulation<F> {
    fn next_item(&mut self) -> Option<Result<SourceFrame, SourceError>> {
        let controls = (self.controls)();
        Some(Ok(self.simulation.step(&controls)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LiveMotion, Scenario};

    #[test]
    fn a_driven_robot_goes_where_it_is_driven_from_frame_to_frame() {
        let simulation = LiveSimulation::new(&Scenario::load("tour").unwrap(), 1).unwrap();
        let start = simulation.truth().world_from_robot;
        let mut speeds = [0.3, 0.3, 0.0, 0.0].into_iter();
        let mut driven = DrivenSimulation::new(simulation, || LiveControls {
            motion: LiveMotion::Walk {
                forward_m_per_s: speeds.next().unwrap(),
                left_m_per_s: 0.0,
                turn_rad_per_s: 0.0,
            },
            ..LiveControls::default()
        });
        let mut way_m = || {
            let truth = driven.next_item().unwrap().unwrap().truth.unwrap();
            truth.world_from_robot.distance_m(&start)
        };
        let ways = [way_m(), way_m(), way_m(), way_m()];
        assert!(ways[0] > 0.0 && ways[1] > 1.9 * ways[0] && ways[1] == ways[3], "{ways:?}");
    }
}
