//! How ffmpeg is called.

use std::{
    ffi::OsString,
    io::{self, Read},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::mpsc,
    thread,
    time::Duration,
};

use super::Pixels;

/// What ffmpeg reads.
#[derive(Debug, Clone)]
pub(crate) struct FfmpegInput {
    /// What the user wrote, for errors.
    pub argument: String,
    /// Arguments before and with `-i`.
    pub args: Vec<OsString>,
    /// Images a second that are taken of it, if not all are.
    pub sampled_hz: Option<f64>,
    /// Where it runs, if not here.
    pub folder: Option<PathBuf>,
    /// Whether images come by themselves and do not wait.
    pub is_live: bool,
    /// Images a second, where the times of the images cannot be had.
    pub rate_hz: f64,
    /// Whether the times that the file says count, not the rate.
    pub has_own_times: bool,
}

/// How images that are neither repeated nor left out are asked for: `-vsync` until version 5.0, `-fps_mode` from then on.
fn passthrough(version: &str) -> [&'static str; 2] {
    let mut numbers = version.trim_start_matches('n').split(['.', '-']).map(str::parse::<u32>);
    let is_old = match (numbers.next(), numbers.next()) {
        (Some(Ok(major)), Some(Ok(minor))) => (major, minor) < (5, 1),
        (Some(Ok(major)), _) => major <= 4,
        // Built from the newest sources.
        _ => false,
    };
    if is_old { ["-vsync", "0"] } else { ["-fps_mode", "passthrough"] }
}

/// In this time every ffmpeg says its version, which it has at hand; and so many bytes of it are enough.
const VERSION_WITHIN: Duration = Duration::from_secs(5);
const VERSION_BYTES: u64 = 4096;

/// What the program says of its version.
fn version(program: &Path) -> io::Result<String> {
    let mut command = Command::new(program);
    command.arg("-version");
    let text = answer(command, VERSION_WITHIN)?;
    Ok(text.split_whitespace().nth(2).unwrap_or_default().to_owned())
}

/// How a program's answer begins.
///
/// # Errors
/// If the program cannot be started, or says nothing more and does not end either.
fn answer(mut command: Command, within: Duration) -> io::Result<String> {
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
    let (sender, receiver) = mpsc::channel();
    if let Some(stdout) = child.stdout.take() {
        thread::spawn(move || {
            let mut text = Vec::new();
            let read = stdout.take(VERSION_BYTES).read_to_end(&mut text);
            // Nobody listens any more if it took too long.
            let _ = sender.send(read.map(|_| String::from_utf8_lossy(&text).into_owned()));
        });
    }
    let text = receiver.recv_timeout(within);
    // Whatever else it does is not wanted.
    child.kill()?;
    child.wait()?;
    text.map_err(|_| io::Error::new(io::ErrorKind::TimedOut, "it does not answer to '-version'"))?
}

/// Why there is no ffmpeg to work with; `None` if there is one.
pub(crate) fn ffmpeg_problem(program: &Path) -> Option<String> {
    version(program).err().map(|error| format!("ffmpeg ('{}'): {error}", program.display()))
}

/// The command that writes every image to standard output and its time to standard error.
pub(crate) fn command(program: &Path, input: &FfmpegInput, pixels: Pixels) -> io::Result<Command> {
    let mode = passthrough(&version(program)?);
    // A path from here would not lead there from the folder in which it runs.
    let is_path = program.components().count() > 1;
    let program = if is_path { std::path::absolute(program)? } else { program.to_path_buf() };
    let (codec, format) = match pixels {
        Pixels::Gray => ("pgm", "gray"),
        Pixels::Color => ("ppm", "rgb24"),
    };
    let mut command = Command::new(program);
    // The filter `showinfo` says the time of every image, at the level `info`; all other lines get their level in front.
    command.args(["-hide_banner", "-nostdin", "-nostats", "-loglevel", "level+info"]);
    command.args(&input.args);
    let sampled = input.sampled_hz.map(|rate_hz| format!("fps={rate_hz},")).unwrap_or_default();
    command.args(["-map", "0:v:0", "-vf", &format!("{sampled}showinfo=checksum=0")]).args(mode);
    command.args(["-f", "image2pipe", "-c:v", codec, "-pix_fmt", format, "pipe:1"]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    if let Some(folder) = &input.folder {
        command.current_dir(folder);
    }
    Ok(command)
}

/// The time in a line of `showinfo`, seconds.
pub(crate) fn time_in(line: &str) -> Option<f64> {
    let (_, rest) = line.split_once("pts_time:")?;
    rest.split_whitespace().next()?.parse().ok().filter(|secs: &f64| secs.is_finite())
}

/// The message of a line that reports a fault.
pub(crate) fn fault_in(line: &str) -> Option<&str> {
    let (_, message) = ["[error] ", "[fatal] ", "[panic] "].iter().find_map(|mark| line.split_once(mark))?;
    Some(message.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_old_and_new() {
        for (version, option) in [
            ("4.4.2-0ubuntu0.22.04.1", "-vsync"),
            ("5.0.1", "-vsync"),
            ("5.1.9-0+deb12u1", "-fps_mode"),
            ("n7.1", "-fps_mode"),
            ("7.0.2-static", "-fps_mode"),
            ("N-118000-g1234567", "-fps_mode"),
            ("", "-fps_mode"),
        ] {
            assert_eq!(passthrough(version)[0], option, "{version}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_program_that_never_ends_is_not_waited_for() {
        let command = |program: &str, argument: &str| {
            let mut command = Command::new(program);
            command.arg(argument);
            command
        };
        let silent = answer(command("sleep", "60"), Duration::from_millis(100)).unwrap_err();
        assert_eq!(silent.kind(), io::ErrorKind::TimedOut);
        let endless = answer(command("yes", "version"), Duration::from_secs(30)).unwrap();
        assert_eq!(endless.len() as u64, VERSION_BYTES);
        assert_eq!(
            answer(command("echo", "ffmpeg version 7.1"), VERSION_WITHIN).unwrap(),
            "ffmpeg version 7.1\n"
        );
    }

    #[test]
    fn lines_of_standard_error() {
        let line = "[Parsed_showinfo_0 @ 0x5] [info] n:   2 pts:   1024 pts_time:0.0666667 duration: 512 fmt:yuv420p";
        assert_eq!(time_in(line), Some(0.066_666_7));
        assert_eq!(time_in("[info] pts_time:NOPTS"), None);
        assert_eq!(fault_in("[mov @ 0x5] [error] moov atom not found"), Some("moov atom not found"));
        assert_eq!(fault_in("[info] Stream mapping:"), None);
    }
}
