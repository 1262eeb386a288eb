//! Where is the camera? Localization with one ordinary camera: on a known map (a RoboCup field, a building), and without a map (SLAM).
//!
//! # On a known map
//!
//! A [`Map`] and a [`Pipeline`]; each [`Frame`] of the robot gives an [`Estimate`]: pose, covariance, reliability, all hypotheses.
//!
//! ```
//! use visloc::{Camera, Frame, Map, Mount, Pipeline, PlanarPose, RgbImage, Timestamp};
//!
//! let map = Map::built_in("robocup-spl-2010")?;
//! let camera = Camera::pinhole((320, 240), (373.0, 373.0), (159.5, 119.5))?;
//! let mount = Mount { height_m: 0.5, tilt_rad: 0.3, ..Mount::default() };
//! let mut pipeline = Pipeline::builder(&map).seed(1).build()?;
//!
//! let bytes = vec![0; 320 * 240 * 3]; // of your camera: rows from the top, of each pixel red, green and blue
//! let image = RgbImage::from_raw(320, 240, bytes)?;
//! let mut frame = Frame::new(Timestamp::from_secs(0.0), image, camera, mount.robot_from_camera());
//! frame.odometry = Some(PlanarPose::new(0.1, 0.0, 0.0)); // if there is some: all motion since any beginning, meters and radians
//! let estimate = pipeline.step(&frame)?;
//! if estimate.is_localized() {
//!     println!("{:?}", estimate.world_from_robot);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A map of your own is a file (`Map::load`: dimensions of a field, plan of a building, SVG, DXF, occupancy grid) or is made in code:
//! [`Field::new`](world::field::Field::new), [`Office::new`](world::office::Office::new). Foot sensors, if the robot has them, are a field of
//! the frame, too. What is known of the pose at the start is given with [`PipelineBuilder::start`]; another algorithm is chosen by name
//! (`.named("mce", None)`) or with parameters of your own ([`Algorithm`]); an algorithm of your own implements [`Localizer`] and is put in
//! with [`PipelineBuilder::localizer`].
//!
//! # Without a map
//!
//! ```
//! use visloc::{Camera, GrayImage, Slam, SlamConfig, Timestamp};
//!
//! let camera = Camera::pinhole((640, 480), (500.0, 500.0), (319.5, 239.5))?;
//! let mut slam = Slam::new(&camera, &SlamConfig::default(), 1)?;
//! let outcome = slam.add_frame(Timestamp::from_secs(0.0), GrayImage::new(640, 480))?;
//! assert!(outcome.camera_from_world.is_none(), "one image has no depth");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # In a map that SLAM has made
//!
//! What SLAM has learned of a place is kept in a file; from then on cameras are found in it, from nothing. With the feature `vmap`:
//!
//! ```
//! # #[cfg(feature = "vmap")]
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use visloc::{GrayFrame, ImageSource, Slam, SlamConfig, Source, io::sequence::{SequenceOptions, open_sequence}, vmap};
//!
//! # let folder = tempfile::tempdir()?;
//! # let (walk, room) = (concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/desk-clip"), folder.path().join("room.vmap"));
//! let mut images = open_sequence(walk.as_ref(), &SequenceOptions::default())?.images;
//! let camera = images.camera().clone();
//! let mut slam = Slam::new(&camera, &SlamConfig::default(), 1)?;
//! while let Some(frame) = images.next_item() {
//!     let frame = frame?;
//!     slam.add_frame(frame.at, frame.image)?;
//! }
//! vmap::save(&room, &vmap::VisualMap::default().after(&slam, vmap::Session::default()), &slam.session_camera())?;
//!
//! let map = vmap::load(&room)?.map; // later, in another program
//! let mut localizer = vmap::MapLocalizer::new(&map.map, None, &camera, &SlamConfig::default(), 1)?;
//! let mut images = open_sequence(walk.as_ref(), &SequenceOptions::default())?.images;
//! let mut known = None;
//! while let (None, Some(frame)) = (&known, images.next_item()) {
//!     let frame = frame?;
//!     known = localizer.step(GrayFrame::new(frame.at, frame.image))?.map(|place| place.world_from_camera);
//! }
//! assert!(known.is_some(), "the camera is found where it was before");
//! # Ok(())
//! # }
//! # #[cfg(not(feature = "vmap"))]
//! # fn main() {}
//! ```
//!
//! # How good it is
//!
//! [`eval`] compares poses with the truth: [`eval::evaluate`] those of a robot, [`eval::camera`] those of a camera, with an alignment.
//!
//! # Features
//!
//! | feature | what it adds |
//! |---|---|
//! | `io` (default) | [`Map::load`], maps from files (without it: [`Map::built_in`], [`Map::parse`]); [`io`]: bags of ROS 2 and ROS 1, datasets, pictures, trajectories, video |
//! | `calib` (default) | [`calib`]: calibration of a camera from pictures of a board |
//! | `vmap` (default) | [`vmap`]: maps of SLAM in files, and cameras that are found in them |
//! | `parallel` (default) | filters with many particles weigh them with several threads |
//! | `compression`, `sqlite` | bags whose parts are packed, and bags in SQLite |
//! | `ros2` | live topics, without a ROS installation |
//! | `sim` | `sim`: simulated robots with cameras |
//!
//! # Conventions
//!
//! A transform is named and typed by its frames, `world_from_robot: Rigid3<World, Robot>` takes points of the robot to the world. The robot
//! looks along x, y is to its left, z up; a camera looks along z, x is to its right, y down. Lengths are in meters (SLAM: in units of the
//! map), angles in radians, pixels have their centers at integers. The same seed and the same frames give the same bits.

pub use nalgebra;
pub use rand;
#[cfg(feature = "calib")]
pub use visloc_calib as calib;
pub use visloc_core::{
    CalibratedImages, CameraPose, CameraTrajectory, Clock, Frame, GrayFrame, GrayImage, GroundContact, Host,
    ImageSizeError, ImageSource, Occupancy, OccupancyGrid, Picture, PlanarTrajectory, RgbImage, Rng, RngTree,
    SkippedInput, Source, SourceError, SourceFrame, SourceStatus, Stamped, StampedPose, Timestamp,
    Trajectory, Truth, eval, gaussian,
    geom::{
        self, Camera, CameraError, CameraFrame, Distortion, Mount, Odom, PlanarPose, Rigid3, Robot, World,
        nao,
    },
    settings,
};
#[cfg(feature = "io")]
pub use visloc_io as io;
pub use visloc_locate::{
    self as locate, ALGORITHMS, Algorithm, ConfigError, Estimate, FeatureChoice, Half, HeadingPrior,
    Hypothesis, Individual, LOCALIZED_RELIABILITY, Localizer, ObservationModel, Pipeline, PipelineBuilder,
    PipelineConfig, PosePrior, Region, SideLines, StartPrior, StepInput, vision::AnalysisError,
};
#[cfg(feature = "sim")]
pub use visloc_sim as sim;
pub use visloc_slam::{
    self as slam, FrameError, FrameOutcome, Schedule, Slam, SlamConfig, SlamPreset, TrackingState,
    TrajectoryPose, ground::GroundOdometer,
};
#[cfg(feature = "vmap")]
pub use visloc_vmap as vmap;
pub use visloc_world::{self as world, Map, MapError};
