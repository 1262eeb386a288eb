//! Markov localization of a robot that walks freely and turns its head.

use nalgebra::Matrix3;
use visloc_core::{
    Rng,
    geom::{PlanarPose, angle, weighted_pose_statistics},
};

use super::{
    Action, Belief, Direction, Grid, MarkovConfig, MarkovFilter, OdometryCutter, expected::ExpectedViews,
    start::belief_of,
};
use crate::{
    ConfigError, Estimate, Hypothesis, Individual, LOCALIZED_RELIABILITY, Localizer, MotionModel,
    ObservationModel, PlanarMotion, PosePrior, Region, StartPrior, StepInput, reliability::blind_share,
    require, vision::Percept,
};

/// At most so many hypotheses ...
const MAX_HYPOTHESES: usize = 8;
/// ... with at least this share of the belief.
const MIN_PROBABILITY: f64 = 0.01;

/// A belief over the grid, moved by odometry and weighed by the landmarks in view.
pub struct Markov {
    config: MarkovConfig,
    grid: Grid,
    filter: MarkovFilter,
    views: ExpectedViews,
    motion: MotionModel,
    cutter: OdometryCutter,
    /// Where the camera looked when the last image was weighed, yaw in the robot's frame, radians.
    weighed_yaw_rad: Option<f64>,
    has_evidence: bool,
    /// What is left of the reliability since a landmark was seen last, 0 to 1.
    trust: f64,
    max_jump_m: f64,
    /// Where the robot was before it was lifted.
    old_pose: Option<PlanarPose>,
    actions: Vec<Action>,
    likelihoods: Vec<f64>,
    estimate: Estimate,
}

visloc_core::debug_shows!([] Markov { config, estimate });

impl Markov {
    /// A localizer for a map with landmarks. Of the observation model it uses the region and the landmarks.
    ///
    /// # Errors
    /// If a parameter is out of its range, the map has no landmarks that can be told apart by color, or the grid is too
    /// large.
    pub fn new(config: MarkovConfig, model: &dyn ObservationModel) -> Result<Self, ConfigError> {
        config.check()?;
        let landmarks = model.landmarks();
        require(
            !landmarks.is_empty(),
            "map",
            "a map with colored landmarks, such as yellow and blue goals",
            "none",
        )?;
        let grid = grid_for(&config, &model.region());
        let num_states = grid.num_states();
        require(num_states <= 1_000_000, "tile_m, num_headings", "at most 1000000 states", num_states)?;
        Ok(Self {
            filter: MarkovFilter::new(known_start(&config, grid), config.outcomes, config.remedy),
            views: ExpectedViews::new(config.view, &grid, landmarks),
            motion: MotionModel::new(config.motion),
            cutter: OdometryCutter::new(&grid),
            weighed_yaw_rad: None,
            has_evidence: config.start.is_known,
            trust: 1.0,
            max_jump_m: model.max_jump_m(),
            old_pose: None,
            actions: Vec::new(),
            likelihoods: Vec::new(),
            estimate: Estimate::unknown(),
            config,
            grid,
        })
    }

    /// The belief.
    pub fn belief(&self) -> &Belief {
        self.filter.belief()
    }

    /// Cuts the motion into actions and does them. Returns whether there was one.
    fn act(&mut self, motion: Option<&PlanarMotion>) -> bool {
        let Some(motion) = motion else { return false };
        self.actions.clear();
        self.cutter.add(&motion.old_from_new, &mut self.actions);
        for action in &self.actions {
            self.filter.act(*action);
        }
        if motion.is_blind {
            self.filter.diffuse(motion.position_noise_m, motion.heading_noise_rad);
        }
        !self.actions.is_empty()
    }

    /// Whether an image is new evidence: the robot acted, or the camera looks elsewhere.
    fn is_new_view(&self, percept: &Percept, acted: bool) -> bool {
        let new_view_rad = self.config.view.new_view_deg.to_radians();
        let yaw_rad = camera_yaw_rad(percept);
        acted
            || self
                .weighed_yaw_rad
                .is_none_or(|weighed| angle::difference(yaw_rad, weighed).abs() >= new_view_rad)
    }

    fn weigh(&mut self, percept: &Percept) {
        self.weighed_yaw_rad = Some(camera_yaw_rad(percept));
        let residual = self.cutter.residual();
        let has_landmark = self.views.likelihoods(percept, &residual, &mut self.likelihoods);
        let weight = self.config.view.weight;
        if weight < 1.0 {
            self.likelihoods.iter_mut().for_each(|l| *l = l.powf(weight));
        }
        self.has_evidence |= has_landmark;
        if has_landmark {
            self.trust = 1.0;
            self.motion.note_evidence();
        }
        self.filter.observe(&self.likelihoods, has_landmark);
    }

    fn update_estimate(&mut self) {
        let belief = self.filter.belief();
        let (best, probability) = belief.best();
        let residual = self.cutter.residual();
        let pose = |index: usize| self.grid.pose(index).compose(&residual);
        let mut world_from_robot = pose(best);
        let mut covariance = state_covariance(&self.grid);
        if self.config.is_mean {
            let near = belief.probabilities().iter().enumerate();
            let near = near.filter(|(i, _)| self.grid.are_neighbors(best, *i)).map(|(i, p)| (pose(i), *p));
            if let Some(statistics) = weighted_pose_statistics(near) {
                world_from_robot = statistics.mean;
                covariance += statistics.covariance;
            }
        }
        let mass = if self.config.counts_neighbors { belief.mass_around(best) } else { probability };
        self.estimate.world_from_robot = world_from_robot;
        self.estimate.covariance = covariance;
        let reliability = reliability_of(mass) * self.trust;
        self.estimate.set_reliability(if self.has_evidence { reliability } else { 0.0 });
        let largest = self.likelihoods.iter().copied().fold(0.0, f64::max);
        let own = self.likelihoods.get(best).copied().unwrap_or(0.0);
        self.estimate.likelihood = if largest > 0.0 { own / largest } else { 0.0 };
        self.estimate.hypotheses.clear();
        let mut order: Vec<usize> = (0..belief.probabilities().len())
            .filter(|i| *i == best || belief.probabilities()[*i] >= MIN_PROBABILITY)
            .collect();
        order.sort_by(|a, b| belief.probabilities()[*b].total_cmp(&belief.probabilities()[*a]));
        self.estimate.hypotheses.extend(order.iter().take(MAX_HYPOTHESES).map(|&index| Hypothesis {
            world_from_robot: pose(index),
            covariance: state_covariance(&self.grid),
            probability: belief.probabilities()[index],
        }));
        self.estimate.normalize_hypotheses();
    }

    /// The image shows nothing. The answer is followed by the motion alone, since tiles are too coarse to tell how uncertain it gets
    /// meanwhile, and trusted less and less.
    fn go_blind(&mut self, motion: Option<&PlanarMotion>) {
        let (secs, noise) = (self.motion.secs(), &self.config.motion);
        self.filter.diffuse(noise.blind_noise_m * secs.sqrt(), noise.blind_noise_rad * secs.sqrt());
        let more_m = self.estimate.go_blind(motion, secs, noise);
        let kept = blind_share(secs, self.config.blind_secs) * (1.0 - more_m / self.max_jump_m).max(0.0);
        self.trust *= kept;
        self.estimate.set_reliability(self.estimate.reliability * kept);
    }

    /// Begins again with a prior. Of an old pose that is kept, the prior's share gets smaller by its own.
    fn begin_again(&mut self, prior: &StartPrior, keeps_old_pose: bool) {
        let start = &self.config.start;
        let old_pose = self.estimate.is_localized().then_some(self.estimate.world_from_robot);
        self.old_pose = old_pose.or(self.old_pose).filter(|_| keeps_old_pose);
        let mut belief = belief_of(self.grid, prior, start.probability);
        if let Some(old_pose) = self.old_pose.filter(|_| start.keep_old_pose_share > 0.0) {
            let old = PosePrior {
                world_from_robot: old_pose,
                position_spread_m: start.old_pose_spread_m,
                heading_spread_rad: start.old_pose_spread_deg.to_radians(),
                weight: 1.0,
            };
            belief.mix(&belief_of(self.grid, &StartPrior::Poses(vec![old]), 1.0), start.keep_old_pose_share);
        }
        self.has_evidence = !prior.is_uniform();
        self.trust = 1.0;
        self.filter = MarkovFilter::new(belief, self.config.outcomes, self.config.remedy);
        self.cutter.reset();
        self.weighed_yaw_rad = None;
        self.likelihoods.clear();
        self.estimate.forget();
    }
}

fn grid_for(config: &MarkovConfig, map: &Region) -> Grid {
    // A map smaller than its border keeps at least its middle.
    let border_x_m = config.border_m.min((map.max_x_m - map.min_x_m) / 2.0);
    let border_y_m = config.border_m.min((map.max_y_m - map.min_y_m) / 2.0);
    let region = Region {
        min_x_m: map.min_x_m + border_x_m,
        max_x_m: map.max_x_m - border_x_m,
        min_y_m: map.min_y_m + border_y_m,
        max_y_m: map.max_y_m - border_y_m,
    };
    Grid::new(&region, config.tile_m, config.num_headings, Direction::PlusX)
}

fn known_start(config: &MarkovConfig, grid: Grid) -> Belief {
    let start = &config.start;
    if !start.is_known {
        return Belief::uniform(grid);
    }
    let pose = PlanarPose::new(start.x_m, start.y_m, start.yaw_deg.to_radians());
    Belief::known(grid, grid.nearest(&pose), start.probability)
}

/// Direction of the optical axis along the ground, in the robot's frame, radians.
fn camera_yaw_rad(percept: &Percept) -> f64 {
    let axis = percept.robot_from_camera.rotate(&nalgebra::Vector3::z());
    axis.y.atan2(axis.x)
}

/// Anywhere in the tile, any heading between the neighbors': variance of a uniform distribution.
fn state_covariance(grid: &Grid) -> Matrix3<f64> {
    let place = grid.tile_m().powi(2) / 12.0;
    let heading = grid.heading_step_rad().powi(2) / 12.0;
    Matrix3::from_diagonal(&nalgebra::Vector3::new(place, place, heading))
}

/// From belief to reliability: straight from 0 at 0 over the limit of "localized" at 0.5 to 1 at 1.
fn reliability_of(mass: f64) -> f64 {
    let (limit, localized) = (MarkovFilter::LOCALIZED_PROBABILITY, LOCALIZED_RELIABILITY);
    let value = if mass <= limit {
        mass / limit * localized
    } else {
        localized + (mass - limit) / (1.0 - limit) * (1.0 - localized)
    };
    value.clamp(0.0, 1.0)
}

impl Localizer for Markov {
    fn reset(&mut self) {
        self.begin_again(&StartPrior::Uniform, false);
    }

    fn reset_to(&mut self, prior: &StartPrior) {
        self.begin_again(prior, true);
    }

    /// Uses no random numbers.
    fn step(&mut self, input: &StepInput<'_>, _rng: &mut Rng) -> &Estimate {
        if input.is_lifted {
            // The odometry of the feet in the air is no motion over the map.
            self.motion.update(input.percept.at, input.odometry);
            self.begin_again(&StartPrior::Uniform, true);
            return &self.estimate;
        }
        let motion = self.motion.update(input.percept.at, input.odometry);
        let acted = self.act(motion.as_ref());
        let shows_landmark = !input.percept.blobs.is_empty();
        let is_blind = !shows_landmark && input.percept.pixels.is_empty();
        if is_blind {
            self.go_blind(motion.as_ref());
        }
        // After a time without anything in view, a landmark is news even if it is where it was.
        let is_news = shows_landmark && self.trust < 1.0;
        if is_news || self.is_new_view(input.percept, acted) {
            self.weigh(input.percept);
        }
        if !is_blind || self.estimate.hypotheses.is_empty() {
            self.update_estimate();
        }
        &self.estimate
    }

    fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    /// States with a share of the belief that can be seen in a picture; the likelihood is relative to the best.
    fn individuals(&self, out: &mut Vec<Individual>) {
        const MIN_SHARE_OF_BEST: f64 = 0.01;
        let belief = self.filter.belief();
        let (_, largest) = belief.best();
        let residual = self.cutter.residual();
        for (index, probability) in belief.probabilities().iter().enumerate() {
            if *probability > MIN_SHARE_OF_BEST * largest {
                out.push(Individual {
                    world_from_robot: self.grid.pose(index).compose(&residual),
                    likelihood: probability / largest,
                    population: 0,
                });
            }
        }
    }
}
