//! Where the frames are in the map as it is now.

use visloc_core::geom::{CameraFrame, Rigid3, World};

use super::FrontEnd;
use crate::{
    frame_log::Seam,
    lie::{CameraFromWorld, exp, log},
    map::KeyframeId,
    outcome::{FramePose, TrajectoryPose},
};

impl FrontEnd {
    /// Poses of all frames that have one, with all corrections of the map so far. Frames follow their keyframes: what the next keyframe has been
    /// moved beside theirs goes over to it in the time between.
    pub fn trajectory(&self) -> Vec<TrajectoryPose> {
        let frames = self.frames.poses();
        let mut poses: Vec<Option<CameraFromWorld>> =
            frames.iter().map(|frame| self.camera_from_world(frame)).collect();
        for seam in self.frames.seams() {
            self.spread(seam, &mut poses);
        }
        let pose = |(frame, pose): (&FramePose, &Option<CameraFromWorld>)| {
            let world_from_camera = pose.as_ref()?.inverse();
            let map = self.map.map_of(frame.place?.0)?;
            let FramePose { at, is_filled_in, is_carried, .. } = *frame;
            Some(TrajectoryPose { at, world_from_camera, map, is_filled_in, is_carried })
        };
        frames.iter().zip(&poses).filter_map(pose).collect()
    }

    /// Lets the frames before a seam go over to the keyframe behind it.
    fn spread(&self, seam: &Seam, poses: &mut [Option<CameraFromWorld>]) {
        let frames = self.frames.poses();
        let Some(end) = seam.number.checked_sub(self.frames.len() - frames.len()) else { return };
        let hangs_on_it = |frame: &&FramePose| frame.place.is_some_and(|(id, _)| id == seam.place.0);
        let start = end - frames[..end].iter().rev().take_while(hangs_on_it).count();
        let map_behind = frames[end].place.and_then(|(id, _)| self.map.map_of(id));
        if map_behind.is_none() || map_behind != self.map.map_of(seam.place.0) {
            return;
        }
        let before = self.pose_on(&seam.place, seam.scale);
        let (Some(before), Some(behind)) = (before, self.camera_from_world(&frames[end])) else { return };
        let secs = |frame: &FramePose| frame.at.secs_since(frames[start].at);
        for (frame, pose) in frames[start..end].iter().zip(&mut poses[start..end]) {
            *pose = pose.map(|pose| gone_over(&pose, (&before, &behind), secs(frame) / secs(&frames[end])));
        }
    }

    pub(super) fn camera_from_world(&self, frame: &FramePose) -> Option<CameraFromWorld> {
        self.pose_on(frame.place.as_ref()?, frame.scale)
    }

    pub(super) fn pose_on(
        &self,
        (keyframe, camera_from_keyframe): &(KeyframeId, Rigid3<CameraFrame, CameraFrame>),
        scale: f64,
    ) -> Option<CameraFromWorld> {
        self.map.map_of(*keyframe)?;
        Some(self.map.pose_on(*keyframe, camera_from_keyframe, scale))
    }
}

/// A pose of which this share goes over from where its keyframe has the next seam to where the next keyframe has it.
fn gone_over(
    pose: &CameraFromWorld,
    (before, behind): (&CameraFromWorld, &CameraFromWorld),
    share: f64,
) -> CameraFromWorld {
    *pose * exp::<World>(&(log(&(before.inverse() * *behind)) * share))
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector6;

    use super::*;
    use crate::lie::moved;

    #[test]
    fn frames_go_over_from_one_keyframe_to_the_next() {
        // A camera that goes ten steps along x and turns; the keyframe behind has moved by 3 cm and 2 degrees beside the one before.
        let step = Vector6::new(-0.1, 0.0, 0.0, 0.0, 0.02, 0.0);
        let pose = |i: usize| moved(&(step * i as f64), &CameraFromWorld::identity());
        let behind = moved(&Vector6::new(0.0, 0.03, 0.0, 0.0, 0.0, 0.035), &pose(10));
        let off = |i: usize| {
            let now = gone_over(&pose(i), (&pose(10), &behind), i as f64 / 10.0);
            (now.inverse().translation() - pose(i).inverse().translation()).norm()
        };
        assert!(off(0) < 1e-12);
        assert!((1..10).all(|i| off(i) > off(i - 1)));
        let now = gone_over(&pose(10), (&pose(10), &behind), 1.0);
        assert!((now.translation() - behind.translation()).norm() < 1e-12);
        assert!((off(9) - 0.9 * 0.03).abs() < 0.005, "{}", off(9));
    }
}
