//! What a picture of the field shows.

use visloc_core::geom::PlanarPose;

use crate::Color;

visloc_core::with_defaults! {
    /// What is drawn on the field. All positions in the frame of the field, meters.
    /// By default nothing on the field. A step of at most 0.5 m: far more than a robot moves between two frames.
    #[derive(Debug, Clone, PartialEq)]
    pub struct FieldPicture {
        /// Large, at the top.
        pub title: String = String::new(),
        /// Below the title, for instance the mean error.
        pub subtitle: String = String::new(),
        /// Where the robot was.
        pub truth: Option<FieldPath> = None,
        /// Where localizers said that it was.
        pub estimates: Vec<FieldPath> = Vec::new(),
        /// Numbered from 1 in this order.
        pub kidnaps: Vec<Kidnap> = Vec::new(),
        /// Where the run starts.
        pub start: Option<PlanarPose> = None,
        /// Points of a path that are farther apart than this are not connected, meters.
        pub max_step_m: f64 = 0.5,
    }
}

/// A path with its name and color.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FieldPath {
    /// In the legend.
    pub label: String,
    /// Of the line.
    pub color: Color,
    /// In order of time. A point that is not finite breaks the line.
    pub points: Vec<PathPoint>,
}

impl FieldPath {
    /// A path of which every point is localized.
    pub fn new(label: &str, color: Color, poses: impl IntoIterator<Item = PlanarPose>) -> Self {
        let points = poses.into_iter().map(|pose| PathPoint::localized(&pose)).collect();
        Self { label: label.to_owned(), color, points }
    }
}

/// One point of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// Position along x, meters.
    pub x_m: f64,
    /// Position along y, meters.
    pub y_m: f64,
    /// Whether the localizer trusts it. Others are drawn faint.
    pub is_localized: bool,
}

impl PathPoint {
    /// A point that the localizer trusts.
    pub fn localized(pose: &PlanarPose) -> Self {
        Self { x_m: pose.x_m, y_m: pose.y_m, is_localized: true }
    }

    /// A point that the localizer does not trust.
    pub fn not_localized(pose: &PlanarPose) -> Self {
        Self { is_localized: false, ..Self::localized(pose) }
    }

    /// Breaks the line.
    pub fn gap() -> Self {
        Self { x_m: f64::NAN, y_m: f64::NAN, is_localized: false }
    }
}

/// The robot was carried away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kidnap {
    /// Where it was picked up.
    pub from: PlanarPose,
    /// Where it was put down.
    pub to: PlanarPose,
}
