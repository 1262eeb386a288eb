//! The trait of all localizers.

use visloc_core::{Rng, geom::PlanarPose};

use crate::{Estimate, StartPrior, camera_misalignment::CameraMisalignment, vision::Percept};

/// What a localizer learns in one step.
#[derive(Debug, Clone, Copy)]
pub struct StepInput<'a> {
    /// What was seen.
    pub percept: &'a Percept,
    /// Accumulated odometry, `odom_from_robot`; `None` if there is none.
    pub odometry: Option<PlanarPose>,
    /// Whether the feet lost the ground: the robot is lifted or has fallen.
    pub is_lifted: bool,
}

/// One particle or exploiter, for pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Individual {
    /// Its pose.
    pub world_from_robot: PlanarPose,
    /// Likelihood of the last image at its pose, 0 to 1.
    pub likelihood: f64,
    /// The population it belongs to: 0 for a particle filter, the race's place for the evolutionary algorithm.
    pub population: usize,
}

/// An algorithm that follows the robot's pose.
///
/// Laws: the same inputs and the same generator give the same estimates, bit by bit. While `is_lifted`, and after
/// [`Localizer::reset`], the reliability is 0. The probabilities of the hypotheses sum to 1, or there are none.
pub trait Localizer: Send {
    /// Forgets everything: the robot may be anywhere on the map.
    fn reset(&mut self);

    /// Begins again with what is known about the pose. Where the robot was before may be kept as one more hypothesis, if
    /// the localizer is set to do so. A localizer that cannot use the prior begins anywhere.
    fn reset_to(&mut self, prior: &StartPrior) {
        let _ = prior;
        self.reset();
    }

    /// Takes in one image and the motion since the last one.
    fn step(&mut self, input: &StepInput<'_>, rng: &mut Rng) -> &Estimate;

    /// Somebody has evidence that the answer is wrong: look everywhere in the next step. A localizer that searches all the
    /// time needs to do nothing.
    fn doubt(&mut self) {}

    /// The answer of the last step.
    fn estimate(&self) -> &Estimate;

    /// What is known of the constant error of the camera's direction; `None` if the localizer does not look for it, or does not know the
    /// place. Of a robot with several cameras, that of the first one.
    fn camera_error(&self) -> Option<CameraMisalignment> {
        self.camera_error_of(0)
    }

    /// The same for any of the cameras, by [`Frame::camera_index`](visloc_core::Frame::camera_index).
    fn camera_error_of(&self, camera_index: usize) -> Option<CameraMisalignment> {
        let _ = camera_index;
        None
    }

    /// Appends all particles or exploiters.
    fn individuals(&self, out: &mut Vec<Individual>);

    /// How many individuals the last step weighed. A localizer whose number changes within a step says so itself; for the
    /// others it is the number of [`Localizer::individuals`].
    fn num_weighed(&self) -> usize {
        let mut all = Vec::new();
        self.individuals(&mut all);
        all.len()
    }
}
