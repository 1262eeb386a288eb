//! What a user writes for a source.

use std::{fmt, io, path::Path};

use crate::{
    sequence::is_image,
    sources::{KINDS, Purpose, SourceKind, SourceOptions, SourcesError, kinds},
};

/// Names that differ in at most so many letters, and in less than half of them, are thought to be meant.
const MAX_TYPOS: usize = 2;

/// A source as a user names it: `KIND:REST`, or a path that says by itself what it is.
#[derive(Clone, Copy)]
pub struct SourceAddress<'a> {
    text: &'a str,
    scheme: &'a str,
    rest: &'a str,
    kind: &'static SourceKind,
}

impl<'a> SourceAddress<'a> {
    /// Finds the kind of source. Opens nothing; of a path it is looked whether it is a file or a folder.
    ///
    /// # Errors
    /// If the kind is unknown, or a path is not there or of no known kind. The error names what is most like it.
    pub fn parse(text: &'a str) -> Result<Self, SourcesError> {
        if let Some((scheme, rest)) = scheme_of(text) {
            let kind = KINDS.iter().find(|kind| kind.schemes.contains(&scheme));
            let kind = kind.ok_or_else(|| unknown_kind(scheme))?;
            // Topics have usual names, and the simulator tells its own.
            if rest.is_empty() && !["ros2", "sim"].contains(&scheme) {
                let reason = format!("expected {}, for instance {}", kind.form, kind.example);
                return Err(SourcesError::CannotDeliver { argument: text.into(), reason });
            }
            return Ok(Self { text, scheme, rest, kind });
        }
        let path = Path::new(text);
        match path.metadata() {
            Ok(found) if found.is_file() || found.is_dir() => {}
            Ok(_) => return Err(SourcesError::NoFile { argument: text.into() }),
            Err(source) if source.kind() == io::ErrorKind::NotFound => {
                let nearest = nearest_name(text);
                return Err(SourcesError::NotFound { argument: text.into(), nearest, known: known_forms() });
            }
            Err(source) => return Err(SourcesError::Unreadable { argument: text.into(), source }),
        }
        let kind = KINDS.iter().find(|kind| (kind.claims)(path));
        let kind = kind.ok_or_else(|| match (path.to_path_buf(), is_image(path)) {
            (path, true) => SourcesError::Photo { path },
            (path, false) => SourcesError::UnknownFile { path, known: known_forms() },
        })?;
        Ok(Self { text, scheme: "", rest: text, kind })
    }

    /// What the user wrote.
    pub fn text(&self) -> &'a str {
        self.text
    }

    /// The word before the colon; empty if there is none.
    pub fn scheme(&self) -> &'a str {
        self.scheme
    }

    /// What stands behind the colon, or everything.
    pub fn rest(&self) -> &'a str {
        self.rest
    }

    /// Whether it delivers a robot's kinematics, not a camera alone.
    pub fn has_robot(&self) -> bool {
        (self.kind.is_robot)(self.rest)
    }

    /// Refuses options that the source has no use for; opens nothing.
    ///
    /// # Errors
    /// If an option would be ignored, contradicts another one or has a senseless value; the error names it.
    pub fn check(&self, options: &SourceOptions, purpose: Purpose) -> Result<(), SourcesError> {
        options.check(self.text, self.kind.name, purpose, &self.kind.honors(purpose, self.rest))
    }

    /// The kind of source.
    pub fn kind(&self) -> &'static SourceKind {
        self.kind
    }
}

impl fmt::Debug for SourceAddress<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SourceAddress").field("text", &self.text).field("kind", &self.kind.name).finish()
    }
}

impl fmt::Display for SourceAddress<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text)
    }
}

/// A word before a colon. One letter is a drive, and a file may have a colon in its name.
fn scheme_of(text: &str) -> Option<(&str, &str)> {
    let (scheme, rest) = text.split_once(':')?;
    let is_word = scheme.len() > 1 && scheme.chars().all(|c| c.is_ascii_alphanumeric());
    (is_word && !Path::new(text).exists()).then_some((scheme, rest))
}

fn unknown_kind(scheme: &str) -> SourcesError {
    let schemes = KINDS.iter().flat_map(|kind| kind.schemes).copied();
    SourcesError::UnknownKind {
        scheme: scheme.into(),
        nearest: nearest(scheme, schemes).map(|name| format!("{name}:")),
        known: known_forms(),
    }
}

/// A name of the simulator, or a file in the same folder.
fn nearest_name(text: &str) -> Option<String> {
    let simulated = kinds::simulated_names();
    if let Some(name) = nearest(text, simulated.iter().map(String::as_str)) {
        return Some(format!("sim:{name}"));
    }
    let path = Path::new(text);
    let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).ok()?.filter_map(Result::ok);
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    let name = nearest(path.file_name()?.to_str()?, names.iter().map(String::as_str))?;
    Some(if folder == Path::new(".") { name.to_owned() } else { folder.join(name).display().to_string() })
}

/// The name that is most like another one, if it is like it.
pub(crate) fn nearest<'n>(name: &str, names: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    let typos = names.map(|known| (strsim::damerau_levenshtein(name, known), known));
    typos.filter(|(typos, _)| *typos <= MAX_TYPOS && 2 * *typos < name.len()).min().map(|(_, known)| known)
}

fn known_forms() -> String {
    KINDS.iter().map(|kind| kind.form).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(text: &str) -> Result<&'static str, String> {
        SourceAddress::parse(text).map(|address| address.kind().name).map_err(|error| error.to_string())
    }

    #[test]
    fn words_and_paths() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, "").unwrap();
            path.display().to_string()
        };
        assert_eq!(kind("sim:robocup").unwrap(), "simulator");
        assert_eq!(kind("ros2:/camera/image").unwrap(), "ROS 2 topics");
        assert_eq!(kind("v4l2:/dev/video0").unwrap(), "camera");
        assert_eq!(kind(&file("a.mcap")).unwrap(), "ROS bag");
        assert_eq!(kind(&file("c.db3")).unwrap(), "ROS bag");
        assert_eq!(kind(&file("d.bag")).unwrap(), "ROS bag");
        assert_eq!(kind(&file("b.MP4")).unwrap(), "video");
        assert_eq!(kind(&folder.path().display().to_string()).unwrap(), "ROS bag");
        assert_eq!(kind(&file("with:colon.mcap")).unwrap(), "ROS bag");
        for (text, expected) in [
            ("loop:", "loop:: expected loop:DIR|FILE.mp4, for instance"),
            ("bag:", "bag:: expected FILE.mcap"),
        ] {
            let error = kind(text).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        assert_eq!(kind("ros2:").unwrap(), "ROS 2 topics", "all names are the usual ones");
        assert!(kind(&file("notes.txt")).unwrap_err().contains("cannot tell what it is"));
        assert!(kind(&file("photo.JPG")).unwrap_err().contains("visloc locate PHOTO"));
    }

    #[test]
    fn typos_get_the_nearest() {
        let error = kind("vidoe:clip.mp4").unwrap_err();
        assert!(error.contains("did you mean 'video:'?") && error.contains("v4l2:DEVICE"), "{error}");
        assert!(!kind("quux:x").unwrap_err().contains("did you mean"));
        assert!(!kind("desk").unwrap_err().contains("did you mean"));
        assert!(kind("robcup").unwrap_err().contains("did you mean 'sim:robocup'?"));
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("run1.mcap"), "").unwrap();
        let error = kind(&folder.path().join("run.mcap").display().to_string()).unwrap_err();
        assert!(error.contains("no such file") && error.contains("run1.mcap'?"), "{error}");
        let below_a_file = folder.path().join("run1.mcap/x").display().to_string();
        let error = kind(&below_a_file).unwrap_err();
        assert!(
            !error.contains("no such file") && !error.contains("did you mean"),
            "the system's reason: {error}"
        );
    }
}
