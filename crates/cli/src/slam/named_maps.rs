//! Map files that other programs name over the network: those of one folder, by names without a way to others.

use std::path::{Path, PathBuf};

/// The files that may be named.
#[derive(Debug)]
pub struct NamedMaps {
    /// What is meant without a name, and the option that says it.
    usual: Option<PathBuf>,
    option: &'static str,
    folder: PathBuf,
}

impl NamedMaps {
    /// The files beside that of an option, or those in the working folder.
    pub fn beside(option: &'static str, usual: Option<&Path>) -> Self {
        let folder = usual.and_then(Path::parent).unwrap_or(Path::new("")).to_path_buf();
        Self { usual: usual.map(Path::to_path_buf), option, folder }
    }

    /// The file of a name, with or without `.vmap`; without a name the usual one.
    pub fn path(&self, name: &str) -> Result<PathBuf, String> {
        if name.is_empty() {
            let missing =
                || format!("expected the name of a map, found none, and {} names none", self.option);
            return self.usual.clone().ok_or_else(missing);
        }
        let stem = name.strip_suffix(".vmap").unwrap_or(name);
        let is_plain = |c: char| c.is_alphanumeric() || "-_. ".contains(c);
        if stem.is_empty() || stem.starts_with('.') || !stem.chars().all(is_plain) {
            return Err(format!(
                "expected the name of a map such as office, without folders, found {name:?}"
            ));
        }
        Ok(self.folder.join(format!("{stem}.vmap")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_nowhere_else() {
        let maps = NamedMaps::beside("--save", Some(Path::new("maps/room.vmap")));
        assert_eq!(maps.path("").unwrap(), Path::new("maps/room.vmap"));
        assert_eq!(maps.path("hall").unwrap(), Path::new("maps/hall.vmap"));
        assert_eq!(maps.path("hall 2.vmap").unwrap(), Path::new("maps/hall 2.vmap"));
        for bad in ["../hall", "/etc/passwd", ".hidden", "..", "a/b", "a\\b", "C:x", ".vmap", "a\0b", "a\nb"]
        {
            assert!(maps.path(bad).unwrap_err().contains("without folders"), "{bad:?}");
        }
        let nowhere = NamedMaps::beside("--save", None);
        assert_eq!(nowhere.path("hall").unwrap(), Path::new("hall.vmap"));
        assert!(nowhere.path("").unwrap_err().contains("--save names none"));
    }
}
