//! Published figures. Source: 2017 sections 7.1 and 7.2.

/// A sequence of the documents: how its folder may be called, and its name in their tables.
const SEQUENCES: [(&[&str], &str); 8] = [
    (&["traj3", "office3", "office_room_traj3", "or3"], "OR3"),
    (&["mh_01", "mh01"], "MH01"),
    (&["mh_02", "mh02"], "MH02"),
    (&["freiburg1_floor", "fr1_floor", "f1f"], "F1F"),
    (&["freiburg2_desk", "fr2_desk", "f2d"], "F2D"),
    (&["freiburg2_360_kidnap", "fr2_360_kidnap", "f2k"], "F2K"),
    (&["freiburg3_walking_static", "fr3_walking_static", "f3w"], "F3W"),
    (&["agz", "zurich"], "ZU"),
];

/// The documents' name of a sequence, told from the name of its folder.
pub(super) fn sequence_name(folder: &str) -> Option<&'static str> {
    let folder = folder.to_lowercase();
    let is_called = |names: &[&str]| names.iter().any(|name| folder.contains(name));
    SEQUENCES.iter().find(|(names, _)| is_called(names)).map(|(_, name)| *name)
}

/// RMSE in meters, tracking and mapping in milliseconds, of configurations 1 to 8.
const CONFIGURATIONS: [(&str, [[f64; 3]; 8]); 2] = [
    (
        "OR3",
        [
            [0.067, 3.84, 3.50],
            [0.068, 3.72, 3.46],
            [0.081, 3.88, 3.88],
            [0.066, 3.69, 3.84],
            [0.110, 6.05, 3.88],
            [0.089, 5.81, 3.67],
            [0.055, 5.87, 4.74],
            [0.068, 5.92, 3.92],
        ],
    ),
    (
        "MH01",
        [
            [0.98, 10.43, 31.42],
            [1.05, 10.03, 32.28],
            [0.15, 10.51, 85.89],
            [0.14, 10.14, 89.61],
            [0.73, 17.12, 21.06],
            [0.49, 17.40, 20.94],
            [0.28, 17.26, 42.21],
            [0.11, 17.25, 42.31],
        ],
    ),
];

/// Error, tracking and mapping of a configuration on a sequence of the documents.
pub(super) fn configuration(sequence: &str, name: &str) -> Option<[f64; 3]> {
    let index = match name {
        "sdvl" => 3,
        "orb-sdvl" => 7,
        other => other.strip_prefix("config")?.parse::<usize>().ok()?.checked_sub(1)?,
    };
    let (_, figures) = CONFIGURATIONS.iter().find(|(known, _)| *known == sequence)?;
    figures.get(index).copied()
}

/// Programs of the comparison.
pub(super) const PROGRAMS: [&str; 6] = ["SDVL", "ORB-SDVL", "PTAM", "SVO", "LSD-SLAM", "ORB-SLAM"];

/// RMSE in meters of these programs; X: less than 30 % tracked, *: less than 70 %.
pub(super) const COMPARISON: [(&str, [&str; 6]); 6] = [
    ("OR3", ["0.066", "0.068", "0.044", "0.094*", "0.092", "0.085"]),
    ("MH01", ["0.147", "0.112", "X", "0.135", "0.254", "0.044"]),
    ("MH02", ["0.115", "0.077", "X", "0.052", "1.395", "0.035"]),
    ("F1F", ["0.026", "0.041", "0.069*", "0.018*", "0.366", "0.013"]),
    ("F2D", ["0.054", "0.034", "X", "X", "0.103", "0.027"]),
    ("ZU", ["1.112", "0.548", "X", "0.331", "0.508", "0.429"]),
];

/// Tracking in milliseconds an image of the same programs.
pub(super) const COMPARISON_MS: [(&str, [&str; 6]); 6] = [
    ("OR3", ["3.69", "5.92", "4.25", "1.50*", "7.91", "20.27"]),
    ("MH01", ["10.14", "17.25", "X", "3.18", "16.63", "34.72"]),
    ("MH02", ["9.93", "16.99", "X", "3.14", "16.87", "30.62"]),
    ("F1F", ["6.06", "8.49", "5.15*", "3.29*", "14.53", "19.39"]),
    ("F2D", ["6.15", "10.32", "X", "X", "12.46", "27.07"]),
    ("ZU", ["8.47", "16.34", "X", "2.36", "17.47", "26.16"]),
];

/// RMSE in meters, tracking and relocalization in milliseconds, on F2K.
pub(super) fn kidnap(sequence: &str, name: &str) -> Option<[f64; 3]> {
    match (sequence, name) {
        ("F2K", "sdvl" | "config4") => Some([0.14, 5.01, 99.75]),
        ("F2K", "orb-sdvl" | "config8") => Some([0.11, 8.21, 43.89]),
        _ => None,
    }
}

/// RMSE in meters, and tracking in milliseconds, on F3W with (config4) and without (config3) rejection; not a number where the
/// documents say only that it jumps.
pub(super) fn dynamic(sequence: &str, name: &str) -> Option<[f64; 2]> {
    match (sequence, name) {
        ("F3W", "config4") => Some([0.012, 5.79]),
        ("F3W", "config3") => Some([f64::NAN, 4.82]),
        _ => None,
    }
}
