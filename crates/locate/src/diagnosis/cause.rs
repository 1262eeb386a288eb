//! What can keep a robot from being localized.

visloc_core::worded_enum! {
    /// Why an image, or a run, did not lead to a place. In the order in which images are asked for them.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Cause {
        /// The image does not belong to its calibration.
        Unusable = "unusable-images",
        /// The feet carry nothing: the robot counts as lifted.
        Lifted = "lifted",
        /// The image is black.
        Black = "black-images",
        /// The image is overexposed.
        White = "overexposed-images",
        /// Focal length and image size do not belong together.
        Calibration = "calibration",
        /// The camera is said to be on the ground or below.
        CameraOnGround = "camera-on-ground",
        /// The camera looks above the horizon.
        CameraUp = "camera-up",
        /// The camera looks at the ground right before the robot.
        CameraDown = "camera-down",
        /// The map is a building without doors.
        MapWithoutDoors = "map-without-doors",
        /// The map is a building, the image shows the carpet of a field.
        FieldImage = "field-images",
        /// The image has no colors, and the map's objects are told apart by color.
        Gray = "gray-images",
        /// The map is a field, the image shows no carpet.
        NoCarpet = "no-carpet",
        /// There is carpet, but hardly any border of lines or goals.
        FewBorders = "few-borders",
        /// No edge of a door is seen.
        NoDoors = "no-doors",
        /// The place is known but for the half of a field that looks alike from both.
        PointSymmetric = "point-symmetric",
        /// Several places fit as well.
        LookAlikes = "look-alikes",
        /// Borders are seen, but no place on the map explains them.
        Unexplained = "unexplained",
        /// A place fits and is not yet confirmed.
        Unconfirmed = "unconfirmed",
        /// Of a run: it is too short to tell.
        ShortRun = "short-run",
        /// Of a run: the camera saw the same all the time.
        SameView = "same-view",
        /// Of a run: there was no odometry.
        NoOdometry = "no-odometry",
    }

    /// Name for programs; stays as it is.
    code
}

impl Cause {
    /// Whether more images from other places may remove the cause.
    pub(super) fn may_pass(self) -> bool {
        matches!(
            self,
            Self::FewBorders | Self::NoDoors | Self::LookAlikes | Self::Unexplained | Self::Unconfirmed
        )
    }
}
