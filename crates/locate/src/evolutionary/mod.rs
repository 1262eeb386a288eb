//! Evolutionary multi-hypothesis localization.
//!
//! Races are populations of exploiters around one hypothesis each; explorers look for new places. Sources: 2010
//! section 5.2; 2017 section 4.2.

mod config;
mod explorers;
mod localizer;
mod race;
mod races;

pub use config::{EvidenceConfig, EvolutionaryConfig, ExplorerConfig, ExplorerKind};
pub use localizer::Evolutionary;
