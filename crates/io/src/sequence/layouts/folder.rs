//! A plain folder of images, or one with a folder `images`, `rgb`, `gray` or `data` of them, beside a calibration
//! (`camera.yaml`, `calibration.yaml`, `sensor.yaml`, `calib.txt` or `*_par.txt`) and maybe `groundtruth.txt` or `groundtruth.tum`.
//!
//! Names that are times become times: a number with a dot is seconds; at least 13 digits are nanoseconds, or micro- or milliseconds if there
//! were more than a thousand images a second else. Otherwise the images follow each other in the order of the numbers in their names, `fps` of the calibration a second, or 30.

use std::{
    path::{Path, PathBuf},
    time::Duration,
};

use visloc_core::Timestamp;

use super::{
    Contents, Layout, file_ending, first_file,
    numbered::{has_images, image_files},
};
use crate::{FileError, camera_trajectory::read_camera_trajectory, sequence::ImageFile, text::parse_secs};

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
    let stamps = in_seconds(&paths).or_else(|| in_parts_of_a_second(&paths));
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

/// The times in the names, if all are numbers with a dot.
fn in_seconds(paths: &[PathBuf]) -> Option<Vec<Timestamp>> {
    paths
        .iter()
        .map(|path| stem(path).filter(|stem| stem.contains('.')))
        .map(|stem| parse_secs(&stem?).ok())
        .collect()
}

/// The times in the names, if all are long whole numbers.
fn in_parts_of_a_second(paths: &[PathBuf]) -> Option<Vec<Timestamp>> {
    /// Digits from which on a number is no count of images: milliseconds since 1970 have as many.
    const LEAST_DIGITS: usize = 13;
    /// No camera takes the next image sooner.
    const LEAST_STEP: Duration = Duration::from_millis(1);
    let number = |path: &PathBuf| stem(path).filter(|stem| stem.len() >= LEAST_DIGITS)?.parse::<i64>().ok();
    let numbers: Vec<i64> = paths.iter().map(number).collect::<Option<_>>()?;
    let mut sorted = numbers.clone();
    sorted.sort_unstable();
    let mut steps: Vec<i64> = sorted.windows(2).map(|pair| pair[1].saturating_sub(pair[0])).collect();
    steps.sort_unstable();
    let step = steps.get(steps.len() / 2).copied().unwrap_or_default();
    let is_possible = |nanos: &i64| {
        step.checked_mul(*nanos).is_none_or(|step| i128::from(step) >= LEAST_STEP.as_nanos() as i128)
    };
    let nanos = [1, 1_000, 1_000_000].into_iter().find(is_possible).unwrap_or(1);
    numbers.into_iter().map(|number| number.checked_mul(nanos).map(Timestamp::from_nanos)).collect()
}

fn stem(path: &Path) -> Option<String> {
    Some(path.file_stem()?.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_numbers_are_times_in_the_unit_that_a_camera_can_have() {
        let steps = [
            (1_403_636_579_763_555_584, 50_000_000),
            (1_403_636_579_763_555, 50_000),
            (1_403_636_579_763, 50),
        ];
        // The last one since the computer was started.
        let since_start = (5_000_000_000_000_i64, 50_000_000);
        for (first, step) in steps.into_iter().chain([since_start]) {
            let paths: Vec<PathBuf> = (0..4).map(|i| format!("{}.jpg", first + i * step).into()).collect();
            let stamps = in_parts_of_a_second(&paths).unwrap();
            assert!((stamps[3].secs_since(stamps[0]) - 0.15).abs() < 1e-9, "{first}");
        }
        assert_eq!(in_parts_of_a_second(&["000123.png".into(), "000124.png".into()]), None);
        let seconds = in_seconds(&["17.25.png".into(), "17.5.png".into()]).unwrap();
        assert_eq!(seconds[1].secs_since(seconds[0]), 0.25);
    }
}
