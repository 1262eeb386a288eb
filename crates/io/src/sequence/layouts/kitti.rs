//! KITTI odometry: `image_0/000000.png`, `times.txt`, `calib.txt`; the truth is `poses.txt` in the folder or `poses/NAME.txt` two
//! folders up, as the benchmark has it. A folder that has `rgb.txt` instead of `times.txt` belongs here too if it has
//! `poses.txt`.
//!
//! `calib.txt`: the first matrix, `P0`, is the left gray camera, whose poses the truth gives; the images are rectified. In `image_2`
//! and `image_3` are the color cameras, `P2` and `P3`, which are a few centimeters beside it.
//!
//! Source: Geiger et al., "Are we ready for autonomous driving? The KITTI vision benchmark suite", 2012, and its page.

use std::path::{Path, PathBuf};

use visloc_core::{CameraPose, CameraTrajectory, Timestamp, files};

use super::{Contents, Layout, first_file, numbered::image_files, tum};
use crate::{
    FileError,
    camera_trajectory::{parse_kitti, read_times},
    sequence::ImageFile,
    text::data_lines,
};

pub(super) const LAYOUT: Layout = Layout {
    key: "kitti",
    name: "KITTI odometry",
    mark: "calib.txt and image_0/",
    is_here: |folder| {
        files::is_there(&folder.join("calib.txt"))
            && (image_folder(folder).is_some() || files::is_there(&folder.join("poses.txt")))
    },
    read,
};

/// Images that KITTI takes in a second, if the times are not there.
const RATE_HZ: f64 = 10.0;

fn image_folder(folder: &Path) -> Option<PathBuf> {
    ["image_0", "image_l", "image_2"].iter().map(|name| folder.join(name)).find(|path| path.is_dir())
}

fn read(folder: &Path) -> Result<Contents, FileError> {
    let mut contents = if files::is_there(&folder.join("rgb.txt")) {
        (tum::LAYOUT.read)(folder)?
    } else {
        read_images(folder)?
    };
    contents.set_calibration(folder.join("calib.txt"));
    if contents.truth.is_none()
        && let Some(file) = truth_file(folder)
    {
        let stamps: Vec<Timestamp> = contents.images.iter().map(|image| image.at).collect();
        contents.set_truth(read_truth(&file, &stamps));
    }
    Ok(contents)
}

fn read_images(folder: &Path) -> Result<Contents, FileError> {
    let mut contents = Contents::default();
    let images = image_folder(folder)
        .ok_or_else(|| FileError::form(folder, "expected a folder image_0, found none"))?;
    let paths = image_files(&images)?;
    let times = folder.join("times.txt");
    let stamps = if files::is_there(&times) {
        read_times(&times)?
    } else {
        contents.warnings.push(format!("{}: not found; {RATE_HZ} images a second assumed", times.display()));
        (0..paths.len()).map(|i| Timestamp::from_secs(i as f64 / RATE_HZ)).collect()
    };
    if stamps.len() != paths.len() {
        contents.warnings.push(format!(
            "{}: expected a time for each of {} images, found {}",
            times.display(),
            paths.len(),
            stamps.len()
        ));
    }
    contents.images = stamps.into_iter().zip(paths).map(|(at, path)| ImageFile { at, path }).collect();
    Ok(contents)
}

/// `poses.txt`, or `../../poses/06.txt` of `sequences/06`.
fn truth_file(folder: &Path) -> Option<PathBuf> {
    if let Some(file) = first_file(folder, &["poses.txt"]) {
        return Some(file);
    }
    let folder = folder.canonicalize().ok()?;
    let name = folder.file_name()?.to_string_lossy().into_owned();
    first_file(folder.parent()?.parent()?, &[&format!("poses/{name}.txt")])
}

/// A pose for each image, in their order.
fn read_truth(path: &Path, stamps: &[Timestamp]) -> Result<CameraTrajectory, FileError> {
    let text = files::read_text(path).map_err(FileError::io(path))?;
    let mut truth = CameraTrajectory::new();
    for ((number, line), at) in data_lines(&text).zip(stamps) {
        let world_from_camera = parse_kitti(line).map_err(FileError::line(path, number))?;
        let _ = truth.push(CameraPose { at: *at, world_from_camera });
    }
    Ok(truth)
}
