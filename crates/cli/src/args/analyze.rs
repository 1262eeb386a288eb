//! `visloc evaluate` and `visloc colors`.

use std::path::PathBuf;

use clap::Args;

use super::JsonArg;

/// Arguments of `visloc evaluate`.
#[derive(Debug, Args)]
#[command(
    long_about = "Compares an estimated trajectory with the truth: position and heading errors from the first \
                  localization on, how soon the robot knew where it was, and how it recovered from kidnaps.\n\n\
                  TRUTH is a trajectory in TUM format or a table with the columns t, x, y, yaw and maybe z. ESTIMATE is \
                  the same, or the table that `visloc localize --estimates` writes. Only that table says how far each \
                  pose can be trusted; without it every pose counts as localized.",
    after_long_help = "Examples:\n  \
                       visloc evaluate truth.tum out/demo/evolutionary.csv\n  \
                       visloc evaluate groundtruth.csv robot.tum --json errors.json\n  \
                       visloc evaluate truth.tum robot.csv --plots out/plots --map robocup-spl-2010"
)]
pub struct EvaluateArgs {
    /// Where the robot was: TUM format or table
    #[arg(value_name = "TRUTH")]
    pub truth: PathBuf,
    /// Where an algorithm said that it was: TUM format or table
    #[arg(value_name = "ESTIMATE")]
    pub estimate: PathBuf,
    /// Draw pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub plots: Option<PathBuf>,
    /// Map below the trajectories in the pictures, built-in or TOML file
    #[arg(long, value_name = "NAME|FILE")]
    pub map: Option<String>,
    #[command(flatten)]
    pub json: JsonArg,
}

/// Arguments of `visloc colors`.
#[derive(Debug, Args)]
#[command(
    long_about = "Learns which colors are carpet, line, goal and ball on your field.\n\n\
                  Take an image of your robot, open it in a drawing program and paint a few patches of each class on a \
                  layer of its own with pure colors: green (0,255,0) carpet, white (255,255,255) lines, yellow \
                  (255,255,0) and blue (0,0,255) goals, orange (255,128,0) ball. Leave the rest black (0,0,0). Save the \
                  layer as PNG of the same size. Carpet and lines are needed, the others keep their defaults.",
    after_long_help = "Example:\n  \
                       visloc colors field.jpg --labels field-labels.png --out colors.toml\n  \
                       visloc localize recording.mcap --map my-field.toml --pipeline colors.toml"
)]
pub struct ColorsArgs {
    /// Image of the robot's camera, JPEG or PNG
    #[arg(value_name = "IMAGE")]
    pub image: PathBuf,
    /// The painted classes, PNG of the same size
    #[arg(long, value_name = "FILE")]
    pub labels: PathBuf,
    /// Where the classes go: a file for `visloc localize --pipeline`
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
}
