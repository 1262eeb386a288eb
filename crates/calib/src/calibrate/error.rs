//! What can be wrong with pictures for a calibration.

use std::fmt;

use thiserror::Error;

use crate::BoardError;

/// Why there is no calibration.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CalibrateError {
    /// The board has impossible dimensions.
    #[error(transparent)]
    Board(#[from] BoardError),
    /// Too few pictures show the board.
    #[error("expected at least {expected} usable pictures of the board, found {found}{}", listed(.dropped))]
    TooFewViews {
        /// Needed.
        expected: usize,
        /// Usable.
        found: usize,
        /// The others.
        dropped: Vec<DroppedView>,
    },
    /// A corner is not in the picture.
    #[error(
        "{name}: expected corners in a picture of {} x {} px, found one at ({:.1}, {:.1})", size_px.0, size_px.1, px.0, px.1
    )]
    Outside {
        /// Name of the picture.
        name: String,
        /// Where the corner is, pixels.
        px: (f64, f64),
        /// Width and height of all pictures.
        size_px: (u32, u32),
    },
    /// No focal length explains the pictures.
    #[error("no camera explains the pictures: are the board's dimensions right, and is it flat?")]
    NoStart,
    /// The pictures leave a parameter open.
    #[error(
        "the pictures do not determine {parameter} ({reason}); the board was tilted by {tilt_deg:.0} degrees at most: take some \
         pictures with it tilted by 30 degrees to each side"
    )]
    Degenerate {
        /// Which.
        parameter: String,
        /// How uncertain it is.
        reason: String,
        /// Largest angle between the board and the image plane, degrees.
        tilt_deg: f64,
    },
}

fn listed(dropped: &[DroppedView]) -> String {
    let shown: Vec<String> =
        dropped.iter().take(3).map(|view| format!("; {}: {}", view.name, view.reason)).collect();
    shown.concat()
}

/// A picture that was not used.
#[derive(Debug, Clone, PartialEq)]
pub struct DroppedView {
    /// Its name.
    pub name: String,
    /// Why.
    pub reason: DropReason,
}

/// Why a picture was not used.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum DropReason {
    /// Fewer corners than a pose needs.
    FewCorners(usize),
    /// The corners are not the image of a plane in front of the camera.
    NotAPlane,
    /// It shows what another one shows, which is used in its place: its name.
    SameView(String),
    /// The residuals are far above those of the others: median of this one and of all, pixels.
    LargeResiduals {
        /// Of this picture.
        median_px: f64,
        /// Of all pictures.
        usual_px: f64,
    },
}

impl fmt::Display for DropReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FewCorners(found) => write!(f, "expected at least 8 corners, found {found}"),
            Self::NotAPlane => write!(f, "the corners are not the picture of a flat board"),
            Self::SameView(of) => write!(f, "shows the same view as {of}"),
            Self::LargeResiduals { median_px, usual_px } => {
                write!(
                    f,
                    "residuals of {median_px:.2} px where the others have {usual_px:.2} px: moved or bent?"
                )
            }
        }
    }
}
