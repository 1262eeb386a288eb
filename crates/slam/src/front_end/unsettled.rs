//! Frames that were tracked while the whole map was being adjusted.

use super::FrontEnd;
use crate::{
    frame_log::Seam,
    lie::CameraFromWorld,
    odometry::CameraMotion,
    track::{Feature, Frame},
};

/// A frame that was tracked where two visits, or two maps, meet but do not fit each other yet. Its pose is right beside what was found in it,
/// which the keyframe that it hangs on may be moved away from.
#[derive(Debug)]
pub(super) struct Unsettled {
    number: usize,
    features: Vec<Feature>,
}

impl FrontEnd {
    /// Keeps what was found in a frame as long as the whole map is being adjusted.
    pub(super) fn remember_unsettled(&mut self, frame: &Frame) {
        // One that has only turned is where its keyframe is.
        if let Some(unsettled) = self.unsettled.as_mut().filter(|_| frame.turned_from.is_none()) {
            unsettled.push(Unsettled { number: frame.number, features: frame.features.clone() });
        }
    }

    /// The whole map was adjusted: the frames since that began are placed where they see what was found in them, and go over to each other as
    /// they moved.
    pub(super) fn settle(&mut self) {
        let unsettled = self.unsettled.take().unwrap_or_default();
        let Some(first) = unsettled.first().map(|first| first.number) else { return };
        let seams = self.frames.seams();
        let newer = seams.partition_point(|seam| seam.number < first)..seams.len();
        let steps: Vec<Option<CameraMotion>> = newer.clone().map(|seam| self.step_at(seam)).collect();
        for frame in &unsettled {
            self.place_again(frame);
        }
        for (index, step) in newer.zip(steps) {
            let Seam { number, place: (before, _), .. } = self.frames.seams()[index];
            if let (Some(step), Some(last)) = (step, self.pose_of_frame(number - 1)) {
                let place = (before, step * last * self.map.pose_of(before).inverse());
                self.frames.seams_mut()[index] = Seam { number, place, scale: self.map.scale_of(before) };
            }
        }
    }

    /// How the camera has moved up to the frame at a seam since the frame before.
    fn step_at(&self, index: usize) -> Option<CameraMotion> {
        let Seam { number, place, scale } = self.frames.seams()[index];
        Some(self.pose_on(&place, scale)? * self.pose_of_frame(number.checked_sub(1)?)?.inverse())
    }

    fn pose_of_frame(&self, number: usize) -> Option<CameraFromWorld> {
        self.camera_from_world(self.frames.get(number)?)
    }

    fn place_again(&mut self, Unsettled { number, features }: &Unsettled) {
        let Some((keyframe, _)) = self.frames.get(*number).and_then(|frame| frame.place) else { return };
        // Keyframes were moved by the adjustment.
        let Some(expected) =
            self.pose_of_frame(*number).filter(|_| self.map.keyframe(keyframe).frame != *number)
        else {
            return;
        };
        let pose = self.tracker.pose_again(&self.map, &expected, features, &mut self.rng);
        if let (Some(pose), Some(frame)) = (pose, self.frames.get_mut(*number)) {
            frame.place = Some((keyframe, pose * self.map.pose_of(keyframe).inverse()));
            frame.scale = self.map.scale_of(keyframe);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Matrix2, Point2, Rotation3, Vector3};
    use visloc_core::{GrayImage, Timestamp, geom::Camera};

    use super::*;
    use crate::{
        config::SlamConfig,
        image::Pyramid,
        map::{KeyframeId, LandmarkId, LandmarkState, Map, NewKeyframe, Observation},
        mapping::DepthFilter,
        outcome::FramePose,
    };

    fn at(x: f64) -> CameraFromWorld {
        CameraFromWorld::new(Rotation3::identity(), Vector3::new(-x, 0.0, 0.0))
    }

    fn add_keyframe(map: &mut Map, frame: usize, x: f64) -> KeyframeId {
        map.add_keyframe(NewKeyframe {
            frame,
            at: Timestamp::default(),
            pyramid: Arc::new(Pyramid::new(GrayImage::new(40, 30), 1)),
            camera_from_world: at(x),
            turned_from: None,
            odometry: None,
        })
    }

    /// A frame as an earlier visit sees it; the keyframe of the new visit is 0.3 off until the map has been adjusted.
    #[test]
    fn frames_are_where_they_see_what_was_found_once_the_map_is_adjusted() {
        let camera = Camera::pinhole((640, 480), (500.0, 500.0), (320.0, 240.0)).unwrap();
        let mut front_end = FrontEnd::new(&camera, &SlamConfig::default(), 1);
        let mut map = Map::new();
        let (old, new) = (add_keyframe(&mut map, 0, 2.0), add_keyframe(&mut map, 100, 1.3));
        let seen = |camera_from_world: &CameraFromWorld, map: &Map, landmark: LandmarkId| {
            let point = camera_from_world.transform(&map.landmark(landmark).point_in_world);
            Feature {
                landmark,
                px: Point2::origin(),
                ray: point.coords / point.z,
                level: 0,
                covariance_px: Matrix2::identity(),
            }
        };
        let ids: Vec<LandmarkId> = (0..80)
            .map(|i| {
                let ray = Vector3::new(f64::from(i % 10) * 0.1 - 0.5, f64::from(i / 10) * 0.1 - 0.4, 1.0);
                let (px, covariance_px) = (Point2::origin(), Matrix2::identity());
                let host = Observation { keyframe: old, px, ray, level: 0, covariance_px };
                let filter = DepthFilter::new(1.0 / (4.0 + f64::from(i % 7)), 1e-3);
                map.add_landmark(host, filter, LandmarkState::Converged)
            })
            .collect();
        front_end.map = map;
        let (first, second) = (at(1.1), at(1.2));
        (0..3).for_each(|i| front_end.frames.push(FramePose::unknown(Timestamp::from_nanos(i))));
        front_end.unsettled = Some(Vec::new());
        front_end.hangs_on = new;
        for (number, pose) in [(1, first), (2, second)] {
            let frame = Frame {
                number,
                at: Timestamp::from_nanos(number as i64),
                pyramid: Arc::new(Pyramid::new(GrayImage::new(40, 30), 1)),
                camera_from_world: pose,
                features: ids.iter().map(|id| seen(&pose, &front_end.map, *id)).collect(),
                turned_from: None,
                odometry: None,
                exposure: None,
            };
            let keyframe = if number == 1 { new } else { old };
            front_end.hang(keyframe, (&frame, &pose));
            front_end.remember_unsettled(&frame);
        }
        front_end.map.set_pose(new, at(1.0));
        let off_m = |front_end: &FrontEnd, number: usize, pose: &CameraFromWorld| {
            (front_end.pose_of_frame(number).unwrap().translation() - pose.translation()).norm()
        };
        assert!(off_m(&front_end, 1, &first) > 0.29, "it has followed the keyframe that it hangs on");
        front_end.settle();
        assert!(off_m(&front_end, 1, &first) < 1e-6 && off_m(&front_end, 2, &second) < 1e-6);
        let seam = front_end.frames.seams()[0];
        let expected = front_end.pose_on(&seam.place, seam.scale).unwrap();
        assert!((expected.translation() - second.translation()).norm() < 1e-6, "nothing is left to go over");
    }
}
