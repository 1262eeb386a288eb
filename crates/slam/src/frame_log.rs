//! The places of the frames so far, or of the newest ones.

use visloc_core::geom::{CameraFrame, Rigid3};

use crate::{
    map::{KeyframeId, push_tightly},
    outcome::FramePose,
};

/// Where frames begin to hang on another keyframe: the place of the first of them on the one before.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seam {
    /// Number of that frame.
    pub number: usize,
    /// The keyframe before, and the frame's pose relative to it.
    pub place: (KeyframeId, Rigid3<CameraFrame, CameraFrame>),
    /// Scale of that keyframe then.
    pub scale: f64,
}

/// Frames in order, by number. Memory is bounded if only the newest are to be remembered.
#[derive(Debug, Default)]
pub(crate) struct FrameLog {
    poses: Vec<FramePose>,
    /// In order.
    seams: Vec<Seam>,
    /// Number of the first frame that is remembered.
    first: usize,
    /// At least so many of the newest frames are remembered; `None` remembers all.
    least: Option<usize>,
}

impl FrameLog {
    pub fn remember(&mut self, least: usize) {
        self.least = Some(least.max(1));
    }

    pub fn push(&mut self, pose: FramePose) {
        push_tightly(&mut self.poses, pose);
        // The older half goes at once, so that a frame costs the same as without.
        if let Some(least) = self.least.filter(|least| self.poses.len() >= 2 * least) {
            let num_old = self.poses.len() - least;
            self.poses.drain(..num_old);
            self.first += num_old;
            self.seams.retain(|seam| seam.number >= self.first);
        }
    }

    /// The frames that are remembered.
    pub fn poses(&self) -> &[FramePose] {
        &self.poses
    }

    /// Notes where a frame is on another keyframe than the one that it hangs on from now on.
    pub fn add_seam(&mut self, seam: Seam) {
        push_tightly(&mut self.seams, seam);
    }

    pub fn seams(&self) -> &[Seam] {
        &self.seams
    }

    pub fn seams_mut(&mut self) -> &mut [Seam] {
        &mut self.seams
    }

    pub fn has_forgotten(&self) -> bool {
        self.first > 0
    }

    /// How many frames there were.
    pub fn len(&self) -> usize {
        self.first + self.poses.len()
    }

    pub fn get(&self, number: usize) -> Option<&FramePose> {
        self.poses.get(number.checked_sub(self.first)?)
    }

    pub fn get_mut(&mut self, number: usize) -> Option<&mut FramePose> {
        self.poses.get_mut(number.checked_sub(self.first)?)
    }

    /// Frames from this number on have no place any more.
    pub fn forget_places_from(&mut self, number: usize) {
        let newer = number.saturating_sub(self.first).min(self.poses.len());
        self.poses[newer..].iter_mut().for_each(|frame| frame.place = None);
        self.seams.retain(|seam| seam.number < number);
    }

    /// No frame has a place any more.
    pub fn forget_places(&mut self) {
        self.poses.iter_mut().for_each(|frame| frame.place = None);
        self.seams.clear();
    }
}

#[cfg(test)]
mod tests {
    use visloc_core::Timestamp;

    use super::*;

    #[test]
    fn the_newest_frames_keep_their_numbers() {
        let mut log = FrameLog::default();
        log.remember(100);
        for number in 0..1_000 {
            log.push(FramePose::unknown(Timestamp::from_nanos(number)));
            assert!(log.poses().len() < 200);
        }
        assert_eq!(log.len(), 1_000);
        assert!(log.has_forgotten() && log.get(0).is_none() && log.get(1_000).is_none());
        for number in 900..1_000 {
            assert_eq!(log.get(number).unwrap().at, Timestamp::from_nanos(number as i64));
        }
    }
}
