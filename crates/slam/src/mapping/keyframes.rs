//! When a frame becomes a keyframe.

use crate::{
    config::MappingConfig,
    map::{KeyframeId, Map},
    track::{Frame, Quality, TrackReport},
};

/// The rule, with what it remembers of the last keyframe. Thesis, section 6.6.2; the shift of the image is an addition.
#[derive(Debug, Clone, Default)]
pub struct KeyframeRule {
    most_matched: usize,
}

impl KeyframeRule {
    /// Takes note of a frame and says whether it should become a keyframe.
    pub fn asks_for(
        &mut self,
        config: &MappingConfig,
        map: &Map,
        last_keyframe: KeyframeId,
        report: &TrackReport,
        image_width: f64,
    ) -> bool {
        self.most_matched = self.most_matched.max(report.num_converged);
        let gap = report.frame.number.saturating_sub(map.keyframe(last_keyframe).frame);
        if report.quality == Quality::Bad || gap < config.min_gap_frames {
            return false;
        }
        let lost = 1.0 - report.num_converged as f64 / self.most_matched.max(1) as f64;
        lost > config.lost_ratio
            || (gap >= config.soft_gap_frames && lost > config.soft_lost_ratio)
            || match mean_shift_px(map, last_keyframe, &report.frame) {
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

/// Mean shift of the landmarks that both see, pixels; `None` if they share fewer than ten.
fn mean_shift_px(map: &Map, keyframe: KeyframeId, frame: &Frame) -> Option<f64> {
    let shift = |feature: &crate::track::Feature| {
        let landmark = map.landmark(feature.landmark);
        landmark.observation_in(keyframe).map(|observation| (observation.px - feature.px).norm())
    };
    let shifts: Vec<f64> = frame.features.iter().filter_map(shift).collect();
    (shifts.len() >= 10).then(|| shifts.iter().sum::<f64>() / shifts.len() as f64)
}
