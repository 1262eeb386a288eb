//! `visloc evaluate` and `visloc colors`.

use std::str::FromStr;

use clap::{Args, ValueEnum};
use visloc_core::eval::camera::{Alignment, Step};

use super::{
    InputName, InputPath, JsonArg, OutputFile, OutputFolder,
    named::named,
    number::{seconds, within},
};

/// Arguments of `visloc evaluate`.
#[derive(Debug, Args)]
#[command(
    long_about = "Compares an estimated trajectory with the truth.\n\n\
                  A robot on the ground: position and heading errors from the first localization on, how soon the robot knew \
                  where it was, and how it recovered from kidnaps. TRUTH is a trajectory in TUM format or a table with the \
                  columns t, x, y, yaw and maybe z. ESTIMATE is the same, or the table that `visloc localize --estimates` \
                  writes. Only that table says how far each pose can be trusted; without it every pose counts as \
                  localized.\n\n\
                  A camera in space: absolute errors after alignment (ATE, APE), relative errors (RPE) and coverage, equal \
                  to those of `evo`. Both files are in TUM, KITTI or EuRoC format. Taken if an option of it is given, or if \
                  poses do not stand upright.",
    after_long_help = "Examples:\n  \
                       visloc evaluate truth.tum out/demo/evolutionary.csv\n  \
                       visloc evaluate groundtruth.csv robot.tum --json errors.json\n  \
                       visloc evaluate truth.tum robot.csv --plots out/plots --map robocup-spl-2010\n  \
                       visloc evaluate groundtruth.txt slam.tum --align sim3 --plots out/errors\n  \
                       visloc evaluate 06.txt estimate.txt --align se3 --delta 100m --all-pairs"
)]
pub struct EvaluateArgs {
    /// Where the robot or camera was
    #[arg(value_name = "TRUTH")]
    pub truth: InputPath,
    /// Where an algorithm said that it was
    #[arg(value_name = "ESTIMATE")]
    pub estimate: InputPath,
    /// Draw pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub plots: Option<OutputFolder>,
    /// Map below the trajectories in the pictures of a robot, built-in or TOML file
    #[arg(long, value_name = "NAME|FILE", requires = "plots", conflicts_with_all = ["align", "delta", "all_pairs", "offset", "max_diff"])]
    pub map: Option<InputName>,
    #[command(flatten)]
    pub json: JsonArg,
    #[command(flatten)]
    pub camera: CameraErrorArgs,
}

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TrajectoryKind {
    /// On the ground: position and heading
    Robot,
    /// In space, six degrees of freedom
    Camera,
}

/// How freely the estimate of a camera is moved before it is compared.
const ALIGNMENTS: &[(&str, Alignment, &str)] = &[
    ("none", Alignment::None, "Not at all"),
    ("se3", Alignment::Rigid, "Rotation and translation"),
    ("sim3", Alignment::Similarity, "Rotation, translation and scale"),
];

/// Options for cameras.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Cameras in space")]
pub struct CameraErrorArgs {
    /// What the trajectories are of [default: camera if an option of it is given or poses are tilted]
    #[arg(long = "as", value_name = "KIND", value_enum)]
    pub kind: Option<TrajectoryKind>,
    /// How freely the estimate may be moved [default: sim3, since one camera knows no scale]
    #[arg(long, value_name = "HOW", value_parser = named(ALIGNMENTS))]
    pub align: Option<Alignment>,
    /// Length of the motions of the relative error: poses (10) or meters (0.5m) [default: 1]
    #[arg(long, value_name = "N|METERS")]
    pub delta: Option<DeltaArg>,
    /// Relative errors of the motions from every pose, not of one motion after the other
    #[arg(long)]
    pub all_pairs: bool,
    /// Largest difference of times that belong together, seconds [default: 0.01]
    #[arg(long, value_name = "SECS", value_parser = seconds)]
    pub max_diff: Option<f64>,
    /// Added to the times of the estimate, seconds [default: 0]
    // One of the clocks may count from 1970.
    #[arg(long, value_name = "SECS", allow_hyphen_values = true, value_parser = within(-1e10, 1e10))]
    pub offset: Option<f64>,
}

impl CameraErrorArgs {
    /// The first option that only errors of a camera have.
    pub fn given(&self) -> Option<&'static str> {
        let Self { kind: _, align, delta, all_pairs, max_diff, offset } = self;
        let all = [
            ("--align", align.is_some()),
            ("--delta", delta.is_some()),
            ("--all-pairs", *all_pairs),
            ("--max-diff", max_diff.is_some()),
            ("--offset", offset.is_some()),
        ];
        all.into_iter().find(|(_, is_given)| *is_given).map(|(flag, _)| flag)
    }
}

/// A number of poses or meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeltaArg(pub Step);

impl FromStr for DeltaArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("expected poses (10) or meters (0.5m), both above 0, found '{text}'");
        let step = match text.strip_suffix('m') {
            Some(meters) => Step::Meters(meters.trim().parse().map_err(|_| expected())?),
            None => Step::Frames(text.parse().map_err(|_| expected())?),
        };
        match step {
            Step::Frames(1..) => Ok(Self(step)),
            Step::Meters(meters) if meters > 0.0 && meters.is_finite() => Ok(Self(step)),
            _ => Err(expected()),
        }
    }
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
    pub image: InputPath,
    /// The painted classes, PNG of the same size
    #[arg(long, value_name = "FILE")]
    pub labels: InputPath,
    /// Where the classes go: a file for `visloc localize --pipeline`
    #[arg(long, value_name = "FILE")]
    pub out: OutputFile,
}
