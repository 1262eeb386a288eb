//! Everything that reads bytes from outside, by name: for the mutations here and for the fuzzer (`fuzz/`), which takes this
//! folder over. A new format is a line in [`PARSERS`].
//!
//! A parser may refuse its input, but it must come back soon and must not panic.

mod bags;
pub mod benchmarks;
mod calibrations;
pub mod experiments;
mod maps;
mod pictures;
mod robots;
mod settings;
mod studio;
mod tables;
mod team;
mod visual_maps;

use std::{fs, path::Path};

use tempfile::TempDir;

/// Something that reads bytes from outside.
pub struct Parser {
    /// Name of the fuzzing target.
    pub name: &'static str,
    /// Longest input that is tried.
    pub max_bytes: usize,
    /// Good inputs, to begin with.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Reads an input as the program does.
    pub read: fn(&[u8]),
}

const TEXT: usize = 64 << 10;
const BINARY: usize = 64 << 10;
const PICTURE: usize = 256 << 10;

/// All of them.
pub const PARSERS: &[Parser] = &[
    Parser { name: "bag_mcap", max_bytes: BINARY, seeds: bags::mcap_seeds, read: bags::mcap },
    Parser { name: "bag_sqlite", max_bytes: BINARY, seeds: bags::sqlite_seeds, read: bags::sqlite },
    Parser { name: "bag_ros1", max_bytes: PICTURE, seeds: bags::ros1_seeds, read: bags::ros1 },
    Parser {
        name: "ros1_definitions",
        max_bytes: TEXT,
        seeds: bags::definition_seeds,
        read: bags::definition,
    },
    Parser { name: "bag_metadata", max_bytes: TEXT, seeds: bags::metadata_seeds, read: bags::metadata },
    Parser { name: "messages", max_bytes: BINARY, seeds: bags::message_seeds, read: bags::messages },
    Parser { name: "image_files", max_bytes: PICTURE, seeds: pictures::file_seeds, read: pictures::file },
    Parser { name: "image_raw", max_bytes: PICTURE, seeds: pictures::raw_seeds, read: pictures::raw },
    Parser {
        name: "image_stream",
        max_bytes: PICTURE,
        seeds: pictures::stream_seeds,
        read: pictures::stream,
    },
    Parser {
        name: "calibration_toml",
        max_bytes: TEXT,
        seeds: calibrations::toml_seeds,
        read: calibrations::toml,
    },
    Parser {
        name: "calibration_yaml",
        max_bytes: TEXT,
        seeds: calibrations::yaml_seeds,
        read: calibrations::yaml,
    },
    Parser {
        name: "trajectories",
        max_bytes: TEXT,
        seeds: tables::trajectory_seeds,
        read: tables::trajectory,
    },
    Parser { name: "dataset_lists", max_bytes: TEXT, seeds: tables::dataset_seeds, read: tables::dataset },
    Parser { name: "robot_description", max_bytes: TEXT, seeds: robots::seeds, read: robots::read },
    Parser { name: "map_toml", max_bytes: TEXT, seeds: maps::toml_seeds, read: maps::toml },
    Parser { name: "map_svg", max_bytes: TEXT, seeds: maps::svg_seeds, read: maps::svg },
    Parser { name: "map_dxf", max_bytes: TEXT, seeds: maps::dxf_seeds, read: maps::dxf },
    Parser { name: "map_list", max_bytes: TEXT, seeds: maps::list_seeds, read: maps::list },
    Parser { name: "map_grid", max_bytes: TEXT, seeds: maps::grid_seeds, read: maps::grid },
    Parser { name: "map_grid_picture", max_bytes: PICTURE, seeds: maps::picture_seeds, read: maps::picture },
    Parser { name: "map_of_slam", max_bytes: BINARY, seeds: visual_maps::seeds, read: visual_maps::read },
    Parser { name: "scenario", max_bytes: TEXT, seeds: settings::scenario_seeds, read: settings::scenario },
    Parser {
        name: "parameters",
        max_bytes: TEXT,
        seeds: settings::parameter_seeds,
        read: settings::parameters,
    },
    Parser {
        name: "ros_parameters",
        max_bytes: TEXT,
        seeds: settings::ros_parameter_seeds,
        read: settings::ros_parameters,
    },
    Parser {
        name: "experiment_records",
        max_bytes: TEXT,
        seeds: experiments::seeds,
        read: experiments::read,
    },
    Parser { name: "benchmark_results", max_bytes: TEXT, seeds: benchmarks::seeds, read: benchmarks::read },
    Parser { name: "addresses", max_bytes: 4 << 10, seeds: settings::address_seeds, read: settings::address },
    Parser { name: "studio_commands", max_bytes: TEXT, seeds: studio::command_seeds, read: studio::commands },
    Parser {
        name: "studio_buildings",
        max_bytes: TEXT,
        seeds: studio::building_seeds,
        read: studio::building,
    },
    Parser { name: "team_messages", max_bytes: 4 << 10, seeds: team::seeds, read: team::read },
    Parser {
        name: "studio_messages",
        max_bytes: BINARY,
        seeds: studio::message_seeds,
        read: studio::message,
    },
    Parser {
        name: "studio_recording",
        max_bytes: BINARY,
        seeds: studio::recording_seeds,
        read: studio::recording,
    },
];

thread_local! {
    static FOLDER: TempDir = in_memory();
}

/// A new folder, where there is one in memory: thousands of small files are written.
pub fn in_memory() -> TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap()
}

/// A folder of this thread, which stays from input to input.
fn in_folder<T>(read: impl FnOnce(&Path) -> T) -> T {
    FOLDER.with(|folder| read(folder.path()))
}

/// The input as a file of this name.
fn as_file<T>(name: &str, bytes: &[u8], read: impl FnOnce(&Path) -> T) -> T {
    in_folder(|folder| {
        let path = folder.join(name);
        fs::write(&path, bytes).unwrap();
        read(&path)
    })
}

/// The first byte, which chooses among some forms, and the rest.
fn choice(bytes: &[u8], num_forms: usize) -> Option<(usize, &[u8])> {
    let (first, rest) = bytes.split_first()?;
    Some((usize::from(*first) % num_forms, rest))
}

/// A seed for [`choice`].
fn chosen(form: usize, bytes: impl AsRef<[u8]>) -> Vec<u8> {
    [&[u8::try_from(form).unwrap()], bytes.as_ref()].concat()
}
