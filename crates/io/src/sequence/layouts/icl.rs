//! ICL-NUIM in its TUM-compatible form: `rgb/N.png` and `*.gt.freiburg`, maybe `associations.txt`; no times, 30 Hz.
//!
//! The true poses are those of the renderer, whose y axis points up, while the images are stored from top to bottom: each pose is
//! mirrored at the plane y = 0. With that, the camera is an ordinary one with fy = +480; the -480 of the dataset's page belongs
//! to the mirrored frame.
//!
//! Source: Handa et al., "A benchmark for RGB-D visual odometry, 3D reconstruction and SLAM", 2014, and its page.

use std::path::Path;

use nalgebra::{Matrix3, Rotation3, Vector3};
use visloc_core::{CameraPose, CameraTrajectory, files, geom::Rigid3};

use super::{Contents, Layout, file_ending, numbered::at_number};
use crate::{FileError, camera_trajectory::read_camera_trajectory, sequence::Calibration};

pub(super) const LAYOUT: Layout = Layout {
    key: "icl",
    name: "ICL-NUIM",
    mark: "rgb/0.png and *.gt.freiburg or associations.txt",
    is_here: |folder| {
        let is_marked = file_ending(folder, ".gt.freiburg").is_some()
            || (files::is_there(&folder.join("associations.txt"))
                && !files::is_there(&folder.join("rgb.txt")));
        is_marked && folder.join("rgb").is_dir()
    },
    read,
};

fn read(folder: &Path) -> Result<Contents, FileError> {
    let calibration =
        Calibration { size_px: Some((640, 480)), ..Calibration::pinhole((481.2, 480.0), (319.5, 239.5)) };
    let mut contents = Contents::numbered(folder, "rgb", calibration)?;
    if let Some(file) = file_ending(folder, ".gt.freiburg") {
        contents.set_truth(read_truth(&file));
    }
    Ok(contents)
}

/// Lines `NUMBER tx ty tz qx qy qz qw`.
fn read_truth(path: &Path) -> Result<CameraTrajectory, FileError> {
    let by_number = read_camera_trajectory(path)?;
    let mut truth = CameraTrajectory::new();
    let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
    for pose in by_number.poses() {
        let rotation = mirror * pose.world_from_camera.rotation() * mirror;
        let world_from_camera = Rigid3::new(
            Rotation3::from_matrix_unchecked(rotation),
            mirror * pose.world_from_camera.translation(),
        );
        // Numbers increase, so times do.
        let _ = truth.push(CameraPose { at: at_number(pose.at.secs()), world_from_camera });
    }
    Ok(truth)
}
