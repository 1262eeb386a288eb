//! Where the images of a run come from.

use std::path::Path;

use visloc_core::{CameraTrajectory, ImageSource, files};
use visloc_io::sequence::{Bound, Sequence, SequenceOptions, SequenceRange, open_sequence};
use visloc_sim::CameraTour;

use crate::published;

/// A sequence that is ready to be followed.
pub(super) struct SlamSequence {
    pub images: Box<dyn ImageSource>,
    pub truth: Option<CameraTrajectory>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Opens a folder or `sim:NAME`, at most so many images of it. A simulated sequence is the same in all runs.
pub(super) fn open(name: &str, max_frames: usize) -> Result<SlamSequence, String> {
    if let Some(tour) = name.strip_prefix("sim:") {
        let tour = CameraTour::new(tour, 1).map_err(|error| error.to_string())?;
        let tour = tour.with_frames(0, max_frames, 1);
        let truth = tour.truth();
        return Ok(SlamSequence { images: Box::new(tour), truth: Some(truth), warnings: Vec::new() });
    }
    let range = SequenceRange { end: Some(Bound::Frame(max_frames)), ..SequenceRange::default() };
    let options = SequenceOptions { range, ..SequenceOptions::default() };
    let Sequence { images, truth, mut warnings, .. } =
        open_sequence(Path::new(name), &options).map_err(|error| error.to_string())?;
    let missing: Vec<_> = images.files().iter().filter(|image| !files::is_there(&image.path)).collect();
    if let Some(first) = missing.first() {
        let (num, all, path) = (missing.len(), images.files().len(), first.path.display());
        warnings.push(format!("{name}: {num} of {all} images are not there and left out; the first: {path}"));
    }
    Ok(SlamSequence { images: Box::new(images), truth, warnings })
}

/// What a sequence is called in tables: the last part of its path.
pub(super) fn short_name(name: &str) -> String {
    let path = Path::new(name);
    let last = path.canonicalize().ok().and_then(|path| path.file_name().map(|n| n.to_os_string()));
    last.map_or_else(|| name.to_owned(), |last| last.to_string_lossy().into_owned())
}

/// Rows of the list of the documents' sequences: name, folders, download.
fn known() -> impl Iterator<Item = &'static [&'static str]> {
    let table = published::table("list/sequences");
    table.into_iter().flat_map(|table| table.rows.iter().map(Vec::as_slice))
}

/// What tables call a sequence: by its name in the documents, if that of its folder tells it.
pub(super) fn table_name(name: &str) -> String {
    let folder = short_name(name);
    let small = folder.to_lowercase();
    let is_called = |row: &&[&str]| row[1].split(", ").any(|beginning| small.starts_with(beginning));
    known().find(is_called).map_or(folder, |row| row[0].to_owned())
}

/// How to get a sequence of the documents and run an experiment on it.
pub(super) fn how_to_get(name: &str, experiment: &str) -> Option<String> {
    let row = known().find(|row| row[0] == name)?;
    let folder = row[2].rsplit(": ").next()?;
    Some(format!("{name} is not here ({}). With it: visloc experiment {experiment} {folder}", row[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequences_of_the_documents_are_told_by_their_folders() {
        let names = ["MH_01_easy", "traj3_frei_png", "rgbd_dataset_freiburg1_floor", "AGZ", "URJC4"];
        assert_eq!(names.map(table_name), ["MH01", "OR3", "F1F", "ZU", "URJC4"]);
        let others = ["living_room_traj3_frei_png", "sim:room", "my_office"];
        assert_eq!(others.map(table_name), others);
    }
}
