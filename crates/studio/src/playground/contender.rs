//! One algorithm with its parameters.

use visloc_base::{Frame, RngTree};
use visloc_locate::{Pipeline, PipelineConfig, PosePrior, StartPrior};
use visloc_world::Map;

use super::overrides::Overrides;
use crate::{Clock, StudioError, view::ContenderView};

/// From this reliability on, what an algorithm knows outlives a change of its parameters.
const WORTH_KEEPING: f64 = 0.3;
/// A pose that is kept is at least so uncertain, meters and radians.
const MIN_SPREAD: (f64, f64) = (0.03, 0.03);
/// Hypotheses that are kept.
const MAX_KEPT: usize = 6;

/// What a contender is made for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting<'a> {
    /// The map.
    pub map: &'a Map,
    /// Parameters of everything but the algorithm.
    pub pipeline: &'a PipelineConfig,
    /// Seed of everything random.
    pub seed: u64,
}

/// An algorithm that looks for the robot.
pub(super) struct Contender {
    name: String,
    overrides: Overrides,
    pipeline: Pipeline,
    analysis_ms: f64,
    localizer_ms: f64,
}

impl Contender {
    /// An algorithm that knows nothing yet.
    ///
    /// # Errors
    /// If there is no such algorithm, or a parameter is wrong.
    pub fn new(name: &str, overrides: Overrides, setting: Setting<'_>) -> Result<Self, StudioError> {
        // The seed of the command line's runners, so that a run can be repeated there.
        let rng = RngTree::new(setting.seed).subtree("pipeline", 0);
        let pipeline = Pipeline::new(setting.map, name, Some(&overrides.toml()?), setting.pipeline, rng)?;
        Ok(Self { name: name.to_owned(), overrides, pipeline, analysis_ms: 0.0, localizer_ms: 0.0 })
    }

    /// The same algorithm with other parameters. It begins where this one believes to be, if that is worth something.
    ///
    /// # Errors
    /// As [`Contender::new`].
    pub fn changed(&self, overrides: Overrides, setting: Setting<'_>) -> Result<Self, StudioError> {
        let mut changed = Self::new(&self.name, overrides, setting)?;
        if let Some(prior) = self.knowledge() {
            changed.pipeline.reset_to(&prior);
        }
        Ok(changed)
    }

    fn knowledge(&self) -> Option<StartPrior> {
        let estimate = self.pipeline.localizer().estimate();
        if estimate.reliability_up_to_symmetry < WORTH_KEEPING {
            return None;
        }
        let prior = |hypothesis: &visloc_locate::Hypothesis| {
            let spread = |i: usize| hypothesis.covariance[(i, i)].max(0.0).sqrt();
            PosePrior {
                world_from_robot: hypothesis.world_from_robot,
                position_spread_m: spread(0).hypot(spread(1)).max(MIN_SPREAD.0),
                heading_spread_rad: spread(2).max(MIN_SPREAD.1),
                weight: hypothesis.probability,
            }
        };
        let priors: Vec<_> = estimate.hypotheses.iter().take(MAX_KEPT).map(prior).collect();
        (!priors.is_empty()).then_some(StartPrior::Poses(priors))
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What is different from its defaults.
    pub fn overrides(&self) -> &Overrides {
        &self.overrides
    }

    /// Takes in a frame.
    ///
    /// # Errors
    /// If the image does not belong to its camera.
    pub fn step(&mut self, frame: &Frame, clock: &Clock) -> Result<(), StudioError> {
        let pipeline = &mut self.pipeline;
        let (analyzed, analysis_ms) = clock.measure(|| pipeline.analyze(frame).map(|_| ()));
        analyzed?;
        let ((), localizer_ms) = clock.measure(|| {
            pipeline.localize(frame);
        });
        (self.analysis_ms, self.localizer_ms) = (analysis_ms, localizer_ms);
        Ok(())
    }

    /// Forgets where the robot is.
    pub fn forget(&mut self) {
        self.pipeline.reset_to(&StartPrior::Uniform);
    }

    /// For the page.
    pub fn view(&self) -> ContenderView<'_> {
        ContenderView {
            name: &self.name,
            pipeline: &self.pipeline,
            analysis_ms: self.analysis_ms,
            localizer_ms: self.localizer_ms,
        }
    }
}

/// Who runs next.
enum Choice {
    /// One who runs already, by its place.
    Stays(usize),
    New(Box<Contender>),
}

/// Replaces the algorithms by those of these names. Who stays keeps what it knows.
///
/// # Errors
/// If there is no algorithm of a name; then all stay as they were.
pub(super) fn line_up(
    contenders: &mut Vec<Contender>,
    names: &[String],
    setting: Setting<'_>,
) -> Result<(), StudioError> {
    let mut stays = vec![false; contenders.len()];
    let mut chosen = Vec::new();
    for name in names {
        let place = (0..stays.len()).find(|i| !stays[*i] && contenders[*i].name() == name);
        chosen.push(match place {
            Some(place) => {
                stays[place] = true;
                Choice::Stays(place)
            }
            None => Choice::New(Box::new(Contender::new(name, Overrides::default(), setting)?)),
        });
    }
    let mut old: Vec<Option<Contender>> = contenders.drain(..).map(Some).collect();
    let taken = |choice| match choice {
        Choice::Stays(place) => old.get_mut(place).and_then(Option::take),
        Choice::New(contender) => Some(*contender),
    };
    *contenders = chosen.into_iter().filter_map(taken).collect();
    Ok(())
}
