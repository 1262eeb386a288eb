//! What the refinement of a pose needs of a map: how far each feature of an image lies from its counterpart, and how that
//! distance changes with the pose.

use nalgebra::{Matrix3, SVector, Vector3};
use visloc_core::{Rng, geom::PlanarPose};

use crate::vision::Percept;

/// Where the camera was, as far as a refinement may change it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraState {
    /// The robot.
    pub world_from_robot: PlanarPose,
    /// Error of the camera's direction: a rotation vector in the camera frame, radians. The true camera frame, seen from
    /// the reported one.
    pub tilt_rad: Vector3<f64>,
    /// Error of the camera's height: how much higher it is than reported, meters.
    pub raise_m: f64,
}

/// What a refinement may change, in this order: x and y (meters), heading (radians), the camera's tilt (three angles, radians), its
/// height (meters).
pub type CameraVector = SVector<f64, 7>;

impl CameraState {
    /// The camera of a robot at this place, as its joints report it.
    pub fn reported(world_from_robot: PlanarPose) -> Self {
        Self { world_from_robot, tilt_rad: Vector3::zeros(), raise_m: 0.0 }
    }
}

impl From<&CameraVector> for CameraState {
    fn from(v: &CameraVector) -> Self {
        Self {
            world_from_robot: PlanarPose::new(v[0], v[1], v[2]),
            tilt_rad: v.fixed_rows::<3>(3).into_owned(),
            raise_m: v[6],
        }
    }
}

/// A feature and its counterpart on the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeatureMatch {
    /// Features of one group are judged together: 0 for borders on the ground, 1 for goals or doors.
    pub group: usize,
    /// Signed distance in the image, and its derivative by (x, y, heading, tilt, height); `None` if the feature has no
    /// counterpart within the gate.
    pub residual: Option<Residual>,
    /// How far a feature without counterpart agrees with the map all the same, 0 to 1: seen from this pose it may show
    /// something that the map does not have.
    pub unmatched_agreement: f64,
    /// Where it lies if it may be of a bar of which the map knows the direction and not the place.
    pub on_bar: Option<OnBar>,
}

/// A feature of a straight thing that stands somewhere in a range, parallel to something on the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnBar {
    /// Which of its two borders: 0 or 1.
    pub side: usize,
    /// How far through the range it is, 0 to 1.
    pub at: f64,
    /// How long the range is in the image there, pixels as in [`Residual::error_px`].
    pub range_px: f64,
}

/// Signed distance of a feature from its counterpart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// The distance in the undistorted image, pixels of an image 320 to 640 px wide: see `px_tolerance`.
    pub error_px: f64,
    /// Its derivative.
    pub jacobian: CameraVector,
}

impl Residual {
    /// Geman and McClure's weight: what is far off does not pull.
    pub(crate) fn weight(&self, gate_px: f64) -> f64 {
        let soft_px = gate_px / 3.0;
        (1.0 + self.error_px.powi(2) / soft_px.powi(2)).powi(-2)
    }
}

/// Matches the features of an image to a map.
pub trait FeatureModel: Send + Sync {
    /// Takes the features of this percept.
    fn condition_on(&mut self, percept: &Percept);

    /// How many features there are.
    fn num_features(&self) -> usize;

    /// How far features are off in this image, against one 320 px wide, in the unit of [`Residual::error_px`].
    fn noise(&self) -> f64 {
        1.0
    }

    /// Matches one feature in `stride`, seen from here. What is farther from its counterpart than `gate_px` has none.
    fn visit_matches(
        &self,
        state: &CameraState,
        gate_px: f64,
        stride: usize,
        visit: &mut dyn FnMut(FeatureMatch),
    );

    /// How long the borders on the ground are that the image must show from here, pixels of an image 320 px wide: those that are thick enough to
    /// be found, at least `margin_px` inside of the image, and not so near that the robot itself may hide them.
    fn expected_px(&self, _state: &CameraState, _margin_px: f64) -> f64 {
        0.0
    }

    /// How long the borders on the ground are that the image must show from here and where it shows nothing but ground, pixels of an image
    /// 320 px wide.
    fn missed_px(&self, _state: &CameraState) -> f64 {
        0.0
    }

    /// A pose at which some of the features fall on counterparts, at random; `None` if the features suggest nothing.
    fn suggest(&self, _rng: &mut Rng) -> Option<PlanarPose> {
        None
    }

    /// Whether the map has landmarks that tell places apart: features of group 1.
    fn has_landmarks(&self) -> bool {
        false
    }

    /// Shares of the features of each group that are as good as all: even at the right place the rest are robots, boards
    /// and people.
    fn full_shares(&self) -> [f64; 2] {
        [0.85, 0.6]
    }

    /// The pose from which everything but the landmarks looks the same, if the map has such a symmetry that only landmarks break.
    fn twin(&self, _world_from_robot: &PlanarPose) -> Option<PlanarPose> {
        None
    }

    /// The pose from which everything looks the same, if the map has such a symmetry.
    fn mirrored(&self, _world_from_robot: &PlanarPose) -> Option<PlanarPose> {
        None
    }
}

/// The rotation of a small rotation vector, to second order.
pub(crate) fn small_rotation(v: &Vector3<f64>) -> Matrix3<f64> {
    let cross = v.cross_matrix();
    Matrix3::identity() + cross + cross * cross * 0.5
}
