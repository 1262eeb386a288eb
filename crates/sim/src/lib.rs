//! Simulator: what a robot with one camera sees, feels and reports in a world described by data.
//!
//! A [`Scenario`] (a TOML file) says what stands where and what the robot does; a [`Simulation`] of it with a seed is
//! a [source](visloc_core::Source) with the truth in every frame; a [`LiveSimulation`] is steered while it runs,
//! and a [`TeamSimulation`] has several robots, each with its camera. [`Scene`] and [`Renderer`] also work on their own, for
//! pictures from any pose. A [`CameraTour`] carries a camera of its own through a textured room, for SLAM.
//!
//! Data flow: `scenario` (files) -> `simulation` builds a `scene` (surfaces, textures, light) and plans the `robot`
//! (motion, head, odometry, feet) -> `render` takes one picture per frame.
//!
//! To add things: a built-in scenario is a file in `scenarios/` and a line in `scenario/load.rs`; a pattern is a
//! variant in `scene/paint.rs`; furniture is a function in `scene/furniture.rs`; a new kind of world is a file beside
//! `scene/field.rs` and a branch in `simulation/world.rs`.

// Pixels, texels and counts of frames are small; the renderer works in single precision on purpose.

mod render;
mod robot;
mod scenario;
mod scene;
mod simulation;
mod tour;

pub use render::{CameraMotion, LabelImage, Renderer, Sensor, Shot};
pub use scenario::{
    BUILT_IN_SCENARIOS, Ball, BoxPiece, CameraSetup, Carry, Factor, FootSetup, FurniturePiece, FurtherCamera,
    GaitSetup, HeadMount, HeadSetup, KinematicsSetup, LightFade, LightSetup, MAX_FRAMES, Motion,
    OdometrySetup, OtherRobot, Panel, PersonSetup, PlacedPose, RobotSetup, Scenario, ScenarioError, Stand,
    Turn, Walk, Wander,
};
pub use scene::{
    Canvas, Color, Cuboid, FieldLook, Figure, FigureKind, FurnitureKind, Label, Lamp, LightGrid, Lighting,
    Paint, Pattern, Room, Scene, Shape, Surface, Texture, TextureId, Wrap,
};
pub use simulation::{
    Detection, DetectorSetup, DrivenSimulation, LiveControls, LiveMotion, LiveSimulation, Simulation, TEAM,
    TeamFrame, TeamSimulation,
};
pub use tour::{CameraTour, TOURS, TourError, TourKind};
