//! When a frame becomes a keyframe.

use crate::{
    config::MappingConfig,
    map::{KeyframeId, LandmarkId, Map},
    track::{Frame, Quality, TrackReport},
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
#[derive(Debug, Clone, Default)]
pub struct KeyframeRule {
    most_matched: usize,
    /// Frame in which the reference was taken.
    since: usize,
}

impl KeyframeRule {
    /// Takes note of a frame and says what should be done. The reference is the keyframe that the frame hangs on.
    pub fn decide(
        &mut self,
        config: &MappingConfig,
        map: &Map,
        reference: KeyframeId,
        report: &TrackReport,
        image_width: f64,
    ) -> KeyframeDecision {
        if !self.is_due(config, map, reference, report, image_width) {
            return KeyframeDecision::Stay;
        }
        let max_shift_px = RETURN_SHIFT * config.max_shift_ratio * image_width;
        match covering(map, reference, report, max_shift_px) {
            Some(earlier) => {
                self.most_matched = report.num_converged;
                self.since = report.frame.number;
                KeyframeDecision::GoBackTo(earlier)
            }
            None => KeyframeDecision::Make,
        }
    }

    fn is_due(
        &mut self,
        config: &MappingConfig,
        map: &Map,
        reference: KeyframeId,
        report: &TrackReport,
        image_width: f64,
    ) -> bool {
        self.most_matched = self.most_matched.max(report.num_converged);
        let since = self.since.max(map.keyframe(reference).frame);
        let gap = report.frame.number.saturating_sub(since);
        if report.quality == Quality::Bad || gap < config.min_gap_frames {
            return false;
        }
        let lost = 1.0 - report.num_converged as f64 / self.most_matched.max(1) as f64;
        lost > config.lost_ratio
            || (gap >= config.soft_gap_frames && lost > config.soft_lost_ratio)
            || match mean_shift_px(map, reference, &report.frame) {
                Some(px) => px > config.max_shift_ratio * image_width,
                // Hardly anything in common: wait until candidates have had a chance.
                None => gap >= 2 * config.min_gap_frames,
            }
    }

    /// Starts over after a keyframe: what counts is how many landmarks *tracking* finds from here on.
    pub fn keyframe_made(&mut self) {
        self.most_matched = 0;
    }
}

/// Share of the shift that asks for a keyframe, and of the shift to the reference, within which an earlier keyframe counts as the same
/// view.
const RETURN_SHIFT: f64 = 0.7;
/// Share of the landmarks in view that an earlier keyframe must see, to count as the same view: not all, since it was made before
/// many of them.
const RETURN_SHARE: f64 = 0.5;

/// The keyframe that sees most of what the frame sees, from nearly the same place: space that is seen again needs no more
/// keyframes, or a robot that goes round would fill its memory.
fn covering(map: &Map, reference: KeyframeId, report: &TrackReport, max_shift_px: f64) -> Option<KeyframeId> {
    let seen: Vec<LandmarkId> = report.frame.features.iter().map(|feature| feature.landmark).collect();
    let min_shared = (RETURN_SHARE * report.num_converged as f64).ceil().max(10.0) as u32;
    let shift = |id: &KeyframeId| mean_shift_px(map, *id, &report.frame).unwrap_or(f64::INFINITY);
    // A camera that goes ahead leaves its reference, but earlier keyframes even more.
    let max_shift_px = max_shift_px.min(RETURN_SHIFT * shift(&reference));
    map.sharing(&seen, min_shared)
        .into_iter()
        .map(|(id, _)| id)
        .filter(|id| *id != reference)
        .map(|id| (shift(&id), id))
        .filter(|(px, _)| *px < max_shift_px)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, id)| id)
}

/// Mean shift of the landmarks that both see, pixels; `None` if they share fewer than ten.
fn mean_shift_px(map: &Map, keyframe: KeyframeId, frame: &Frame) -> Option<f64> {
    let shift = |feature: &crate::track::Feature| {
        let landmark = map.landmark(feature.landmark);
        landmark.observation_in(keyframe).map(|observation| (observation.px - feature.px).norm())
    };
    let shifts: Vec<f64> = frame.features.iter().filter_map(shift).collect();
    (shifts.len() >= 10).then(|| shifts.iter().sum::<f64>() / shifts.len() as f64)
}
