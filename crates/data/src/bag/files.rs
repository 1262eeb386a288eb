//! The files of a recording.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::bag::BagError;

/// The MCAP files of a recording in order: the file itself, or those of a rosbag2 folder.
pub(super) fn bag_files(path: &Path) -> Result<Vec<PathBuf>, BagError> {
    let io_error = |action| move |source| BagError::Io { path: path.to_path_buf(), action, source };
    let kind = fs::metadata(path).map_err(io_error("open it"))?;
    if !kind.is_dir() {
        return Ok(vec![path.to_path_buf()]);
    }
    let metadata = path.join("metadata.yaml");
    let files = if metadata.is_file() {
        let text = fs::read_to_string(&metadata).map_err(|source| BagError::Io {
            path: metadata.clone(),
            action: "read it",
            source,
        })?;
        listed_files(&text).into_iter().map(|name| path.join(name)).collect()
    } else {
        mcap_files_by_name(path).map_err(io_error("list it"))?
    };
    check_files(path, files)
}

fn mcap_files_by_name(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let file = entry?.path();
        if file.extension().is_some_and(|extension| extension == "mcap") {
            files.push(file);
        }
    }
    files.sort();
    Ok(files)
}

fn check_files(folder: &Path, files: Vec<PathBuf>) -> Result<Vec<PathBuf>, BagError> {
    let folder_error = |reason: String| BagError::Folder { path: folder.to_path_buf(), reason };
    if files.is_empty() {
        return Err(folder_error("expected .mcap files, or their names in metadata.yaml; found none".into()));
    }
    for file in &files {
        if file.extension().is_none_or(|extension| extension != "mcap") {
            let name = file.display();
            return Err(folder_error(format!(
                "metadata.yaml lists '{name}'; only .mcap files can be read (convert other storage with 'ros2 bag \
                 convert', unpack .zstd files with 'zstd -d')"
            )));
        }
        if !file.is_file() {
            return Err(folder_error(format!(
                "metadata.yaml lists '{}', which is not there",
                file.display()
            )));
        }
    }
    Ok(files)
}

/// The entries of `relative_file_paths` in the metadata of rosbag2, which is YAML in a fixed layout.
fn listed_files(yaml: &str) -> Vec<String> {
    yaml.lines()
        .map(str::trim)
        .skip_while(|line| *line != "relative_file_paths:")
        .skip(1)
        .map_while(|line| line.strip_prefix("- "))
        .map(|name| name.trim_matches(|c| c == '"' || c == '\'').to_string())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_come_from_the_metadata_in_order() {
        let yaml = "rosbag2_bagfile_information:\n  relative_file_paths:\n    - b_1.mcap\n    - \"a_2.mcap\"\n  files:\n    - path: x\n";
        assert_eq!(listed_files(yaml), ["b_1.mcap", "a_2.mcap"]);
        assert!(listed_files("nothing: here").is_empty());
    }

    #[test]
    fn missing_parts_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let error = bag_files(folder.path()).unwrap_err().to_string();
        assert!(error.contains("expected .mcap files"), "{error}");
        fs::write(folder.path().join("metadata.yaml"), "relative_file_paths:\n  - part_0.mcap\n").unwrap();
        let error = bag_files(folder.path()).unwrap_err().to_string();
        assert!(error.contains("part_0.mcap"), "{error}");
        let error = bag_files(&folder.path().join("nowhere.mcap")).unwrap_err().to_string();
        assert!(error.contains("nowhere.mcap"), "{error}");
    }
}
