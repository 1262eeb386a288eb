//! Learns the observation tables of the Markov experiment anew and writes them where the program takes them from:
//! `cargo run --release -p visloc-experiments --example learn_markov_tables`.

use std::{error::Error, fs, path::Path};

use visloc_experiments::markov::{Captures, MarkovExperiment, MarkovSettings};

fn main() -> Result<(), Box<dyn Error>> {
    let captures = Some(Captures { per_state: 50, seed: 1 });
    let settings = MarkovSettings { captures, ..MarkovSettings::default() };
    let experiment = MarkovExperiment::new(settings, 1)?;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    fs::write(folder.join("markov-tables.csv"), experiment.learned_tables().to_csv())?;
    fs::write(folder.join("markov-densities.csv"), experiment.learned_densities().to_csv())?;
    Ok(())
}
