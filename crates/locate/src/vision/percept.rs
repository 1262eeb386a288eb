//! What the analysis of one image found.

use nalgebra::{Point2, Vector2};
use rand::RngExt;
use thiserror::Error;
use visloc_core::{
    Frame, Rng, Timestamp,
    geom::{Camera, CameraFrame, Rigid3, Robot},
};

use crate::vision::{DetectedObject, FieldFeatures};

/// Which edge of a door, as it is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum DoorSide {
    /// The door is at the right of the edge.
    Left,
    /// The door is at the left of the edge.
    Right,
}

/// What a feature pixel is part of. Observation models compare a pixel with map objects of its kind only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum FeatureKind {
    /// Border of a white line on the ground.
    FieldLine,
    /// Border of a yellow goal.
    YellowGoal,
    /// Border of a blue goal.
    BlueGoal,
    /// Upright border of a post of a white goal.
    WhiteGoal,
    /// Upright edge of a door, where the wall begins.
    DoorEdge {
        /// Which of its edges.
        side: DoorSide,
        /// Index of the door's color in the map.
        paint: u8,
    },
    /// Where a wall meets the floor.
    WallFoot,
    /// Where a door meets the floor.
    DoorFoot,
    /// A line with nothing known beside it. Only among what was dropped.
    UnknownLine,
}

impl FeatureKind {
    /// Whether the pixel belongs to a goal.
    pub fn is_goal(self) -> bool {
        matches!(self, Self::YellowGoal | Self::BlueGoal | Self::WhiteGoal)
    }

    /// Whether the pixel belongs to an upright edge of a door.
    pub fn is_door_edge(self) -> bool {
        matches!(self, Self::DoorEdge { .. })
    }
}

/// A pixel that the localizer weighs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeaturePixel {
    /// Where it is in the image, pixels.
    pub px: Point2<f64>,
    /// Where it would be without lens distortion, pixels.
    pub ideal_px: Point2<f64>,
    /// What it is part of.
    pub kind: FeatureKind,
}

/// A border pixel together with the side on which its object lies: what the refinement of a pose matches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BorderPixel {
    /// Where it would be without lens distortion, pixels.
    pub ideal_px: Point2<f64>,
    /// Unit vector along the scan line, towards the inside of the line or goal.
    pub inward: Vector2<f64>,
    /// What it is part of.
    pub kind: FeatureKind,
}

visloc_core::worded_enum! {
    /// Why a pixel was dropped. In the order in which the filters run.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum DropReason {
        /// A white run without carpet on both sides is not a field line.
        NotBesideCarpet = "not beside carpet",
        /// A white run is thinner than a field line at its distance: a net, a scratch, noise.
        TooThin = "too thin",
        /// A goal's border that neither runs upright nor lies above the horizon: the goal's base, not post or crossbar.
        NotPostOrBar = "not post or bar",
        /// Too few of the eight pixels around it have its color.
        Isolated = "isolated",
        /// The colors on both sides of a line are not those of a door's edge or of the floor's border.
        UnknownColors = "unknown colors",
        /// A door's edge that does not stand upright.
        NotUpright = "not upright",
        /// A border of the floor that stands upright: the side of a thing that stands on the floor.
        Upright = "upright",
        /// A line that is too short, even joined with others.
        TooShort = "too short",
        /// Its ground point is farther away than any line can be.
        BeyondHorizon = "beyond horizon",
        /// Its ground point is so near that it is the robot's own body.
        OwnBody = "own body",
        /// Above the end of the carpet.
        BeyondFieldEnd = "beyond end of field",
        /// A goal color outside of every blob that could be a goal.
        NotInGoalBlob = "not in a goal blob",
        /// Inside of an obstacle, most likely another robot.
        InObstacle = "in an obstacle",
        /// Taken out at random because enough pixels are left.
        RandomDiscard = "random discard",
    }

    /// Short name for tables and legends.
    name
}

/// A pixel that a filter took out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DroppedPixel {
    /// Where it is in the image, pixels.
    pub px: Point2<f64>,
    /// What it looked like.
    pub kind: FeatureKind,
    /// Which filter took it out.
    pub reason: DropReason,
}

/// A patch of one color that may be a landmark of the map, as a whole. Several patches of one kind can belong to one
/// landmark, for instance the two posts of a goal whose crossbar is out of view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PerceivedBlob {
    /// What it is part of.
    pub kind: FeatureKind,
    /// Pixels of its color.
    pub area_px: f64,
    /// Middle of its pixels, pixels.
    pub centroid_px: Point2<f64>,
}

/// Ground that shows nothing but carpet: no line of the map can be there.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BareGround {
    /// Side of a patch, pixels of the image.
    pub patch_px: f64,
    /// Middles of the patches that are bare with all eight around them, pixels without lens distortion.
    pub middles: Vec<Point2<f64>>,
}

/// The input of one localizer step: what was seen, with which camera, from which height and direction.
#[derive(Debug, Clone, Default)]
pub struct Percept {
    /// When the image was taken.
    pub at: Timestamp,
    /// The kept pixels.
    pub pixels: Vec<FeaturePixel>,
    /// All pixels that passed the filters, evenly thinned out to a bounded number: the random discard has no say here.
    pub borders: Vec<BorderPixel>,
    /// Where the ground shows nothing but carpet.
    pub bare_ground: BareGround,
    /// Lines, junctions, circle, marks and posts; empty if they are not looked for.
    pub features: FieldFeatures,
    /// Robots and balls, the clearest first; empty if they are not looked for in this image.
    pub objects: Vec<DetectedObject>,
    /// The dropped pixels.
    pub dropped: Vec<DroppedPixel>,
    /// The valid patches of color, in no special order.
    pub blobs: Vec<PerceivedBlob>,
    /// Which of the robot's cameras it is of, from 0.
    pub camera_index: usize,
    /// Calibration of the camera.
    pub camera: Camera,
    /// Pose of the camera relative to the robot.
    pub robot_from_camera: Rigid3<Robot, CameraFrame>,
    /// How much the image tells about the pose, 0 to 1.
    pub quality: f64,
    /// Whether it holds something that leaves few poses possible (field: a goal; office: a door).
    pub is_informative: bool,
}

impl Percept {
    /// Begins with a frame, as if nothing were seen in it.
    pub(super) fn begin(&mut self, frame: &Frame) -> Result<(), AnalysisError> {
        let found_px = (frame.image.width(), frame.image.height());
        if found_px != frame.camera.size_px() {
            return Err(AnalysisError::Size { at: frame.at, expected_px: frame.camera.size_px(), found_px });
        }
        if !frame.robot_from_camera.is_finite() {
            return Err(AnalysisError::Mount {
                at: frame.at,
                found: format!("{:?}", frame.robot_from_camera),
            });
        }
        self.at = frame.at;
        (self.camera_index, self.camera) = (frame.camera_index, frame.camera);
        self.robot_from_camera = frame.robot_from_camera;
        self.pixels.clear();
        self.borders.clear();
        self.bare_ground.middles.clear();
        self.dropped.clear();
        Ok(())
    }

    /// Keeps at most so many of these pixels, chosen at random; the others are among the dropped ones. `None` keeps all.
    pub(super) fn keep(&mut self, pixels: &mut Vec<FeaturePixel>, most: Option<usize>, rng: &mut Rng) {
        if let Some(most) = most.filter(|most| pixels.len() > *most) {
            for i in 0..most {
                let other = rng.random_range(i..pixels.len());
                pixels.swap(i, other);
            }
            let reason = DropReason::RandomDiscard;
            let dropped = |pixel: &FeaturePixel| DroppedPixel { px: pixel.px, kind: pixel.kind, reason };
            self.dropped.extend(pixels[most..].iter().map(dropped));
            pixels.truncate(most);
        }
        self.pixels.extend_from_slice(pixels);
    }

    /// How many pixels a filter dropped.
    pub fn num_dropped(&self, reason: DropReason) -> usize {
        self.dropped.iter().filter(|pixel| pixel.reason == reason).count()
    }
}

/// An image that cannot be analyzed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum AnalysisError {
    /// The image does not belong to the camera's calibration.
    #[error(
        "image at {at}: expected {} x {} px from the camera calibration, found {} x {} px",
        expected_px.0, expected_px.1, found_px.0, found_px.1
    )]
    Size {
        /// Stamp of the image.
        at: Timestamp,
        /// Width and height of the calibration.
        expected_px: (u32, u32),
        /// Width and height of the image.
        found_px: (u32, u32),
    },
    /// The pose of the camera on the robot has values that are not finite.
    #[error("image at {at}: expected a pose of the camera on the robot in finite numbers, found {found}")]
    Mount {
        /// Stamp of the image.
        at: Timestamp,
        /// The pose, as text.
        found: String,
    },
}
