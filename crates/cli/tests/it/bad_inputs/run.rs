//! Runs the program on a cell and judges what it does.

use std::{
    collections::{BTreeMap, BTreeSet},
    ffi::OsString,
    fmt, fs,
    os::unix::{ffi::OsStringExt, fs::symlink, process::ExitStatusExt},
    path::{Path, PathBuf},
    process::{Command, ExitStatus, Stdio},
    time::{Duration, Instant},
};

use tempfile::TempDir;

use super::{
    cell::Cell,
    damages::{Damage, Verdict},
    kinds::{Input, write_good_files},
};
use crate::parsers::in_memory;

/// Most processor time of a run, seconds; without optimization everything takes longer.
const MAX_SECS: u64 = if cfg!(debug_assertions) { 30 } else { 5 };
/// A run that takes longer without using the processor hangs. Other programs may keep it waiting for a while.
const MAX_WAIT: Duration = Duration::from_secs(40);
/// Most memory, KiB.
const MAX_KIB: u64 = 6 << 20;
/// Longest error, letters.
const MAX_LINE: usize = 1200;

/// The good files that commands need beside the input.
pub struct Fixtures {
    folder: TempDir,
}

/// The options of each command.
pub type Options = BTreeMap<String, BTreeSet<String>>;

/// All options that a text names.
pub fn options_in(text: &str) -> BTreeSet<String> {
    let words = text.split(|c: char| !(c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'));
    words.filter(|word| word.starts_with("--") && word.len() > 3).map(str::to_owned).collect()
}

/// How a run ended.
pub struct Outcome {
    status: Option<ExitStatus>,
    stdout: String,
    stderr: String,
    written: Vec<String>,
    words: Vec<OsString>,
}

impl Fixtures {
    pub fn new() -> Self {
        let folder = in_memory();
        write_good_files(folder.path());
        Self { folder }
    }

    /// Makes the input of a cell in a folder of its own and runs the command there.
    pub fn run(&self, cell: &Cell) -> Outcome {
        let place = in_memory();
        let name = lay(cell, cell.kind.good(), place.path());
        let words: Vec<OsString> = cell
            .slot
            .command
            .split(' ')
            .chain(cell.slot.words.split(' '))
            .map(|word| match word {
                "{}" => name.clone(),
                word => match word.strip_prefix('@') {
                    Some(good) => self.folder.path().join(good).into(),
                    None => word.into(),
                },
            })
            .collect();
        let (stdout, stderr) = (place.path().join(".stdout"), place.path().join(".stderr"));
        let status = run_bounded(place.path(), &words, [&stdout, &stderr]);
        let read = |path: &Path| String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
        let (stdout, stderr) = (read(&stdout), read(&stderr));
        Outcome { status, stdout, stderr, written: files_in(&place.path().join("out")), words }
    }
}

/// Writes the damaged input; its name for the command.
fn lay(cell: &Cell, input: &Input, folder: &Path) -> OsString {
    let (main, bytes) = input.main();
    for (name, bytes) in &input.files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let path = folder.join(main);
    match cell.content(input) {
        Some(content) => fs::write(&path, content).unwrap(),
        None => fs::remove_file(&path).unwrap(),
    }
    let extension = Path::new(input.name).extension().map(|e| e.to_string_lossy().into_owned());
    let ending = extension.map_or_else(String::new, |extension| format!(".{extension}"));
    let renamed = |name: OsString| {
        fs::rename(folder.join(input.name), folder.join(&name)).unwrap();
        name
    };
    match cell.damage {
        Damage::Folder => fs::create_dir(&path).unwrap(),
        Damage::Device => symlink("/dev/zero", &path).unwrap(),
        Damage::Pipe => {
            let done = Command::new("mkfifo").arg(&path).status().unwrap();
            assert!(done.success());
        }
        Damage::LinkLoop => symlink(path.file_name().unwrap(), &path).unwrap(),
        Damage::Huge => {
            fs::write(&path, bytes).unwrap();
            fs::File::options().append(true).open(&path).unwrap().set_len(1 << 40).unwrap();
        }
        Damage::NoFolder => {
            let whole = folder.join(input.name);
            // Of an input of several files that is named by one of them, that one.
            let remove = if whole.is_dir() { fs::remove_dir_all(&whole) } else { fs::remove_file(&whole) };
            remove.unwrap();
            fs::write(&whole, bytes).unwrap();
        }
        Damage::LongName => return format!("input{}{ending}", "x".repeat(300)).into(),
        Damage::OddName => return renamed(format!("in\n'put{ending}").into()),
        Damage::ForeignName => {
            return renamed(OsString::from_vec([b"in\xffput", ending.as_bytes()].concat()));
        }
        _ => {}
    }
    input.name.into()
}

/// Runs the program with a limit on processor time and memory; `None` if it hangs.
// A program that hangs has to be ended.
#[allow(clippy::disallowed_methods)]
fn run_bounded(folder: &Path, words: &[OsString], [stdout, stderr]: [&PathBuf; 2]) -> Option<ExitStatus> {
    let limited = format!("ulimit -t {MAX_SECS}; ulimit -v {MAX_KIB}; exec \"$0\" \"$@\"");
    let to = |path: &Path| Stdio::from(fs::File::create(path).unwrap());
    let mut child = Command::new("sh")
        .args(["-c", &limited, env!("CARGO_BIN_EXE_visloc")])
        .args(words)
        .current_dir(folder)
        .env("RAYON_NUM_THREADS", "2")
        .stdin(Stdio::null())
        .stdout(to(stdout))
        .stderr(to(stderr))
        .spawn()
        .unwrap();
    let start = Instant::now();
    while start.elapsed() < MAX_WAIT {
        if let Some(status) = child.try_wait().unwrap() {
            return Some(status);
        }
        std::thread::sleep(Duration::from_millis(4));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    None
}

fn files_in(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<_> = self.words.iter().map(|word| word.to_string_lossy()).collect();
        write!(f, "visloc {}\n    {}{}", words.join(" "), self.stdout.trim_end(), self.stderr.trim_end())
    }
}

impl Outcome {
    /// An option that the user is told of, and that neither the command has nor another one that is named with it.
    fn foreign_option(&self, cell: &Cell, options: &Options) -> Option<String> {
        let said = format!("{}{}", self.stdout, self.stderr);
        let is_meant = |(command, known): (&String, &BTreeSet<String>), option: &String| {
            known.contains(option)
                && (command == cell.slot.command || said.contains(&format!("visloc {command}")))
        };
        // That of cargo.
        let named = options_in(&said).into_iter().filter(|option| option != "--features");
        named.into_iter().find(|option| !options.iter().any(|command| is_meant(command, option)))
    }

    /// What is wrong with it, if anything is.
    pub fn fault(&self, cell: &Cell, options: &Options) -> Option<String> {
        let foreign = self.foreign_option(cell, options);
        foreign.map(|option| format!("names {option}, which it does not have")).or_else(|| self.bad_end(cell))
    }

    fn bad_end(&self, cell: &Cell) -> Option<String> {
        let Some(status) = self.status else { return Some("hangs".to_owned()) };
        let Some(code) = status.code() else {
            return Some(format!("killed by signal {:?} (processor time or memory)", status.signal()));
        };
        if self.stderr.contains("panicked") || !(0..=2).contains(&code) {
            return Some(format!("ends with {code}"));
        }
        if let Some(left) = self.written.iter().find(|name| name.contains(".part")) {
            return Some(format!("leaves {left} behind"));
        }
        match (cell.verdict, code) {
            (Verdict::Fine | Verdict::Told, 0) => self.silent(cell.verdict),
            (Verdict::Refused | Verdict::Kept | Verdict::TooSmall, 0) => Some("a silent success".to_owned()),
            // A name that is no text cannot be told in words.
            (_, 2) => {
                (cell.damage != Damage::ForeignName).then(|| "bad usage, but it is bad input".to_owned())
            }
            (Verdict::Fine, _) => Some("refused".to_owned()),
            (Verdict::Refused | Verdict::TooSmall, _) if !self.written.is_empty() => {
                Some(format!("leaves {:?}", self.written))
            }
            _ => self.bad_sentence(cell),
        }
    }

    /// Whether nothing is said although something was left out.
    fn silent(&self, verdict: Verdict) -> Option<String> {
        const SAYING: [&str; 7] =
            ["left out", "note", "not used", "not found", "expected", "cut off", "held"];
        let says = || SAYING.iter().any(|word| self.stdout.contains(word) || self.stderr.contains(word));
        (verdict == Verdict::Told && !says()).then(|| "not a word about what is wrong".to_owned())
    }

    /// What is wrong with the error.
    fn bad_sentence(&self, cell: &Cell) -> Option<String> {
        const INTERNAL: [&str; 7] =
            ["usize", "u32", "f64", "Os {", "unwrap", "Tracking(", "stream did not contain"];
        let lines: Vec<&str> = self.stderr.lines().collect();
        let [line] = lines[..] else { return Some(format!("{} lines of errors", lines.len())) };
        let Some(error) = line.strip_prefix("error: ") else { return Some("no error".to_owned()) };
        let names = cell.kind.good();
        let is_source = cell.verdict == Verdict::TooSmall && error.contains("bag.mcap");
        let is_named = error.contains(names.name)
            || error.contains("input")
            || error.contains(names.main().0)
            || (cell.damage == Damage::ForeignName && error.contains("in\u{fffd}put"))
            || is_source;
        if !is_named && cell.damage != Damage::OddName {
            return Some("does not name the input".to_owned());
        }
        if error.chars().count() > MAX_LINE {
            return Some(format!("an error of {} letters", error.chars().count()));
        }
        INTERNAL.iter().find(|word| error.contains(**word)).map(|word| format!("says {word:?}"))
    }
}
