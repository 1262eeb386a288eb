//! A network that loses and delays messages.

use rand::RngExt as _;
use visloc_core::{Rng, Timestamp};
use visloc_locate::team::TeamMessage;

/// Messages on their way.
pub(super) struct Network {
    loss: f64,
    delay_secs: f64,
    rng: Rng,
    waiting: Vec<(Timestamp, usize, TeamMessage)>,
}

impl Network {
    pub fn new(loss: f64, delay_secs: f64, rng: Rng) -> Self {
        Self { loss, delay_secs, rng, waiting: Vec::new() }
    }

    /// Sends a message to a robot: with the stated loss, after the stated delay and up to half of it more.
    pub fn send(&mut self, now: Timestamp, to: usize, message: &TeamMessage) {
        let (is_lost, more) = (self.rng.random_bool(self.loss), self.rng.random_range(1.0..=1.5));
        if !is_lost {
            self.waiting.push((now + self.delay_secs * more, to, message.clone()));
        }
    }

    /// What has arrived until now, with the time of arrival, in the order of arrival.
    pub fn arrived(&mut self, now: Timestamp) -> Vec<(Timestamp, usize, TeamMessage)> {
        let (mut arrived, waiting): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.waiting).into_iter().partition(|(at, ..)| *at <= now);
        self.waiting = waiting;
        arrived.sort_by_key(|(at, ..)| *at);
        arrived
    }
}
