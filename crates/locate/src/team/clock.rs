//! Clocks of different robots.

use std::collections::VecDeque;

use visloc_core::Timestamp;

/// The least delay is looked for among the messages of this time, seconds: clocks drift apart slowly.
const WINDOW_SECS: f64 = 20.0;
/// Messages that are remembered at most.
const MAX_REMEMBERED: usize = 128;

/// How far the clock of another robot is behind one's own, with the least delay of its messages in it.
///
/// Nothing comes before it was sent, so the message that came soonest bounds the offset. The delay of that message cannot be told from an
/// offset without an answer; it makes the other robot seem younger by as much.
#[derive(Debug, Clone, Default)]
pub(super) struct ClockOffset {
    /// Arrival by the own clock, and by how much that is after the stamp, seconds. Later ones are larger, so the first is the least.
    least: VecDeque<(Timestamp, f64)>,
}

impl ClockOffset {
    /// Takes in a message that was stamped by the other clock and arrived by the own one.
    pub fn hear(&mut self, stamp: Timestamp, arrival: Timestamp) {
        let behind_secs = arrival.secs_since(stamp);
        while self.least.back().is_some_and(|(_, secs)| *secs >= behind_secs) {
            self.least.pop_back();
        }
        if self.least.len() < MAX_REMEMBERED {
            self.least.push_back((arrival, behind_secs));
        }
        while self.least.front().is_some_and(|(at, _)| arrival.secs_since(*at) > WINDOW_SECS) {
            self.least.pop_front();
        }
    }

    /// A time of the other clock by the own one.
    pub fn to_own(&self, stamp: Timestamp) -> Timestamp {
        stamp + self.behind_secs()
    }

    /// A time of the own clock by the other one.
    pub fn to_other(&self, at: Timestamp) -> Timestamp {
        at + -self.behind_secs()
    }

    fn behind_secs(&self) -> f64 {
        self.least.front().map_or(0.0, |(_, secs)| *secs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_delay_is_the_offset() {
        let mut clock = ClockOffset::default();
        let at = |secs: f64| Timestamp::from_secs(secs);
        for (sent, delay) in [(1.0, 0.3), (2.0, 0.05), (3.0, 0.2), (4.0, 0.4)] {
            clock.hear(at(sent), at(sent + 7.0 + delay));
        }
        assert!((clock.to_own(at(5.0)).secs() - 12.05).abs() < 1e-6);
        // The soonest one is forgotten after a while: a clock may drift.
        for i in 0..30 {
            clock.hear(at(5.0 + f64::from(i)), at(12.3 + f64::from(i)));
        }
        assert!((clock.to_own(at(40.0)).secs() - 47.3).abs() < 1e-6);
    }
}
