//! The published figures of the same experiments. Source: 2010 sections 5.1.5, 5.2.4 and 5.3.

use super::sets::RobocupSet;

/// What the documents report of a set: position error, meters; heading error, degrees; kidnaps; time to a reliability
/// above 0.6 after a kidnap, seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Published {
    pub algorithm: &'static str,
    pub position_m: &'static str,
    pub heading_deg: &'static str,
    pub right: &'static str,
    pub reliable_s: &'static str,
}

/// Rows for a set; none if the documents have nothing of the kind.
pub(super) fn rows(set: RobocupSet) -> &'static [Published] {
    match set {
        RobocupSet::Tours => &TOURS,
        RobocupSet::Kidnaps => &KIDNAPS,
        RobocupSet::Unfelt => &UNFELT,
        RobocupSet::NoOdometry | RobocupSet::Crowd | RobocupSet::White => &[],
    }
}

const TOURS: [Published; 2] = [
    Published {
        algorithm: "evolutionary",
        position_m: "0.142",
        heading_deg: "8.4",
        right: "-",
        reliable_s: "-",
    },
    Published { algorithm: "mcae", position_m: "0.174", heading_deg: "12.0", right: "-", reliable_s: "-" },
];

const KIDNAPS: [Published; 2] = [
    Published {
        algorithm: "evolutionary",
        position_m: "0.149",
        heading_deg: "6.4",
        right: "3 of 3",
        reliable_s: "20.7",
    },
    Published {
        algorithm: "mcae",
        position_m: "0.222",
        heading_deg: "11.5",
        right: "3 of 4",
        reliable_s: "16.5",
    },
];

const UNFELT: [Published; 1] = [Published {
    algorithm: "evolutionary",
    position_m: "-",
    heading_deg: "-",
    right: "-",
    reliable_s: "30",
}];
