//! The null control: individuals that know nothing.

use visloc_core::Rng;
use visloc_locate::{Estimate, Individual, Localizer, Region, StepInput};

/// Draws all individuals anew everywhere in each step, whatever was seen. A criterion that it meets says nothing.
#[derive(Debug, Clone)]
pub struct UniformControl {
    region: Region,
    num_individuals: usize,
    individuals: Vec<Individual>,
    estimate: Estimate,
}

impl UniformControl {
    /// A control with so many individuals.
    pub fn new(region: Region, num_individuals: usize) -> Self {
        Self { region, num_individuals, individuals: Vec::new(), estimate: Estimate::unknown() }
    }
}

impl Localizer for UniformControl {
    fn reset(&mut self) {
        self.individuals.clear();
    }

    fn step(&mut self, _input: &StepInput<'_>, rng: &mut Rng) -> &Estimate {
        self.individuals.clear();
        self.individuals.extend((0..self.num_individuals).map(|_| Individual {
            world_from_robot: self.region.sample(rng),
            likelihood: 0.0,
            population: 0,
        }));
        &self.estimate
    }

    fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    fn individuals(&self, out: &mut Vec<Individual>) {
        out.extend_from_slice(&self.individuals);
    }
}
