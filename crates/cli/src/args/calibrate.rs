//! `visloc calibrate`.

use clap::{Args, ValueEnum};
use visloc_calib::{AprilGrid, Board, BoardError, Checkerboard, LensModel};

use super::{
    InputName, JsonArg, OutputFile, OutputFolder, PictureSourceArgs,
    named::named,
    number::{board_side, number, whole},
};

/// Kinds of boards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PatternArg {
    /// Black and white squares
    Checkerboard,
    /// Tags of the family tag36h11 in a grid, as Kalibr prints them
    Aprilgrid,
}

/// Lenses.
const LENSES: &[(&str, LensModel, &str)] = &[
    ("radtan", LensModel::RadialTangential, "Radial-tangential with k1, k2, p1, p2, k3: ordinary lenses"),
    ("radtan4", LensModel::RadialTangential4, "Radial-tangential without k3"),
    (
        "kannala-brandt",
        LensModel::KannalaBrandt,
        "Equidistant fisheye with k1 to k4: lenses of more than 100 degrees",
    ),
];

/// The board.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Board")]
pub struct PatternArgs {
    /// Kind of board
    #[arg(long, value_enum, default_value_t = PatternArg::Checkerboard)]
    pub pattern: PatternArg,
    /// Inner corners of a checkerboard (one less than squares), or tags of a grid: columns x rows
    #[arg(long, value_name = "CxR", value_parser = columns_and_rows)]
    pub size: Option<(usize, usize)>,
    /// Side of a square, meters
    #[arg(long, value_name = "METERS", value_parser = board_side)]
    pub square: Option<f64>,
    /// Side of a tag with its black border, meters
    #[arg(long, value_name = "METERS", value_parser = board_side)]
    pub tag: Option<f64>,
    /// Gap between tags as a share of a tag [default: 0.3]
    #[arg(long, value_name = "SHARE", value_parser = number)]
    pub spacing: Option<f64>,
    /// Number of the first tag [default: 0]
    #[arg(long, value_name = "ID", value_parser = whole::<usize>(0..))]
    pub first_tag: Option<usize>,
    /// Width of a tag's black border, cells: 2 on boards of Kalibr, 1 on plain tags [default: 2]
    #[arg(long, value_name = "CELLS", value_parser = whole::<usize>(0..))]
    pub border: Option<usize>,
}

impl PatternArgs {
    /// The board, checked.
    pub fn board(&self) -> Result<Board, BoardError> {
        self.refuse_other_pattern()?;
        let missing = |expected: &str| BoardError { expected: expected.into(), found: "none".into() };
        let needed = |option: Option<f64>, expected: &str| option.ok_or_else(|| missing(expected));
        let (columns, rows) = self.size.ok_or_else(|| missing("--size, columns x rows of the board"))?;
        let board = match self.pattern {
            PatternArg::Checkerboard => Board::Checkerboard(Checkerboard {
                columns,
                rows,
                square_m: needed(self.square, "--square, the side of a square in meters")?,
            }),
            PatternArg::Aprilgrid => Board::AprilGrid(AprilGrid {
                columns,
                rows,
                tag_m: needed(self.tag, "--tag, the side of a tag in meters")?,
                spacing: self.spacing.unwrap_or(0.3),
                first_id: self.first_tag.unwrap_or(0),
                border_cells: self.border.unwrap_or(2),
            }),
        };
        board.check().map(|()| board)
    }

    /// Whether there is a board at all.
    pub fn is_given(&self) -> bool {
        let is_tag =
            self.tag.is_some() || self.spacing.is_some() || self.first_tag.is_some() || self.border.is_some();
        self.size.is_some() || self.square.is_some() || is_tag || self.pattern == PatternArg::Aprilgrid
    }

    fn refuse_other_pattern(&self) -> Result<(), BoardError> {
        let (of_other, pattern) = match self.pattern {
            PatternArg::Checkerboard => (
                [
                    ("--tag", self.tag.is_some()),
                    ("--spacing", self.spacing.is_some()),
                    ("--first-tag", self.first_tag.is_some()),
                    ("--border", self.border.is_some()),
                ]
                .to_vec(),
                "--pattern aprilgrid",
            ),
            PatternArg::Aprilgrid => (vec![("--square", self.square.is_some())], "--pattern checkerboard"),
        };
        match of_other.into_iter().find(|(_, is_given)| *is_given) {
            Some((found, _)) => Err(BoardError {
                expected: format!("{pattern} with {found}"),
                found: "the other pattern".into(),
            }),
            None => Ok(()),
        }
    }
}

/// `9x6`.
fn columns_and_rows(text: &str) -> Result<(usize, usize), String> {
    let parts =
        text.split_once(['x', 'X']).and_then(|(c, r)| Some((c.trim().parse().ok()?, r.trim().parse().ok()?)));
    parts.ok_or_else(|| format!("expected columns x rows, for instance 9x6, found '{text}'"))
}

/// Arguments of `visloc calibrate`.
#[derive(Debug, Args)]
#[command(
    long_about = "Calibrates a camera from pictures of a flat board: finds the board in every picture, estimates focal lengths, \
                  principal point and distortion, says how well each is known, and what to photograph next.\n\n\
                  Take 15 to 30 sharp pictures, the board in every part of the image, tilted by 30 degrees to each side, once so \
                  near that it fills the image. docs/calibration.md goes through it; visloc camera board prints a board.\n\n\
                  Without a board (no --size), the camera is found from a video that it took while it moved and turned: focal length, \
                  principal point and two radial coefficients, to about a percent.",
    after_long_help = "Examples:\n  \
                       visloc calibrate first.mp4 --out camera.toml\n  \
                       visloc calibrate photos --size 9x6 --square 0.025 --out camera.toml --report out/camera\n  \
                       visloc calibrate photos --pattern aprilgrid --size 6x6 --tag 0.088 --model kannala-brandt --out camera.toml\n  \
                       visloc calibrate photos --size 9x6 --square 0.025 --ros camera_info.yaml"
)]
pub struct CalibrateArgs {
    /// Folder of images (PNG, JPEG) of one camera, or a video, camera, bag or topic (`visloc sources`)
    #[arg(value_name = "SOURCE")]
    pub source: InputName,
    /// The lens [default: radtan]
    #[arg(long, value_parser = named(LENSES))]
    pub model: Option<LensModel>,
    /// Write the camera to this file, TOML
    #[arg(long, value_name = "FILE")]
    pub out: Option<OutputFile>,
    /// Write the camera to this file, as ROS reads it (YAML of a CameraInfo)
    #[arg(long, value_name = "FILE")]
    pub ros: Option<OutputFile>,
    /// Write a report with pictures into this folder
    #[arg(long, value_name = "DIR")]
    pub report: Option<OutputFolder>,
    #[command(flatten)]
    pub json: JsonArg,
    #[command(flatten)]
    pub options: PictureSourceArgs,
    #[command(flatten)]
    pub pattern: PatternArgs,
}
