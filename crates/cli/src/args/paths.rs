//! Arguments that name something in the file system.
//!
//! What is read and what is written have types of their own, so that one place ([`crate::claims`]) knows inputs and outputs of every
//! command. An argument of another type that holds a path is found by a test.

use std::{
    fmt,
    ops::Deref,
    path::{Path, PathBuf},
};

use clap::builder::{PathBufValueParser, TryMapValueParser, TypedValueParser, ValueParserFactory};

/// A path that does one of these things, and what the typed one is made to, or why it cannot be one.
macro_rules! path_type {
    ($(#[$doc:meta])* $name:ident) => { path_type! { $(#[$doc])* $name, Ok } };
    ($(#[$doc:meta])* $name:ident, $made:expr) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Eq)]
        pub struct $name(PathBuf);

        impl Deref for $name {
            type Target = Path;

            fn deref(&self) -> &Path {
                &self.0
            }
        }

        impl AsRef<Path> for $name {
            fn as_ref(&self) -> &Path {
                &self.0
            }
        }

        impl From<PathBuf> for $name {
            fn from(path: PathBuf) -> Self {
                Self(path)
            }
        }

        impl ValueParserFactory for $name {
            type Parser = TryMapValueParser<PathBufValueParser, fn(PathBuf) -> Result<Self, String>>;

            fn value_parser() -> Self::Parser {
                PathBufValueParser::new().try_map(|typed| $made(typed).map(Self))
            }
        }
    };
}

path_type! {
    /// A file or folder that is read, or a program that is run.
    InputPath
}
path_type! {
    /// A file that is written; `-` is standard output.
    OutputFile, stream_or
}
path_type! {
    /// A map of SLAM that is read, and may become another one in the course of it: [`OutputMap`] may have the same name.
    InputMap
}
path_type! {
    /// A map of SLAM that is written. One that was there is kept beside it.
    OutputMap, named
}
path_type! {
    /// A folder that files are written into.
    OutputFolder, named
}
path_type! {
    /// A recording that grows during a run: one that is there is replaced with `--overwrite` only.
    OutputRecording, named
}

/// Standard output where the system has a path for it.
pub const STANDARD_OUTPUT: &str = "/dev/stdout";

// What a parser of clap makes of a typed path is a `Result`, so this one is one as well.
fn stream_or(typed: PathBuf) -> Result<PathBuf, String> {
    Ok(if cfg!(unix) && is_stream(&typed) { STANDARD_OUTPUT.into() } else { typed })
}

/// A path that cannot be standard output.
fn named(typed: PathBuf) -> Result<PathBuf, String> {
    if is_stream(&typed) {
        return Err("- is standard output, which is for single files that are written at once; give a name (./- for that one)".to_owned());
    }
    Ok(typed)
}

fn is_stream(typed: &Path) -> bool {
    typed.as_os_str() == "-"
}

/// Something that is read, by its name or by its path: a source, a map, a scenario.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputName(String);

impl Deref for InputName {
    type Target = str;

    fn deref(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for InputName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl ValueParserFactory for InputName {
    type Parser = TryMapValueParser<PathBufValueParser, fn(PathBuf) -> Result<Self, String>>;

    fn value_parser() -> Self::Parser {
        let of = |path: PathBuf| {
            let text = path.into_os_string().into_string();
            text.map(Self).map_err(|_| "expected a name in UTF-8; rename the file or its folder".to_owned())
        };
        PathBufValueParser::new().try_map(of)
    }
}

/// For commands that write recordings.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct OverwriteArg {
    /// Replace recordings that are there already
    #[arg(long)]
    pub overwrite: bool,
}
