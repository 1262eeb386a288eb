//! A plain folder of images, or one with a folder `images`, `rgb`, `gray` or `data` of them, beside a calibration
//! (`camera.yaml`, `calibration.yaml`, `sensor.yaml`, `calib.txt` or `*_par.txt`) and maybe `groundtruth.txt` or `groundtruth.tum`.
//!
//! Names that are times become times: at least 16 digits are nanoseconds, a number with a dot seconds. Otherwise the images follow
//! each other in the order of their numbers, `fps` of the calibration a second, or 30.

use std::path::{Path, PathBuf};

use visloc_core::Timestamp;

use super::{
    Contents, Layout, file_ending, first_file,
    numbered::{has_images, image_files},
};
use crate::{
    FileError,
    camera_trajectory::read_camera_trajectory,
    sequence::ImageFile,
    text::{parse_nanos, parse_secs},
};

pub(super) const LAYOUT: Layout = Layout {
    key: "images",
    name: "folder of images",
    mark: "PNG or JPEG files",
    is_here: |folder| image_folder(folder).is_some(),
    read,
};

/// Images a second of a folder that does not say: what most cameras take.
const RATE_HZ: f64 = 30.0;

fn image_folder(folder: &Path) -> Option<PathBuf> {
    if has_images(folder) {
        return Some(folder.to_path_buf());
    }
    let names = ["images", "rgb", "gray", "data", "image_0"];
    names.iter().map(|name| folder.join(name)).find(|folder| has_images(folder))
}

fn read(folder: &Path) -> Result<Contents, FileError> {
    let mut contents = Contents { calibration_file: folder.join("camera.yaml"), ..Contents::default() };
    let names = ["camera.yaml", "calibration.yaml", "sensor.yaml", "calib.txt"];
    let calibration = first_file(folder, &names).or_else(|| file_ending(folder, "_par.txt"));
    if let Some(file) = calibration {
        contents.set_calibration(file);
    }
    let paths = image_files(&image_folder(folder).unwrap_or_else(|| folder.to_path_buf()))?;
    let rate_hz = contents.calibration.as_ref().and_then(|c| c.rate_hz).unwrap_or(RATE_HZ);
    let stamps: Option<Vec<Timestamp>> = paths.iter().map(|path| stamp(path)).collect();
    let mut images: Vec<ImageFile> = match stamps {
        Some(stamps) => stamps.into_iter().zip(paths).map(|(at, path)| ImageFile { at, path }).collect(),
        None => (0..)
            .zip(paths)
            .map(|(i, path)| ImageFile { at: Timestamp::from_secs(f64::from(i) / rate_hz), path })
            .collect(),
    };
    images.sort_by_key(|image| image.at);
    images.dedup_by_key(|image| image.at);
    contents.images = images;
    if let Some(file) = first_file(folder, &["groundtruth.txt", "groundtruth.tum"]) {
        contents.set_truth(read_camera_trajectory(&file));
    }
    Ok(contents)
}

/// The time in a name.
fn stamp(path: &Path) -> Option<Timestamp> {
    let stem = path.file_stem()?.to_string_lossy().into_owned();
    match stem.len() {
        16.. if !stem.contains('.') => parse_nanos(&stem).ok(),
        _ if stem.contains('.') => parse_secs(&stem).ok(),
        _ => None,
    }
}
