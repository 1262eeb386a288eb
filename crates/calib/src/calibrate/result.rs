//! The outcome.

use nalgebra::{Point2, Vector2};
use visloc_core::geom::Camera;

use super::DroppedView;
use crate::{Board, CameraFromBoard, LensModel};

/// A calibrated camera and how well it is known.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// The camera.
    pub camera: Camera,
    /// Which lens was estimated.
    pub model: LensModel,
    /// The board.
    pub board: Board,
    /// All parameters with their standard deviations.
    pub parameters: Vec<Parameter>,
    /// Pictures that were used.
    pub views: Vec<View>,
    /// Pictures that were not.
    pub dropped: Vec<DroppedView>,
    /// Root of the mean squared distance between corners and their projection, pixels (the definition of OpenCV), without the
    /// corners that were left out.
    pub rms_px: f64,
    /// Median distance, pixels.
    pub median_px: f64,
    /// Standard deviation of a corner along one axis, corrected for the number of parameters, pixels.
    pub corner_noise_px: f64,
    /// Steps of the refinement.
    pub iterations: usize,
}

/// A parameter of the camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// fx, fy, cx, cy (pixels), k1 and so on.
    pub name: &'static str,
    /// The estimate.
    pub value: f64,
    /// Its standard deviation.
    pub standard_deviation: f64,
}

/// A picture.
#[derive(Debug, Clone)]
pub struct View {
    /// Its name.
    pub name: String,
    /// Where the board is.
    pub camera_from_board: CameraFromBoard,
    /// Its corners.
    pub corners: Vec<SeenCorner>,
}

/// A corner in a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenCorner {
    /// Number on the board.
    pub id: usize,
    /// Where it is seen, pixels.
    pub px: Point2<f64>,
    /// Seen minus projected, pixels.
    pub residual_px: Vector2<f64>,
    /// Whether it is so far off that it was left out.
    pub is_outlier: bool,
}

impl View {
    /// Root of the mean squared distance of the corners that were used, pixels.
    pub fn rms_px(&self) -> f64 {
        let used: Vec<f64> =
            self.corners.iter().filter(|c| !c.is_outlier).map(|c| c.residual_px.norm_squared()).collect();
        (used.iter().sum::<f64>() / used.len().max(1) as f64).sqrt()
    }

    /// Angle between the board and the image plane, radians.
    pub fn tilt_rad(&self) -> f64 {
        self.camera_from_board.rotation()[(2, 2)].abs().min(1.0).acos()
    }
}

impl Calibration {
    /// Corners that were used.
    pub fn num_corners(&self) -> usize {
        self.corners().filter(|corner| !corner.is_outlier).count()
    }

    /// Corners that were left out.
    pub fn num_outliers(&self) -> usize {
        self.corners().filter(|corner| corner.is_outlier).count()
    }

    /// All corners of all pictures.
    pub fn corners(&self) -> impl Iterator<Item = &SeenCorner> {
        self.views.iter().flat_map(|view| &view.corners)
    }
}
