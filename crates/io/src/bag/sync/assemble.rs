//! What all topics say at the time of a picture.

use nalgebra::Rotation3;
use visloc_core::{
    Frame, GroundContact, RgbImage, SourceFrame, Timestamp,
    geom::{Camera, CameraFrame, PlanarPose, Rigid3, Robot, angle},
};

use super::{SynchronizedFrame, Synchronizer};
use crate::bag::{EncodedImage, history::Lookup};

impl Synchronizer {
    /// Everything at the time of the picture, or why the picture cannot be used.
    pub(super) fn assemble(&mut self, image: &EncodedImage) -> Result<SynchronizedFrame, String> {
        let at = image.at;
        let camera = self.camera_at(at).ok_or_else(|| {
            format!("expected a calibration on '{}' before or with the image", self.topics.camera_info)
        })?;
        let (robot_from_camera, is_pose_held) = self.camera_pose_for(image)?;
        let pixels = image.decode()?;
        self.check_size(&pixels, &camera)?;
        let (odometry, is_between) = self.odometry_at(at);
        let frame = Frame {
            at,
            image: pixels,
            camera_index: 0,
            camera,
            robot_from_camera,
            odometry,
            ground_contact: self.ground_contact_at(at),
        };
        let truth = self.truth.nearest(at, 0.5 * self.interval_secs(at));
        let source_frame = SourceFrame { frame, truth };
        Ok(SynchronizedFrame {
            source_frame,
            has_held_values: is_pose_held || (self.expected.has_odometry && !is_between),
        })
    }

    /// The odometry at a time, and whether there are samples on both sides of it.
    fn odometry_at(&self, at: Timestamp) -> (Option<PlanarPose>, bool) {
        let on_the_way =
            |(a, b, fraction): (PlanarPose, PlanarPose, f64)| interpolate_planar(&a, &b, fraction);
        match self.odometry.lookup(at) {
            Some(Lookup::Between(a, b, fraction)) => (Some(on_the_way((a, b, fraction))), true),
            // Before there are two samples nothing tells a motion.
            Some(Lookup::Held(pose)) if self.odometry.is_beginning(at) => (Some(pose), false),
            _ => (self.odometry.beyond(at).map(on_the_way), false),
        }
    }

    /// Where the camera was on the robot, and whether that is the last known value instead of one interpolated.
    fn camera_pose_for(&self, image: &EncodedImage) -> Result<(Rigid3<Robot, CameraFrame>, bool), String> {
        if let Some(robot_from_camera) = self.given.robot_from_camera {
            return Ok((robot_from_camera, false));
        }
        let (base_frame, camera_frame) = (&self.base_frame, self.camera_frame_of(image));
        let pose = self.tree.lookup(base_frame, camera_frame, image.at).map_err(|reason| {
            match self.joints.explain(base_frame, camera_frame, &self.tree) {
                Some(more) => format!("{reason}; {more}"),
                None => reason,
            }
        })?;
        let (level, is_level_held) = match self.topics.imu.is_empty() {
            true => (Rotation3::identity(), false),
            false => self.level.level_from_base(base_frame, &self.tree, image.at)?,
        };
        let rotation: Rotation3<f64> = level * pose.dst_from_src.rotation.to_rotation_matrix();
        let translation = level * pose.dst_from_src.translation.vector;
        Ok((Rigid3::new(rotation, translation), pose.is_held || is_level_held))
    }

    fn camera_at(&self, at: Timestamp) -> Option<Camera> {
        self.given
            .camera
            .or_else(|| self.cameras.last_until(at))
            .or_else(|| self.cameras.nearest(at, f64::INFINITY))
    }

    fn check_size(&mut self, pixels: &RgbImage, camera: &Camera) -> Result<(), String> {
        let (width, height) = camera.size_px();
        if (pixels.width(), pixels.height()) == (width, height) {
            return Ok(());
        }
        self.num_wrong_size += 1;
        let (found_width, found_height) = (pixels.width(), pixels.height());
        Err(format!(
            "the calibration is for {width} x {height} px, the image has {found_width} x {found_height} px"
        ))
    }

    fn ground_contact_at(&self, at: Timestamp) -> Option<GroundContact> {
        let pressure = self.foot_pressure.last_until(at).map(GroundContact::Pressure);
        pressure.or_else(|| self.foot_contact.last_until(at).map(GroundContact::Contact))
    }
}

/// Straight line for the position, shortest turn for the heading.
fn interpolate_planar(a: &PlanarPose, b: &PlanarPose, fraction: f64) -> PlanarPose {
    let turn_rad = angle::difference(b.yaw_rad, a.yaw_rad);
    PlanarPose::new(
        a.x_m + fraction * (b.x_m - a.x_m),
        a.y_m + fraction * (b.y_m - a.y_m),
        a.yaw_rad + fraction * turn_rad,
    )
}
