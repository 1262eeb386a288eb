//! The algorithms with their parameters in this experiment.

use crate::positions::Contender;

/// Individuals of every contender.
pub(super) const NUM_INDIVIDUALS: usize = 500;

/// All contenders.
pub(super) fn all() -> Vec<Contender> {
    let filter = |label: &str, algorithm: &str, more: &str| Contender {
        label: label.to_owned(),
        algorithm: algorithm.to_owned(),
        config: format!("{PLAIN_FILTER}{more}"),
        num_individuals: NUM_INDIVIDUALS,
    };
    let never = "[restart]\nmin_likelihood = 0.0\n";
    let injection = |alpha_slow: f64, alpha_fast: f64| {
        let alphas = format!("alpha_slow = {alpha_slow:?}\nalpha_fast = {alpha_fast:?}\n");
        format!("{never}[injection]\nmax_share = 1.0\nsource = \"uniform\"\n{alphas}")
    };
    vec![
        filter("MC, no recovery", "mc", never),
        filter("MC systematic, restart when lost", "mc-systematic", RESTART),
        filter("MCA, averages 0.05 and 0.4 (published)", "mca", &injection(0.05, 0.4)),
        filter("MCA, averages 0.001 and 0.1 (peers)", "mca", &injection(0.001, 0.1)),
        Contender {
            label: "evolutionary".to_owned(),
            algorithm: "evolutionary".to_owned(),
            config: EVOLUTIONARY.to_owned(),
            num_individuals: NUM_INDIVIDUALS,
        },
    ]
}

/// Constant noise of 0.05 m, weights equal to the likelihood, a uniform start, every individual in every iteration.
const PLAIN_FILTER: &str = "\
num_particles = 500
elite_share = 0.0
weight_exponent = 1.0
[initialization]
aimed_share = 0.0
[noise]
position_m = 0.05
heading_rad = 0.0
growth = 0.0
[clusters]
max_clusters = 0
";

/// No particle is within 2 m for three iterations.
const RESTART: &str = "[restart]\nmin_likelihood = 0.15\nafter = 3\n";

/// At most 400 exploiters and, when lost, 100 explorers. Health follows the likelihood at once, and few victories
/// are remembered, so that a race that is wrong dies as soon as its nine lives are over.
const EVOLUTIONARY: &str = "\
max_races = 4
num_exploiters = 400
max_exploiters = 400
weight_exponent = 1.0
birth_noise_m = 0.2
birth_noise_rad = 0.0
mutation_noise_m = 0.1
mutation_noise_rad = 0.0
noise_growth = 0.0
health_follow = 1.0
max_victories = 3
min_health = 0.25
lost_health = 0.25
merge_distance_m = 2.0
merge_turn_rad = 4.0
[explorers]
is_aimed = false
is_refined = false
num_random = 10
deep_factor = 10
num_candidates = 6
period = 1
num_slices = 1
";
