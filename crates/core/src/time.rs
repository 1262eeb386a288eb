//! Time stamps.

use std::{fmt, ops};

use serde::{Deserialize, Serialize};

/// A point in time, nanoseconds since the epoch of the recording. Always from the data, never from the wall clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Timestamp {
    nanos: i64,
}

impl Timestamp {
    /// From nanoseconds.
    pub const fn from_nanos(nanos: i64) -> Self {
        Self { nanos }
    }

    /// From seconds and nanoseconds, as ROS headers write them.
    pub fn from_ros(secs: i32, nanos: u32) -> Self {
        Self { nanos: i64::from(secs) * 1_000_000_000 + i64::from(nanos) }
    }

    /// From seconds, rounded to nanoseconds. What is not a number is 0; what is too large or too small for a stamp (292 years) is the last or
    /// the first one.
    pub fn from_secs(secs: f64) -> Self {
        Self { nanos: (secs * 1e9).round() as i64 }
    }

    /// Nanoseconds.
    pub const fn nanos(self) -> i64 {
        self.nanos
    }

    /// Seconds; exact to about 0.2 microseconds for today's dates.
    pub fn secs(self) -> f64 {
        self.nanos as f64 * 1e-9
    }

    /// Seconds from `earlier` to this; negative if `earlier` is later.
    pub fn secs_since(self, earlier: Self) -> f64 {
        self.nanos.saturating_sub(earlier.nanos) as f64 * 1e-9
    }
}

impl ops::Add<f64> for Timestamp {
    type Output = Self;

    /// The time `secs` later.
    fn add(self, secs: f64) -> Self {
        Self { nanos: self.nanos.saturating_add(Self::from_secs(secs).nanos) }
    }
}

impl fmt::Display for Timestamp {
    /// Seconds with nine decimals, without the loss of a float.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.nanos < 0 { "-" } else { "" };
        let nanos = self.nanos.unsigned_abs();
        write!(f, "{sign}{}.{:09}", nanos / 1_000_000_000, nanos % 1_000_000_000)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn display_keeps_nanoseconds() {
        assert_eq!(Timestamp::from_ros(1_700_000_000, 33_333_333).to_string(), "1700000000.033333333");
        assert_eq!(Timestamp::from_nanos(-1_500_000_000).to_string(), "-1.500000000");
    }

    #[test]
    fn differences_are_exact() {
        let start = Timestamp::from_ros(1_700_000_000, 0);
        assert!(((start + 0.1).secs_since(start) - 0.1).abs() < 1e-12);
    }

    #[test]
    fn no_time_is_beyond_the_first_and_the_last() {
        let (first, last) = (Timestamp::from_nanos(i64::MIN), Timestamp::from_nanos(i64::MAX));
        assert_eq!((last + 1.0, first + -1.0, Timestamp::from_secs(1e300)), (last, first, last));
        assert!(last.secs_since(first) > 9e9 && first.secs_since(last) < -9e9);
    }
}
