//! What is measured.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::Kind;

/// Claims that are farther from the truth than this are wrong, meters.
pub const WRONG_CLAIM_M: f64 = 0.3;

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Mean position error from the first claim on, whether the place is claimed or not.
    PositionM,
    /// Mean position error while the place is claimed.
    ClaimedPositionM,
    /// Median position error while the place is claimed.
    ClaimedMedianM,
    /// Mean heading error from the first claim on.
    HeadingDeg,
    /// Root mean square of the position error after alignment with scale.
    AteM,
    /// Share of the frames with a claimed place, or with a camera pose.
    Coverage,
    /// Share of the claims that are wrong.
    WrongClaims,
    /// From the first frame to the first claim.
    FirstClaimS,
    /// Share of the kidnaps after which the place was found.
    KidnapsFound,
    /// From the putting down to the right place, median over the kidnaps that were found.
    RecoveryS,
    /// Localization or tracking of an image, mean.
    TimeMs,
    /// Processor time of the whole program for an image, with reading, decoding and mapping.
    ProgramMs,
    /// Most memory of the program.
    MemoryMb,
}

impl Quantity {
    /// All, in the order of the report.
    pub const ALL: [Self; 13] = [
        Self::PositionM,
        Self::ClaimedPositionM,
        Self::ClaimedMedianM,
        Self::HeadingDeg,
        Self::AteM,
        Self::Coverage,
        Self::WrongClaims,
        Self::FirstClaimS,
        Self::KidnapsFound,
        Self::RecoveryS,
        Self::TimeMs,
        Self::ProgramMs,
        Self::MemoryMb,
    ];

    /// The error that stands first for a kind of recording.
    pub fn main_of(kind: Kind) -> Self {
        match kind {
            Kind::Map => Self::PositionM,
            Kind::Slam => Self::AteM,
        }
    }

    /// Whether recordings of a kind have it.
    #[cfg_attr(not(test), allow(dead_code))]
    pub fn is_of(self, kind: Kind) -> bool {
        match self {
            Self::AteM => kind == Kind::Slam,
            Self::Coverage | Self::TimeMs | Self::ProgramMs | Self::MemoryMb => true,
            _ => kind == Kind::Map,
        }
    }

    /// Whether it comes from the pass that measures times.
    pub fn is_cost(self) -> bool {
        matches!(self, Self::TimeMs | Self::ProgramMs | Self::MemoryMb)
    }

    /// Whether more of it is better.
    pub fn is_better_high(self) -> bool {
        matches!(self, Self::Coverage | Self::KidnapsFound)
    }

    /// For tables, with the unit.
    pub fn title(self) -> &'static str {
        match self {
            Self::PositionM => "position error from the first claim on, mean [m]",
            Self::ClaimedPositionM => "position error while claimed, mean [m]",
            Self::ClaimedMedianM => "position error while claimed, median [m]",
            Self::HeadingDeg => "heading error from the first claim on, mean [deg]",
            Self::AteM => "ATE RMSE, aligned with scale [m]",
            Self::Coverage => "share of the frames with a pose",
            Self::WrongClaims => "share of the claims that are wrong (above 0.3 m)",
            Self::FirstClaimS => "first claim after [s]",
            Self::KidnapsFound => "share of the kidnaps found again",
            Self::RecoveryS => "found again after a kidnap, median [s]",
            Self::TimeMs => "localization or tracking of an image, mean [ms]",
            Self::ProgramMs => "processor time of the program an image [ms]",
            Self::MemoryMb => "most memory [MB]",
        }
    }

    /// A value for people.
    pub fn text(self, value: f64) -> String {
        match self {
            Self::Coverage | Self::WrongClaims | Self::KidnapsFound => percent(value),
            Self::MemoryMb => format!("{value:.0}"),
            Self::HeadingDeg | Self::FirstClaimS | Self::RecoveryS => format!("{value:.1}"),
            Self::TimeMs | Self::ProgramMs => format!("{value:.2}"),
            _ if value < 0.1 => format!("{value:.4}"),
            _ => format!("{value:.3}"),
        }
    }

    /// A change below this is none, in the quantity's unit.
    pub fn least_change(self) -> f64 {
        match self {
            Self::PositionM | Self::ClaimedPositionM | Self::ClaimedMedianM | Self::AteM => 1e-4,
            Self::HeadingDeg => 0.05,
            Self::Coverage | Self::WrongClaims | Self::KidnapsFound => 0.002,
            Self::FirstClaimS | Self::RecoveryS => 0.1,
            Self::TimeMs | Self::ProgramMs => 0.05,
            Self::MemoryMb => 1.0,
        }
    }
}

/// A share for people.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    // 99.96 % is not all of it.
    let is_whole = (percent - percent.round()).abs() < 1e-9;
    if is_whole { format!("{percent:.0} %") } else { format!("{percent:.1} %").replace("100.0", "99.9") }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.title())
    }
}
