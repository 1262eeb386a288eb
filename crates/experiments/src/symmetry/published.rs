//! The published figures. Source: 2017 section 5.1.

/// Numbers of positions of the published tables.
pub(super) const POSITIONS: [usize; 3] = [2, 3, 4];
/// Numbers of particles of the published tables.
pub(super) const PARTICLES: [usize; 4] = [100, 200, 500, 1000];
/// Numbers of explorers of the published tables.
pub(super) const EXPLORERS: [usize; 5] = [1, 5, 10, 20, 50];

/// Successes of 100 of a filter with static positions: for each number of particles those of 2, 3 and 4 positions.
pub(super) fn static_successes(filter: &str) -> Option<[[u32; 3]; 4]> {
    match filter {
        "MC" => Some([[0, 0, 0], [10, 0, 0], [47, 12, 0], [76, 49, 16]]),
        "MCA" => Some([[9, 2, 0], [13, 1, 0], [43, 16, 4], [79, 56, 18]]),
        "MCE" => Some([[11, 0, 0], [30, 8, 3], [79, 51, 29], [96, 92, 84]]),
        "MCAe" => Some([[9, 2, 0], [37, 9, 2], [81, 47, 34], [96, 90, 77]]),
        _ => None,
    }
}

/// Successes of 100 of a filter with 1,000 particles when the positions move 1 cm per iteration.
pub(super) fn moving_successes(filter: &str) -> Option<[u32; 3]> {
    match filter {
        "MCE" => Some([75, 40, 20]),
        "MCAe" => Some([74, 43, 21]),
        _ => None,
    }
}

/// Successes of 100 of the evolutionary algorithm, for each number of explorers.
pub(super) const EVOLUTIONARY_SUCCESSES: [[u32; 3]; 5] =
    [[100, 100, 96], [100, 100, 100], [100, 100, 100], [100, 100, 100], [100, 100, 100]];

/// Mean iterations until all positions are found, for each number of explorers.
pub(super) const EVOLUTIONARY_ITERATIONS: [[f64; 3]; 5] = [
    [78.58, 90.22, 104.94],
    [14.6, 17.88, 22.96],
    [8.67, 9.61, 12.34],
    [4.38, 5.18, 6.38],
    [2.24, 2.49, 4.39],
];
