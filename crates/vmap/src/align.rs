//! Giving a map a frame and a unit of length that mean something.

use nalgebra::{Matrix3, Rotation3, Vector3};
use thiserror::Error;
use visloc_core::{CameraPose, CameraTrajectory, Timestamp, eval::camera as eval};
use visloc_slam::{atlas::Similarity, map::MapId};

use crate::{
    MapScale, ScaleSource, VisualMap,
    frame::move_map,
    ground::{Ground, find_ground},
};

/// Largest difference of stamps that belong together, seconds.
const TOLERANCE_SECS: f64 = 0.01;
/// Fewest keyframes that a map is aligned by: three fix a similarity, the fourth tells how well.
const LEAST_PAIRS: usize = 4;

/// A map whose rotation is known worse than this is not aligned, radians.
const MOST_TURN_RAD: f64 = 0.1;
/// Directions of a truth are those of the camera if the places, turned by them, are off by at most this share of how far they are spread: the
/// axes of another body are turned by a right angle. Nor may they differ from what places tell by more standard deviations than this.
const MOST_MISFIT: f64 = 0.2;
const MOST_SIGMAS: f64 = 4.0;
/// Cosine of the angle up to which cameras are held upright in the mean: 60 degrees.
const LEAST_UPRIGHT: f64 = 0.5;
/// All sessions are aligned together if they fit that well, in units of how well the best one does.
const ALIKE: f64 = 3.0;
/// Between two keyframes a camera is this share of the distance to the nearer one off the straight way: that of an arc of a sixth of a turn.
const OFF_THE_CHORD: f64 = 0.25;

/// How well a map was aligned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aligned {
    /// Keyframes whose true place is known.
    pub num_pairs: usize,
    /// Length of a map unit before, meters.
    pub scale: f64,
    /// Standard deviation of the scale as a share of it. As everything along a way, errors of places are alike from one to the next: many of
    /// them do not tell more than one.
    pub relative_sigma: f64,
    /// Standard deviation of the rotation about the axis of which least is known, radians.
    pub turn_sigma_rad: f64,
    /// Root of the mean square of what is left, meters.
    pub rmse_m: f64,
}

/// Two times that give no scale.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum BetweenError {
    /// The map was not made then.
    #[error("expected times of the images from {first_secs:.3} to {last_secs:.3} s, or 0 to {:.3} s after the first keyframe; found {found_secs} s", last_secs - first_secs)]
    Outside {
        /// Time of the first keyframe, seconds.
        first_secs: f64,
        /// Time of the last keyframe.
        last_secs: f64,
        /// What was given.
        found_secs: f64,
    },
    /// The camera has not moved between them.
    #[error("the camera was at the same place at both times")]
    SamePlace,
}

/// The scale by the distance between two places of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScaledBetween {
    /// Length of a map unit before, meters.
    pub scale: f64,
    /// Standard deviation of the scale as a share of it.
    pub relative_sigma: f64,
    /// The times, seconds after the first keyframe.
    pub secs: [f64; 2],
}

impl VisualMap {
    /// The keyframes of a map as trajectories, one for each session by whose clock they were taken: where the time goes back, another
    /// session has gone on in the map.
    pub fn ways(&self, map: MapId) -> Vec<CameraTrajectory> {
        let mut ways: Vec<CameraTrajectory> = Vec::new();
        for (_, keyframe) in self.map.all_keyframes().filter(|(_, keyframe)| keyframe.map == map) {
            let world_from_camera = keyframe.camera_from_world().inverse();
            let pose = CameraPose { at: keyframe.at, world_from_camera };
            if ways.last_mut().is_none_or(|way| way.push(pose).is_err()) {
                let mut way = CameraTrajectory::new();
                // The first one has none before it.
                let _ = way.push(pose);
                ways.push(way);
            }
        }
        ways
    }

    /// How many keyframes of a map have a known place.
    pub fn num_known_places(&self, map: MapId, truth: &CameraTrajectory) -> usize {
        self.ways(map).iter().map(|way| eval::associate(truth, way, TOLERANCE_SECS).len()).sum()
    }

    /// Turns, enlarges and moves a map to known places of its camera, and to their directions where these are the camera's own. `None` if
    /// fewer than four keyframes have one, or if they lie about on a line and their directions do not help.
    pub fn align(&mut self, map: MapId, truth: &CameraTrajectory) -> Option<Aligned> {
        let of_sessions: Vec<Vec<eval::PosePair>> =
            self.ways(map).iter().map(|way| eval::associate(truth, way, TOLERANCE_SECS)).collect();
        let all = Known::of(of_sessions.concat());
        let best = of_sessions.into_iter().filter_map(Known::of).min_by(|a, b| a.misfit.total_cmp(&b.misfit));
        // The truth may be that of one session, whose clock showed the times of others, too.
        let is_of_all = |all: &Known| best.as_ref().is_none_or(|best| all.misfit <= ALIKE * best.misfit);
        let Known { num_pairs, fit, misfit } = all.filter(is_of_all).or(best)?;
        let Fit { similarity, rmse, turn_sigma_rad } = fit;
        let aligned = Aligned {
            num_pairs,
            scale: similarity.scale,
            relative_sigma: misfit / 3_f64.sqrt(),
            turn_sigma_rad,
            rmse_m: rmse,
        };
        let known = MapScale { source: ScaleSource::Aligned, relative_sigma: aligned.relative_sigma };
        self.transform(map, &similarity, known);
        Some(aligned)
    }

    /// Gives a map its scale from the distance between the places of its camera at two times: those of the images, or seconds after the
    /// first keyframe.
    ///
    /// # Errors
    /// If the map was not made at these times, or the camera has not moved between them.
    pub fn scale_by_distance(
        &mut self,
        map: MapId,
        times_secs: [f64; 2],
        meters: f64,
    ) -> Result<ScaledBetween, BetweenError> {
        // Of a map in which others have gone on, the first session that was under way then.
        let ways = self.ways(map);
        let found = ways.iter().map(|way| Ok((way, during(way.poses(), times_secs)?)));
        let found = found.reduce(|first, next| first.or_else(|error| next.map_err(|_| error)));
        let (way, secs) = found.unwrap_or(Err(BetweenError::SamePlace))?;
        let way = way.poses();
        let first = way.first().ok_or(BetweenError::SamePlace)?;
        let [(from, from_off), (to, to_off)] = secs.map(|secs| place_at(way, first.at + secs));
        let distance = (from - to).norm();
        let scale = meters / distance;
        if !(scale.is_finite() && scale > 0.0) {
            return Err(BetweenError::SamePlace);
        }
        let relative_sigma = OFF_THE_CHORD * from_off.hypot(to_off) / distance;
        let similarity = Similarity { scale, rotation: Matrix3::identity(), translation: Vector3::zeros() };
        self.transform(map, &similarity, MapScale { source: ScaleSource::TwoPoints, relative_sigma });
        Ok(ScaledBetween { scale, relative_sigma, secs })
    }

    /// Gives a map its scale from the height of its camera above the ground, meters. `None` if no ground is seen.
    pub fn scale_by_height(&mut self, map: MapId, meters: f64) -> Option<(f64, Ground)> {
        let ground = find_ground(&self.map.with_active(map))?;
        let scale = meters / ground.height;
        let similarity = Similarity { scale, rotation: Matrix3::identity(), translation: Vector3::zeros() };
        let scale_of = MapScale { source: ScaleSource::CameraHeight, relative_sigma: ground.relative_sigma };
        self.transform(map, &similarity, scale_of);
        Some((scale, ground))
    }

    /// Takes a map to another frame and unit of length.
    pub fn transform(&mut self, map: MapId, similarity: &Similarity, scale: MapScale) {
        move_map(&mut self.map, map, similarity);
        let least = map.index() + 1;
        if self.scales.len() < least {
            self.scales.resize(least, MapScale::default());
        }
        self.scales[map.index()] = scale;
        if scale.source == ScaleSource::Aligned {
            if self.levels.len() < least {
                self.levels.resize(least, false);
            }
            self.levels[map.index()] = self.is_held_upright(map);
        }
    }

    /// Whether z points up, as far as the cameras tell, which are held upright in the mean.
    fn is_held_upright(&self, map: MapId) -> bool {
        let ups = self.map.all_keyframes().filter(|(_, keyframe)| keyframe.map == map);
        // The axes of the images point down.
        let ups = ups.map(|(_, keyframe)| -keyframe.camera_from_world().rotation().row(1).transpose());
        let (sum, num) = ups.fold((Vector3::zeros(), 0.0), |(sum, num), up| (sum + up, num + 1.0));
        sum.z > LEAST_UPRIGHT * num
    }
}

/// How keyframes are taken to their known places.
struct Known {
    num_pairs: usize,
    fit: Fit,
    /// What is left as a share of how far the places are spread.
    misfit: f64,
}

impl Known {
    /// `None` if there are too few, or if they do not fix the similarity.
    fn of(pairs: Vec<eval::PosePair>) -> Option<Self> {
        let fit =
            fit(&pairs).filter(|fit| pairs.len() >= LEAST_PAIRS && fit.turn_sigma_rad <= MOST_TURN_RAD)?;
        let misfit = fit.rmse / Scatter::of(&pairs).truth.trace().sqrt();
        Some(Self { num_pairs: pairs.len(), fit, misfit })
    }
}

/// A similarity, and how well it is known.
struct Fit {
    similarity: Similarity,
    rmse: f64,
    turn_sigma_rad: f64,
}

/// How places lie about their means.
struct Scatter {
    /// Means of truth and estimate.
    means: [Vector3<f64>; 2],
    /// Mean of truth times estimate.
    product: Matrix3<f64>,
    /// Mean of truth times truth, and of estimate times estimate.
    truth: Matrix3<f64>,
    estimate: Matrix3<f64>,
}

impl Scatter {
    fn of(pairs: &[eval::PosePair]) -> Self {
        let num = pairs.len() as f64;
        let places = |pair: &eval::PosePair| {
            [&pair.truth, &pair.estimate].map(|pose| *pose.world_from_camera.translation())
        };
        let mut means = [Vector3::zeros(); 2];
        for pair in pairs {
            means.iter_mut().zip(places(pair)).for_each(|(mean, place)| *mean += place / num);
        }
        let [mut product, mut truth, mut estimate] = [Matrix3::zeros(); 3];
        for pair in pairs {
            let [t, e] = places(pair);
            let (t, e) = (t - means[0], e - means[1]);
            product += t * e.transpose() / num;
            truth += t * t.transpose() / num;
            estimate += e * e.transpose() / num;
        }
        Self { means, product, truth, estimate }
    }

    /// The best similarity with a rotation.
    fn similarity(&self, rotation: Matrix3<f64>) -> Similarity {
        let scale = (rotation.transpose() * self.product).trace() / self.estimate.trace();
        Similarity { scale, rotation, translation: self.means[0] - rotation * self.means[1] * scale }
    }

    /// Root of the mean square of what a similarity leaves.
    fn rmse(&self, similarity: &Similarity) -> f64 {
        let Similarity { scale, rotation, .. } = similarity;
        let cross = (rotation.transpose() * self.product).trace();
        let square = self.truth.trace() - 2.0 * scale * cross + scale * scale * self.estimate.trace();
        square.max(0.0).sqrt()
    }
}

/// The similarity with which places and directions fit best: both add to the matrix of which the nearest rotation is taken (Wahba's problem).
fn fit(pairs: &[eval::PosePair]) -> Option<Fit> {
    let scatter = Scatter::of(pairs);
    let num = pairs.len() as f64;
    let turns = || {
        pairs.iter().map(|pair| {
            pair.truth.world_from_camera.rotation() * pair.estimate.world_from_camera.rotation().transpose()
        })
    };
    let mean_turn = turns().sum::<Matrix3<f64>>() / num;
    let by_directions = nearest_rotation(&mean_turn)?;
    let square = |turn: Matrix3<f64>| angle(&(by_directions.transpose() * turn)).powi(2);
    let direction_rad = (turns().map(square).sum::<f64>() / num).sqrt().max(1e-4);
    let by_places =
        eval::align(pairs, eval::Alignment::Similarity).map(|found| scatter.similarity(found.rotation));
    let start = by_places.unwrap_or_else(|| scatter.similarity(by_directions));
    let place = scatter.rmse(&start).max(1e-9 * scatter.truth.trace().sqrt());
    let both = scatter.product * (start.scale / place.powi(2)) + mean_turn / (2.0 * direction_rad.powi(2));
    let both = scatter.similarity(nearest_rotation(&both)?);
    // About the axis of which places tell least, the other two directions count.
    let across =
        start.scale.powi(2) * (scatter.estimate.trace() - scatter.estimate.symmetric_eigenvalues().max());
    let by_places_rad = place / across.max(0.0).sqrt();
    // Those of another body, or none, contradict the places.
    let misfit = scatter.rmse(&scatter.similarity(by_directions));
    let apart_rad = by_places.map_or(0.0, |found| angle(&(found.rotation.transpose() * by_directions)));
    let are_of_camera = misfit <= MOST_MISFIT * scatter.truth.trace().sqrt()
        && apart_rad <= MOST_SIGMAS * direction_rad.hypot(by_places_rad);
    let (similarity, turn_sigma_rad) = if are_of_camera {
        (both, (direction_rad.powi(-2) + by_places_rad.powi(-2)).powf(-0.5))
    } else {
        (by_places?, by_places_rad)
    };
    Some(Fit { similarity, rmse: scatter.rmse(&similarity), turn_sigma_rad })
}

fn angle(rotation: &Matrix3<f64>) -> f64 {
    Rotation3::from_matrix_unchecked(*rotation).angle()
}

fn nearest_rotation(matrix: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = matrix.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mut signs = Vector3::new(1.0, 1.0, 1.0);
    signs[svd.singular_values.imin()] = (u.determinant() * v_t.determinant()).signum();
    Some(u * Matrix3::from_diagonal(&signs) * v_t)
}

/// Times as seconds after the first of some keyframes: they are given so, or as those of the images.
fn during(way: &[CameraPose], times_secs: [f64; 2]) -> Result<[f64; 2], BetweenError> {
    // Images may come before the first keyframe and after the last one.
    const SLACK_SECS: f64 = 0.5;
    let [first, .., last] = way else { return Err(BetweenError::SamePlace) };
    let (first_secs, last_secs) = (first.at.secs(), last.at.secs());
    let all = -SLACK_SECS..=last_secs - first_secs + SLACK_SECS;
    let mut secs = [0.0; 2];
    for (after, found_secs) in secs.iter_mut().zip(times_secs) {
        let given = [found_secs - first_secs, found_secs].into_iter().find(|after| all.contains(after));
        *after = given.ok_or(BetweenError::Outside { first_secs, last_secs, found_secs })?;
    }
    Ok(secs)
}

/// Where the camera was, on straight lines between keyframes, and how far from the nearest keyframe.
fn place_at(way: &[CameraPose], at: Timestamp) -> (Vector3<f64>, f64) {
    let next = way.partition_point(|pose| pose.at < at).clamp(1, way.len() - 1);
    let [before, after] = [&way[next - 1], &way[next]];
    let [from, to] = [before, after].map(|pose| *pose.world_from_camera.translation());
    let share = (at.secs_since(before.at) / after.at.secs_since(before.at)).clamp(0.0, 1.0);
    let place = from + (to - from) * share;
    (place, (place - from).norm().min((place - to).norm()))
}

#[cfg(test)]
mod tests {
    use visloc_core::geom::Rigid3;

    use super::*;

    /// A drive ahead that bends by a hair, as an estimate that wobbles and as truth in a frame of its own, with directions of a body that
    /// is turned against the camera.
    fn drive(body_from_camera: Rotation3<f64>, bend: f64) -> Vec<eval::PosePair> {
        let truth_from_map = Rotation3::from_euler_angles(0.4, -0.7, 1.9);
        let pair = |i: i32| {
            let s = f64::from(i);
            let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), 2.0 * bend * s);
            let place = Vector3::new(bend * s * s, 0.0, s);
            let wobble = Vector3::new((3.1 * s).sin(), (2.3 * s).cos(), (1.7 * s).sin()) * 0.02;
            let pose = |rotation: Rotation3<f64>, place: Vector3<f64>| CameraPose {
                at: Timestamp::from_secs(s),
                world_from_camera: Rigid3::new(rotation, place),
            };
            eval::PosePair {
                truth: pose(truth_from_map * turn * body_from_camera.inverse(), truth_from_map * place * 3.0),
                estimate: pose(turn, place + wobble),
            }
        };
        (0..30).map(pair).collect()
    }

    fn off_rad(fit: &Fit) -> f64 {
        let truth_from_map = Rotation3::from_euler_angles(0.4, -0.7, 1.9);
        (truth_from_map.inverse() * Rotation3::from_matrix_unchecked(fit.similarity.rotation)).angle()
    }

    #[test]
    fn a_straight_drive_is_turned_by_the_directions_of_its_camera() {
        let found = fit(&drive(Rotation3::identity(), 1e-5)).unwrap();
        assert!(off_rad(&found) < 0.005 && found.turn_sigma_rad < 0.005, "{}", off_rad(&found));
        assert!((found.similarity.scale - 3.0).abs() < 0.01);
    }

    #[test]
    fn directions_of_another_body_do_not_count() {
        let body = Rotation3::from_euler_angles(-1.5, 0.0, -1.5);
        assert!(fit(&drive(body, 1e-5)).unwrap().turn_sigma_rad > MOST_TURN_RAD);
        let bent = fit(&drive(body, 0.02)).unwrap();
        assert!(off_rad(&bent) < bent.turn_sigma_rad && bent.turn_sigma_rad < MOST_TURN_RAD);
    }
}
