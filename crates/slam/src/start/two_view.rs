//! Which motion explains two views, and whether it is sure enough to start a map on.

use std::fmt;

use nalgebra::{Matrix3, Point3, Vector3};
use rand::RngExt;
use visloc_core::Rng;

use super::{
    TwoViewMotion, decompose_essential, decompose_homography, fit_essential, fit_homography,
    motion::{essential_of, refine_motion, sampson, triangulate_pairs},
};
use crate::solve::cos_parallax;

/// A pair of rays (z = 1), in the first and in the second view.
type Pair = (Vector3<f64>, Vector3<f64>);

/// What two views must show.
#[derive(Debug, Clone, Copy)]
pub struct TwoViewSettings {
    /// Length of a pixel on the plane z = 1.
    pub pixel: f64,
    /// Largest Sampson distance of an inlier, pixels.
    pub inlier_px: f64,
    /// Fewest points.
    pub min_points: usize,
    /// Least share of pairs that must agree.
    pub min_inlier_ratio: f64,
    /// Least angle between the rays to a point, radians; a quarter of the points must have it.
    pub min_parallax_rad: f64,
    /// Random samples for each model.
    pub num_samples: usize,
}

/// Why a map is not started yet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StartWait {
    /// The image has too few corners: how many.
    FewCorners(usize),
    /// The corners have moved too little: the median shift, pixels.
    LittleMotion(f64),
    /// The rays hardly change direction, as under pure rotation: the angle that a quarter of the corners exceed, radians.
    LittleParallax(f64),
    /// Too few pairs agree on one motion: the share.
    NoCommonMotion(f64),
    /// Two motions explain the views equally well.
    Ambiguous,
    /// Too many corners were lost on the way; it starts again from the newest image.
    TracksLost(LostTracks),
}

/// What was left when a start was given up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LostTracks {
    /// Corners that could still be followed.
    pub num: usize,
    /// Corners at the beginning.
    pub of: usize,
}

impl fmt::Display for StartWait {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FewCorners(num) => write!(f, "only {num} corners in the image"),
            Self::LittleMotion(px) => write!(f, "the image has moved by {px:.1} px only"),
            Self::LittleParallax(rad) => write!(
                f,
                "the camera turns but hardly moves: {:.2} deg of parallax; move it sideways",
                rad.to_degrees()
            ),
            Self::NoCommonMotion(share) => {
                write!(f, "only {:.0} % of the corners move together", share * 100.0)
            }
            Self::Ambiguous => write!(f, "two motions explain the images equally well"),
            Self::TracksLost(LostTracks { num, of }) => {
                write!(f, "only {num} of {of} corners could be followed")
            }
        }
    }
}

/// The motion of two views and the points that they see.
#[derive(Debug, Clone)]
pub struct TwoView {
    /// Motion with a translation of length 1.
    pub motion: TwoViewMotion,
    /// Points in the first camera, one entry for each pair; `None` for outliers.
    pub points: Vec<Option<Point3<f64>>>,
    /// Angle between the rays of a pair that a quarter of the pairs exceed, radians.
    pub parallax_rad: f64,
}

struct Candidate {
    motion: TwoViewMotion,
    points: Vec<Option<Point3<f64>>>,
    num_points: usize,
    cost: f64,
}

/// Finds the motion. Samples of eight pairs give essential matrices, samples of four give homographies; the motions of the
/// best of both are refined on all pairs and compared by the same cost, so that neither a dominant plane nor the lack of
/// one matters. All motions that explain the views about as well as the best one come back, the best first.
/// `hints` are motions tried beside, for instance those of the frame before.
///
/// # Errors
/// Why the two views are not enough.
pub fn solve_two_view(
    pairs: &[Pair],
    hints: &[TwoViewMotion],
    settings: &TwoViewSettings,
    rng: &mut Rng,
) -> Result<Vec<TwoView>, StartWait> {
    if pairs.len() < settings.min_points {
        return Err(StartWait::TracksLost(LostTracks { num: pairs.len(), of: pairs.len() }));
    }
    let limit = settings.inlier_px * settings.pixel;
    let mut motions = hints.to_vec();
    let essential = best_of_samples(pairs, 8, settings, rng, &ESSENTIAL);
    motions.extend(essential.iter().flat_map(decompose_essential));
    let homography = best_of_samples(pairs, 4, settings, rng, &HOMOGRAPHY);
    motions.extend(homography.iter().flat_map(decompose_homography));
    let mut candidates: Vec<Candidate> = motions
        .iter()
        .map(|motion| judge(&refine_motion(motion, pairs, 3.0 * limit, 10), pairs, limit))
        .collect();
    candidates.sort_by(|a, b| b.num_points.cmp(&a.num_points).then(a.cost.total_cmp(&b.cost)));
    let Some(best) = candidates.first() else { return Err(StartWait::NoCommonMotion(0.0)) };
    let share = best.num_points as f64 / pairs.len() as f64;
    let parallax_rad = upper_quartile_parallax(best);
    if parallax_rad < settings.min_parallax_rad {
        return Err(StartWait::LittleParallax(parallax_rad));
    }
    if share < settings.min_inlier_ratio || best.num_points < settings.min_points {
        return Err(StartWait::NoCommonMotion(share));
    }
    let mut kept: Vec<&Candidate> = Vec::new();
    for candidate in &candidates {
        // One of little parallax is a rival too: it may be the true one of a camera that turns.
        let is_rival = candidate.num_points as f64 > 0.7 * best.num_points as f64;
        if is_rival && kept.iter().all(|other| is_different(&candidate.motion, &other.motion)) {
            kept.push(candidate);
        }
    }
    let two_view = |candidate: &&Candidate| TwoView {
        motion: candidate.motion,
        points: candidate.points.clone(),
        parallax_rad: upper_quartile_parallax(candidate),
    };
    Ok(kept.iter().map(two_view).collect())
}

/// The model with the least truncated cost, fitted again to its inliers.
fn best_of_samples(
    pairs: &[Pair],
    size: usize,
    settings: &TwoViewSettings,
    rng: &mut Rng,
    model: &Model,
) -> Option<Matrix3<f64>> {
    let limit2 = (settings.inlier_px * settings.pixel).powi(2);
    let cost = |matrix: &Matrix3<f64>| {
        pairs.iter().map(|pair| (model.error2)(matrix, pair).min(limit2)).sum::<f64>()
    };
    let mut best: Option<(f64, Matrix3<f64>)> = None;
    let mut sample = Vec::with_capacity(pairs.len());
    for _ in 0..settings.num_samples {
        sample.clear();
        sample.extend((0..size).map(|_| pairs[rng.random_range(0..pairs.len())]));
        let Some(matrix) = (model.fit)(&sample) else { continue };
        let cost = cost(&matrix);
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, matrix));
        }
    }
    let (least, matrix) = best?;
    sample.clear();
    sample.extend(pairs.iter().filter(|pair| (model.error2)(&matrix, pair) < limit2));
    let refitted = (model.fit)(&sample).filter(|refitted| sample.len() > size && cost(refitted) < least);
    Some(refitted.unwrap_or(matrix))
}

/// How a 3 x 3 matrix is fitted to pairs, and how far a pair is from it (squared, on the plane z = 1).
struct Model {
    fit: fn(&[Pair]) -> Option<Matrix3<f64>>,
    error2: fn(&Matrix3<f64>, &Pair) -> f64,
}

const ESSENTIAL: Model =
    Model { fit: fit_essential, error2: |matrix, pair| sampson(matrix, &pair.0, &pair.1).powi(2) };
const HOMOGRAPHY: Model = Model { fit: fit_homography, error2: transfer_error };

fn transfer_error(homography: &Matrix3<f64>, pair: &Pair) -> f64 {
    let forward = homography * pair.0;
    if forward.z.abs() < 1e-9 {
        return f64::INFINITY;
    }
    (forward / forward.z - pair.1).norm_squared() * 0.5
}

fn judge(motion: &TwoViewMotion, pairs: &[Pair], limit: f64) -> Candidate {
    let essential = essential_of(motion);
    let mut points = triangulate_pairs(motion, pairs);
    let mut cost = 0.0;
    for (point, (first, second)) in points.iter_mut().zip(pairs) {
        let error2 = sampson(&essential, first, second).powi(2);
        if point.is_none() || error2 > limit * limit {
            *point = None;
            cost += limit * limit;
        } else {
            cost += error2;
        }
    }
    let num_points = points.iter().flatten().count();
    Candidate { motion: *motion, points, num_points, cost }
}

/// The angle that a quarter of the points exceed. A camera that goes straight ahead sees most points with hardly any parallax, and
/// the near ones beside its way with enough.
fn upper_quartile_parallax(candidate: &Candidate) -> f64 {
    let second_center = Point3::from(*candidate.motion.inverse().translation());
    let angle =
        |point: &Point3<f64>| cos_parallax(point, &Point3::origin(), &second_center).clamp(-1.0, 1.0).acos();
    let mut angles: Vec<f64> = candidate.points.iter().flatten().map(angle).collect();
    angles.sort_by(f64::total_cmp);
    angles.get(angles.len() * 3 / 4).copied().unwrap_or(0.0)
}

/// More than 10 degrees apart in direction or 2 degrees in rotation.
fn is_different(a: &TwoViewMotion, b: &TwoViewMotion) -> bool {
    let turn = (*a * b.inverse()).rotation_angle_rad();
    a.translation().dot(b.translation()) < 10.0_f64.to_radians().cos() || turn > 2.0_f64.to_radians()
}
