//! The files of a recording.

use std::{
    fs,
    path::{Path, PathBuf},
};

use serde::Deserialize;
use visloc_core::files;

use crate::{bag::BagError, text::yaml_reason};

/// Endings of the files that a folder of rosbag2 has.
const EXTENSIONS: [&str; 2] = ["mcap", "db3"];
/// Since this version names in `metadata.yaml` are relative to its folder; before, to the folder above.
const NAMES_IN_FOLDER_VERSION: u32 = 4;

/// The files of a recording in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct BagFiles {
    pub paths: Vec<PathBuf>,
    /// Whether each message is packed by itself, with zstd.
    pub are_messages_packed: bool,
}

/// What is of interest in `metadata.yaml`.
#[derive(Deserialize)]
struct Metadata {
    rosbag2_bagfile_information: Information,
}

#[derive(Deserialize)]
#[serde(default)]
#[derive(Default)]
struct Information {
    version: u32,
    relative_file_paths: Vec<String>,
    compression_format: Option<String>,
    compression_mode: Option<String>,
}

/// The file itself, or those of a rosbag2 folder.
pub(super) fn bag_files(path: &Path) -> Result<BagFiles, BagError> {
    let io_error = |action| move |source| BagError::Io { path: path.to_path_buf(), action, source };
    let kind = fs::metadata(path).map_err(io_error("open it"))?;
    if !kind.is_dir() {
        return Ok(BagFiles { paths: vec![path.to_path_buf()], are_messages_packed: false });
    }
    let metadata = path.join("metadata.yaml");
    if files::is_there(&metadata) {
        let text = files::read_text(&metadata).map_err(|source| BagError::Io {
            path: metadata.clone(),
            action: "read it",
            source,
        })?;
        return listed_files(path, &text).map_err(|reason| BagError::Folder { path: metadata, reason });
    }
    let paths = files_by_name(path).map_err(io_error("list it"))?;
    if paths.is_empty() {
        let reason = "expected .mcap or .db3 files, or their names in metadata.yaml; found none".into();
        return Err(BagError::Folder { path: path.to_path_buf(), reason });
    }
    Ok(BagFiles { paths, are_messages_packed: false })
}

/// The files that are taken for one recording since nothing says which ones belong to it; `None` of a file, or if `metadata.yaml` does.
pub(crate) fn files_without_metadata(path: &Path) -> Option<Vec<PathBuf>> {
    let is_told = !path.is_dir() || files::is_there(&path.join("metadata.yaml"));
    files_by_name(path).ok().filter(|_| !is_told)
}

/// The files of one recording in order of their numbers: `name_2` comes before `name_10`.
fn files_by_name(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        found.push(entry?.path());
    }
    let has_extension =
        |file: &PathBuf, wanted: &str| file.extension().is_some_and(|extension| extension == wanted);
    // A recording in two forms is read once.
    let extension =
        EXTENSIONS.into_iter().find(|wanted| found.iter().any(|file| has_extension(file, wanted)));
    found.retain(|file| extension.is_some_and(|wanted| has_extension(file, wanted)));
    found.sort_by_cached_key(|file| {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = stem.trim_end_matches(|c: char| c.is_ascii_digit()).to_string();
        (name.clone(), stem[name.len()..].parse::<u64>().unwrap_or(0), stem)
    });
    Ok(found)
}

/// The files that `metadata.yaml` lists.
fn listed_files(folder: &Path, yaml: &str) -> Result<BagFiles, String> {
    let metadata: Metadata = serde_saphyr::from_str(yaml)
        .map_err(|error| format!("expected the metadata of rosbag2: {}", yaml_reason(&error)))?;
    let Information { version, relative_file_paths: names, compression_format, compression_mode } =
        metadata.rosbag2_bagfile_information;
    if names.is_empty() {
        return Err("expected names of files under relative_file_paths, found none".into());
    }
    let mut paths = Vec::new();
    for name in names {
        let extension = Path::new(&name).extension().unwrap_or_default().to_string_lossy().into_owned();
        if !EXTENSIONS.contains(&extension.as_str()) {
            return Err(format!(
                "it lists '{name}'; expected .mcap or .db3 files (unpack others, such as .db3.zstd with 'zstd -d', and name them \
                 as they are then)"
            ));
        }
        let above = folder.parent().map(|above| above.join(&name));
        let above = above.filter(|file| version < NAMES_IN_FOLDER_VERSION && files::is_there(file));
        let file = above.unwrap_or_else(|| folder.join(&name));
        if !files::is_there(&file) {
            return Err(format!("it lists '{name}', which is not there"));
        }
        paths.push(file);
    }
    let mode = compression_mode.unwrap_or_default().to_lowercase();
    let format = compression_format.unwrap_or_default();
    match (mode.as_str(), format.as_str()) {
        ("message", "zstd") => Ok(BagFiles { paths, are_messages_packed: true }),
        ("message", _) => Err(format!("its messages are packed with '{format}'; expected zstd")),
        _ => Ok(BagFiles { paths, are_messages_packed: false }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(files: &[PathBuf]) -> Vec<String> {
        files.iter().map(|file| file.file_name().unwrap().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn file_names_come_from_the_metadata_in_order() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b_1.mcap", "a_2.mcap"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let yaml = "rosbag2_bagfile_information:\n  relative_file_paths:\n    - b_1.mcap\n    - \"a_2.mcap\"\n  files:\n    - path: x\n";
        let files = listed_files(folder.path(), yaml).unwrap();
        assert_eq!(names(&files.paths), ["b_1.mcap", "a_2.mcap"]);
        assert!(!files.are_messages_packed);
        let packed = format!("{yaml}  compression_mode: MESSAGE\n  compression_format: ");
        assert!(listed_files(folder.path(), &(packed.clone() + "zstd")).unwrap().are_messages_packed);
        assert!(listed_files(folder.path(), &(packed + "fake")).unwrap_err().contains("'fake'"));
        assert!(listed_files(folder.path(), "nothing: here").is_err());
    }

    #[test]
    fn numbers_order_files_without_metadata() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["run_10.db3", "run_2.db3", "run_1.db3", "notes.txt"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let files = bag_files(folder.path()).unwrap();
        assert_eq!(names(&files.paths), ["run_1.db3", "run_2.db3", "run_10.db3"]);
    }

    #[test]
    fn missing_and_packed_parts_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let error = bag_files(folder.path()).unwrap_err().to_string();
        assert!(error.contains("expected .mcap or .db3 files"), "{error}");
        for (name, expected) in [("part_0.mcap", "not there"), ("part_0.db3.zstd", "zstd -d")] {
            let yaml = format!("rosbag2_bagfile_information:\n  relative_file_paths: [{name}]\n");
            fs::write(folder.path().join("metadata.yaml"), yaml).unwrap();
            let error = bag_files(folder.path()).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains(expected), "{error}");
        }
        let error = bag_files(&folder.path().join("nowhere.mcap")).unwrap_err().to_string();
        assert!(error.contains("nowhere.mcap"), "{error}");
    }
}
