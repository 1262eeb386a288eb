//! The particles: motion and weights.

use rand::{Rng as _, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
#[cfg(feature = "parallel")]
use rayon::prelude::*;
use visloc_core::{Rng, geom::PlanarPose};

use super::weights::{Weights, to_f64};
use crate::{ObservationModel, PlanarMotion};

/// Particles weighed by one thread at a time: long enough, at half a microsecond each, to be worth a thread's while.
#[cfg(feature = "parallel")]
const CHUNK: usize = 256;

/// Standard deviations of noise on a pose.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PoseNoise {
    /// Of x and y, meters.
    pub position_m: f64,
    /// Of the heading, radians.
    pub heading_rad: f64,
}

/// Poses with weights. The elite comes first, random newcomers last.
#[derive(Debug, Clone, Default)]
pub struct Particles {
    poses: Vec<PlanarPose>,
    /// Likelihoods of the last image.
    likelihoods: Vec<f64>,
    weights: Weights,
    num_elite: usize,
    num_newcomers: usize,
    next: Vec<PlanarPose>,
    next_numbers: Vec<f64>,
}

impl Particles {
    /// Removes all particles.
    pub fn clear(&mut self) {
        self.start([]);
    }

    /// New particles with equal weights.
    pub fn start(&mut self, poses: impl IntoIterator<Item = PlanarPose>) {
        self.poses.clear();
        self.poses.extend(poses);
        self.likelihoods.clear();
        self.likelihoods.resize(self.poses.len(), 0.0);
        self.weights.reset(self.poses.len());
        (self.num_elite, self.num_newcomers) = (0, 0);
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// Their poses, `world_from_robot`.
    pub fn poses(&self) -> &[PlanarPose] {
        &self.poses
    }

    /// Likelihoods of the last image, 0 to 1; of a copy, its parent's; of a newcomer, 0.
    pub fn likelihoods(&self) -> &[f64] {
        &self.likelihoods
    }

    /// Weights over the largest weight, 0 to 1.
    pub fn weights(&self) -> &[f64] {
        self.weights.relative()
    }

    /// How many equally weighted particles would say as much, over their number.
    pub fn effective_share(&self) -> f64 {
        self.weights.effective_sample_size() / to_f64(self.poses.len())
    }

    /// Mean likelihood of the last image, with or without the newcomers.
    pub fn mean_likelihood(&self, has_newcomers: bool) -> f64 {
        let left_out = if has_newcomers { 0 } else { self.num_newcomers };
        let counted = match self.likelihoods.len().saturating_sub(left_out) {
            0 => &self.likelihoods[..],
            count => &self.likelihoods[..count],
        };
        counted.iter().sum::<f64>() / to_f64(counted.len().max(1))
    }

    /// Moves all particles with the robot. The elite moves without noise; for the others the noise of the motion and
    /// `noise` are one draw.
    pub fn propagate(&mut self, motion: Option<&PlanarMotion>, noise: &PoseNoise, rng: &mut Rng) {
        let step = motion.map_or(PlanarPose::default(), |motion| motion.old_from_new);
        let (motion_m, motion_rad) = motion.map_or((0.0, 0.0), |m| (m.position_noise_m, m.heading_noise_rad));
        let position_m = motion_m.hypot(noise.position_m);
        let heading_rad = motion_rad.hypot(noise.heading_rad);
        let has_step = step != PlanarPose::default();
        let num_elite = self.num_elite.min(self.poses.len());
        let (elite, others) = self.poses.split_at_mut(num_elite);
        if has_step {
            elite.iter_mut().for_each(|pose| *pose = pose.compose(&step));
        }
        if position_m == 0.0 && heading_rad == 0.0 {
            if has_step {
                others.iter_mut().for_each(|pose| *pose = pose.compose(&step));
            }
            return;
        }
        // Several times cheaper than the localizer's own, and its stream is the same on every platform.
        let mut draws = Xoshiro256PlusPlus::seed_from_u64(rng.next_u64());
        let mut unit = || -> f64 { StandardNormal.sample(&mut draws) };
        for pose in others {
            let moved = if has_step { pose.compose(&step) } else { *pose };
            let x_m = moved.x_m + position_m * unit();
            let y_m = moved.y_m + position_m * unit();
            *pose = if heading_rad > 0.0 {
                PlanarPose::new(x_m, y_m, moved.yaw_rad + heading_rad * unit())
            } else {
                PlanarPose { x_m, y_m, yaw_rad: moved.yaw_rad }
            };
        }
    }

    /// Weighs all particles against the image that the model was conditioned on: the weight is multiplied by the
    /// likelihood to the power of `exponent`. On all processors from `parallel_from` particles on; since every particle is
    /// weighed on its own and sums are made in order, the result is the same bit by bit.
    pub fn weigh(&mut self, model: &dyn ObservationModel, exponent: f64, parallel_from: usize) {
        if self.poses.len() >= parallel_from {
            log_likelihoods_of_many(model, &self.poses, &mut self.likelihoods);
        } else {
            model.log_likelihoods(&self.poses, &mut self.likelihoods);
        }
        self.weights.multiply(&mut self.likelihoods, exponent);
    }

    /// Puts the indices of the best `count` particles first, the best of all at the front.
    pub fn rank(&self, count: usize, order: &mut Vec<usize>) {
        let logs = self.weights.logs();
        let better = |a: &usize, b: &usize| logs[*b].total_cmp(&logs[*a]).then(a.cmp(b));
        let count = count.min(self.poses.len());
        order.clear();
        if logs.is_empty() || count == 0 {
            order.extend(0..count);
            return;
        }
        order.extend(0..self.poses.len());
        if count < order.len() {
            order.select_nth_unstable_by(count - 1, better);
        }
        order[..count].sort_unstable_by(better);
        order.truncate(count);
    }

    /// Replaces the particles by copies of some of them, of which the first `num_elite` are the elite, and by newcomers.
    /// `logs` are the logarithms of the copies' weights; equal weights if it is empty.
    pub fn replace(
        &mut self,
        sources: &[usize],
        logs: &[f64],
        num_elite: usize,
        newcomers: impl IntoIterator<Item = PlanarPose>,
    ) {
        self.next.clear();
        self.next_numbers.clear();
        self.next.extend(sources.iter().map(|i| self.poses[*i]));
        self.next.extend(newcomers);
        std::mem::swap(&mut self.poses, &mut self.next);
        self.next_numbers.extend(sources.iter().map(|i| self.likelihoods[*i]));
        self.next_numbers.resize(self.poses.len(), 0.0);
        std::mem::swap(&mut self.likelihoods, &mut self.next_numbers);
        self.num_elite = num_elite;
        self.num_newcomers = self.poses.len() - sources.len();
        if logs.is_empty() {
            self.weights.reset(self.poses.len());
        } else {
            self.next_numbers.clear();
            self.next_numbers.extend_from_slice(logs);
            self.next_numbers.resize(self.poses.len(), 0.0);
            self.weights.set_logs(&self.next_numbers);
        }
    }

    /// Logarithms of the weights over the largest one; empty if all are equal.
    pub(super) fn log_weights(&self) -> &[f64] {
        self.weights.logs()
    }
}

#[cfg(feature = "parallel")]
fn log_likelihoods_of_many(model: &dyn ObservationModel, poses: &[PlanarPose], out: &mut [f64]) {
    poses
        .par_chunks(CHUNK)
        .zip(out.par_chunks_mut(CHUNK))
        .for_each(|(poses, out)| model.log_likelihoods(poses, out));
}

#[cfg(not(feature = "parallel"))]
fn log_likelihoods_of_many(model: &dyn ObservationModel, poses: &[PlanarPose], out: &mut [f64]) {
    model.log_likelihoods(poses, out);
}
