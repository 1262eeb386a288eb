//! When a frame becomes a keyframe.

use crate::{
    config::MappingConfig,
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkId, Map},
    track::{Feature, Frame, Quality, TrackReport, focal_px},
};

/// What to do about keyframes after a tracked frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeyframeDecision {
    /// Nothing: the reference keyframe still covers the view.
    Stay,
    /// Another keyframe covers the view: take it as the reference.
    GoBackTo(KeyframeId),
    /// Make a keyframe of this frame.
    Make,
}

/// The rule, with what it remembers since the reference keyframe was taken. Thesis, section 6.6.2; the shift of the image and the
/// return to keyframes of an earlier visit are additions.
#[derive(Debug, Clone)]
pub struct KeyframeRule {
    config: MappingConfig,
    image_width_px: f64,
    most_matched: usize,
    /// Frame in which the reference was taken.
    since: usize,
}

impl KeyframeRule {
    /// The rule for images of this width.
    pub fn new(config: &MappingConfig, image_width_px: f64) -> Self {
        Self { config: config.clone(), image_width_px, most_matched: 0, since: 0 }
    }

    /// Takes note of a frame and says what should be done. The reference is the keyframe that the frame hangs on.
    pub fn decide(
        &mut self,
        map: &Map,
        reference: KeyframeId,
        report: &TrackReport,
        focal_px: f64,
    ) -> KeyframeDecision {
        if report.quality == Quality::Bad {
            return self.decide_blindly(map, reference, &report.frame, focal_px);
        }
        if !self.is_due(map, reference, report) {
            return KeyframeDecision::Stay;
        }
        let max_shift_px = RETURN_SHIFT * self.max_shift_px();
        match covering(map, reference, report, max_shift_px) {
            Some(earlier) => {
                self.most_matched = report.num_converged;
                self.since = report.frame.number;
                KeyframeDecision::GoBackTo(earlier)
            }
            None if report.quality == Quality::Good || report.num_matched >= LEAST_MATCHES => {
                KeyframeDecision::Make
            }
            None => KeyframeDecision::Stay,
        }
    }

    /// The same for a frame whose pose is not known from its image: by how far it looks elsewhere.
    fn decide_blindly(
        &self,
        map: &Map,
        reference: KeyframeId,
        frame: &Frame,
        focal_px: f64,
    ) -> KeyframeDecision {
        let reference = (map.keyframe(reference).camera_from_world(), map.depth_of(reference).unwrap_or(1.0));
        let looks_elsewhere = self.looks_elsewhere(reference, &frame.camera_from_world, focal_px);
        if looks_elsewhere { KeyframeDecision::Make } else { KeyframeDecision::Stay }
    }

    /// Whether a camera sees so much else than from another pose, from which the scene is this deep, that a keyframe is due.
    pub fn looks_elsewhere(
        &self,
        (before, depth): (&CameraFromWorld, f64),
        camera_from_world: &CameraFromWorld,
        focal_px: f64,
    ) -> bool {
        let moved = *camera_from_world * before.inverse();
        let shift_px = focal_px * (moved.rotation_angle_rad() + moved.translation().norm() / depth);
        shift_px > self.max_shift_px()
    }

    fn is_due(&mut self, map: &Map, reference: KeyframeId, report: &TrackReport) -> bool {
        self.most_matched = self.most_matched.max(report.num_converged);
        let config = &self.config;
        let since = self.since.max(map.keyframe(reference).frame);
        let gap = report.frame.number.saturating_sub(since);
        if gap < config.min_gap_frames {
            return false;
        }
        let lost = 1.0 - report.num_converged as f64 / self.most_matched.max(1) as f64;
        lost > config.lost_ratio
            || (gap >= config.soft_gap_frames && lost > config.soft_lost_ratio)
            || match mean_shift_px(map, reference, &report.frame) {
                Some(px) => px > self.max_shift_px(),
                // Hardly anything in common: wait until candidates have had a chance.
                None => gap >= 2 * config.min_gap_frames,
            }
    }

    /// Shift of the image that asks for a keyframe.
    fn max_shift_px(&self) -> f64 {
        self.config.max_shift_ratio * self.image_width_px
    }

    /// Starts over after a keyframe: what counts is how many landmarks *tracking* finds from here on.
    pub fn keyframe_made(&mut self) {
        self.most_matched = 0;
    }

    /// Starts over with a new map.
    pub fn restart(&mut self) {
        self.most_matched = 0;
        self.since = 0;
    }
}

/// Share of the shift that asks for a keyframe within which an earlier keyframe counts as the same view.
const RETURN_SHIFT: f64 = 0.7;
/// Share of the landmarks in view that an earlier keyframe must see, to count as the same view: not all, since it was made before
/// many of them.
const RETURN_SHARE: f64 = 0.5;
/// Fewest matches of a frame whose pose is good enough for a keyframe. Thesis, section 6.9: the fewest of a frame that is not bad.
const LEAST_MATCHES: usize = 20;

/// The keyframe that sees most of what the frame sees, from nearly the same place: space that is seen again needs no more
/// keyframes, or a robot that goes round would fill its memory.
fn covering(map: &Map, reference: KeyframeId, report: &TrackReport, max_shift_px: f64) -> Option<KeyframeId> {
    let seen: Vec<LandmarkId> = report.frame.features.iter().map(|feature| feature.landmark).collect();
    // A camera that goes ahead shares most with the reference, one that comes back with where it comes to.
    let min_shared = (RETURN_SHARE * report.num_converged as f64).ceil().max(10.0) as u32;
    let min_shared = min_shared.max(num_shared(map, reference, report));
    let shift = |id: &KeyframeId| mean_shift_px(map, *id, &report.frame).unwrap_or(f64::INFINITY);
    // A camera that goes ahead leaves its reference, but earlier keyframes even more.
    let max_shift_px = max_shift_px.min(shift(&reference));
    map.sharing(&seen, min_shared)
        .into_iter()
        .map(|(id, _)| id)
        .filter(|id| *id != reference)
        .map(|id| (shift(&id), id))
        .filter(|(px, _)| *px < max_shift_px)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, id)| id)
}

/// How many landmarks a frame shares with a keyframe.
fn num_shared(map: &Map, id: KeyframeId, report: &TrackReport) -> u32 {
    let is_shared = |feature: &&Feature| {
        let landmark = map.landmark(feature.landmark);
        landmark.is_converged() && landmark.observation_in(id).is_some()
    };
    report.frame.features.iter().filter(is_shared).count() as u32
}

/// Mean shift of the landmarks that both see, pixels; `None` if they share fewer than ten.
fn mean_shift_px(map: &Map, keyframe: KeyframeId, frame: &Frame) -> Option<f64> {
    let foreign = map.keyframe(keyframe).foreign.as_ref();
    let shift = |feature: &crate::track::Feature| {
        let observation = map.landmark(feature.landmark).observation_in(keyframe)?;
        Some(match foreign {
            None => (observation.px - feature.px).norm(),
            Some(foreign) => (observation.ray - feature.ray).xy().norm() * focal_px(&foreign.camera),
        })
    };
    let shifts: Vec<f64> = frame.features.iter().filter_map(shift).collect();
    (shifts.len() >= 10).then(|| shifts.iter().sum::<f64>() / shifts.len() as f64)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Matrix2, Point2, Vector3};
    use visloc_core::{GrayImage, Timestamp};

    use super::*;
    use crate::{
        image::Pyramid,
        lie::CameraFromWorld,
        map::{LandmarkState, NewKeyframe, Observation},
        mapping::DepthFilter,
        track::LocalMap,
    };

    const WIDTH_PX: f64 = 640.0;
    /// Columns of ten landmarks each, so many pixels apart.
    const STEP_PX: f64 = 4.0;

    /// A camera that has moved sideways by so many columns sees the next thirty.
    fn seen_from(column: usize) -> impl Iterator<Item = (usize, Point2<f64>)> {
        (column * 10..(column + 30) * 10).map(move |i| {
            let x = (i / 10 - column) as f64 * STEP_PX;
            (i, Point2::new(x, (i % 10) as f64 * 20.0))
        })
    }

    fn frame(number: usize) -> Frame {
        Frame {
            number,
            at: Timestamp::default(),
            pyramid: Arc::new(Pyramid::new(GrayImage::new(40, 30), 1)),
            camera_from_world: CameraFromWorld::identity(),
            features: Vec::new(),
            turned_from: None,
            odometry: None,
            exposure: None,
        }
    }

    /// A map whose keyframes, one for every hundredth frame, were taken from these columns.
    fn map_of(columns: &[usize]) -> (Map, Vec<Option<LandmarkId>>) {
        let mut map = Map::new();
        let mut ids: Vec<Option<LandmarkId>> = vec![None; 1000];
        for (k, column) in columns.iter().enumerate() {
            let Frame { at, pyramid, camera_from_world, .. } = frame(0);
            let made = NewKeyframe {
                frame: k * 100,
                at,
                pyramid,
                camera_from_world,
                turned_from: None,
                odometry: None,
            };
            let keyframe = map.add_keyframe(made);
            for (i, px) in seen_from(*column) {
                let (ray, covariance_px) = (Vector3::z(), Matrix2::identity());
                let observation = Observation { keyframe, px, ray, level: 0, covariance_px };
                match ids[i] {
                    Some(id) => map.add_observation(id, observation),
                    None => {
                        let filter = DepthFilter::new(1.0, 0.1);
                        ids[i] = Some(map.add_landmark(observation, filter, LandmarkState::Converged));
                    }
                }
            }
        }
        (map, ids)
    }

    /// What the rule says about a frame from a column, long after the newest keyframe.
    fn decision(columns: &[usize], reference: usize, from: usize, most_matched: usize) -> KeyframeDecision {
        let (map, ids) = map_of(columns);
        let mut frame = frame(columns.len() * 100);
        let feature = |(i, px): (usize, Point2<f64>)| {
            let (landmark, covariance_px) = (ids[i]?, Matrix2::identity());
            Some(Feature { landmark, px, ray: Vector3::z(), level: 0, covariance_px })
        };
        frame.features = seen_from(from).filter_map(feature).collect();
        let num_converged = frame.features.len();
        let report = TrackReport {
            expected_from_world: frame.camera_from_world,
            frame,
            quality: Quality::Good,
            tried: Vec::new(),
            num_searched: num_converged,
            num_fixed_searched: 0,
            num_matched: num_converged,
            num_converged,
            local_map: LocalMap::default(),
            covariance: None,
        };
        let reference = KeyframeId(reference as u32);
        let mut rule =
            KeyframeRule { most_matched, ..KeyframeRule::new(&MappingConfig::default(), WIDTH_PX) };
        rule.decide(&map, reference, &report, 500.0)
    }

    #[test]
    fn a_camera_that_comes_back_goes_back_to_its_keyframes() {
        // 6 % of the image are ten columns.
        assert_eq!(decision(&[0, 12, 24], 2, 14, 0), KeyframeDecision::GoBackTo(KeyframeId(1)));
        assert_eq!(decision(&[0, 12, 24], 2, 20, 0), KeyframeDecision::Stay);
        assert_eq!(decision(&[0, 30], 1, 14, 0), KeyframeDecision::Make, "nothing is near");
    }

    #[test]
    fn a_camera_that_goes_ahead_makes_keyframes() {
        assert_eq!(decision(&[0, 6], 1, 17, 0), KeyframeDecision::Make);
        // It has lost landmarks; the older keyframe is near, but farther behind than the newer one.
        assert_eq!(decision(&[4, 6], 1, 8, 400), KeyframeDecision::Make);
        assert_eq!(decision(&[8, 6], 1, 8, 400), KeyframeDecision::GoBackTo(KeyframeId(0)));
        // It has lost landmarks without moving: an older keyframe that sees less of what is left is no help.
        assert_eq!(decision(&[1, 8], 1, 6, 400), KeyframeDecision::Make);
    }
}
