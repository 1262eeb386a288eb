//! Random particles when the belief explains the images worse than it used to.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::{Rng, geom::PlanarPose};

use crate::{ConfigError, ObservationModel, require};

/// Where random particles are put.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InjectionSource {
    /// Anywhere on the map. Source: 2017 section 2.1.4.
    Uniform,
    /// At poses that agree with some part of the image, after "sensor resetting", Lenser and Veloso, 2000.
    Proposed,
}

impl InjectionSource {
    /// One random pose.
    pub(super) fn sample(self, model: &dyn ObservationModel, rng: &mut Rng) -> PlanarPose {
        match self {
            Self::Uniform => model.sample(rng),
            Self::Proposed => model.propose(rng),
        }
    }
}

visloc_core::with_defaults! {
    /// Parameters of the augmented filter: a share of the particles is random, the larger the more the mean likelihood has
    /// dropped. Source: 2017 section 2.1.4, equations 2.9 to 2.11; Thrun, Burgard, Fox 2005, table 8.3.
    ///
    /// The averages follow the likelihoods themselves, not normalized weights, whose mean says nothing. They are never set
    /// back after random particles were put in, so that the search goes on until it succeeds.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct InjectionConfig {
        /// Largest share of random particles; 0 switches them off.
        #[schemars(range(min = 0.0, max = 1.0))]
        pub max_share: f64 = 0.0,
        /// Smallest share of random particles, at all times; the documents have 0.
        #[schemars(extend("x-only-if" = "max_share > 0"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub min_share: f64 = 0.0,
        /// How fast the slow average follows. Source: 2017 section 2.1.4, 0.05.
        #[schemars(extend("x-only-if" = "max_share > 0"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub alpha_slow: f64 = 0.05,
        /// How fast the fast average follows. Source: 2017 section 2.1.4, 0.4.
        #[schemars(extend("x-only-if" = "max_share > 0"))]
        #[schemars(range(min = 0.0, max = 1.0))]
        pub alpha_fast: f64 = 0.4,
        /// Whether random particles are left out of the mean likelihood in the image after they were put in. Deviation, the
        /// documents count them: many random particles then lower the mean, which calls for still more of them.
        #[schemars(extend("x-only-if" = "max_share > 0"))]
        pub is_mean_of_survivors: bool = true,
        /// Where random particles are put.
        #[schemars(extend("x-only-if" = "max_share > 0"))]
        pub source: InjectionSource = InjectionSource::Uniform,
    }
}

impl InjectionConfig {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        let (share, slow) = (self.min_share, self.alpha_slow);
        require(share <= self.max_share, "injection.min_share", "at most injection.max_share", share)?;
        require(slow <= self.alpha_fast, "injection.alpha_slow", "at most injection.alpha_fast", slow)
    }
}

/// A slow and a fast average of the mean likelihood.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Recovery {
    slow: f64,
    fast: f64,
}

impl Recovery {
    /// Takes in the mean likelihood of an image; returns the share of particles that should be random.
    pub fn update(&mut self, mean_likelihood: f64, config: &InjectionConfig) -> f64 {
        if config.max_share <= 0.0 {
            return 0.0;
        }
        if mean_likelihood.is_finite() {
            self.slow += config.alpha_slow * (mean_likelihood - self.slow);
            self.fast += config.alpha_fast * (mean_likelihood - self.fast);
        }
        let drop = if self.slow > 0.0 { 1.0 - self.fast / self.slow } else { 0.0 };
        drop.clamp(config.min_share, config.max_share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AUGMENTED: InjectionConfig = InjectionConfig {
        max_share: 1.0,
        min_share: 0.0,
        alpha_slow: 0.05,
        alpha_fast: 0.4,
        is_mean_of_survivors: true,
        source: InjectionSource::Uniform,
    };

    /// Equations 2.9 to 2.11 by hand.
    #[test]
    fn share_by_hand() {
        let mut recovery = Recovery { slow: 0.8, fast: 0.8 };
        // slow 0.8 + 0.05 (0.1 - 0.8) = 0.765, fast 0.8 + 0.4 (0.1 - 0.8) = 0.52
        let share = recovery.update(0.1, &AUGMENTED);
        assert!((share - (1.0 - 0.52 / 0.765)).abs() < 1e-12);
    }

    #[test]
    fn none_while_the_mean_grows_or_when_switched_off() {
        let mut recovery = Recovery::default();
        for mean in [0.1, 0.2, 0.5, 0.9, 0.9] {
            assert!(recovery.update(mean, &AUGMENTED).abs() < 1e-12);
        }
        let off = InjectionConfig::default();
        let mut recovery = Recovery { slow: 0.8, fast: 0.8 };
        assert!(recovery.update(0.0, &off).abs() < 1e-12);
    }

    #[test]
    fn the_search_goes_on_until_the_mean_is_back() {
        let mut recovery = Recovery { slow: 0.9, fast: 0.9 };
        let shares: Vec<f64> = (0..20).map(|_| recovery.update(0.01, &AUGMENTED)).collect();
        assert!(shares[3..].iter().all(|share| *share > 0.6), "{shares:?}");
        let back: Vec<f64> = (0..5).map(|_| recovery.update(0.9, &AUGMENTED)).collect();
        assert!(back[1..].iter().all(|share| *share == 0.0), "{back:?}");
        let again: Vec<f64> = (0..3).map(|_| recovery.update(0.01, &AUGMENTED)).collect();
        assert!(again[2] > 0.2, "and can begin again soon: {again:?}");
    }

    #[test]
    fn limits() {
        let config = InjectionConfig { min_share: 0.05, max_share: 0.3, ..AUGMENTED };
        let mut recovery = Recovery { slow: 0.9, fast: 0.9 };
        assert!((recovery.update(0.9, &config) - 0.05).abs() < 1e-12);
        assert!((recovery.update(0.0, &config) - 0.3).abs() < 1e-12);
        assert!(InjectionConfig { min_share: 0.5, max_share: 0.3, ..AUGMENTED }.check().is_err());
    }
}
