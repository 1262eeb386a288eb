//! Measured times; never used for a result.

use visloc_core::Clock;

/// Time spent on the stages of one frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StageTimes {
    stages: Vec<(&'static str, f64)>,
}

impl StageTimes {
    /// Adds seconds to a stage.
    pub fn add(&mut self, stage: &'static str, secs: f64) {
        match self.stages.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, sum)) => *sum += secs,
            None => self.stages.push((stage, secs)),
        }
    }

    /// Names and seconds, in order of first use.
    #[must_use]
    pub fn stages(&self) -> &[(&'static str, f64)] {
        &self.stages
    }

    /// Sum over all stages, seconds.
    #[must_use]
    pub fn total_secs(&self) -> f64 {
        self.stages.iter().map(|(_, secs)| secs).sum()
    }
}

/// Measures one stage after the other.
#[derive(Debug)]
pub struct StageTimer {
    clock: Clock,
    last: f64,
    times: StageTimes,
}

impl StageTimer {
    /// Starts the first stage.
    #[must_use]
    pub fn start(clock: Clock) -> Self {
        Self { last: clock.secs(), clock, times: StageTimes::default() }
    }

    /// Ends a stage and starts the next. A stage can be ended several times; its times add up.
    pub fn end(&mut self, stage: &'static str) {
        let now = self.clock.secs();
        self.times.add(stage, now - self.last);
        self.last = now;
    }

    /// Starts a stage anew: the time since the last one counts for none.
    pub fn restart(&mut self) {
        self.last = self.clock.secs();
    }

    /// What was measured.
    #[must_use]
    pub fn finish(self) -> StageTimes {
        self.times
    }
}
