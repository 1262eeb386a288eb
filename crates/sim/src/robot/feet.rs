//! Pressure sensors under the feet.

use visloc_core::{RngTree, gaussian};

use super::plan::Activity;
use crate::scenario::FootSetup;

/// Four sensors under each foot.
#[derive(Debug)]
pub(crate) struct Feet {
    setup: FootSetup,
    random: RngTree,
}

/// Shares of a foot's load: front left, front right, back left, back right. The heel carries more.
const SHARES: [f64; 4] = [0.22, 0.22, 0.28, 0.28];

impl Feet {
    pub(crate) fn new(setup: &FootSetup, random: &RngTree) -> Self {
        Self { setup: setup.clone(), random: *random }
    }

    /// Forces in newtons, left foot first, for frame `index`. `stride_rad` is the phase of the walk, `swing` its
    /// strength, 0 to 1.
    pub(crate) fn pressure(
        &self,
        activity: Activity,
        (stride_rad, swing): (f64, f64),
        index: u64,
    ) -> [f64; 8] {
        let rng = &mut self.random.stream("feet", index);
        let swing = if activity == Activity::LiftedUnnoticed { 1.0 } else { swing };
        let left = 0.5 + 0.5 * (1.6 * swing * stride_rad.sin()).clamp(-1.0, 1.0);
        let weight_n = if activity == Activity::Lifted { 0.0 } else { self.setup.weight_n };
        let loads_n = [weight_n * left, weight_n * (1.0 - left)];
        std::array::from_fn(|sensor| {
            let load_n = loads_n[sensor / 4] * SHARES[sensor % 4];
            let is_loaded = load_n > 0.05;
            // An unloaded sensor does not jitter as much, and none pulls.
            let noise_n = self.setup.noise_n * if is_loaded { 1.0 } else { 0.2 };
            (load_n + gaussian(rng, noise_n)).max(0.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_carry_the_weight_on_the_ground_and_vanish_in_the_air() {
        let feet = Feet::new(&FootSetup::default(), &RngTree::new(1));
        let sum = |activity, swing, index: u32| {
            let stride = f64::from(index) * 0.2;
            feet.pressure(activity, (stride, swing), u64::from(index)).iter().sum::<f64>()
        };
        for index in 0..100 {
            assert!((sum(Activity::Standing, 0.0, index) - 45.0).abs() < 4.0);
            assert!((sum(Activity::Walking, 1.0, index) - 45.0).abs() < 4.0);
            assert!((sum(Activity::LiftedUnnoticed, 0.0, index) - 45.0).abs() < 4.0);
            assert!(sum(Activity::Lifted, 0.0, index) < 1.0);
        }
    }

    #[test]
    fn walking_shifts_the_load_from_foot_to_foot() {
        let feet = Feet::new(&FootSetup::default(), &RngTree::new(1));
        let left = |stride: f64| feet.pressure(Activity::Walking, (stride, 1.0), 0)[..4].iter().sum::<f64>();
        assert!(left(1.5) > 40.0 && left(4.7) < 5.0);
        assert!(feet.pressure(Activity::Standing, (1.5, 0.0), 0)[..4].iter().sum::<f64>() < 26.0);
    }
}
