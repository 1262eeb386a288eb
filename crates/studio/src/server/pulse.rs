//! Signs of life between updates. What has stalled must not look alive: neither a program that is stopped, nor one whose engine hangs
//! while its server goes on, nor a link on which nothing comes through. A source that has nothing new is none of these.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// How often a program gives a sign of life.
pub(super) const PULSE_EVERY: Duration = Duration::from_millis(250);
/// What has not answered for so long is stale, seconds. The page has the same number.
pub(super) const STALE_SECS: f64 = 1.0;

/// A sign of life, as JSON in a text: `{"type": "pulse", "busy_secs": 0.01}`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename = "pulse")]
pub(super) struct Pulse {
    /// How long the engine has answered nobody, seconds.
    pub busy_secs: f64,
}

impl Pulse {
    pub fn text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    pub fn read(text: &str) -> Option<Self> {
        serde_json::from_str(text).ok()
    }
}

/// How long a program elsewhere has not answered.
#[derive(Debug, Default)]
pub(super) struct Silence {
    /// Since anything came.
    secs: f64,
    /// The last sign of life; `None` before the first one, from a program that gives none.
    pulse: Option<Pulse>,
}

impl Silence {
    /// Something has come.
    pub fn ends(&mut self) {
        self.secs = 0.0;
    }

    /// A sign of life has come.
    pub fn take(&mut self, pulse: Pulse) {
        self.pulse = Some(pulse);
        self.ends();
    }

    pub fn pass(&mut self, secs: f64) {
        self.secs += secs;
    }

    /// How long it has not answered, if that is too long, seconds.
    pub fn stale_secs(&self) -> Option<f64> {
        let secs = self.secs + self.pulse?.busy_secs;
        (secs > STALE_SECS).then_some(secs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silence_and_a_busy_engine_add_up() {
        let mut silence = Silence::default();
        silence.pass(60.0);
        assert_eq!(silence.stale_secs(), None, "nobody has promised anything");
        silence.take(Pulse::read(&Pulse { busy_secs: 0.0 }.text()).unwrap());
        silence.pass(0.9);
        assert_eq!(silence.stale_secs(), None);
        silence.pass(0.2);
        assert!(silence.stale_secs().is_some_and(|secs| (secs - 1.1).abs() < 1e-9));
        silence.take(Pulse { busy_secs: 3.0 });
        assert_eq!(silence.stale_secs(), Some(3.0), "the server goes on, the engine does not");
        assert_eq!(Pulse::read("{\"type\":\"play\"}"), None);
    }
}
