//! A part of the runs.

use std::{fmt, str::FromStr};

/// Every `count`-th run, starting with run number `index` (from 1): one job of an array of jobs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    count: u64,
}

impl Shard {
    /// All runs.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Whether the run at this place in the list of all runs belongs to the part.
    pub fn contains(self, place: u64) -> bool {
        place % self.count == self.index - 1
    }

    /// Whether the part is all of it.
    pub fn is_whole(self) -> bool {
        self.count == 1
    }
}

impl Default for Shard {
    fn default() -> Self {
        Self::WHOLE
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        let parts = parts.filter(|(index, count)| (1..=*count).contains(index));
        let (index, count) =
            parts.ok_or_else(|| format!("expected K/N with K from 1 to N, found {text:?}"))?;
        Ok(Self { index, count })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_share_all_runs_without_overlap() {
        let shards: Vec<Shard> = ["1/3", "2/3", "3/3"].iter().map(|s| s.parse().unwrap()).collect();
        for place in 0..20 {
            assert_eq!(shards.iter().filter(|shard| shard.contains(place)).count(), 1);
        }
        assert!("2/3".parse::<Shard>().unwrap().contains(1), "counted from 1");
        assert!(Shard::WHOLE.contains(7) && Shard::WHOLE.is_whole());
    }

    #[test]
    fn senseless_parts_are_refused() {
        for text in ["0/3", "4/3", "1/0", "1", "a/b", "-1/3", ""] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
