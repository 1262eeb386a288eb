//! An algorithm of one's own, in the program's pipeline: `cargo run --release -p visloc --example own_localizer`

use visloc::{
    Estimate, Hypothesis, Individual, Localizer, Map, ObservationModel, Pipeline, PlanarPose, Rng, Source,
    StepInput, gaussian,
    io::bag::{BagReader, BagTopics},
    nalgebra::Matrix3,
};

/// Keeps the best of many random poses: some where the image suggests, some near the last best one.
struct RandomSearch {
    model: Box<dyn ObservationModel>,
    odometry: Option<PlanarPose>,
    estimate: Estimate,
}

impl Localizer for RandomSearch {
    fn reset(&mut self) {
        (self.odometry, self.estimate) = (None, Estimate::unknown());
    }

    fn step(&mut self, input: &StepInput<'_>, rng: &mut Rng) -> &Estimate {
        self.model.condition_on(input.percept);
        let mut last = self.estimate.world_from_robot;
        if let (Some(before), Some(now)) = (self.odometry, input.odometry) {
            last = last.compose(&before.inverse().compose(&now));
        }
        self.odometry = input.odometry;
        let near =
            |rng: &mut Rng| PlanarPose::new(gaussian(rng, 0.1), gaussian(rng, 0.1), gaussian(rng, 0.1));
        let mut poses = vec![last];
        poses.extend((0..100).map(|_| last.compose(&near(rng))));
        poses.extend((0..100).map(|_| self.model.propose(rng)));
        let weighed = poses.into_iter().map(|pose| (self.model.likelihood(&pose), pose));
        let (likelihood, best) = weighed.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
        // The law of all localizers: nothing is relied on while the robot is lifted.
        let reliability =
            if input.is_lifted { 0.0 } else { 0.9 * self.estimate.reliability + 0.1 * likelihood };
        let covariance = Matrix3::identity() * 0.01;
        self.estimate = Estimate {
            world_from_robot: best,
            covariance,
            reliability,
            likelihood,
            hypotheses: vec![Hypothesis { world_from_robot: best, covariance, probability: 1.0 }],
            ..Estimate::unknown()
        };
        &self.estimate
    }

    fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    fn individuals(&self, _out: &mut Vec<Individual>) {}
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let map = Map::load("robocup-spl-2010")?;
    let own = |model| RandomSearch { model, odometry: None, estimate: Estimate::unknown() };
    let mut pipeline = Pipeline::builder(&map).localizer(own).build()?;
    let mut frames = BagReader::open("testdata/R1-excerpt.mcap", BagTopics::default())?;
    while let Some(next) = frames.next_item() {
        let next = next?;
        let estimate = pipeline.step(&next.frame)?;
        let error_m = next.truth.map(|truth| truth.world_from_robot.distance_m(&estimate.world_from_robot));
        println!("{}: reliability {:.2}, error {error_m:.2?} m", next.frame.at, estimate.reliability);
    }
    Ok(())
}
