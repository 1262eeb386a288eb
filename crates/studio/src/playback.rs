//! Playing, pausing and the pace of what goes on in steps.

use serde_json::{Value, json};

use crate::{Command, StudioError};

/// Fastest pace, as multiple of reality.
const MAX_SPEED: f64 = 16.0;

visloc_core::with_defaults! {
    /// Whether a session goes on by itself, and how fast.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(crate) struct Playback {
        is_playing: bool = true,
        /// As multiple of reality; 0 is as fast as possible.
        speed: f64 = 1.0,
    }
}

impl Playback {
    /// Whether it goes on by itself.
    pub fn is_playing(&self) -> bool {
        self.is_playing
    }

    pub fn play(&mut self) {
        self.is_playing = true;
    }

    pub fn pause(&mut self) {
        self.is_playing = false;
    }

    /// Plays, pauses or changes the pace, if a command says so; whether it was such a command.
    pub fn handle(&mut self, command: &Command) -> Result<bool, StudioError> {
        match *command {
            Command::Play {} => self.play(),
            Command::Pause {} => self.pause(),
            Command::Speed { factor } if (0.0..=MAX_SPEED).contains(&factor) => self.speed = factor,
            Command::Speed { factor } => {
                return Err(StudioError::command("speed", format!("0 to {MAX_SPEED}"), factor));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Time to the next step if there are `secs` between them in reality; `None` while it pauses.
    pub fn wait_secs(&self, secs: f64) -> Option<f64> {
        self.is_playing.then(|| if self.speed > 0.0 { secs / self.speed } else { 0.0 })
    }

    /// For the state message.
    pub fn fields(&self) -> Value {
        json!({ "is_playing": self.is_playing, "speed": self.speed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pace_divides_the_wait_and_a_wrong_one_changes_nothing() {
        let mut playback = Playback::default();
        assert_eq!(playback.wait_secs(0.1), Some(0.1));
        assert!(playback.handle(&Command::Speed { factor: 4.0 }).unwrap());
        assert_eq!(playback.wait_secs(0.1), Some(0.025));
        for factor in [-1.0, 16.1, f64::NAN, f64::INFINITY] {
            let error = playback.handle(&Command::Speed { factor }).unwrap_err();
            assert!(error.to_string().contains("0 to 16"), "{error}");
        }
        assert_eq!(playback.fields(), json!({ "is_playing": true, "speed": 4.0 }));
        playback.handle(&Command::Speed { factor: 0.0 }).unwrap();
        assert_eq!(playback.wait_secs(0.1), Some(0.0), "as fast as possible");
    }

    #[test]
    fn a_pause_lasts_until_play() {
        let mut playback = Playback::default();
        assert!(playback.handle(&Command::Pause {}).unwrap());
        assert_eq!(playback.wait_secs(0.1), None);
        assert!(!playback.handle(&Command::Forget {}).unwrap(), "a command of others");
        assert!(playback.handle(&Command::Play {}).unwrap() && playback.is_playing());
    }
}
