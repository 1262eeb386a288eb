//! The camera is followed in the map.

use nalgebra::Matrix6;

use super::{FrontEnd, Keeping};
use crate::{
    config::TrackingConfig,
    frame_log::Seam,
    lie::CameraFromWorld,
    map::{KeyframeId, LandmarkId},
    mapping::KeyframeDecision,
    odometry::CameraMotion,
    outcome::{FrameOutcome, TrackingState},
    schedule::{FrameJob, Job},
    timing::StageTimer,
    track::{Frame, FrameWork, Incoming, Quality, TrackReport, focal_px},
};

/// Landmarks of a fixed map that show its place well, in units of the fewest from which a pose counts: as long as an image has as many,
/// nothing is added around it.
const ENOUGH_FIXED: usize = 5;

impl FrontEnd {
    pub(super) fn track(
        &mut self,
        incoming: &Incoming<'_>,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Option<Job> {
        let report = self.tracker.track(&self.map, incoming, &mut FrameWork { rng: &mut self.rng, timer });
        if let Some(report) = report.as_ref().filter(|report| self.judge_supposed(report)) {
            outcome.matches = (report.num_searched, report.num_matched);
            outcome.state = TrackingState::Lost;
            self.remember(incoming, None);
            return self.lose(incoming.at);
        }
        match report {
            Some(report) if report.quality != Quality::Bad => {
                self.num_bad = 0;
                if let Some(job) = self.look_elsewhere(incoming, &report, outcome, timer) {
                    return Some(job);
                }
                self.remember(incoming, report.covariance.filter(|_| self.supposed.is_none()));
                Some(self.accept(report, outcome, timer))
            }
            // In a fixed map the camera is looked for instead.
            Some(report)
                if self.keeping == Keeping::Growing
                    && let Some(moved) = self.tracker.moved(incoming) =>
            {
                self.num_bad = if self.contradicts(&report) { self.num_bad + 1 } else { 0 };
                if self.num_bad >= self.config.tracking.max_bad_frames
                    && let Some(job) = self.found_elsewhere(incoming, outcome, timer)
                {
                    return Some(job);
                }
                Some(self.carry(report, &moved, outcome, timer))
            }
            report => {
                if self.keeping == Keeping::Growing
                    && let Some(report) = &report
                    && let Some(job) = self.found_near(&report.local_map, incoming, outcome, timer)
                {
                    return Some(job);
                }
                outcome.matches = report.map_or((0, 0), |r| (r.num_searched, r.num_matched));
                outcome.state = TrackingState::Tracking(Quality::Bad);
                self.remember(incoming, None);
                self.num_bad += 1;
                // The camera may have been carried away: in a fixed map there is nothing that could be lost by looking elsewhere.
                if self.keeping != Keeping::Growing
                    && let Some(job) = self.found_elsewhere(incoming, outcome, timer)
                {
                    return Some(job);
                }
                if self.num_bad < self.config.tracking.max_bad_frames {
                    return None;
                }
                outcome.state = TrackingState::Lost;
                self.lose(incoming.at)
            }
        }
    }

    /// Whether a frame does not show what should be in view, enough of it for a good frame: somebody may have carried the camera away.
    /// An image that shows too little says nothing.
    fn contradicts(&self, report: &TrackReport) -> bool {
        let TrackingConfig { min_match_ratio, min_matches, .. } = self.config.tracking;
        report.num_searched as f64 * min_match_ratio >= min_matches as f64 && report.num_matched < min_matches
    }

    /// Lets odometry carry the pose of the last frame on, where the image tells too little. Mapping goes on: what comes into view is
    /// known soon.
    fn carry(
        &mut self,
        mut report: TrackReport,
        moved: &CameraMotion,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Job {
        let number = report.frame.number;
        if let Some(last) = self.tracker.last() {
            report.frame.camera_from_world = *moved * last.camera_from_world;
            report.expected_from_world = report.frame.camera_from_world;
        }
        report.frame.features.clear();
        (report.num_matched, report.num_converged) = (0, 0);
        let job = self.accept(report, outcome, timer);
        outcome.state = TrackingState::Carried;
        if let Some(frame) = self.frames.get_mut(number) {
            frame.is_carried = true;
        }
        job
    }

    /// Keeps an image, since the next map may know it, too.
    pub(super) fn remember(&mut self, incoming: &Incoming<'_>, covariance: Option<Matrix6<f64>>) {
        if self.keeping == Keeping::Growing {
            self.backfill.remember(incoming, covariance);
        }
    }

    /// The keyframe of the map that shows most of what was found in a frame, unless the one that the last frame hangs on shows half as much.
    fn keyframe_to_hang_on(&self, frame: &Frame) -> KeyframeId {
        let found: Vec<LandmarkId> = frame.features.iter().map(|feature| feature.landmark).collect();
        let map = self.map.map_of(self.hangs_on);
        let sharing = self.map.sharing(&found, 1);
        let Some((best, most)) = sharing.iter().find(|(id, _)| self.map.map_of(*id) == map) else {
            return self.hangs_on;
        };
        let stays = sharing.iter().any(|(id, shared)| *id == self.hangs_on && 2 * shared >= *most);
        if stays { self.hangs_on } else { *best }
    }

    /// Hangs a frame on a keyframe, to which the frames before go over. As long as the map does not fit what is seen, the frame may be found among other
    /// landmarks than those were: then they go over from where it was expected.
    pub(super) fn hang(&mut self, keyframe: KeyframeId, (frame, expected): (&Frame, &CameraFromWorld)) {
        let before = std::mem::replace(&mut self.hangs_on, keyframe);
        // Fixed ones never move beside each other.
        let stay = self.map.is_fixed(before) && self.map.is_fixed(keyframe);
        if keyframe != before && !stay && self.map.map_of(before) == self.map.map_of(keyframe) {
            let pose = if self.unsettled.is_some() { expected } else { &frame.camera_from_world };
            let place = (before, *pose * self.map.pose_of(before).inverse());
            self.frames.add_seam(Seam { number: frame.number, place, scale: self.map.scale_of(before) });
        }
        let place = (keyframe, frame.camera_from_world * self.map.pose_of(keyframe).inverse());
        self.place(frame.number, place, self.map.scale_of(keyframe));
    }

    /// Takes over a tracked frame and decides whether it should become a keyframe.
    pub(super) fn accept(
        &mut self,
        report: TrackReport,
        outcome: &mut FrameOutcome,
        timer: &mut StageTimer,
    ) -> Job {
        outcome.state = match self.supposed {
            Some(_) => TrackingState::Supposed,
            None => TrackingState::Tracking(report.quality),
        };
        outcome.camera_from_world = Some(report.frame.camera_from_world);
        outcome.covariance = report.covariance;
        outcome.map = Some(self.map.active());
        outcome.matches = (report.num_searched, report.num_matched);
        let is_converged = |id| self.map.landmark(id).is_converged();
        outcome.features = report.frame.features.iter().map(|f| (f.px, is_converged(f.landmark))).collect();
        let seen = report.frame.features.iter().copied();
        outcome.fixed = seen.filter(|seen| self.map.is_fixed_landmark(seen.landmark)).collect();
        let tried = report.tried.iter().copied().filter(|id| self.map.is_fixed_landmark(*id));
        outcome.fixed_tried = tried.collect();
        outcome.num_fixed_searched = report.num_fixed_searched;
        let shows_enough = self.keeping == Keeping::Extending
            && outcome.fixed.len() >= ENOUGH_FIXED * self.config.tracking.min_matches;
        let decision = if self.keeping == Keeping::Fixed || shows_enough || self.supposed.is_some() {
            report
                .local_map
                .keyframes
                .first()
                .map_or(KeyframeDecision::Stay, |id| KeyframeDecision::GoBackTo(*id))
        } else if self.awaits_keyframe {
            KeyframeDecision::Stay
        } else {
            self.rule.decide(&self.map, self.anchor, &report, focal_px(&self.camera))
        };
        if let KeyframeDecision::GoBackTo(earlier) = decision {
            self.anchor = earlier;
        }
        let makes_keyframe = decision == KeyframeDecision::Make;
        self.anchor_scale = self.map.scale_of(self.anchor);
        let anchor_from_world = self.map.pose_of(self.anchor);
        let keyframe = match decision {
            _ if self.unsettled.is_some() => self.keyframe_to_hang_on(&report.frame),
            KeyframeDecision::GoBackTo(earlier) => earlier,
            _ => self.hangs_on,
        };
        self.hang(keyframe, (&report.frame, &report.expected_from_world));
        self.remember_unsettled(&report.frame);
        self.tracker.accept(report.frame.clone());
        self.awaits_keyframe |= makes_keyframe;
        self.fill_back();
        timer.end("keyframe decision");
        let (anchor, anchor_scale) = (self.anchor, self.anchor_scale);
        // Only orders for keyframes are sure to be done.
        let crossings = if makes_keyframe { std::mem::take(&mut self.crossings) } else { Vec::new() };
        Job::Frame(Box::new(FrameJob {
            report,
            makes_keyframe,
            anchor,
            anchor_from_world,
            anchor_scale,
            crossings,
        }))
    }
}
