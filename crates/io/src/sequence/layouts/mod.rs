//! The layouts of datasets. A new one is a file here and a line in [`LAYOUTS`].

mod euroc;
mod folder;
mod icl;
mod kitti;
mod list;
mod numbered;
mod tum;
mod zurich;

use std::path::{Path, PathBuf};

pub use numbered::{image_files, instead_of_images, is_image};
use visloc_core::{CameraTrajectory, SkippedInput, files};

use super::{Calibration, ImageFile};
use crate::FileError;

/// What a dataset's folder says.
#[derive(Debug, Default)]
pub(super) struct Contents {
    /// The camera, if the dataset says it.
    pub calibration: Option<Calibration>,
    /// Why the dataset's calibration cannot be used.
    pub calibration_error: Option<FileError>,
    /// Where the calibration is or was looked for.
    pub calibration_file: PathBuf,
    /// Images in order of time; stamps strictly increase.
    pub images: Vec<ImageFile>,
    /// Lines of lists that cannot be used.
    pub skipped: Vec<SkippedInput>,
    /// True poses of the camera.
    pub truth: Option<CameraTrajectory>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

impl Contents {
    /// Of a dataset without times: its images by their numbers, and its camera unless a file says another one.
    fn numbered(folder: &Path, images: &str, calibration: Calibration) -> Result<Self, FileError> {
        let mut contents = Self { calibration: Some(calibration), ..Self::default() };
        if let Some(file) = first_file(folder, &["camera.yaml", "calibration.yaml"]) {
            contents.set_calibration(file);
        }
        for path in numbered::image_files(&folder.join(images))? {
            if let Some(number) = numbered::number_in(&path) {
                contents.images.push(ImageFile { at: numbered::at_number(number as f64), path });
            }
        }
        contents.images.dedup_by_key(|image| image.at);
        Ok(contents)
    }

    /// Takes over a truth; one that cannot be read is a warning, since the images can be used without it.
    fn set_truth(&mut self, truth: Result<CameraTrajectory, FileError>) {
        match truth {
            Ok(truth) => self.truth = Some(truth),
            Err(error) => self.warnings.push(format!("the truth is not used: {error}")),
        }
    }

    /// Takes over the calibration of a file; one that cannot be read matters only if the user gives no other.
    fn set_calibration(&mut self, file: PathBuf) {
        match super::read_calibration(&file) {
            Ok(calibration) => self.calibration = Some(calibration),
            Err(error) => self.calibration_error = Some(error),
        }
        self.calibration_file = file;
    }
}

/// One layout.
pub(super) struct Layout {
    /// For commands, a word.
    pub key: &'static str,
    /// For people.
    pub name: &'static str,
    /// What marks it, for people.
    pub mark: &'static str,
    /// Whether a folder has it.
    pub is_here: fn(&Path) -> bool,
    /// Reads lists, calibration and truth, but no images.
    pub read: fn(&Path) -> Result<Contents, FileError>,
}

/// All layouts, in the order in which they are tried.
pub(super) static LAYOUTS: &[Layout] =
    &[euroc::LAYOUT, icl::LAYOUT, zurich::LAYOUT, kitti::LAYOUT, tum::LAYOUT, folder::LAYOUT];

/// The first of some files that exists.
fn first_file(folder: &Path, names: &[&str]) -> Option<PathBuf> {
    names.iter().map(|name| folder.join(name)).find(|path| files::is_there(path))
}

/// The first file of a folder, in alphabetical order, whose name ends so.
fn file_ending(folder: &Path, ending: &str) -> Option<PathBuf> {
    let entries = std::fs::read_dir(folder).ok()?;
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    paths.filter(|path| path.to_string_lossy().ends_with(ending)).min()
}
