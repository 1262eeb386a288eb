//! `visloc camera` and `visloc check-camera`.

use clap::{Args, Subcommand};
use visloc_io::camera_file::CameraFormat;

use super::{
    InputName, InputPath, JsonArg, OutputFile, OutputFolder, PatternArgs, PictureSourceArgs, SeedArg,
    named::named,
    number::{numbers, whole},
};

/// Arguments of `visloc check-camera`.
#[derive(Debug, Args)]
#[command(
    long_about = "Says whether a calibration is plausible for given images: size and shape, principal point, angle of view, \
                  distortion that folds back inside of the image, straight edges that are bent without the distortion.\n\n\
                  The exit code is 0 if nothing is wrong (warnings are allowed) and 1 if something is.",
    after_long_help = "Examples:\n  visloc check-camera camera.toml photos\n  visloc check-camera camera_info.yaml photos --json check.json"
)]
pub struct CheckCameraArgs {
    /// Calibration: TOML, or YAML of ROS, Kalibr or OpenCV
    #[arg(value_name = "CAMERA")]
    pub camera: InputPath,
    /// Folder of images of this camera, a single image, or another source; walls, doors or field lines near the border say most
    #[arg(value_name = "SOURCE")]
    pub source: Option<InputName>,
    #[command(flatten)]
    pub json: JsonArg,
    #[command(flatten)]
    pub options: PictureSourceArgs,
}

/// Arguments of `visloc camera`.
#[derive(Debug, Args)]
#[command(arg_required_else_help = true)]
pub struct CameraArgs {
    /// What to do.
    #[command(subcommand)]
    pub command: CameraCommand,
}

/// Commands of `visloc camera`.
#[derive(Debug, Subcommand)]
pub enum CameraCommand {
    /// Convert a calibration: reads TOML, ROS, Kalibr, OpenCV
    Convert {
        /// Calibration
        #[arg(value_name = "IN")]
        input: InputPath,
        /// File to write
        #[arg(value_name = "OUT")]
        output: OutputFile,
        /// Form of the file [default: toml for .toml, ros for .yaml]
        #[arg(long, value_parser = named(FORMATS))]
        format: Option<CameraFormat>,
    },
    /// Draw a board to print, SVG in true size
    Board {
        /// File to write
        #[arg(long, value_name = "FILE.svg")]
        out: OutputFile,
        #[command(flatten)]
        pattern: PatternArgs,
    },
    /// Write a page on which map and image are laid over each other by hand, for a browser
    ///
    /// The lines of the map are drawn over the image while intrinsics and pose are changed with sliders, numbers or the pointer:
    /// drag a corner of the map to where it is in the image, and the rest follows. The page saves a camera file with the pose.
    ByHand {
        /// Image, PNG or JPEG
        #[arg(value_name = "IMAGE")]
        image: InputPath,
        /// Built-in map or file
        #[arg(long, value_name = "NAME|FILE")]
        map: InputName,
        /// Camera to start from [default: 60 degrees across, no distortion]
        #[arg(long, value_name = "FILE")]
        camera: Option<InputPath>,
        /// Pose of the camera to start from: x, y, height (meters), heading, pitch down, roll clockwise (degrees)
        #[arg(
            long,
            value_name = "X,Y,Z,HEADING,PITCH,ROLL",
            value_parser = six_numbers, allow_hyphen_values = true
        )]
        pose: Option<[f64; 6]>,
        /// Page to write
        #[arg(long, value_name = "FILE.html")]
        out: OutputFile,
    },
    /// Draw pictures of a board as a camera would see it, to try a calibration out
    Render {
        /// The camera: TOML, ROS, Kalibr, OpenCV
        #[arg(value_name = "CAMERA")]
        camera: InputPath,
        /// How many pictures
        #[arg(long, value_name = "N", default_value_t = 20, value_parser = whole::<u32>(1..=1000))]
        count: u32,
        /// Folder for the pictures
        #[arg(long, value_name = "DIR")]
        out: OutputFolder,
        #[command(flatten)]
        seed: SeedArg,
        #[command(flatten)]
        pattern: PatternArgs,
    },
}

/// Six numbers with commas between them.
fn six_numbers(text: &str) -> Result<[f64; 6], String> {
    numbers(text).map_err(|_| {
        format!("expected x,y,height,heading,pitch,roll, each from -10000 to 10000, found '{text}'")
    })
}

/// Forms of calibrations.
const FORMATS: &[(&str, CameraFormat, &str)] = &[
    ("toml", CameraFormat::Toml, "visloc's own"),
    ("ros", CameraFormat::Ros, "CameraInfo of ROS, YAML"),
    ("kalibr", CameraFormat::Kalibr, "camchain of Kalibr, YAML"),
    ("opencv", CameraFormat::OpenCv, "FileStorage of OpenCV, %YAML:1.0"),
];
