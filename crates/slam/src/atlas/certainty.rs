//! How sure the edges of a pose graph are, where several kinds of them have to be weighed.

use nalgebra::{SMatrix, SVector};

use super::{PoseGraphEdge, Similarity};
use crate::map::Crossing;

/// Standard deviation of the turn between keyframes that share landmarks, radians, and of the shift, share of the depth of the scene. This and
/// what follows is from three runs of a rendered walk through corridors and rooms against the truth: along the
/// corridors a second's drift was 0.05 degrees and 0.2 % of the scale over four keyframes, in quick turns 0.45 degrees and up to 5 % over
/// fifteen. About 60 edges lead over each place, so one is eight times less sure than all.
const TURN_SIGMA: f64 = 0.0035;
/// The same of the logarithm of the scale.
const SCALE_SIGMA: f64 = 0.008;
/// Turn between two keyframes from which on the standard deviation of the turn grows with it, radians: what comes into view has been seen from few places.
const TURN_GROWS: f64 = 0.026;
/// Turn from which on that of the scale grows.
const SCALE_GROWS: f64 = 0.0087;
/// Standard deviation of the scale of a keyframe that is found at an earlier place: eight ratios of depths or more, each good to some percent.
const FOUND_SCALE_SIGMA: f64 = 0.01;

type Matrix7 = SMatrix<f64, 7, 7>;

/// Whitening of what landmarks say of two keyframes that share them.
pub(super) fn of_shared(first_from_second: &Similarity) -> Matrix7 {
    let turn = crate::lie::rotation_vector(&first_from_second.rotation).norm();
    let grown = |sigma: f64, grows: f64| sigma * 1.0_f64.hypot(turn / grows);
    diagonal(grown(TURN_SIGMA, TURN_GROWS), grown(SCALE_SIGMA, SCALE_GROWS))
}

/// Whitening of where a keyframe was found at an earlier place.
pub(super) fn of_sighting() -> Matrix7 {
    diagonal(TURN_SIGMA, FOUND_SCALE_SIGMA)
}

fn diagonal(pose: f64, scale: f64) -> Matrix7 {
    Matrix7::from_diagonal(&SVector::from_fn(|i, _| 1.0 / if i < 6 { pose } else { scale }))
}

/// The edge of a frame that two parts of the map know, in a graph of this length. It says nothing of the scale.
pub(super) fn edge_across(
    crossing: &Crossing,
    (first, second): (usize, usize),
    length: f64,
) -> Option<PoseGraphEdge> {
    let whitening = crossing.covariance().try_inverse()?.cholesky()?.l().transpose();
    let mut weight = Matrix7::zeros();
    // An error begins with the turn, a covariance with the translation.
    weight.fixed_view_mut::<6, 3>(0, 0).copy_from(&whitening.fixed_columns::<3>(3));
    weight.fixed_view_mut::<6, 3>(0, 3).copy_from(&(whitening.fixed_columns::<3>(0) * length));
    Some(PoseGraphEdge {
        first,
        second,
        first_from_second: Similarity::of_pose(&crossing.after.camera_from_keyframe),
        at_first: Similarity::of_pose(&crossing.before.camera_from_keyframe),
        weight,
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3, Vector6};
    use visloc_core::geom::Rigid3;

    use super::{super::PoseGraph, *};
    use crate::{
        lie::{CameraFromWorld, exp},
        map::{KeyframeId, Standing},
    };

    const LENGTH: f64 = 3.0;

    fn pose<Dst, Src>(turn: [f64; 3], shift: [f64; 3]) -> Rigid3<Dst, Src> {
        Rigid3::new(Rotation3::from_scaled_axis(Vector3::from(turn)), Vector3::from(shift))
    }

    /// What a frame that two keyframes know costs if the second one has it elsewhere: this much farther in its own axes and turned, and larger
    /// by the logarithm of the scale.
    fn cost(variances: Vector6<f64>, off: &Vector6<f64>, log_scale: f64) -> f64 {
        let camera_from_world: CameraFromWorld = pose([0.3, -0.2, 0.5], [1.0, 2.0, -0.5]);
        let standing = |id: u32, camera_from_keyframe| Standing {
            keyframe: KeyframeId(id),
            camera_from_keyframe,
            scale: 1.0,
            covariance: SMatrix::from_diagonal(&(0.5 * variances)),
        };
        let before = standing(0, pose([0.1, 0.4, 0.0], [0.2, 0.0, 0.7]));
        let after = standing(1, pose([-0.2, 0.1, 0.3], [-0.4, 0.3, 0.1]));
        let mut scaled = SVector::zeros();
        scaled[6] = log_scale;
        let seen = Similarity::from_coordinates(&scaled, LENGTH)
            .after(&Similarity::of_pose(&(exp(off) * camera_from_world)));
        let nodes = vec![
            Similarity::of_pose(&(before.camera_from_keyframe.inverse() * camera_from_world)),
            Similarity::of_pose(&after.camera_from_keyframe).inverse().after(&seen),
        ];
        let edge = edge_across(&Crossing { before, after }, (0, 1), LENGTH).unwrap();
        PoseGraph { nodes, num_fixed: 1, edges: vec![edge], length: LENGTH }.cost()
    }

    #[test]
    fn a_frame_that_two_maps_know_costs_its_distance_in_standard_deviations() {
        let sigmas = Vector6::new(0.1, 0.2, 0.3, 0.01, 0.02, 0.03);
        let variances = sigmas.component_mul(&sigmas);
        assert!(cost(variances, &Vector6::zeros(), 0.0) < 1e-18);
        assert!(cost(variances, &Vector6::zeros(), 0.4) < 1e-18, "it does not know the scale");
        for i in 0..6 {
            let mut off = Vector6::zeros();
            off[i] = 0.1 * sigmas[i];
            let cost = cost(variances, &off, 0.0);
            assert!((cost - 0.01).abs() < 1e-5, "{i}: {cost}");
        }
    }
}
