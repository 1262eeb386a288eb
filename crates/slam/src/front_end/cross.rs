//! Where the map that was started last lies to the one in which the camera was lost.

use nalgebra::{Matrix6, Vector6};
use visloc_core::geom::{CameraFrame, Rigid3};

use super::FrontEnd;
use crate::{
    backfill::{Found, MOTION_FRAMES},
    lie::{CameraFromWorld, exp, log},
    map::{Crossing, KeyframeId, Standing},
};

/// Longest time without a pose over which the camera is taken to go on as before, seconds: whoever walks does not stop within it.
const MOST_GAP_SECS: f64 = 0.2;
/// Standard deviation of what it does in that time, share of the way and of the turn: within half a step and half a turn of the head.
const MOTION_SHARE: f64 = 0.2;
/// Standard deviations of a frame at the end of a map, in units of those that its landmarks say: landmarks that were made last, in a quick
/// turn, are off together, and so are the up to fifteen frames of one loss, which count one by one. On a rendered walk with such a turn frames were 1 to 4 cm and 0.4 to 1.9 degrees off, where the covariances said 3 mm
/// and 0.2 degrees.
const END_OF_MAP: f64 = 10.0;

impl FrontEnd {
    /// A frame that was followed back from the new map and was tracked in an earlier one.
    pub(super) fn crossing_at(&self, found: &Found) -> Option<Crossing> {
        let frame = self.frames.get(found.number)?;
        let (keyframe, camera_from_keyframe) = frame.place?;
        let is_other = self.map.map_of(keyframe)? != self.map.active();
        let covariance = at_end_of_map(&found.covariance_before?);
        let before = Standing { keyframe, camera_from_keyframe, scale: frame.scale, covariance };
        let covariance = at_end_of_map(&found.covariance?);
        let after = self.standing((found.keyframe, found.camera_from_keyframe), covariance);
        is_other.then_some(Crossing { before, after })
    }

    /// The moment between the last frame that was tracked in an earlier map and the first that the new one knows: from both sides the
    /// camera is taken to have moved on as it did there, in the unit of either map.
    pub(super) fn crossing_between(
        &self,
        (number, covariance): (usize, Matrix6<f64>),
        followed: &[Found],
    ) -> Option<Crossing> {
        let (next, first) = (followed.first()?, followed.last()?);
        let last = self.frames.get(number)?;
        let earlier = self.frames.get(number.checked_sub(MOTION_FRAMES)?)?;
        let (keyframe, _) = last.place?;
        let of_map = self.map.map_of(keyframe).filter(|map| *map != self.map.active())?;
        let is_same = earlier.place.is_some_and(|(keyframe, _)| self.map.map_of(keyframe) == Some(of_map));
        let gap_secs = first.at.secs_since(last.at);
        if !is_same || followed.len() <= MOTION_FRAMES || gap_secs > MOST_GAP_SECS {
            return None;
        }
        let pose = self.camera_from_world(last)?;
        let motion = pose * self.camera_from_world(earlier)?.inverse();
        let share = 0.5 * gap_secs / last.at.secs_since(earlier.at);
        let before = self.moved_on(&pose, keyframe, (&motion, share), covariance);
        let back = first.camera_from_keyframe * next.camera_from_keyframe.inverse();
        let share = 0.5 * gap_secs / next.at.secs_since(first.at);
        let pose = first.camera_from_keyframe * self.map.pose_of(first.keyframe);
        let after = self.moved_on(&pose, first.keyframe, (&back, share), first.covariance?);
        Some(Crossing { before, after })
    }

    /// Where a camera is after a share of a motion that it has just made.
    fn moved_on(
        &self,
        pose: &CameraFromWorld,
        keyframe: KeyframeId,
        (motion, share): (&Rigid3<CameraFrame, CameraFrame>, f64),
        covariance: Matrix6<f64>,
    ) -> Standing {
        let twist: Vector6<f64> = log(motion) * share;
        let [way, turn] = [0, 3].map(|first| MOTION_SHARE * twist.fixed_rows::<3>(first).norm());
        let unsure = Vector6::from_fn(|i, _| if i < 3 { way * way } else { turn * turn });
        let camera_from_keyframe = exp(&twist) * *pose * self.map.pose_of(keyframe).inverse();
        let covariance = at_end_of_map(&covariance) + Matrix6::from_diagonal(&unsure);
        self.standing((keyframe, camera_from_keyframe), covariance)
    }

    fn standing(
        &self,
        (keyframe, camera_from_keyframe): (KeyframeId, Rigid3<CameraFrame, CameraFrame>),
        covariance: Matrix6<f64>,
    ) -> Standing {
        Standing { keyframe, camera_from_keyframe, scale: self.map.scale_of(keyframe), covariance }
    }
}

fn at_end_of_map(covariance: &Matrix6<f64>) -> Matrix6<f64> {
    covariance * (END_OF_MAP * END_OF_MAP)
}
