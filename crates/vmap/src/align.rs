//! Giving a map a frame and a unit of length that mean something.

use nalgebra::{Matrix3, Vector3};
use visloc_core::{CameraPose, CameraTrajectory, Timestamp, eval::camera as eval};
use visloc_slam::{
    atlas::Similarity,
    map::{Keyframe, KeyframeId, MapId},
};

use crate::{
    MapScale, ScaleSource, VisualMap,
    frame::move_map,
    ground::{Ground, find_ground},
};

/// Largest difference of stamps that belong together, seconds.
const TOLERANCE_SECS: f64 = 0.01;
/// Fewest keyframes that a map is aligned by: three fix a similarity, the fourth tells how well.
const LEAST_PAIRS: usize = 4;

/// How well a map was aligned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aligned {
    /// Keyframes whose true place is known.
    pub num_pairs: usize,
    /// Length of a map unit before, meters.
    pub scale: f64,
    /// Standard deviation of the scale as a share of it.
    pub relative_sigma: f64,
    /// Root of the mean square of what is left, meters.
    pub rmse_m: f64,
}

impl VisualMap {
    /// The keyframes of a map as a trajectory, in order of time.
    #[must_use]
    pub fn way(&self, map: MapId) -> CameraTrajectory {
        let pose = |(_, k): (KeyframeId, &Keyframe)| CameraPose {
            at: k.at,
            world_from_camera: k.camera_from_world().inverse(),
        };
        let of_map = self.map.all_keyframes().filter(|(_, keyframe)| keyframe.map == map);
        let mut poses: Vec<CameraPose> = of_map.map(pose).collect();
        poses.sort_by_key(|pose| pose.at);
        let mut way = CameraTrajectory::new();
        for pose in poses {
            // A second keyframe of the same time is left out.
            let _ = way.push(pose);
        }
        way
    }

    /// Turns, enlarges and moves a map to known places of its camera. `None` if fewer than four keyframes have one, or they all lie
    /// on a line.
    pub fn align(&mut self, map: MapId, truth: &CameraTrajectory) -> Option<Aligned> {
        let pairs = eval::associate(truth, &self.way(map), TOLERANCE_SECS);
        if pairs.len() < LEAST_PAIRS {
            return None;
        }
        let found = eval::align(&pairs, eval::Alignment::Similarity)?;
        let error = eval::absolute_error(&pairs, eval::Alignment::Similarity)?;
        // Of a scale that is fitted to points with independent errors: error over the spread of the points.
        let place = |pair: &eval::PosePair| *pair.truth.world_from_camera.translation();
        let num = pairs.len() as f64;
        let mean = pairs.iter().map(place).sum::<Vector3<f64>>() / num;
        let spread = pairs.iter().map(|pair| (place(pair) - mean).norm_squared()).sum::<f64>().sqrt();
        let relative_sigma = error.rmse / 3_f64.sqrt() / spread;
        let similarity =
            Similarity { scale: found.scale, rotation: found.rotation, translation: found.translation };
        self.transform(map, &similarity, MapScale { source: ScaleSource::Aligned, relative_sigma });
        Some(Aligned { num_pairs: pairs.len(), scale: found.scale, relative_sigma, rmse_m: error.rmse })
    }

    /// Gives a map its scale from the distance between the places of its camera at two times. The keyframes next to the times are taken.
    /// `None` if they are one keyframe or at the same place.
    pub fn scale_by_distance(
        &mut self,
        map: MapId,
        times: (Timestamp, Timestamp),
        meters: f64,
    ) -> Option<f64> {
        let way = self.way(map);
        let nearest = |at: Timestamp| {
            way.poses().iter().min_by(|a, b| a.at.secs_since(at).abs().total_cmp(&b.at.secs_since(at).abs()))
        };
        let (first, second) = (nearest(times.0)?, nearest(times.1)?);
        let distance =
            (first.world_from_camera.translation() - second.world_from_camera.translation()).norm();
        let scale = Some(meters / distance).filter(|scale| scale.is_finite() && *scale > 0.0)?;
        let similarity = Similarity { scale, rotation: Matrix3::identity(), translation: Vector3::zeros() };
        let known = MapScale { source: ScaleSource::TwoPoints, relative_sigma: 0.0 };
        self.transform(map, &similarity, known);
        Some(scale)
    }

    /// Gives a map its scale from the height of its camera above the ground, meters. `None` if no ground is seen.
    pub fn scale_by_height(&mut self, map: MapId, meters: f64) -> Option<(f64, Ground)> {
        let ground = find_ground(&self.map.with_active(map))?;
        let scale = meters / ground.height;
        let similarity = Similarity { scale, rotation: Matrix3::identity(), translation: Vector3::zeros() };
        let relative_sigma = ground.spread / ground.height / (ground.num_keyframes as f64).sqrt();
        self.transform(map, &similarity, MapScale { source: ScaleSource::CameraHeight, relative_sigma });
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
            self.levels[map.index()] = true;
        }
    }
}
