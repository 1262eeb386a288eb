//! `visloc locate`.

use clap::Args;

use super::{
    InputName, InputPath, JsonArg, OutputFolder, SeedArg,
    number::{degrees, within},
};

/// Arguments of `visloc locate`.
#[derive(Debug, Args)]
#[command(
    long_about = "Says where a single photo was taken: all places of the map that explain it, each with how probable it is, and how probable \
                  it is that it was none of them. On a field that equals itself turned by 180 degrees there are always two.\n\n\
                  The better pitch and height of the camera are known the fewer places are left; what is not given is searched.\n\n\
                  In a map of visloc slam (.vmap) a photo is recognized by what it shows; pitch and height come of it.",
    after_long_help = "Examples:\n  \
                       visloc locate photo.jpg --map robocup-spl-2024 --camera camera.toml\n  \
                       visloc locate photo.jpg --map my-field.toml --camera camera.toml --pitch 12 --height 0.5 --out out/photo\n  \
                       visloc locate photo.jpg --map room.vmap --camera camera.toml --out out/photo"
)]
pub struct LocateArgs {
    /// Photo, PNG or JPEG
    #[arg(value_name = "PHOTO")]
    pub photo: InputPath,
    /// Built-in map, TOML file, or map of visloc slam (.vmap)
    #[arg(long, value_name = "NAME|FILE")]
    pub map: InputName,
    /// Calibration of the camera: TOML, or YAML of ROS, Kalibr or OpenCV
    #[arg(long, value_name = "FILE")]
    pub camera: InputPath,
    /// How far the camera looks down, degrees, within a few
    #[arg(long, value_name = "DEG", value_parser = degrees, allow_hyphen_values = true)]
    pub pitch: Option<f64>,
    /// Height of the camera above the ground, meters, within a twentieth
    #[arg(long, value_name = "M", value_parser = within(0.05, 100.0))]
    pub height: Option<f64>,
    /// Parameters of image analysis and observation model, TOML
    #[arg(long, value_name = "FILE")]
    pub pipeline: Option<InputPath>,
    /// Draw the map over the photo as it is seen from each place, into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<OutputFolder>,
    #[command(flatten)]
    pub seed: SeedArg,
    #[command(flatten)]
    pub json: JsonArg,
}
