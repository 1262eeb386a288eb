//! Files that a run writes.

use std::{
    fs,
    io::{self, ErrorKind, Write},
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail};
use visloc_core::{
    StampedPose, Timestamp,
    files::{self, NewFile},
};
use visloc_io::trajectory::{write_tum_header, write_tum_pose};

use super::{FrameRecord, Saving};
use crate::{
    args::{STANDARD_OUTPUT, TextOutArg},
    say,
};

/// First line of a table of estimates. Seconds, meters and radians; `t`, `x`, `y`, `yaw` as in tables of the truth.
pub const CSV_HEADER: &str =
    "t,x,y,yaw,reliability,likelihood,sigma_x,sigma_y,sigma_yaw,hypotheses,quality,pixels,individuals";

/// So much data is lost at most if the program is killed, seconds.
const FLUSH_SECS: f64 = 1.0;

/// Trajectory and table of one algorithm. Until the run ends they have `.part` behind their names.
#[derive(Default)]
pub struct OutputFiles {
    trajectory: Option<GrowingFile>,
    estimates: Option<GrowingFile>,
    flushed_at: Option<Timestamp>,
}

/// A file that takes lines until one cannot be written; why is told at the end, so that the run goes on for the other outputs.
struct GrowingFile {
    path: PathBuf,
    file: NewFile,
    fault: Option<io::Error>,
}

impl OutputFiles {
    /// Creates the files that are wanted, and their folders.
    pub fn create(trajectory: Option<&Path>, estimates: Option<&Path>) -> Result<Self> {
        let mut files = Self {
            trajectory: trajectory.map(GrowingFile::create).transpose()?,
            estimates: estimates.map(GrowingFile::create).transpose()?,
            flushed_at: None,
        };
        if let Some(file) = &mut files.trajectory {
            file.write(write_tum_header);
        }
        if let Some(file) = &mut files.estimates {
            file.write(|writer| writeln!(writer, "{CSV_HEADER}"));
        }
        Ok(files)
    }

    /// Appends a frame.
    pub fn append(&mut self, record: &FrameRecord) {
        if let Some(file) = &mut self.trajectory {
            let world_from_robot = record.world_from_robot;
            let pose = StampedPose { at: record.at, world_from_robot, height_m: 0.0 };
            file.write(|writer| write_tum_pose(writer, &pose));
        }
        if let Some(file) = &mut self.estimates {
            file.write(|writer| writeln!(writer, "{}", csv_line(record)));
        }
        let flushed_at = *self.flushed_at.get_or_insert(record.at);
        if record.at.secs_since(flushed_at) >= FLUSH_SECS {
            self.flushed_at = Some(record.at);
            let files = [&mut self.trajectory, &mut self.estimates];
            files.into_iter().flatten().for_each(|file| file.write(Write::flush));
        }
    }

    /// Gives the files their names.
    pub fn finish(&mut self) -> Result<()> {
        let mut saving = Saving::default();
        let files = [&mut self.trajectory, &mut self.estimates].map(Option::take);
        files.into_iter().flatten().for_each(|file| saving.save(file.finish()));
        saving.end()
    }
}

impl GrowingFile {
    fn create(path: &Path) -> Result<Self> {
        let file = NewFile::create_growing(path);
        let part = files::part_path(path);
        let place = if part.is_dir() { &part } else { path };
        let file = file.with_context(|| format!("{}: cannot create it", place.display()))?;
        Ok(Self { path: path.to_path_buf(), file, fault: None })
    }

    fn write(&mut self, write: impl FnOnce(&mut NewFile) -> io::Result<()>) {
        if self.fault.is_none() {
            self.fault = write(&mut self.file).err();
        }
    }

    fn finish(self) -> Result<()> {
        let finished = self.fault.map_or_else(|| self.file.finish(), Err);
        finished.with_context(|| format!("{}: cannot write it", self.path.display()))
    }
}

/// Writes a whole file, and makes its folder.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    files::write(path, text).with_context(|| format!("{}: cannot write it", path.display()))
}

/// Prints a text, or writes it to the file that was asked for and says so.
pub fn print_or_write(text: &str, asked: &TextOutArg) -> Result<()> {
    match &asked.out {
        None => say::text(format_args!("{text}")),
        Some(path) => {
            write_text(path, text)?;
            if **path != *Path::new(STANDARD_OUTPUT) {
                say::line!("written: {}", path.display());
            }
        }
    }
    Ok(())
}

fn csv_line(record: &FrameRecord) -> String {
    let pose = record.world_from_robot;
    let [sigma_x, sigma_y, sigma_yaw] = record.sigma;
    format!(
        "{},{:.6},{:.6},{:.6},{:.6},{:.6},{sigma_x:.6},{sigma_y:.6},{sigma_yaw:.6},{},{:.4},{},{}",
        record.at,
        pose.x_m,
        pose.y_m,
        pose.yaw_rad,
        record.reliability,
        record.likelihood,
        record.num_hypotheses,
        record.quality,
        record.num_pixels,
        record.num_individuals,
    )
}

/// Refuses a folder that has anything in it: many files are written into it, and somebody's own would be mixed with them.
pub fn expect_new_folder(path: &Path) -> Result<()> {
    let has_entries = match fs::read_dir(path) {
        Ok(mut entries) => entries.next().is_some(),
        Err(error) if error.kind() == ErrorKind::NotFound => false,
        Err(error) => return Err(error).with_context(|| path.display().to_string()),
    };
    if has_entries {
        bail!("{}: expected a new or empty folder, so that nothing is lost or mixed", path.display());
    }
    Ok(())
}
