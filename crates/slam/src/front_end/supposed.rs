//! A place where a lost camera was found, but of which more is missed than seen: a thing that is there twice, such as a door, looks the
//! same.

use super::FrontEnd;
use crate::{
    atlas::IN_A_ROW,
    lie::CameraFromWorld,
    map::{Keyframe, KeyframeId},
    recognize::Located,
    track::{Frame, Quality, TrackReport, focal_px, scene_depth},
};

/// Where the camera is supposed to be. Its frames have a pose there, but the map does not learn from them: at a wrong place it would bend.
#[derive(Debug)]
pub(super) struct Supposed {
    /// Number of the first frame there.
    first: usize,
    num_looks: usize,
    /// The pose at the last look.
    looked_from: CameraFromWorld,
    /// The last frame before the camera was lost, and the keyframe that covered its view.
    last: Option<Frame>,
    anchor: KeyframeId,
}

impl FrontEnd {
    /// Whether a lost camera is sure to be where it was found. As for loops and maps that meet, the way tells, or the place shows most of
    /// what is there.
    pub(super) fn is_told_by_way_or_view(&self, located: &Located) -> bool {
        located.report.is_mostly_found() || self.may_have_come_to(located)
    }

    /// Whether the way to where the camera was found is none that it was too slow for, by the fastest that it has been in that map.
    fn may_have_come_to(&self, located: &Located) -> bool {
        let is_same_map = self.map.keyframe(located.keyframe).map == self.map.active();
        // With odometry a camera is only lost if somebody has carried it away.
        let last = self.tracker.last().filter(|last| is_same_map && last.odometry.is_none());
        let Some(last) = last else { return false };
        let found = &located.report.frame;
        let center = |frame: &Frame| *frame.camera_from_world.inverse().translation();
        (center(found) - center(last)).norm() <= self.fastest() * found.at.secs_since(last.at)
    }

    /// The fastest that the camera has been from one keyframe of its map to the next, map units per second.
    fn fastest(&self) -> f64 {
        let speed = |before: &Keyframe, next: &Keyframe| {
            let way = next.center_in_world() - before.center_in_world();
            way.norm() / next.at.secs_since(before.at)
        };
        let keyframes = self.map.keyframes().map(|(_, keyframe)| keyframe);
        let next = self.map.keyframes().map(|(_, keyframe)| keyframe).skip(1);
        keyframes.zip(next).map(|(before, next)| speed(before, next)).fold(0.0, f64::max)
    }

    /// The place where a lost camera was found is only supposed.
    pub(super) fn suppose(&mut self, report: &TrackReport) {
        self.refute();
        self.is_refuted = false;
        self.supposed = Some(Supposed {
            first: report.frame.number,
            num_looks: 1,
            looked_from: report.frame.camera_from_world,
            last: self.tracker.last().cloned(),
            anchor: self.anchor,
        });
    }

    /// The place where the camera is followed is sure.
    pub(super) fn be_sure(&mut self) {
        self.supposed = None;
        self.is_refuted = false;
        self.backfill.forget_recent();
    }

    /// Judges by another frame the place where the camera is only supposed to be: from now on it may be sure. Says whether it is to be given up,
    /// since the camera has gone on and still misses more of it than it sees.
    pub(super) fn judge_supposed(&mut self, report: &TrackReport) -> bool {
        if self.supposed.is_some() && report.quality == Quality::Good && report.is_mostly_found() {
            self.be_sure();
        }
        let Some(supposed) = &mut self.supposed else { return false };
        let here = report.frame.camera_from_world;
        let before = (&supposed.looked_from, scene_depth(&self.map, &report.frame));
        if self.rule.looks_elsewhere(before, &here, focal_px(&self.camera)) {
            supposed.looked_from = here;
            supposed.num_looks += 1;
        }
        supposed.num_looks > IN_A_ROW
    }

    /// The camera is lost again. If its place was only supposed, it was never there, and all is as before; says whether that is so.
    pub(super) fn refute(&mut self) -> bool {
        let Some(Supposed { first, last, anchor, .. }) = self.supposed.take() else { return false };
        self.is_refuted = true;
        self.frames.forget_places_from(first);
        self.tracker.forget();
        if let Some(mut last) = last {
            let pose = self.frames.get(last.number).and_then(|frame| self.camera_from_world(frame));
            last.camera_from_world = pose.unwrap_or(last.camera_from_world);
            self.tracker.restart_from(last);
        }
        (self.anchor, self.hangs_on) = (anchor, anchor);
        self.activate_anchor();
        true
    }
}
