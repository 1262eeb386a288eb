//! What the mapper has changed is taken over.

use visloc_core::geom::{Camera, CameraFrame, Rigid3};

use super::{FrontEnd, Phase};
use crate::{
    frame_log::Seam,
    lie::CameraFromWorld,
    map::{KeyframeId, Map},
    outcome::{FramePose, Mapped},
    schedule::Update,
};

impl FrontEnd {
    /// Takes over what the mapper has finished. What belongs to a map that was given up is left out.
    pub fn apply(&mut self, update: Update) -> Option<Mapped> {
        self.set_camera(&update.camera);
        self.readout = update.readout;
        if update.epoch != self.epoch {
            return None;
        }
        let made = update.mapped.report.keyframe;
        if let Some(keyframe) = made {
            self.rehang(update.mapped.frame, keyframe, &update.camera_from_world);
            (self.anchor, self.hangs_on) = (keyframe, keyframe);
            self.rule.keyframe_made();
        }
        let scale_before = if made.is_some() { 1.0 } else { self.anchor_scale };
        self.map = update.map;
        if self.phase == Phase::Tracking {
            self.activate_anchor();
            self.anchor_scale = self.map.scale_of(self.anchor);
            self.tracker.scale_motion(self.anchor_scale / scale_before);
        }
        if update.was_awaited {
            self.awaits_keyframe = false;
        }
        if update.has_moved && !update.was_awaited {
            self.settle();
        }
        self.unsettled = update.is_adjusting.then(|| self.unsettled.take().unwrap_or_default());
        if update.has_moved {
            let first = update.mapped.frame.saturating_add(usize::from(update.was_awaited));
            self.correct_last(first, made);
        }
        Some(update.mapped)
    }

    /// Goes on in the map of the keyframe that frames hang on.
    pub(super) fn activate_anchor(&mut self) {
        if let Some(map) = self.map.map_of(self.anchor) {
            self.map.activate(map);
        }
    }

    /// Gives the map out of hand, so that the mapper need not copy what it changes.
    pub fn release_map(&mut self) {
        self.map = Map::new();
    }

    /// Takes over a camera that is known better.
    fn set_camera(&mut self, camera: &Camera) {
        if *camera != self.camera {
            self.camera = *camera;
            self.tracker.set_camera(camera);
            self.relocator.set_camera(camera);
            self.initializer.set_camera(camera);
            self.backfill.set_camera(camera);
        }
    }

    /// Hangs a frame that has become a keyframe on itself, and the frames tracked since then on it, too.
    fn rehang(&mut self, number: usize, keyframe: KeyframeId, camera_from_world: &CameraFromWorld) {
        if let Some(FramePose { place: Some(place), scale, .. }) = self.frames.get(number).copied() {
            self.frames.add_seam(Seam { number, place, scale });
        }
        // The keyframe has just been made: its scale is 1.
        self.anchor_scale = 1.0;
        let world_from_keyframe = camera_from_world.inverse();
        for later in number + 1..self.frames.len() {
            if let Some(pose) = self.frames.get(later).and_then(|frame| self.camera_from_world(frame)) {
                self.place(later, (keyframe, pose * world_from_keyframe), 1.0);
            }
        }
        self.place(number, (keyframe, Rigid3::identity()), 1.0);
    }

    /// Notes where a frame is, if it is still remembered.
    pub(super) fn place(
        &mut self,
        number: usize,
        place: (KeyframeId, Rigid3<CameraFrame, CameraFrame>),
        scale: f64,
    ) {
        if let Some(frame) = self.frames.get_mut(number) {
            frame.place = Some(place);
            frame.scale = scale;
            frame.is_carried = false;
        }
    }

    /// Takes over the pose of the last frame, from this number on, from the changed map. The very frame that a map was started with keeps its pose:
    /// its landmarks have hardly moved with it.
    fn correct_last(&mut self, first: usize, made: Option<KeyframeId>) {
        let Some(last) = self.tracker.last().map(|last| last.number) else { return };
        let later = self.frames.get(last).filter(|_| last >= first);
        let pose = later.and_then(|frame| self.camera_from_world(frame));
        let pose =
            pose.or_else(|| made.filter(|_| last + 1 == first).map(|keyframe| self.map.pose_of(keyframe)));
        if let Some(pose) = pose {
            self.tracker.correct_last(pose);
        }
    }
}
