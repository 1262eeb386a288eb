//! Robots and balls in an image.

use nalgebra::{Matrix2, Point2};

/// What was detected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ObjectKind {
    /// A robot, of whichever team.
    Robot,
    /// The ball.
    Ball,
}

/// A robot or a ball in one image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectedObject {
    /// What it is.
    pub kind: ObjectKind,
    /// Where its middle stands on the ground, seen from the robot: ahead and to the left, meters.
    pub in_robot: Point2<f64>,
    /// Covariance of that, square meters.
    pub covariance: Matrix2<f64>,
    /// Left, top, right, bottom of the box that was judged, pixels.
    pub bounds_px: [f64; 4],
    /// Log of how much better it explains the image than the ground alone, capped.
    pub evidence_nats: f64,
}
