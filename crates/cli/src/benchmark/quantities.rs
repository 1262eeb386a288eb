//! What is measured.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::Kind;

/// Claims that are farther from the truth than this are wrong, meters.
pub const WRONG_CLAIM_M: f64 = 0.3;

/// What is measured, in the order of the report; the titles say more. "From the first claim on" counts every frame, "while claimed" those
/// with a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    PositionM,
    ClaimedPositionM,
    ClaimedMedianM,
    HeadingDeg,
    AteM,
    Coverage,
    WrongClaims,
    FirstClaimS,
    KidnapsFound,
    RecoveryS,
    TimeMs,
    ProgramMs,
    MemoryMb,
}

/// How a value is written.
#[derive(Clone, Copy)]
enum Shown {
    /// In percent.
    Share,
    /// Three decimals, four below 0.1.
    Meters,
    /// So many decimals.
    Decimals(usize),
}

use Shown::{Decimals, Meters, Share};

/// Each with its title, how it is written, and the change below which there is none.
const PROPERTIES: [(Quantity, &str, Shown, f64); 13] = [
    (Quantity::PositionM, "position error from the first claim on, mean [m]", Meters, 1e-4),
    (Quantity::ClaimedPositionM, "position error while claimed, mean [m]", Meters, 1e-4),
    (Quantity::ClaimedMedianM, "position error while claimed, median [m]", Meters, 1e-4),
    (Quantity::HeadingDeg, "heading error from the first claim on, mean [deg]", Decimals(1), 0.05),
    (Quantity::AteM, "ATE RMSE, aligned with scale [m]", Meters, 1e-4),
    (Quantity::Coverage, "share of the frames with a pose", Share, 0.002),
    (Quantity::WrongClaims, "share of the claims that are wrong (above 0.3 m)", Share, 0.002),
    (Quantity::FirstClaimS, "first claim after [s]", Decimals(1), 0.1),
    (Quantity::KidnapsFound, "share of the kidnaps found again", Share, 0.002),
    (Quantity::RecoveryS, "found again after a kidnap, median [s]", Decimals(1), 0.1),
    (Quantity::TimeMs, "localization or tracking of an image, median [ms]", Decimals(2), 0.05),
    (Quantity::ProgramMs, "processor time of the program an image [ms]", Decimals(2), 0.05),
    (Quantity::MemoryMb, "most memory [MB]", Decimals(0), 1.0),
];

impl Quantity {
    /// All, in the order of the report.
    pub fn all() -> impl Iterator<Item = Self> {
        PROPERTIES.iter().map(|property| property.0)
    }

    /// The error that stands first for a kind of recording.
    pub fn main_of(kind: Kind) -> Self {
        match kind {
            Kind::Map => Self::PositionM,
            Kind::Slam => Self::AteM,
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
        PROPERTIES[self as usize].1
    }

    /// A value for people.
    pub fn text(self, value: f64) -> String {
        match PROPERTIES[self as usize].2 {
            Share => percent(value),
            Meters => format!("{value:.*}", if value < 0.1 { 4 } else { 3 }),
            Decimals(number) => format!("{value:.number$}"),
        }
    }

    /// A change below this is none, in the quantity's unit.
    pub fn least_change(self) -> f64 {
        PROPERTIES[self as usize].3
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn properties_stand_in_the_order_of_the_quantities() {
        assert!(Quantity::all().enumerate().all(|(i, quantity)| quantity as usize == i));
        assert_eq!(Quantity::Coverage.text(0.999_99), "99.9 %");
        assert_eq!([Quantity::AteM.text(0.012_34), Quantity::AteM.text(0.123_4)], ["0.0123", "0.123"]);
    }
}
