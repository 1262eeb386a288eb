//! Image analysis: from a camera image to the few pixels that a localizer weighs.
//!
//! The result is a [`Percept`], the same type for every world: labelled feature pixels, the camera they were seen with,
//! and the quality of the image. [`field::FieldAnalyzer`] makes percepts on a RoboCup field,
//! [`office::OfficeAnalyzer`] inside a building.
//! Sources: master's thesis of 2010, section 4.2; doctoral thesis of 2017, sections 5.2.1 and 5.3.1.

pub mod color;
mod detected_object;
pub mod field;
mod field_features;
mod image_look;
mod line_fit;
pub mod office;
mod percept;

use nalgebra::{Point2, Point3};
use visloc_core::{Frame, geom::Plane};

/// Pixels of an image of this width in a pixel of an image 320 px wide, for which lengths in images are given.
pub(crate) fn px_scale(width_px: u32) -> f64 {
    f64::from(width_px) / 320.0
}

/// So many pixels of an image of this width blur into one: noise, pictures' compression and errors of lens and map let images up to 640 px wide
/// tell single pixels, and wider ones no smaller angle.
pub(crate) fn blur_px(width_px: u32) -> u32 {
    (width_px / 640).max(1)
}

/// How far off a thing in an image of this width may be, against one 320 to 640 px wide: in wider images the blur decides, in smaller ones what
/// the map and the robot's joints do not know is as large an angle as in an image 320 px wide.
pub(crate) fn px_tolerance(width_px: u32) -> f64 {
    let scale = px_scale(width_px);
    scale.min(1.0) * (scale / 2.0).max(1.0)
}

/// How far off borders in an image of this width are about a true pose, against an image 320 px wide, in its pixels times [`px_tolerance`]. A part
/// is the same angle in every image (map, lens, joints), a part the same share of a pixel. Measured, in pixels of an image 320 px wide: 0.60,
/// 0.36, 0.31 and 0.29 at 160, 320, 640 and 1280 px.
pub(crate) fn border_noise(width_px: u32) -> f64 {
    let off_px = |scale: f64| (0.28 * scale).hypot(0.26);
    off_px(px_scale(width_px)) / off_px(1.0) / px_tolerance(width_px)
}

/// A number of pixels of an image 320 px wide in an image of another width: at least one.
pub(crate) fn px_in(width_px: u32, px: u32) -> u32 {
    ((f64::from(px) * px_scale(width_px)).round() as u32).max(1)
}

/// Distance along the ground from the robot to what a pixel shows of it, meters; `None` above the horizon.
pub(crate) fn ground_distance_m(frame: &Frame, px: &Point2<f64>) -> Option<f64> {
    let direction = frame.robot_from_camera.rotate(&frame.camera.bearing(px));
    let eye = Point3::from(*frame.robot_from_camera.translation());
    let point = Plane::ground().intersect_ray(&eye, &direction)?;
    Some(point.x.hypot(point.y))
}

pub use detected_object::{DetectedObject, ObjectKind};
pub use field_features::{
    CenterCircle, FieldFeatures, GoalPost, Junction, JunctionKind, LineSegment, PenaltyMark, PostSide,
};
pub use image_look::ImageLook;
pub use percept::{
    AnalysisError, BareGround, BorderPixel, DoorSide, DropReason, DroppedPixel, FeatureKind, FeaturePixel,
    PerceivedBlob, Percept,
};
