//! Monte Carlo localization (particle filters).
//!
//! Sources: 2010 section 5.1; 2017 sections 2.1.4 and 4.1.

mod cluster;
mod config;
mod filter;
mod resample;

pub use cluster::{ClusterConfig, Clusters};
pub use config::MonteCarloConfig;
pub use filter::MonteCarlo;
pub(crate) use filter::share;
pub use resample::Resampling;
