//! Which motion explains two views, and whether it is sure enough to start a map on.

use std::{f64::consts::PI, fmt};

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use rand::RngExt;
use visloc_core::{
    Rng,
    geom::{Rigid3, nearest_rotation},
};

use super::{
    KnownMotion, RayPair, TwoViewMotion, decompose_essential, decompose_homography, fit_essential,
    fit_homography,
    motion::{essential_of, refine_motion, triangulate_pairs},
};
use crate::solve::cos_parallax;

/// What two views must show.
#[derive(Debug, Clone, Copy)]
pub struct TwoViewSettings {
    /// Largest epipolar error of an inlier, standard deviations.
    pub inlier_sigmas: f64,
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
    /// Images that they were followed through.
    pub num_images: usize,
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
            Self::TracksLost(LostTracks { num, of, .. }) => {
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
/// one matters. Where few corners tell a turn from a shift, all samples may miss the true motion, and a wrong one has no rival: so
/// the error is descended from directions all over the sphere, too. All motions that explain the views about as well as the best one
/// come back, the best first. `hints` are motions tried beside, for instance those of the frame before. A motion that is known has no
/// rivals: it is refined, and refused if the views contradict it.
///
/// # Errors
/// Why the two views are not enough.
pub fn solve_two_view(
    pairs: &[RayPair],
    (hints, known): (&[TwoViewMotion], Option<&KnownMotion>),
    settings: &TwoViewSettings,
    rng: &mut Rng,
) -> Result<Vec<TwoView>, StartWait> {
    if pairs.len() < settings.min_points {
        return Err(StartWait::TracksLost(LostTracks { num: pairs.len(), of: pairs.len(), num_images: 0 }));
    }
    let limit = settings.inlier_sigmas;
    let motions = match known {
        Some(known) => {
            let refined = refine_motion(&known.motion, (pairs, Some(known)), limit / SURE, MOST_STEPS);
            if known.may_be(&refined, SURE) { vec![refined] } else { Vec::new() }
        }
        None => search(pairs, hints, settings, rng),
    };
    let mut candidates: Vec<Candidate> = motions.iter().map(|motion| judge(motion, pairs, limit)).collect();
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

/// Refined motions from samples, hints and all over the sphere.
fn search(
    pairs: &[RayPair],
    hints: &[TwoViewMotion],
    settings: &TwoViewSettings,
    rng: &mut Rng,
) -> Vec<TwoViewMotion> {
    let mut motions = hints.to_vec();
    let essential = best_of_samples(pairs, 8, settings, rng, &ESSENTIAL);
    motions.extend(essential.iter().flat_map(decompose_essential));
    let homography = best_of_samples(pairs, 4, settings, rng, &HOMOGRAPHY);
    motions.extend(homography.iter().flat_map(decompose_homography));
    // An error that is no inlier is beyond what is sure.
    let least_sigma = settings.inlier_sigmas / SURE;
    let refined = |motion: &TwoViewMotion| refine_motion(motion, (pairs, None), least_sigma, MOST_STEPS);
    let mut motions: Vec<TwoViewMotion> = motions.iter().map(refined).collect();
    // The opposite direction has the same error: only where the points lie tells them apart.
    let spread = spread_motions(pairs, settings.inlier_sigmas);
    motions.extend(spread.iter().map(refined).flat_map(|m| [m, reversed(&m)]));
    motions
}

/// Standard deviations beyond which a motion is not the one that is known.
pub const SURE: f64 = 4.0;

/// Most steps of the refinement. From a start that is far off the last ones are short: what is left of the error is noise.
const MOST_STEPS: usize = 10;

/// Directions all over one half of the sphere, the other half being their opposites: 20 degrees from one to the next.
const NUM_DIRECTIONS: usize = 50;
/// Steps for the best turn with a given direction.
const TURN_STEPS: usize = 4;

/// Motions in directions all over the sphere, each with its best turn, that explain the pairs better than the directions around them.
fn spread_motions(pairs: &[RayPair], limit: f64) -> Vec<TwoViewMotion> {
    let products = pairs.iter().map(|pair| pair.second.normalize() * pair.first.normalize().transpose());
    let still = nearest_rotation(&products.sum::<Matrix3<f64>>());
    let turned = |i: usize| {
        // Points of equal area: Swinbank and Purser, "Fibonacci grids", 2006.
        let z = (i as f64 + 0.5) / NUM_DIRECTIONS as f64;
        let (sin, cos) = (i as f64 * (3.0 - 5.0_f64.sqrt()) * PI).sin_cos();
        let flat = (1.0 - z * z).sqrt();
        let motion = Rigid3::new(still, Vector3::new(flat * cos, flat * sin, z));
        let fixed = KnownMotion { motion, deviations: (FIXED, f64::INFINITY) };
        let motion = refine_motion(&motion, (pairs, Some(&fixed)), limit / SURE, TURN_STEPS);
        let essential = essential_of(&motion);
        let cost = pairs.iter().map(|pair| pair.epipolar_error(&essential).powi(2).min(limit * limit));
        (motion, cost.sum::<f64>())
    };
    let all: Vec<(TwoViewMotion, f64)> = (0..NUM_DIRECTIONS).map(turned).collect();
    let reach = 1.5 * (2.0 * PI / NUM_DIRECTIONS as f64).sqrt();
    let is_least = |(motion, cost): &&(TwoViewMotion, f64)| {
        let is_near =
            |other: &TwoViewMotion| motion.translation().dot(other.translation()).abs() > reach.cos();
        all.iter().all(|(other, other_cost)| cost <= other_cost || !is_near(other))
    };
    all.iter().filter(is_least).map(|(motion, _)| *motion).collect()
}

/// Deviation of a direction that is given, radians.
const FIXED: f64 = 1e-6;

/// The same turn in the opposite direction.
fn reversed(motion: &TwoViewMotion) -> TwoViewMotion {
    Rigid3::new(Rotation3::from_matrix_unchecked(*motion.rotation()), -motion.translation())
}

/// The model with the least truncated cost, fitted again to its inliers.
fn best_of_samples(
    pairs: &[RayPair],
    size: usize,
    settings: &TwoViewSettings,
    rng: &mut Rng,
    model: &Model,
) -> Option<Matrix3<f64>> {
    let limit2 = settings.inlier_sigmas.powi(2);
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

/// How a 3 x 3 matrix is fitted to pairs, and how far a pair is from it (squared, in standard deviations).
struct Model {
    fit: fn(&[RayPair]) -> Option<Matrix3<f64>>,
    error2: fn(&Matrix3<f64>, &RayPair) -> f64,
}

const ESSENTIAL: Model =
    Model { fit: fit_essential, error2: |matrix, pair| pair.epipolar_error(matrix).powi(2) };
const HOMOGRAPHY: Model = Model { fit: fit_homography, error2: transfer_error };

fn transfer_error(homography: &Matrix3<f64>, pair: &RayPair) -> f64 {
    let forward = homography * pair.first;
    if forward.z.abs() < 1e-9 {
        return f64::INFINITY;
    }
    let error = (forward / forward.z - pair.second).xy();
    // Both images of a corner look alike, so its covariance in the first one is taken as it is. Half: two dimensions.
    let inverse = (pair.first_covariance + pair.second_covariance).try_inverse();
    inverse.map_or(f64::INFINITY, |inverse| error.dot(&(inverse * error)) * 0.5)
}

fn judge(motion: &TwoViewMotion, pairs: &[RayPair], limit: f64) -> Candidate {
    let essential = essential_of(motion);
    let mut points = triangulate_pairs(motion, pairs);
    let mut cost = 0.0;
    for (point, pair) in points.iter_mut().zip(pairs) {
        let error2 = pair.epipolar_error(&essential).powi(2);
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

#[cfg(test)]
mod tests {
    use nalgebra::Matrix2;
    use visloc_core::RngTree;

    use super::{super::shape_deviation, *};

    const SIGMA: f64 = 1e-3;

    /// Points at depths from 2 to 6 as two views see them, free of noise; a unit is so many lengths of the translation.
    fn pairs(motion: &TwoViewMotion, units: f64) -> Vec<RayPair> {
        let mut rng = RngTree::new(3).stream("points", 0);
        let mut any = || rng.random_range(-1.0..1.0);
        let pair = |_| {
            let depth = 4.0 + 2.0 * any();
            let point = Point3::new(0.6 * any() * depth, 0.45 * any() * depth, depth);
            let moved = motion.rotate(&point.coords) * units + motion.translation();
            let covariance = Matrix2::identity() * (SIGMA * SIGMA);
            RayPair {
                first: point.coords / point.z,
                second: moved / moved.z,
                first_covariance: covariance,
                second_covariance: covariance,
            }
        };
        (0..80).map(pair).collect()
    }

    fn motion(direction: [f64; 3]) -> TwoViewMotion {
        let turn = Rotation3::from_scaled_axis(Vector3::new(0.02, -0.05, 0.03));
        Rigid3::new(turn, Vector3::from(direction).normalize())
    }

    #[test]
    fn the_motion_is_found_where_a_sample_misses_it() {
        let settings = TwoViewSettings {
            inlier_sigmas: 3.0,
            min_points: 40,
            min_inlier_ratio: 0.6,
            min_parallax_rad: 0.005,
            num_samples: 1,
        };
        for direction in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.2], [0.7, -0.2, -0.7], [-0.5, 0.4, 0.7]] {
            let truth = motion(direction);
            // A third of the corners have slid along what they are a corner of, so that the only sample of eight holds some of them.
            let mut pairs = pairs(&truth, 5.0);
            let mut rng = RngTree::new(2).stream("slides", 0);
            for pair in pairs.iter_mut().step_by(3) {
                let slide = Vector3::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0), 0.0);
                pair.second += slide.normalize() * (20.0 * SIGMA);
            }
            let mut rng = RngTree::new(1).stream("samples", 0);
            let found = solve_two_view(&pairs, (&[], None), &settings, &mut rng).unwrap();
            assert!(
                found.iter().any(|two_view| !is_different(&two_view.motion, &truth)),
                "{direction:?} is not among {} motions",
                found.len()
            );
        }
    }

    #[test]
    fn a_motion_that_is_known_has_no_rivals() {
        let settings = TwoViewSettings {
            inlier_sigmas: 3.0,
            min_points: 20,
            min_inlier_ratio: 0.6,
            min_parallax_rad: 0.005,
            num_samples: 1,
        };
        let truth = motion([1.0, 0.0, 0.0]);
        let pairs = &pairs(&truth, 5.0)[..20];
        let mut rng = RngTree::new(1).stream("samples", 0);
        let mut solve = |motion| {
            let known = KnownMotion { motion, deviations: (0.05, 0.01) };
            solve_two_view(pairs, (&[], Some(&known)), &settings, &mut rng)
        };
        let off = Rigid3::new(Rotation3::from_scaled_axis(Vector3::new(0.02, -0.06, 0.03)), Vector3::x());
        let found = solve(off).unwrap();
        assert!(found.len() == 1, "{} motions", found.len());
        let turn = (found[0].motion * truth.inverse()).rotation_angle_rad();
        assert!(turn < 0.002 && found[0].motion.translation().dot(truth.translation()) > 0.9999, "{turn}");
        // The views contradict what is said to be known.
        assert!(solve(motion([0.0, 0.0, 1.0])).is_err());
    }

    #[test]
    fn an_error_is_measured_in_the_deviations_of_its_corner() {
        let truth = motion([1.0, 0.0, 0.0]);
        let essential = essential_of(&truth);
        let mut pair = pairs(&truth, 5.0)[0];
        assert!(pair.epipolar_error(&essential).abs() < 1e-6);
        let across = (essential * pair.first).xy().normalize();
        let shift = across * (2.0 * SIGMA);
        pair.second += Vector3::new(shift.x, shift.y, 0.0);
        pair.first_covariance = Matrix2::zeros();
        assert!((pair.epipolar_error(&essential).abs() - 2.0).abs() < 0.05);
        // Along an edge that lies across, a corner is known badly, and the same error tells little.
        pair.second_covariance += across * across.transpose() * (99.0 * SIGMA * SIGMA);
        assert!((pair.epipolar_error(&essential).abs() - 0.2).abs() < 0.005);
    }

    #[test]
    fn more_parallax_bends_a_start_less() {
        let truth = motion([0.7, -0.2, -0.7]);
        let deviation = |units| {
            let mut rng = RngTree::new(5).stream("noise", 0);
            let mut pairs = pairs(&truth, units);
            for pair in &mut pairs {
                pair.second.x += SIGMA * rng.random_range(-1.7..1.7);
                pair.second.y += SIGMA * rng.random_range(-1.7..1.7);
            }
            let refined = refine_motion(&truth, (&pairs, None), 9.0, 10);
            shape_deviation(&refined, &pairs)
        };
        let (far, near) = (deviation(40.0), deviation(4.0));
        assert!(near < 0.03 && far > 5.0 * near, "{far} with a tenth of the parallax, {near} with all of it");
    }
}
