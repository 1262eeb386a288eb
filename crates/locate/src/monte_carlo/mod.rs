//! Monte Carlo localization (particle filters).
//!
//! One filter, made of parts that can be chosen apart from each other: initialization, weights, drawing of survivors and
//! when it is done, elite, random newcomers, number of particles, answer. The filters of the documents, classic and
//! augmented with and without elitism, and KLD-sampling are settings of them (see [`MonteCarloConfig`]).
//!
//! Sources: 2010 section 5.1; 2017 sections 2.1.4 and 4.1.

mod cluster;
mod config;
mod estimator;
mod filter;
mod particles;
mod recovery;
mod resample;
mod sample_size;
mod survivors;
#[cfg(test)]
mod tests;
mod weights;

pub use cluster::{ClusterConfig, Clusters};
pub use config::{InitializationConfig, MonteCarloConfig, NoiseConfig, RestartConfig};
pub use estimator::{EstimateConfig, EstimateKind};
pub use filter::MonteCarlo;
pub(crate) use filter::share;
pub use particles::{Particles, PoseNoise};
pub use recovery::{InjectionConfig, InjectionSource};
pub use resample::{Resampling, ResamplingConfig, ResamplingTrigger};
pub use sample_size::{SampleSizeConfig, SampleSizeRule, kld_sample_size, normal_quantile};
