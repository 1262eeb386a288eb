//! Parameters of algorithms that a building wants different from a field.

/// Parameters of an algorithm inside a building, as TOML over its defaults. There are many places that look alike, so
/// many hypotheses are held and explorers bring many candidates; an iteration costs the same for any number of them.
#[must_use]
pub fn algorithm_defaults(algorithm: &str) -> Option<&'static str> {
    match algorithm {
        "evolutionary" | "evolutionary-grid" => Some(EVOLUTIONARY),
        _ => None,
    }
}

const EVOLUTIONARY: &str = "
max_races = 60
max_exploiters = 300
max_victories = 8

[evidence]
per_image = 8.0

[explorers]
num_candidates = 40
is_refined = false
num_slices = 4
";
