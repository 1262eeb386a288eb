//! `visloc likelihood`.

use std::str::FromStr;

use clap::Args;

use super::{
    InputName, InputPath, JsonArg, OutputFolder, SeedArg, SourceArgs, TopicArgs,
    number::{degrees, numbers, seconds, within},
};

/// Arguments of `visloc likelihood`.
#[derive(Debug, Args)]
#[command(
    long_about = "Draws how well every pose on the map explains one image: over all places with the best or a given heading, as \
                  colors and as a surface in space, and over all headings at one place.\n\n\
                  The image is a frame of a recording (or of sim:SCENARIO), or one from a pose that you choose. The pictures \
                  show the maximum, and the true pose where it is known.",
    after_long_help = "Examples:\n  \
                       visloc likelihood --view 0.6,1.3,-30                          on the field of 2010\n  \
                       visloc likelihood --view -2,0.5,10 --pan 30 --map robocup-spl-2024\n  \
                       visloc likelihood recording.mcap --at 12.5 --map robocup-spl-2010 --heading truth\n  \
                       visloc likelihood sim:crowd --at 8 --step 0.1 --out out/crowd"
)]
pub struct LikelihoodArgs {
    /// ROS 2 bag (.mcap or folder), sim:SCENARIO, ... (see: visloc sources)
    #[arg(value_name = "SOURCE", required_unless_present = "view")]
    pub bag: Option<InputName>,
    /// Which frame of the recording: the first that is so many seconds after the start
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = seconds, conflicts_with = "view")]
    pub at: f64,
    /// Instead of a recording, a simulated image from this pose: meters, meters, degrees
    #[arg(long, value_name = "X,Y,DEG", conflicts_with = "bag", allow_hyphen_values = true, value_parser = numbers::<3>)]
    pub view: Option<[f64; 3]>,
    /// With --view: how far the head is turned to the left, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_hyphen_values = true, value_parser = degrees, requires = "view", conflicts_with = "bag")]
    pub pan: f64,
    /// With --view: how far the head looks down, degrees
    #[arg(long, value_name = "DEG", default_value_t = 13.0, allow_hyphen_values = true, value_parser = degrees, requires = "view", conflicts_with = "bag")]
    pub tilt: f64,
    /// Built-in map or TOML file; may be left out with sim:SCENARIO [default with --view: robocup-spl-2010]
    #[arg(long, value_name = "NAME|FILE")]
    pub map: Option<InputName>,
    /// Heading at every place: "best", "truth" or degrees
    #[arg(long, value_name = "HEADING", default_value = "best", allow_hyphen_values = true)]
    pub heading: HeadingText,
    /// Place of the profile over all headings, meters [default: the true place, else the maximum]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = numbers::<2>)]
    pub place: Option<[f64; 2]>,
    /// Side of a cell of the map, meters
    #[arg(long, value_name = "M", default_value_t = 0.05, value_parser = within(0.01, 1.0))]
    pub step: f64,
    /// Weigh all pixels instead of a few taken at random
    #[arg(long)]
    pub all_pixels: bool,
    /// Parameters of image analysis and observation model, TOML
    #[arg(long, value_name = "FILE")]
    pub pipeline: Option<InputPath>,
    /// Folder for pictures and tables
    #[arg(long, value_name = "DIR", default_value = "out/likelihood")]
    pub out: OutputFolder,
    #[command(flatten)]
    pub seed: SeedArg,
    #[command(flatten)]
    pub json: JsonArg,
    #[command(flatten)]
    pub options: SourceArgs,
    #[command(flatten)]
    pub topics: TopicArgs,
}

/// A heading as it is typed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HeadingText {
    /// The best at each place.
    Best,
    /// The true one everywhere.
    Truth,
    /// So many degrees everywhere.
    Degrees(f64),
}

impl FromStr for HeadingText {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "best" => Ok(Self::Best),
            "truth" => Ok(Self::Truth),
            _ => match numbers::<1>(text) {
                Ok([degrees]) => Ok(Self::Degrees(degrees)),
                Err(_) => Err(format!("expected best, truth or degrees, found {text:?}")),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_places_and_headings_are_read() {
        assert_eq!(numbers("1, -2,30"), Ok([1.0, -2.0, 30.0]));
        assert!(numbers::<3>("1,2").is_err() && numbers::<2>("1,x").is_err());
        assert!(numbers::<2>("nan,1").is_err());
        assert_eq!("-45".parse(), Ok(HeadingText::Degrees(-45.0)));
        assert!("north".parse::<HeadingText>().unwrap_err().contains("truth"));
        assert!(within(0.01, 1.0)("0").is_err() && seconds("-1").is_err());
    }
}
