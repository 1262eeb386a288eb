//! Candidates: made at keyframes, measured in every frame, promoted when their depth is sure.

use nalgebra::{Matrix2, Point3};
use visloc_core::geom::Camera;

use super::{DepthFilter, EpipolarSearch, lens::FIRST_SETTLED_AT};
use crate::{
    config::{FeatureConfig, MappingConfig},
    feature::{Corner, CornerGrid, CornerSearch, detect_corners, gradient_noise},
    map::{KeyframeId, LandmarkId, LandmarkState, Map, Observation},
    solve::cos_parallax,
    track::{FEW_KNOWN, Found, Matcher},
};

/// How far above the noise of the image the score of a weak corner must be.
const NOISE_FACTOR: f32 = 4.0;
/// Cosine of the least parallax of a landmark (half a degree): below, errors of the poses pass for depth.
const MAX_COS_PARALLAX: f64 = 0.999_962;

/// New corners in cells where the keyframe has no landmark, strongest first.
pub fn new_corners(
    map: &Map,
    keyframe: KeyframeId,
    camera: &Camera,
    features: &FeatureConfig,
    max: usize,
) -> Vec<Corner> {
    let frame = map.keyframe(keyframe);
    let Some(pyramid) = frame.pyramid() else { return Vec::new() };
    let mut grid = CornerGrid::new(camera.size_px(), features.cell_px);
    for id in frame.landmarks.iter() {
        if let Some(observation) = map.landmark(*id).observation_in(keyframe) {
            grid.take(grid.cell(&observation.px));
        }
    }
    let mut corners = corners_in_two_passes(&pyramid, &grid, features);
    corners.truncate(max);
    corners
}

/// Strong corners first, weak ones in the cells that stay empty.
pub fn corners_in_two_passes(
    pyramid: &crate::image::Pyramid,
    grid: &CornerGrid,
    features: &FeatureConfig,
) -> Vec<Corner> {
    let search = CornerSearch {
        num_levels: features.search_levels,
        threshold: features.fast_threshold,
        min_score: features.min_score,
    };
    if features.low_fast_threshold >= features.fast_threshold {
        return detect_corners(pyramid, grid, (search, search));
    }
    let low = CornerSearch {
        threshold: features.low_fast_threshold,
        min_score: features
            .low_min_score
            .max(NOISE_FACTOR * gradient_noise(pyramid, 1).first().copied().unwrap_or(0.0)),
        ..search
    };
    detect_corners(pyramid, grid, (search, low))
}

/// Inverse depths of the landmarks that a keyframe sees: median and a high value. `None` if there are too few.
fn inverse_depths(map: &Map, keyframe: KeyframeId) -> Option<(f64, f64)> {
    let frame = map.keyframe(keyframe);
    let depth = |id: &LandmarkId| {
        let landmark = map.landmark(*id);
        landmark.is_converged().then(|| frame.camera_from_world().transform(&landmark.point_in_world).z)
    };
    let mut depths: Vec<f64> = frame.landmarks.iter().filter_map(depth).filter(|z| *z > 0.0).collect();
    if depths.len() < 5 {
        return None;
    }
    depths.sort_by(f64::total_cmp);
    Some((1.0 / depths[depths.len() / 2], 1.0 / depths[depths.len() / 50]))
}

/// Adds a candidate for each corner, with a depth that is as uncertain as the scene is deep.
pub fn add_candidates(
    map: &mut Map,
    keyframe: KeyframeId,
    camera: &Camera,
    corners: &[Corner],
    fallback_depth: f64,
) -> Vec<LandmarkId> {
    let (median, high) =
        inverse_depths(map, keyframe).unwrap_or((1.0 / fallback_depth, 2.0 / fallback_depth));
    // Two standard deviations reach from infinity to half again as near as the nearest landmarks.
    let deviation = 0.5 * median.max(1.5 * high - median);
    let add = |corner: &Corner| {
        let ray = camera.bearing(&corner.px);
        let host = Observation {
            keyframe,
            px: corner.px,
            ray,
            level: corner.level,
            covariance_px: corner_covariance(corner.level),
        };
        map.add_landmark(host, DepthFilter::new(median, deviation), LandmarkState::Candidate)
    };
    corners.iter().map(add).collect()
}

/// Covariance of a place that defines a patch, squared pixels of level 0.
pub fn corner_covariance(level: usize) -> Matrix2<f64> {
    const SIGMA_PX: f64 = 0.2;
    Matrix2::identity() * (SIGMA_PX * f64::from(1_u32 << level)).powi(2)
}

/// Measures a candidate in an image and tells where it was found.
pub fn measure(map: &mut Map, id: LandmarkId, matcher: &Matcher<'_>) -> Option<Found> {
    let search = matcher.search_epipolar(map, map.landmark(id));
    let landmark = map.landmark_mut(id);
    match search {
        EpipolarSearch::Unseen => None,
        EpipolarSearch::Missed => {
            landmark.filter.iter_mut().for_each(|filter| filter.add_miss());
            landmark.num_missed += 1;
            None
        }
        EpipolarSearch::Found { found, inverse_depth, standard_deviation } => {
            landmark.filter.iter_mut().for_each(|filter| filter.add(inverse_depth, standard_deviation));
            landmark.num_missed = 0;
            landmark.num_found += 1;
            place(map, id);
            Some(found)
        }
    }
}

/// Puts a candidate where its filter says.
pub fn place(map: &mut Map, id: LandmarkId) {
    let landmark = map.landmark(id);
    let host = landmark.host();
    let Some(filter) = &landmark.filter else { return };
    let point = Point3::from(host.ray / filter.inverse_depth());
    let point_in_world = map.keyframe(host.keyframe).camera_from_world().inverse().transform(&point);
    map.landmark_mut(id).point_in_world = point_in_world;
}

/// What became of a candidate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It stays a candidate.
    Wait,
    /// Its depth is sure.
    Promote,
    /// It is not worth more searches.
    Drop,
}

/// Whether the depth of so few of these landmarks is known that a pose hangs on candidates. A fixed map holds its unit of length by itself, one
/// with odometry by that, and one that has just begun is not settled yet: all its depths are rough.
pub fn is_short_of_known(map: &Map, landmarks: impl Iterator<Item = LandmarkId>) -> bool {
    let known = landmarks.filter(|id| map.landmark(*id).is_converged());
    let is_held =
        || map.has_fixed() || map.keyframes().next_back().is_none_or(|(_, last)| last.odometry.is_some());
    // The keyframes are gone through only where it matters.
    known.take(FEW_KNOWN).count() < FEW_KNOWN
        && !is_held()
        && map.keyframes().take(FIRST_SETTLED_AT).count() == FIRST_SETTLED_AT
}

/// Judges a candidate from the camera that measured it last. Where known landmarks are few, a rough depth is enough: from then on bundles adjust it
/// together with the poses that it was measured from, which its filter takes for exact.
pub fn judge(
    map: &Map,
    id: LandmarkId,
    center: &Point3<f64>,
    (config, is_short_of_known): (&MappingConfig, bool),
) -> Verdict {
    let landmark = map.landmark(id);
    let Some(filter) = &landmark.filter else { return Verdict::Drop };
    if landmark.num_missed > config.max_candidate_misses || filter.inlier_ratio() < 0.3 {
        return Verdict::Drop;
    }
    let host_center = map.keyframe(landmark.host().keyframe).center_in_world();
    let cos = cos_parallax(&landmark.point_in_world, host_center, center);
    let distance = (landmark.point_in_world - center).norm();
    let deviation = filter.standard_deviation() / filter.inverse_depth();
    let is_small = |error: f64| error < 0.1;
    let is_sure = if is_short_of_known {
        is_small(deviation)
    } else {
        is_small(filter.linearity_index(distance, cos)) && deviation < config.max_depth_deviation
    };
    if is_sure && cos < MAX_COS_PARALLAX && landmark.num_found >= 3 {
        Verdict::Promote
    } else {
        Verdict::Wait
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Point2, Rotation3, Vector3};
    use visloc_core::{GrayImage, Timestamp};

    use super::*;
    use crate::{
        image::Pyramid,
        lie::CameraFromWorld,
        map::NewKeyframe,
        odometry::{OdomFromCamera, OdomPose},
    };

    fn host(keyframe: KeyframeId) -> Observation {
        let covariance_px = corner_covariance(0);
        Observation { keyframe, px: Point2::origin(), ray: Vector3::z(), level: 0, covariance_px }
    }

    /// Adds a keyframe at the origin.
    fn add_keyframe(map: &mut Map, odometry: Option<OdomPose>) -> KeyframeId {
        map.add_keyframe(NewKeyframe {
            frame: 0,
            at: Timestamp::default(),
            pyramid: Arc::new(Pyramid::new(GrayImage::new(40, 30), 1)),
            camera_from_world: CameraFromWorld::new(Rotation3::identity(), Vector3::zeros()),
            turned_from: None,
            odometry,
        })
    }

    /// A map that has been settled, with known landmarks, and a candidate in a distance of 1 with a standard deviation of the depth, found often
    /// enough.
    fn scene(num_known: usize, deviation: f64) -> (Map, LandmarkId) {
        let mut map = Map::new();
        let keyframe = add_keyframe(&mut map, None);
        (1..FIRST_SETTLED_AT).for_each(|_| {
            add_keyframe(&mut map, None);
        });
        for _ in 0..num_known {
            map.add_landmark(host(keyframe), DepthFilter::new(1.0, 0.01), LandmarkState::Converged);
        }
        let filter = DepthFilter::new(1.0, deviation);
        let id = map.add_landmark(host(keyframe), filter, LandmarkState::Candidate);
        map.landmark_mut(id).num_found = 3;
        (map, id)
    }

    /// What becomes of the candidate, seen from so far beside its host.
    fn verdict(num_known: usize, deviation: f64, baseline: f64) -> Verdict {
        let (map, id) = scene(num_known, deviation);
        let landmarks = map.landmarks().map(|(id, _)| id);
        let is_short = is_short_of_known(&map, landmarks);
        judge(&map, id, &Point3::new(baseline, 0.0, 0.0), (&MappingConfig::default(), is_short))
    }

    #[test]
    fn a_rough_depth_is_enough_where_known_landmarks_are_few() {
        assert_eq!(verdict(FEW_KNOWN, 0.06, 0.05), Verdict::Wait);
        assert_eq!(verdict(FEW_KNOWN - 1, 0.06, 0.05), Verdict::Promote);
        assert_eq!(verdict(FEW_KNOWN, 0.02, 0.05), Verdict::Promote);
        assert_eq!(verdict(0, 0.15, 0.05), Verdict::Wait, "a guess is not a depth");
        assert_eq!(
            verdict(0, 0.06, 0.005),
            Verdict::Wait,
            "from nearly the same place errors of the poses pass for depth"
        );
    }

    #[test]
    fn what_holds_the_unit_of_length_by_itself_is_never_short_of_known_landmarks() {
        let is_short = |map: &Map, id: LandmarkId| is_short_of_known(map, [id].into_iter());
        let (mut map, id) = scene(0, 0.06);
        assert!(is_short(&map, id));
        let here = OdomPose { odom_from_camera: OdomFromCamera::identity(), stretch: 0 };
        add_keyframe(&mut map, Some(here));
        assert!(!is_short(&map, id), "odometry");
        let (mut map, id) = scene(0, 0.06);
        map.fix();
        assert!(!is_short(&map, id), "a fixed map");
        let mut young = Map::new();
        let keyframe = add_keyframe(&mut young, None);
        let id = young.add_landmark(host(keyframe), DepthFilter::new(1.0, 0.06), LandmarkState::Candidate);
        assert!(!is_short(&young, id), "all depths of a map that has just begun are rough");
    }
}
