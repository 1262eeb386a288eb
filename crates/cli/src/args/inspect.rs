//! `visloc config` and `visloc map`.

use clap::{Args, Subcommand};

use super::{
    InputMap, InputName, InputPath, JsonArg, OutputFile, OutputFolder, OutputMap, SeedArg,
    number::{number, whole},
};

/// Arguments of `visloc config`.
#[derive(Debug, Args)]
#[command(
    arg_required_else_help = true,
    long_about = "Shows the parameters that can be set in files, with their defaults, as TOML.",
    after_long_help = "Example:\n  \
                       visloc config show mce > mce.toml\n  \
                       visloc localize recording.mcap --map robocup-spl-2010 --algorithm mce --config mce.toml\n  \
                       visloc config show sdvl > sdvl.toml"
)]
pub struct ConfigArgs {
    /// What to do.
    #[command(subcommand)]
    pub command: ConfigCommand,
}

/// Commands of `visloc config`.
#[derive(Debug, Subcommand)]
pub enum ConfigCommand {
    /// Print the defaults of an algorithm, of SLAM, of the pipeline or of the topics
    Show {
        /// Name of an algorithm or of a preset of SLAM (sdvl, orb-sdvl, small, config1 to config8), or "pipeline" or "topics"
        #[arg(value_name = "NAME")]
        name: String,
        #[command(flatten)]
        out: TextOutArg,
    },
}

/// Where a text goes.
#[derive(Debug, Args)]
pub struct TextOutArg {
    /// Write it to this file in place of printing it
    #[arg(long, value_name = "FILE")]
    pub out: Option<OutputFile>,
}

/// Arguments of `visloc map`.
#[derive(Debug, Args)]
#[command(
    arg_required_else_help = true,
    long_about = "Maps that are drawn: check says what is wrong with one and where, what was passed over in a file of another format, \
                  and what hinders a robot from being found in it; import makes one. Maps that SLAM made (.vmap): what is in them, meters \
                  and a frame for them, two made one, smaller ones, files for other programs.",
    after_long_help = "Examples:\n  visloc map check my-field.toml\n  visloc map show robocup-spl-2010 --out my-field.toml\n  \
                       visloc map info room.vmap --plots out/room\n  \
                       visloc map align room.vmap --to truth.tum --out room.vmap\n  \
                       visloc map merge room.vmap hall.vmap --out both.vmap\n  \
                       visloc map trim room.vmap --keyframes 100 --out small.vmap\n  \
                       visloc map export room.vmap --colmap out/colmap"
)]
pub struct MapArgs {
    /// What to do.
    #[command(subcommand)]
    pub command: MapCommand,
}

/// Arguments of `visloc map align`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("by").required(true).args(["to", "distance", "camera_height"])))]
pub struct MapAlignArgs {
    /// Map of visloc slam (.vmap)
    #[arg(value_name = "FILE")]
    pub map: InputMap,
    /// True places of the camera while the map was made, TUM format or EuRoC's CSV
    #[arg(long, value_name = "FILE")]
    pub to: Option<InputPath>,
    /// Distance between the places of the camera at the two times of --between, meters
    #[arg(long, value_name = "METERS", value_parser = number, requires = "between")]
    pub distance: Option<f64>,
    /// Height of the camera above the ground that it saw while the map was made, meters
    #[arg(long, value_name = "METERS", value_parser = number)]
    pub camera_height: Option<f64>,
    /// Two times of the images that the map was made of, seconds
    #[arg(long, value_name = "SECONDS", value_parser = number, num_args = 2, requires = "distance")]
    pub between: Option<Vec<f64>>,
    /// Where the aligned map goes; it may be the same file, which is kept as FILE~ then
    #[arg(long, value_name = "FILE")]
    pub out: OutputMap,
}

/// Commands of `visloc map`.
#[derive(Debug, Subcommand)]
pub enum MapCommand {
    /// Say what is wrong with a map, or print its dimensions
    Check {
        /// Built-in map, TOML file, list of walls and doors (.yaml), occupancy grid of map_server (.yaml), plan (.svg, .dxf)
        #[arg(value_name = "NAME|FILE")]
        map: InputName,
        /// Draw the map into this folder
        #[arg(long, value_name = "DIR")]
        plots: Option<OutputFolder>,
        /// Where the findings go
        #[command(flatten)]
        json: JsonArg,
    },
    /// Print a map in another format as TOML, to go on from
    Import {
        /// List of walls and doors (.yaml), occupancy grid of map_server (.yaml), plan (.svg, .dxf), measures of a field (.yaml)
        #[arg(value_name = "FILE")]
        file: InputName,
        #[command(flatten)]
        out: TextOutArg,
    },
    /// Print a built-in map as TOML, to start a map of your own from; of a map of visloc slam (.vmap) what info says
    Show {
        /// Built-in map, or map of visloc slam (.vmap)
        #[arg(value_name = "NAME|FILE")]
        map: InputName,
        /// Draw the map into this folder
        #[arg(long, value_name = "DIR")]
        plots: Option<OutputFolder>,
        #[command(flatten)]
        out: TextOutArg,
    },
    /// Say what a map of visloc slam (.vmap) has: keyframes, landmarks, scale, where it comes from; draw it
    Info {
        /// Map of visloc slam
        #[arg(value_name = "FILE")]
        map: InputPath,
        /// Draw the map from above and aside into this folder
        #[arg(long, value_name = "DIR")]
        plots: Option<OutputFolder>,
        /// Where the findings go
        #[command(flatten)]
        json: JsonArg,
    },
    /// Give a map of visloc slam (.vmap) the frame and the meters of known places, or its scale
    Align(MapAlignArgs),
    /// Make one map of two maps of visloc slam (.vmap) that show a common place
    Merge {
        /// Map whose frame and unit of length stay, unless only the other one's are known
        #[arg(value_name = "FILE")]
        map: InputMap,
        /// Map that becomes a part of it
        #[arg(value_name = "OTHER")]
        other: InputMap,
        /// Where the one map goes; it may be one of the two, which is kept as FILE~ then
        #[arg(long, value_name = "FILE")]
        out: OutputMap,
        #[command(flatten)]
        seed: SeedArg,
    },
    /// Make a map of visloc slam (.vmap) smaller: keyframes of which most is seen by others go
    Trim {
        /// Map of visloc slam
        #[arg(value_name = "FILE")]
        map: InputMap,
        /// Keyframes to keep of the largest map in it
        #[arg(long, value_name = "N", value_parser = whole::<u32>(2..))]
        keyframes: u32,
        /// Where the smaller map goes; it may be the same file, which is kept as FILE~ then
        #[arg(long, value_name = "FILE")]
        out: OutputMap,
    },
    /// Write a map of visloc slam (.vmap) for other programs
    Export {
        /// Map of visloc slam
        #[arg(value_name = "FILE")]
        map: InputPath,
        /// Write the landmarks and the ways of the cameras to this file, PLY
        #[arg(long, value_name = "FILE")]
        points: Option<OutputFile>,
        /// Write the model of COLMAP (cameras.txt, images.txt, points3D.txt) and the images into this folder
        #[arg(long, value_name = "DIR")]
        colmap: Option<OutputFolder>,
        /// Write transforms.json of nerfstudio and the images into this folder
        #[arg(long, value_name = "DIR")]
        nerfstudio: Option<OutputFolder>,
        /// Write a floor picture for Nav2 into this folder (floor.pgm, floor.yaml): of a map in meters that has z up
        #[arg(long, value_name = "DIR")]
        floor: Option<OutputFolder>,
    },
}
