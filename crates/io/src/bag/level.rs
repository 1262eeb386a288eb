//! Where up is, by an IMU, for robots whose trunk tilts against the ground.

use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};
use visloc_core::Timestamp;

use crate::bag::{
    history::{History, Lookup, MAX_AGE_SECS, Pushed},
    tf_tree::TfTree,
};

/// What an IMU says of the vertical.
#[derive(Debug, Clone, Default)]
pub(super) struct Level {
    /// Up, in the frame of the IMU.
    ups: History<Vector3<f64>>,
    imu_frame: String,
}

impl Level {
    /// Takes in the orientation of an IMU in a frame whose z points up.
    pub(super) fn push(
        &mut self,
        at: Timestamp,
        imu_frame: &str,
        world_from_imu: &UnitQuaternion<f64>,
    ) -> Pushed {
        if self.imu_frame != imu_frame {
            *self = Self { ups: History::default(), imu_frame: imu_frame.to_owned() };
        }
        self.ups.push(at, world_from_imu.inverse() * Vector3::z())
    }

    pub(super) fn newest_at(&self) -> Option<Timestamp> {
        self.ups.newest_at()
    }

    pub(super) fn forget_before(&mut self, at: Timestamp) {
        self.ups.forget_before(at);
    }

    /// The shortest turn that levels the robot's frame on the ground at a time, and whether that is from the last known value; or why it is
    /// not known.
    pub(super) fn level_from_base(
        &self,
        base_frame: &str,
        tree: &TfTree,
        at: Timestamp,
    ) -> Result<(Rotation3<f64>, bool), String> {
        let (up_in_imu, is_held) = match self.ups.lookup(at) {
            Some(Lookup::Between(a, b, fraction)) => (a.lerp(&b, fraction), false),
            Some(Lookup::Held(up)) => (up, true),
            None => {
                return Err(format!("expected a message of the IMU within {MAX_AGE_SECS} s, found none"));
            }
        };
        let imu_frame = &self.imu_frame;
        let is_known = imu_frame == base_frame || tree.has_parent(imu_frame) || tree.has_children(imu_frame);
        if !is_known {
            return Err(format!(
                "expected a transform to the frame of the IMU, '{imu_frame}', found none: publish it (it never changes), or have the IMU \
                 name a frame of the robot"
            ));
        }
        let pose = tree.lookup(base_frame, imu_frame, at)?;
        let up = Unit::new_normalize(pose.dst_from_src.rotation * up_in_imu);
        let level = Rotation3::rotation_between(&up, &Vector3::z_axis());
        let level = level.ok_or_else(|| "expected a robot that stands, found one on its head".to_owned())?;
        Ok((level, is_held || pose.is_held))
    }
}
