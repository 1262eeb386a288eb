//! From the map's frame to the one that is shown.
//!
//! One camera knows neither scale nor direction. With the truth the map is moved, turned and scaled onto it; without it, the map
//! is turned so that the first camera looks level.

use nalgebra::{Matrix3, Point3, Vector3};
use visloc_core::{
    CameraPose, CameraTrajectory, Timestamp,
    eval::camera::{Alignment, align, associate},
    geom::Similarity,
};
use visloc_slam::Slam;

/// The alignment is made anew after so many frames.
const ALIGN_EVERY: usize = 10;
/// Poses further apart in time are not compared, seconds.
const TOLERANCE_SECS: f64 = 0.01;

/// Takes points of the map to the frame that is shown.
#[derive(Debug)]
pub(super) struct Display {
    truth: Option<CameraTrajectory>,
    shown_from_map: Similarity,
    num_frames: usize,
    is_aligned: bool,
    /// Whether what is shown has the frame of a map that was there before.
    is_fixed: bool,
}

/// x to the right stays, z ahead becomes y, y down becomes -z.
fn upright() -> Similarity {
    let rotation = Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0);
    Similarity { rotation, ..Similarity::identity() }
}

impl Display {
    pub fn new(truth: Option<CameraTrajectory>) -> Self {
        Self { truth, shown_from_map: upright(), num_frames: 0, is_aligned: false, is_fixed: false }
    }

    /// In the frame of a map of an earlier session, which may have z up; the truth has the same frame.
    pub fn of_map(is_level: bool, truth: Option<CameraTrajectory>) -> Self {
        let shown_from_map = if is_level { Similarity::identity() } else { upright() };
        Self { truth, shown_from_map, num_frames: 0, is_aligned: is_level, is_fixed: true }
    }

    /// One more place of the truth, where it is told with the images. Times that do not increase are passed over.
    pub fn add_truth(&mut self, pose: CameraPose) {
        let _ = self.truth.get_or_insert_default().push(pose);
    }

    /// Another truth, of a camera that somebody carries elsewhere.
    pub fn set_truth(&mut self, truth: CameraTrajectory) {
        self.truth = Some(truth);
    }

    /// Takes in what has been found by now.
    pub fn follow(&mut self, slam: &Slam) {
        self.num_frames += 1;
        if self.is_fixed {
            return;
        }
        let is_due = self.num_frames.is_multiple_of(ALIGN_EVERY);
        let Some(truth) = self.truth.as_ref().filter(|_| is_due || !self.is_aligned) else { return };
        let mut estimate = CameraTrajectory::new();
        for pose in slam.trajectory() {
            let _ = estimate.push(CameraPose { at: pose.at, world_from_camera: pose.world_from_camera });
        }
        if let Some(found) = align(&associate(truth, &estimate, TOLERANCE_SECS), Alignment::Similarity) {
            (self.shown_from_map, self.is_aligned) = (found, true);
        }
    }

    /// Whether what is shown has the truth's scale.
    pub fn is_aligned(&self) -> bool {
        self.is_aligned
    }

    /// Shown length of a map unit.
    pub fn scale(&self) -> f64 {
        self.shown_from_map.scale
    }

    pub fn truth(&self) -> Option<&CameraTrajectory> {
        self.truth.as_ref()
    }

    pub fn truth_at(&self, at: Timestamp) -> Option<&CameraPose> {
        self.truth.as_ref()?.nearest(at, TOLERANCE_SECS)
    }

    pub fn point(&self, point_in_map: &Point3<f64>) -> Point3<f64> {
        self.shown_from_map.point(point_in_map)
    }

    pub fn direction(&self, direction_in_map: &Vector3<f64>) -> Vector3<f64> {
        self.shown_from_map.rotation * direction_in_map
    }
}
