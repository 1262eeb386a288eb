//! Parameters that a building wants different from a field.

use crate::{
    Algorithm,
    evolutionary::{EvidenceConfig, EvolutionaryConfig, ExplorerConfig},
    monte_carlo::{MonteCarloConfig, NoiseConfig},
    refine::RefinementConfig,
};

/// Parameters of the tracks inside a building. Every door may be the one that is seen, so there are as many tracks as the
/// building has places that look alike, and they must be told apart by what adds up: a few pixels on something that is not
/// on the map say nothing.
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
        mount_pitch_rad: 0.0,
        mount_roll_rad: 0.0,
        mount_yaw_rad: 0.0,
        ..RefinementConfig::default()
    }
}

/// The same algorithm for the inside of a building, with tracks that refine its hypotheses or without. There are many places that look
/// alike, so many hypotheses are held and explorers bring many candidates; an iteration costs the same for any number of them. The
/// pixel distance that counts as no agreement is smaller than on a field, so likelihoods fall faster and weights need a smaller exponent.
pub fn in_building(algorithm: Algorithm, is_refined: bool) -> Algorithm {
    match algorithm {
        Algorithm::Evolutionary(config) => Algorithm::Evolutionary(EvolutionaryConfig {
            max_races: 60,
            // With tracks every new place gets one at once, so fewer individuals need to stay with it.
            max_exploiters: if is_refined { 180 } else { 300 },
            max_victories: 8,
            weight_exponent: 8.0,
            mutation_noise_m: 0.012,
            mutation_noise_rad: 0.004,
            fit_health: 0.86,
            evidence: EvidenceConfig {
                per_image: 4.0,
                max_difference: 0.2,
                late_handicap: 6.0,
                hopeless: 7.0,
                ..config.evidence
            },
            explorers: ExplorerConfig {
                num_candidates: 40,
                is_refined: false,
                num_slices: 8,
                ..config.explorers
            },
            ..config
        }),
        Algorithm::MonteCarlo(config) => Algorithm::MonteCarlo(MonteCarloConfig {
            num_particles: 600,
            weight_exponent: 8.0,
            noise: NoiseConfig { heading_rad: 0.01, fit_likelihood: 0.85, ..config.noise },
            ..config
        }),
        other @ Algorithm::Markov(_) => other,
    }
}
