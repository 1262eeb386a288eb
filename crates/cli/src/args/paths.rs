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

/// A path that does one of these things.
macro_rules! path_type {
    ($(#[$doc:meta])* $name:ident) => {
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
            type Parser = clap::builder::MapValueParser<PathBufValueParser, fn(PathBuf) -> Self>;

            fn value_parser() -> Self::Parser {
                PathBufValueParser::new().map(Self)
            }
        }
    };
}

path_type! {
    /// A file or folder that is read, or a program that is run.
    InputPath
}
path_type! {
    /// A file that is written.
    OutputFile
}
path_type! {
    /// A map of SLAM that is read, and may become another one in the course of it: [`OutputMap`] may have the same name.
    InputMap
}
path_type! {
    /// A map of SLAM that is written. One that was there is kept beside it.
    OutputMap
}
path_type! {
    /// A folder that files are written into.
    OutputFolder
}
path_type! {
    /// A recording that grows during a run: one that is there is replaced with `--overwrite` only.
    OutputRecording
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
