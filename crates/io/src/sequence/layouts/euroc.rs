//! EuRoC MAV in the ASL layout: `mav0/cam0/data.csv`, `mav0/cam0/data/NANOSECONDS.png`, `mav0/cam0/sensor.yaml`. The folder may be
//! the sequence, its `mav0` or the parent of `cam0`; without `data.csv` the times are the names of the images.
//!
//! The truth is that of the body: `state_groundtruth_estimate0/data.csv` (or `groundtruth_body.tum`), which becomes the camera's with
//! `T_BS` of `sensor.yaml`.
//!
//! Source: Burri et al., "The EuRoC micro aerial vehicle datasets", 2016.

use std::path::{Path, PathBuf};

use visloc_core::{
    CameraPose, CameraTrajectory, files,
    geom::{CameraFrame, Rigid3},
};

use super::{
    Contents, Layout, first_file,
    list::{Parsed, read_list},
    numbered::image_files,
};
use crate::{FileError, camera_trajectory::read_camera_trajectory, sequence::ImageFile, text::parse_nanos};

pub(super) const LAYOUT: Layout = Layout {
    key: "euroc",
    name: "EuRoC (ASL)",
    mark: "mav0/cam0/sensor.yaml",
    is_here: |folder| camera_folder(folder).is_some(),
    read,
};

fn camera_folder(folder: &Path) -> Option<PathBuf> {
    let candidates = [folder.join("mav0/cam0"), folder.join("cam0")];
    candidates
        .into_iter()
        .find(|cam0| files::is_there(&cam0.join("sensor.yaml")) && cam0.join("data").is_dir())
}

fn read(folder: &Path) -> Result<Contents, FileError> {
    let cam0 = camera_folder(folder).unwrap_or_else(|| folder.join("mav0/cam0"));
    let mut contents = Contents::default();
    contents.set_calibration(cam0.join("sensor.yaml"));
    let images = cam0.join("data");
    let list = cam0.join("data.csv");
    if files::is_there(&list) {
        read_list(&list, &images, parse_line, &mut contents)?;
    } else {
        for path in image_files(&images)? {
            let stamp = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
            let at = parse_nanos(&stamp).map_err(|reason| FileError::form(&path, reason))?;
            contents.images.push(ImageFile { at, path });
        }
    }
    let root = cam0.parent().unwrap_or(folder);
    let names = ["state_groundtruth_estimate0/data.csv", "groundtruth_body.tum", "../groundtruth_body.tum"];
    if let Some(file) = first_file(root, &names) {
        let body_from_camera = contents.calibration.as_ref().and_then(|c| c.body_from_camera);
        contents.set_truth(read_truth(&file, &body_from_camera.unwrap_or_default()));
    }
    Ok(contents)
}

fn parse_line(line: &str) -> Parsed<'_> {
    let (stamp, name) =
        line.split_once(',').ok_or_else(|| format!("expected 'NANOSECONDS,FILE', found '{line}'"))?;
    Ok((parse_nanos(stamp.trim())?, name.trim()))
}

/// The body's trajectory as that of the camera.
fn read_truth(
    path: &Path,
    body_from_camera: &Rigid3<CameraFrame, CameraFrame>,
) -> Result<CameraTrajectory, FileError> {
    let body = read_camera_trajectory(path)?;
    let mut truth = CameraTrajectory::new();
    for pose in body.poses() {
        let world_from_camera = pose.world_from_camera * *body_from_camera;
        let _ = truth.push(CameraPose { world_from_camera, ..*pose });
    }
    Ok(truth)
}
