//! The algorithms with their parameters in this experiment.

use crate::positions::Contender;

/// Noise of a copy in MC and MCA, meters. The documents do not say it; with this one the published figures come out.
const NOISE_M: f64 = 0.1;
/// The same for MCE and MCAe, whose published figures come out with a little more noise.
const ELITIST_NOISE_M: f64 = 0.15;

/// Numbers of particles of the published tables.
pub(super) const PARTICLES: [usize; 4] = [100, 200, 500, 1000];
/// Numbers of explorers of the published tables.
pub(super) const EXPLORERS: [usize; 5] = [1, 5, 10, 20, 50];
/// Numbers of exploiters of a race of the published times.
pub(super) const EXPLOITERS: [usize; 4] = [5, 10, 20, 50];

/// Parts of a particle filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Filter {
    /// In tables.
    pub label: &'static str,
    algorithm: &'static str,
    noise_m: f64,
    elite_share: f64,
    /// Whether survivors are drawn only when the effective sample size is below half of the particles.
    is_selective: bool,
}

/// The published filters, and systematic resampling as the fair opponent, in every iteration and when it is due.
pub(super) const FILTERS: [Filter; 6] = [
    Filter { label: "MC", algorithm: "mc", noise_m: NOISE_M, elite_share: 0.0, is_selective: false },
    Filter { label: "MCA", algorithm: "mca", noise_m: NOISE_M, elite_share: 0.0, is_selective: false },
    Filter {
        label: "MCE",
        algorithm: "mce",
        noise_m: ELITIST_NOISE_M,
        elite_share: 0.2,
        is_selective: false,
    },
    Filter {
        label: "MCAe",
        algorithm: "mcae",
        noise_m: ELITIST_NOISE_M,
        elite_share: 0.2,
        is_selective: false,
    },
    Filter {
        label: "MC systematic",
        algorithm: "mc-systematic",
        noise_m: NOISE_M,
        elite_share: 0.0,
        is_selective: false,
    },
    Filter {
        label: "MC systematic, when due",
        algorithm: "mc-systematic",
        noise_m: NOISE_M,
        elite_share: 0.0,
        is_selective: true,
    },
];

/// Label of the null control.
pub(super) const CONTROL: &str = "uniform (null control)";

/// A particle filter with weights equal to the likelihood, constant noise and a uniform start, as published.
pub(super) fn filter(filter: &Filter, num_particles: usize) -> Contender {
    let Filter { elite_share, noise_m, .. } = filter;
    let mut config = format!(
        "num_particles = {num_particles}\nelite_share = {elite_share:?}\n{PLAIN_FILTER}position_m = {noise_m:?}\n"
    );
    if filter.label.starts_with("MCA") {
        config += PLAIN_INJECTION;
    }
    if filter.is_selective {
        config += "[resampling]\ntrigger = \"effective-sample-size\"\nmin_effective_share = 0.5\n";
    }
    Contender {
        label: filter.label.to_owned(),
        algorithm: filter.algorithm.to_owned(),
        config,
        num_individuals: num_particles,
    }
}

/// What the documents do not have is switched off; runs are parallel, so particles need not be. Ends in the table of the noise.
const PLAIN_FILTER: &str = "\
weight_exponent = 1.0
parallel_from = 1000000
[initialization]
aimed_share = 0.0
[restart]
min_likelihood = 0.0
[clusters]
max_clusters = 0
[noise]
heading_rad = 0.0
growth = 0.0
";

/// Random particles as in the document: anywhere, and counted in the mean likelihood.
const PLAIN_INJECTION: &str = "[injection]\nsource = \"uniform\"\nis_mean_of_survivors = false\n";

/// Particles that know nothing.
pub(super) fn control(num_individuals: usize) -> Contender {
    Contender {
        label: CONTROL.to_owned(),
        algorithm: "uniform".to_owned(),
        config: String::new(),
        num_individuals,
    }
}

/// The published evolutionary algorithm: 4 races of 20 exploiters; every explorer is a candidate in every iteration.
///
/// The documents give no more. Two readings make the published iterations come out: an explorer founds a race where the
/// likelihood is at least 0.25 (within 1.67 m of a position), and races nearer than the experiment's own 2 m are one.
pub(super) fn evolutionary(num_explorers: usize) -> Contender {
    evolutionary_of(20, num_explorers)
}

/// The same with so many exploiters in each race.
pub(super) fn evolutionary_of(num_exploiters: usize, num_explorers: usize) -> Contender {
    Contender {
        label: format!("evolutionary, {num_explorers} explorers"),
        algorithm: "evolutionary".to_owned(),
        config: format!(
            "max_races = 4\nnum_exploiters = {num_exploiters}\n{PLAIN_EVOLUTIONARY}num_random = {num_explorers}\nnum_candidates = {num_explorers}\n"
        ),
        num_individuals: 4 * num_exploiters + num_explorers,
    }
}

/// 120 individuals that keep up to 8 positions: 96 exploiters, shared equally by the races, and 24 explorers.
pub(super) fn evolutionary_long() -> Contender {
    Contender {
        label: "evolutionary, 120 individuals".to_owned(),
        algorithm: "evolutionary".to_owned(),
        config: format!(
            "max_races = 8\nnum_exploiters = 96\nmax_exploiters = 96\n{PLAIN_EVOLUTIONARY}num_random = 24\nnum_candidates = 24\n"
        ),
        num_individuals: 120,
    }
}

/// Noise and thresholds for a world of 20 m without headings; explorers everywhere, as many at any time.
const PLAIN_EVOLUTIONARY: &str = "\
weight_exponent = 1.0
birth_noise_m = 0.2
birth_noise_rad = 0.0
mutation_noise_m = 0.1
mutation_noise_rad = 0.0
noise_growth = 0.0
min_health = 0.25
merge_distance_m = 2.0
merge_turn_rad = 4.0
[explorers]
is_aimed = false
is_refined = false
deep_factor = 1
period = 1
num_slices = 1
";
