//! Parameters that a building wants different from a field.

use crate::refine::RefinementConfig;

/// Parameters of the tracks inside a building. Every door may be the one that is seen, so there are as many tracks as the
/// building has places that look alike, and they must be told apart by what adds up: a few pixels on something that is not
/// on the map say nothing.
#[must_use]
pub fn refinement_defaults() -> RefinementConfig {
    RefinementConfig {
        max_tracks: 400,
        max_fits: 24,
        search_poses: 150,
        max_births: 5,
        has_look_alikes: true,
        evidence_per_image: 4.0,
        evidence_deadband: 0.01,
        agreement_px: 2.0,
        max_evidence_difference: 0.3,
        evidence_kept: 0.998,
        stale_evidence_kept: 0.7,
        hopeless: 30.0,
        lost_agreement: 0.25,
        ..RefinementConfig::default()
    }
}

/// Parameters of an algorithm inside a building, as TOML over its defaults. There are many places that look alike, so
/// many hypotheses are held and explorers bring many candidates; an iteration costs the same for any number of them. The
/// pixel distance that counts as no agreement is smaller than on a field, so likelihoods fall faster and weights need a
/// smaller exponent.
#[must_use]
pub fn algorithm_defaults(algorithm: &str) -> Option<&'static str> {
    match algorithm {
        "evolutionary" | "evolutionary-grid" => Some(EVOLUTIONARY),
        "mce" | "mc" | "mca" | "mcae" | "kld" | "mc-systematic" => Some(MONTE_CARLO),
        _ => None,
    }
}

/// What of that is different where tracks refine the hypotheses: every new place gets its track at once, so fewer individuals
/// need to stay with it.
#[must_use]
pub fn refined_algorithm_defaults(algorithm: &str) -> Option<&'static str> {
    matches!(algorithm, "evolutionary" | "evolutionary-grid").then_some("max_exploiters = 180")
}

const EVOLUTIONARY: &str = "
max_races = 60
max_exploiters = 300
max_victories = 8
weight_exponent = 8.0
mutation_noise_m = 0.012
mutation_noise_rad = 0.004
fit_health = 0.86

[evidence]
per_image = 4.0
max_difference = 0.2
late_handicap = 6.0
hopeless = 7.0

[explorers]
num_candidates = 40
is_refined = false
num_slices = 8
";

const MONTE_CARLO: &str = "
num_particles = 600
weight_exponent = 8.0

[noise]
heading_rad = 0.01
fit_likelihood = 0.85
";
