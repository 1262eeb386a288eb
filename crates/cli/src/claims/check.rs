//! Whether the outputs of a command may be made.

use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use visloc_core::files;

use super::{
    Claims,
    collect::{Input, Output, UseAs},
    identity::{Identity, Kind},
};
use crate::{args::STANDARD_OUTPUT, say};

/// Endings of recordings, and how they begin.
const RECORDING_ENDINGS: [&str; 4] = ["mcap", "db3", "bag", "rrd"];
/// Endings of files that are no recordings of ours; any other one is part of the name of a folder.
const FOREIGN_ENDINGS: [&str; 20] = [
    "bag", "db3", "mp4", "mov", "mkv", "avi", "png", "jpg", "jpeg", "txt", "csv", "json", "toml", "yaml",
    "tum", "gz", "zst", "lz4", "zip", "tar",
];
const RECORDING_STARTS: [&[u8]; 4] = [b"\x89MCAP", b"SQLite format 3\0", b"#ROSBAG V", b"RRF"];

impl Claims {
    /// Refuses outputs that would harm an input, another output or a recording, or that cannot be written. Creates nothing.
    pub fn check(&self) -> Result<()> {
        for (number, output) in self.outputs.iter().enumerate() {
            for input in &self.inputs {
                check_input(input, output)?;
            }
            let earlier = self.outputs.iter().take(number).find(|earlier| is_same_output(earlier, output));
            if let Some(earlier) = earlier {
                bail!("{}: expected another file than {}", output.text, earlier.text);
            }
            self.outputs.iter().try_for_each(|other| check_apart(output, other))?;
            self.check_among_pictures(output)?;
            self.check_recording(output)?;
            check_ending(output)?;
        }
        self.outputs.iter().try_for_each(check_writable)
    }

    /// Whether a result goes to standard output.
    pub fn takes_standard_output(&self) -> bool {
        self.outputs.iter().any(is_standard_output)
    }

    /// Says which files were there already, and where they are now.
    pub fn say_kept(&self) {
        for output in &self.outputs {
            // A link stays one: what it leads to is replaced.
            let written = if output.path.is_symlink() { output.identity.path() } else { &output.path };
            let kept = files::kept_path(written);
            if output.identity.kind() == Kind::File && Identity::of(&kept).is_node_of(&output.identity) {
                say::note!("{}: the file that was there is kept as {}", output.text, kept.display());
            }
            let kept = files::kept_path(&files::part_path(written));
            if Identity::of(&kept).is_node_of(&output.part) {
                say::note!(
                    "{}: the unfinished one that was there is kept as {}",
                    output.text,
                    kept.display()
                );
            }
        }
    }

    /// Pictures that are written into a folder may get any name there.
    fn check_among_pictures(&self, output: &Output) -> Result<()> {
        let is_folder_of = |folder: &&Output| {
            folder.use_as == UseAs::Folder
                && is_picture(&output.path)
                && output.identity.is_in(&folder.identity)
        };
        match self.outputs.iter().find(is_folder_of) {
            Some(folder) => {
                bail!("{}: {} writes pictures there; choose another folder", output.text, folder.text)
            }
            None => Ok(()),
        }
    }

    /// Recordings are replaced on demand only.
    fn check_recording(&self, output: &Output) -> Result<()> {
        if self.is_overwriting == Some(true) || !holds_recording(output) {
            return Ok(());
        }
        match self.is_overwriting {
            Some(_) => bail!(
                "{}: there is one already; choose another name, or replace it with --overwrite",
                output.text
            ),
            None => bail!("{}: there is a recording already; choose another name", output.text),
        }
    }
}

fn is_standard_output(output: &Output) -> bool {
    [STANDARD_OUTPUT, "/dev/fd/1", "/proc/self/fd/1"].iter().any(|name| output.path == Path::new(name))
}

fn is_same_output(a: &Output, b: &Output) -> bool {
    // Nobody can tell one result from the other.
    if is_standard_output(a) && is_standard_output(b) {
        return true;
    }
    // Devices take everything, and pictures of several kinds share a folder.
    let is_shared =
        a.identity.kind() == Kind::Device || (a.use_as == UseAs::Folder && b.use_as == UseAs::Folder);
    !is_shared && a.identity.is(&b.identity)
}

/// Refuses an output that has, or is below, a name that another one takes.
fn check_apart(output: &Output, other: &Output) -> Result<()> {
    // Files go into folders, and streams take no other names.
    if other.use_as == UseAs::Folder || other.identity.kind() == Kind::Device {
        return Ok(());
    }
    let whole = other.identity.path();
    if output.identity.is_below(whole) {
        bail!("{}: {} is no folder for other results; choose another place", output.text, other.text);
    }
    let [kept, part] = [files::kept_path(whole), files::part_path(whole)];
    let has_name = |name: &Path| Identity::of(name).is(&output.identity) || output.identity.is_below(name);
    if has_name(&kept) {
        bail!("{}: what was there of {} is kept under that name", output.text, other.text);
    }
    if has_name(&part) || has_name(&files::kept_path(&part)) {
        bail!("{}: {} needs that name until it is complete", output.text, other.text);
    }
    Ok(())
}

fn check_input(input: &Input, output: &Output) -> Result<()> {
    let (read, written) = (&input.identity, &output.identity);
    if matches!(output.use_as, UseAs::Map | UseAs::File) && written.kind() == Kind::File {
        let kept = files::kept_path(written.path());
        if Identity::of(&kept).is(read) {
            bail!("{}: what is there is kept as {}, which is read", output.text, kept.display());
        }
    }
    let part = files::part_path(written.path());
    if output.use_as != UseAs::Folder && Identity::of(&part).is(read) {
        bail!("{}: until it is complete it is {}, which is read", output.text, part.display());
    }
    if output.use_as == UseAs::Map && input.is_map && written.is(read) {
        return Ok(());
    }
    if written.is(read) {
        bail!("{}: expected something else than {}, which is read", output.text, input.text);
    }
    let is_refused = match output.use_as {
        // What is new there is read by the next run if its name is that of an image or of a recording.
        UseAs::File | UseAs::Map => {
            let is_taken = written.kind() != Kind::Missing
                || is_picture(&output.path)
                || has_ending(&output.path, &RECORDING_ENDINGS);
            is_taken && written.is_inside(read)
        }
        // A new part of a recording would belong to it.
        UseAs::Recording => written.is_inside(read) || read.is_inside(written),
        UseAs::Folder => has_harm(written, read),
    };
    if is_refused {
        bail!("{}: it has to do with {}, which is read; choose another place", output.text, input.text);
    }
    Ok(())
}

/// Whether pictures that are written into a folder could replace what is read, or be taken for it.
fn has_harm(folder: &Identity, read: &Identity) -> bool {
    let is_nested = folder.is_inside(read);
    folder.entries().filter(|path| is_picture(path)).any(|path| {
        if is_nested {
            // Pictures of visloc come in pairs; others are part of the input.
            return !(path.with_extension("svg").exists() && path.with_extension("png").exists());
        }
        let entry = Identity::of(&path);
        entry.is(read) || entry.is_inside(read)
    })
}

/// A name must not promise another form than the one that is written.
fn check_ending(output: &Output) -> Result<()> {
    let found = output.path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    if let (Some(wanted), Some(found)) = (&output.ending, &found)
        && wanted != found
    {
        bail!("{}: expected a name that ends with .{wanted}, which is what is written", output.text);
    }
    let is_foreign = output.use_as == UseAs::Recording && has_ending(&output.path, &FOREIGN_ENDINGS);
    if is_foreign && output.identity.kind() != Kind::Folder {
        bail!(
            "{}: recordings are written as MCAP: name it .mcap, or without an ending for a folder",
            output.text
        );
    }
    Ok(())
}

fn is_picture(path: &Path) -> bool {
    has_ending(path, &["svg", "png", "jpg", "jpeg"])
}

fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| endings.contains(&&*ending))
}

/// Whether something is there that took a run to make.
fn holds_recording(output: &Output) -> bool {
    match (output.use_as, output.identity.kind()) {
        (UseAs::Recording, Kind::File) => true,
        (UseAs::Recording, Kind::Folder) => output.identity.entries().next().is_some(),
        (UseAs::File | UseAs::Map, Kind::File) => is_recording(output.identity.path()),
        _ => false,
    }
}

fn is_recording(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(16).read_to_end(&mut start));
    let is_begun = |known: &&[u8]| start.starts_with(known);
    has_ending(path, &RECORDING_ENDINGS) || (read.is_ok() && RECORDING_STARTS.iter().any(is_begun))
}

/// Tried before the run: what took an hour must not fail at its end for a reason that was there at its start.
fn check_writable(output: &Output) -> Result<()> {
    let path: PathBuf = output.path.clone();
    let tried = match output.use_as {
        UseAs::File | UseAs::Map => files::try_file(&path),
        UseAs::Folder => files::try_folder(&path),
        UseAs::Recording if output.identity.kind() == Kind::Folder => files::try_folder(&path),
        // The bag will be a folder.
        UseAs::Recording if path.extension().is_none() && files::is_name_of_folder(&path) => {
            files::try_folder(&path)
        }
        UseAs::Recording => files::try_file(&path),
    };
    tried.with_context(|| format!("{}: cannot write there", output.text))
}
