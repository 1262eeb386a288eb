//! All algorithms of a run, as people choose and change them.

use serde_json::Value;
use visloc_core::{Clock, Frame, settings::Overrides};

use super::{Contender, LineupError, RunSettings};
use crate::StartPrior;

/// Most algorithms at once.
pub const MAX_ALGORITHMS: usize = 4;

/// Algorithms that run side by side on the same frames.
#[derive(Debug)]
pub struct Lineup {
    settings: RunSettings,
    clock: Clock,
    contenders: Vec<Contender>,
    num_changes: u64,
}

impl Lineup {
    /// The algorithms of the settings, which know nothing yet. The clock measures their steps.
    ///
    /// # Errors
    /// If there is no algorithm of a name, or a parameter is wrong.
    pub fn new(settings: RunSettings, clock: Clock) -> Result<Self, LineupError> {
        let contenders = started(&settings, &clock)?;
        Ok(Self { settings, clock, contenders, num_changes: 0 })
    }

    /// What they run with.
    pub fn settings(&self) -> &RunSettings {
        &self.settings
    }

    /// How often settings have changed: a scene message of another number is out of date.
    pub fn num_changes(&self) -> u64 {
        self.num_changes
    }

    /// The algorithms, in the order of the settings.
    pub fn contenders(&self) -> &[Contender] {
        &self.contenders
    }

    /// The algorithms, to step them one by one.
    pub fn contenders_mut(&mut self) -> &mut [Contender] {
        &mut self.contenders
    }

    /// All take in a frame.
    ///
    /// # Errors
    /// If the image does not belong to its camera.
    pub fn step(&mut self, frame: &Frame) -> Result<(), LineupError> {
        self.contenders.iter_mut().try_for_each(|contender| contender.step(frame))
    }

    /// Everything from the beginning, with the parameters as they are.
    ///
    /// # Errors
    /// As [`Lineup::new`]; then nothing has changed.
    pub fn reset(&mut self, seed: u64) -> Result<(), LineupError> {
        let settings = RunSettings { seed, ..self.settings.clone() };
        self.contenders = started(&settings, &self.clock)?;
        self.change_to(settings);
        Ok(())
    }

    /// All begin again with what is known about the pose.
    pub fn reset_to(&mut self, prior: &StartPrior) {
        self.contenders.iter_mut().for_each(|contender| contender.reset_to(prior));
    }

    /// Changes a parameter of one algorithm, by its place, or one that all share. Who believes to be somewhere goes on there.
    ///
    /// # Errors
    /// If there is no such parameter, or it cannot have the value; then nothing has changed.
    pub fn set(&mut self, algorithm: Option<usize>, path: &str, value: &Value) -> Result<(), LineupError> {
        let changed = match algorithm {
            None => self
                .settings
                .pipeline_overrides()
                .and_then(|overrides| self.change_pipeline(&overrides.with(path, value))),
            Some(algorithm) => {
                let known = self.contenders.get(algorithm);
                let overrides = known.map(|it| it.overrides().with(path, value)).unwrap_or_default();
                self.change(algorithm, overrides)
            }
        };
        changed.map_err(|error| LineupError::Parameter {
            path: path.to_owned(),
            value: value.clone(),
            reason: error.to_string(),
        })
    }

    /// Defaults again, of one algorithm, by its place, or of what all share.
    ///
    /// # Errors
    /// If there is no such algorithm.
    pub fn set_defaults(&mut self, algorithm: Option<usize>) -> Result<(), LineupError> {
        match algorithm {
            None => self.change_pipeline(&Overrides::default()),
            Some(algorithm) => self.change(algorithm, Overrides::default()),
        }
    }

    fn change_to(&mut self, settings: RunSettings) {
        self.settings = settings;
        self.num_changes += 1;
    }

    /// Changes parameters of one algorithm.
    fn change(&mut self, algorithm: usize, overrides: Overrides) -> Result<(), LineupError> {
        let num = self.contenders.len();
        let old = self.contenders.get(algorithm);
        let old = old.ok_or_else(|| LineupError::refused("algorithm", format!("below {num}"), algorithm))?;
        let changed = old.changed(overrides.clone(), &self.settings, &self.clock)?;
        self.contenders[algorithm] = changed;
        let mut settings = self.settings.clone();
        settings.algorithms[algorithm].1 = overrides;
        self.change_to(settings);
        Ok(())
    }

    /// Changes parameters that all algorithms share.
    fn change_pipeline(&mut self, overrides: &Overrides) -> Result<(), LineupError> {
        let settings = self.settings.with_pipeline(overrides)?;
        let changed = |old: &Contender| old.changed(old.overrides().clone(), &settings, &self.clock);
        self.contenders = self.contenders.iter().map(changed).collect::<Result<_, _>>()?;
        self.change_to(settings);
        Ok(())
    }

    /// Replaces the algorithms by those of these names. Who stays keeps what it knows.
    ///
    /// # Errors
    /// If there is no algorithm of a name, or they are too many; then nothing has changed.
    pub fn line_up(&mut self, names: &[String]) -> Result<(), LineupError> {
        if names.is_empty() || names.len() > MAX_ALGORITHMS {
            let expected = format!("1 to {MAX_ALGORITHMS}");
            return Err(LineupError::refused("algorithms", expected, names.len()));
        }
        let mut stays = vec![false; self.contenders.len()];
        let mut chosen = Vec::new();
        for name in names {
            let place = (0..stays.len()).find(|i| !stays[*i] && self.contenders[*i].name() == name);
            chosen.push(match place {
                Some(place) => {
                    stays[place] = true;
                    Choice::Stays(place)
                }
                None => Choice::New(Box::new(Contender::new(
                    name,
                    Overrides::default(),
                    &self.settings,
                    &self.clock,
                )?)),
            });
        }
        let mut old: Vec<Option<Contender>> = self.contenders.drain(..).map(Some).collect();
        let taken = |choice| match choice {
            Choice::Stays(place) => old.get_mut(place).and_then(Option::take),
            Choice::New(contender) => Some(*contender),
        };
        self.contenders = chosen.into_iter().filter_map(taken).collect();
        let algorithms = self.contenders.iter().map(|it| (it.name().to_owned(), it.overrides().clone()));
        let settings = RunSettings { algorithms: algorithms.collect(), ..self.settings.clone() };
        self.change_to(settings);
        Ok(())
    }
}

/// Who runs next.
enum Choice {
    /// One who runs already, by its place.
    Stays(usize),
    New(Box<Contender>),
}

fn started(settings: &RunSettings, clock: &Clock) -> Result<Vec<Contender>, LineupError> {
    let contender =
        |(name, overrides): &(String, Overrides)| Contender::new(name, overrides.clone(), settings, clock);
    settings.algorithms.iter().map(contender).collect()
}
