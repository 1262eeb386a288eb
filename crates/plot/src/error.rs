//! What can go wrong with a picture.

use std::{io, path::PathBuf};

/// Why a picture could not be rasterized or saved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// The scale is not a positive number or the PNG would be too large.
    #[error(
        "scale {scale} of a picture of {width_px} x {height_px} pixels: expected a positive scale and at most {max_px} pixels along each side"
    )]
    Scale {
        /// The refused scale.
        scale: f32,
        /// Width of the picture at scale 1.
        width_px: f32,
        /// Height of the picture at scale 1.
        height_px: f32,
        /// Longest permitted side.
        max_px: f32,
    },
    /// The SVG is not valid.
    #[error("the picture is not a valid SVG")]
    #[cfg(feature = "png")]
    Svg(#[from] resvg::usvg::Error),
    /// The pixels could not be written as PNG.
    #[error("encoding the PNG failed: {0}")]
    Png(String),
    /// A file could not be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}
