//! Runs the program and makes recordings for it.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
};

use serde_json::Value;
use tempfile::TempDir;
use visloc_core::{Source, SourceFrame};
use visloc_io::bag::{BagReader, BagTopics, BagWriter, BagWriterOptions};

/// Map of all test recordings.
pub const MAP: &str = "robocup-spl-2010";

/// Makes a script that other programs may start.
///
/// Another process writes the file: one that this process writes is also open in whatever another test starts meanwhile, until that
/// has become the other program, and a file that is open for writing cannot be started (`ETXTBSY`).
pub fn write_program(path: &Path, script: &str) {
    let written = Command::new("/bin/sh")
        .args(["-c", "printf %s \"$2\" >\"$1\" && chmod 755 \"$1\"", "sh"])
        .arg(path)
        .arg(script)
        .status();
    assert!(written.unwrap().success(), "{}", path.display());
}

/// An empty folder in which the program runs.
pub struct Workspace {
    folder: TempDir,
}

/// How a run ended.
pub struct Outcome {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Workspace {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Runs the program here.
    pub fn visloc(&self, args: &[&str]) -> Outcome {
        let mut command = Command::new(env!("CARGO_BIN_EXE_visloc"));
        let output = command.args(args).current_dir(self.folder.path()).output().unwrap();
        Outcome {
            code: output.status.code().expect("not killed"),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Starts the program and goes on meanwhile.
    pub fn start(&self, args: &[&str]) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_visloc"));
        command.args(args).current_dir(self.folder.path()).stdout(Stdio::piped()).spawn().unwrap()
    }

    /// Runs the program, which must work.
    pub fn must(&self, args: &[&str]) -> Outcome {
        let outcome = self.visloc(args);
        assert_eq!(outcome.code, 0, "{args:?}: {}", outcome.stderr);
        assert_eq!(outcome.stderr, "", "quiet in a pipe");
        outcome
    }

    /// Runs the program, which must refuse with one line. Returns the line.
    pub fn refused(&self, args: &[&str]) -> String {
        let outcome = self.visloc(args);
        assert_eq!(outcome.code, 1, "{args:?}: {}", outcome.stdout);
        let lines: Vec<&str> = outcome.stderr.lines().collect();
        assert_eq!(lines.len(), 1, "{}", outcome.stderr);
        assert!(lines[0].starts_with("error: "), "{}", lines[0]);
        assert!(!outcome.stderr.contains("panicked"), "{}", outcome.stderr);
        lines[0].to_owned()
    }

    /// The first frames of an excerpt, changed by `change`, as a new recording.
    pub fn bag(&self, name: &str, num_frames: usize, change: impl Fn(usize, &mut SourceFrame)) {
        self.bag_with(name, num_frames, BagWriterOptions::default(), change);
    }

    /// The same, written in another way.
    pub fn bag_with(
        &self,
        name: &str,
        num_frames: usize,
        options: BagWriterOptions,
        change: impl Fn(usize, &mut SourceFrame),
    ) {
        let mut reader = BagReader::open(excerpt("R1"), BagTopics::default()).unwrap();
        let mut writer = BagWriter::create_with(self.path(name), BagTopics::default(), options).unwrap();
        for index in 0..num_frames {
            let mut frame = reader.next_item().expect("long enough").unwrap();
            change(index, &mut frame);
            writer.write(&frame).unwrap();
        }
        writer.finish().unwrap();
    }

    /// An excerpt whose messages are changed by `change` (topic, number on the topic, data).
    pub fn rewrite_messages(&self, name: &str, mut change: impl FnMut(&str, usize, &mut Vec<u8>)) {
        let bytes = fs::read(excerpt("R1")).unwrap();
        let file = fs::File::create(self.path(name)).unwrap();
        let mut writer = mcap::Writer::new(std::io::BufWriter::new(file)).unwrap();
        let mut counts = std::collections::BTreeMap::<String, usize>::new();
        for message in mcap::MessageStream::new(&bytes).unwrap() {
            let mut message = message.unwrap();
            let count = counts.entry(message.channel.topic.clone()).or_default();
            change(&message.channel.topic, *count, message.data.to_mut());
            *count += 1;
            writer.write(&message).unwrap();
        }
        writer.finish().unwrap();
    }
}

/// An excerpt of a recording.
pub fn excerpt(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../testdata/{name}-excerpt.mcap"))
}

/// The same as text.
pub fn excerpt_text(name: &str) -> String {
    excerpt(name).to_str().unwrap().to_owned()
}

/// Lines of a file that are not comments.
pub fn data_lines(text: &str) -> Vec<&str> {
    text.lines().filter(|line| !line.starts_with('#')).collect()
}
