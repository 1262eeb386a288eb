//! What can keep a robot from being localized.

/// Why an image, or a run, did not lead to a place. In the order in which images are asked for them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// The image does not belong to its calibration.
    Unusable,
    /// The feet carry nothing: the robot counts as lifted.
    Lifted,
    /// The image is black.
    Black,
    /// The image is overexposed.
    White,
    /// Focal length and image size do not belong together.
    Calibration,
    /// The camera is said to be on the ground or below.
    CameraOnGround,
    /// The camera looks above the horizon.
    CameraUp,
    /// The camera looks at the ground right before the robot.
    CameraDown,
    /// The map is a building without doors.
    MapWithoutDoors,
    /// The map is a building, the image shows the carpet of a field.
    FieldImage,
    /// The image has no colors, and the map's objects are told apart by color.
    Gray,
    /// The map is a field, the image shows no carpet.
    NoCarpet,
    /// There is carpet, but hardly any border of lines or goals.
    FewBorders,
    /// No edge of a door is seen.
    NoDoors,
    /// The place is known but for the half of a field that looks alike from both.
    PointSymmetric,
    /// Several places fit as well.
    LookAlikes,
    /// Borders are seen, but no place on the map explains them.
    Unexplained,
    /// A place fits and is not yet confirmed.
    Unconfirmed,
    /// Of a run: it is too short to tell.
    ShortRun,
    /// Of a run: the camera saw the same all the time.
    SameView,
    /// Of a run: there was no odometry.
    NoOdometry,
}

impl Cause {
    /// All causes.
    pub const ALL: [Self; 21] = [
        Self::Unusable,
        Self::Lifted,
        Self::Black,
        Self::White,
        Self::Calibration,
        Self::CameraOnGround,
        Self::CameraUp,
        Self::CameraDown,
        Self::MapWithoutDoors,
        Self::FieldImage,
        Self::Gray,
        Self::NoCarpet,
        Self::FewBorders,
        Self::NoDoors,
        Self::PointSymmetric,
        Self::LookAlikes,
        Self::Unexplained,
        Self::Unconfirmed,
        Self::ShortRun,
        Self::SameView,
        Self::NoOdometry,
    ];

    /// Name for programs; stays as it is.
    pub fn code(self) -> &'static str {
        match self {
            Self::Unusable => "unusable-images",
            Self::Lifted => "lifted",
            Self::Black => "black-images",
            Self::White => "overexposed-images",
            Self::Calibration => "calibration",
            Self::CameraOnGround => "camera-on-ground",
            Self::CameraUp => "camera-up",
            Self::CameraDown => "camera-down",
            Self::MapWithoutDoors => "map-without-doors",
            Self::FieldImage => "field-images",
            Self::Gray => "gray-images",
            Self::NoCarpet => "no-carpet",
            Self::FewBorders => "few-borders",
            Self::NoDoors => "no-doors",
            Self::PointSymmetric => "point-symmetric",
            Self::LookAlikes => "look-alikes",
            Self::Unexplained => "unexplained",
            Self::Unconfirmed => "unconfirmed",
            Self::ShortRun => "short-run",
            Self::SameView => "same-view",
            Self::NoOdometry => "no-odometry",
        }
    }

    /// Whether more images from other places may remove the cause.
    pub(super) fn may_pass(self) -> bool {
        matches!(
            self,
            Self::FewBorders | Self::NoDoors | Self::LookAlikes | Self::Unexplained | Self::Unconfirmed
        )
    }
}
