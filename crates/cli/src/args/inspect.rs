//! `visloc config` and `visloc map`.

use clap::{Args, Subcommand};

use super::{InputName, JsonArg, OutputFolder};

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
        /// Name of an algorithm or of a preset of SLAM (sdvl, orb-sdvl, config1 to config8), or "pipeline" or "topics"
        #[arg(value_name = "NAME")]
        name: String,
    },
}

/// Arguments of `visloc map`.
#[derive(Debug, Args)]
#[command(
    arg_required_else_help = true,
    long_about = "Checks a map: prints its dimensions, or says what is wrong with it and where, what was passed over in a file of \
                  another format, and what hinders a robot from being found in it.",
    after_long_help = "Examples:\n  visloc map check my-field.toml\n  visloc map show robocup-spl-2010 > my-field.toml"
)]
pub struct MapArgs {
    /// What to do.
    #[command(subcommand)]
    pub command: MapCommand,
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
    /// Print a building in another format as a map in TOML, to go on from
    Import {
        /// List of walls and doors (.yaml), occupancy grid of map_server (.yaml), plan (.svg, .dxf)
        #[arg(value_name = "FILE")]
        file: InputName,
    },
    /// Print a built-in map as TOML, to start a map of your own from
    Show {
        /// Built-in map
        #[arg(value_name = "NAME")]
        map: String,
    },
}
