//! What is told of a frame: by a system that makes its map, or by one that finds the camera in the map of an earlier session.

use visloc_core::geom::{CameraFrame, Rigid3, World};
use visloc_slam::{FrameOutcome, TrackingState};
use visloc_vmap::{CameraEstimate, Support};

/// What is known of the camera after a frame.
pub(super) struct Told<'a> {
    /// Where it is.
    pub world_from_camera: Option<Rigid3<World, CameraFrame>>,
    /// Whether its place is not known.
    pub is_lost: bool,
    /// The same in words.
    pub state: String,
    /// In the map of an earlier session.
    pub place: Option<Place<'a>>,
}

/// What is known of a place in the map of an earlier session.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    /// How far it can be trusted, 0 to 1.
    pub reliability: f64,
    /// Landmarks of that map that the image shows.
    pub num_of_map: usize,
    /// Where the camera was while it was localized, as it is shown.
    pub way: &'a [f64],
}

impl Told<'_> {
    /// By a system that makes its map.
    pub fn of_slam(outcome: &FrameOutcome) -> Self {
        let state = match outcome.state {
            TrackingState::Starting(wait) => format!("starting: {wait}"),
            TrackingState::Tracking(quality) => format!("tracking, {}", quality.name()),
            TrackingState::Supposed => "maybe here".to_owned(),
            TrackingState::Carried => "carried by odometry".to_owned(),
            TrackingState::Lost => "lost".to_owned(),
        };
        Self {
            world_from_camera: outcome.camera_from_world.map(|pose| pose.inverse()),
            is_lost: outcome.state == TrackingState::Lost,
            state,
            place: None,
        }
    }
}

impl<'a> Told<'a> {
    /// In the map of an earlier session.
    pub fn in_map(estimate: Option<&CameraEstimate>, outcome: &FrameOutcome, way: &'a [f64]) -> Self {
        let is_localized = estimate.is_some_and(CameraEstimate::is_localized);
        let state = match estimate {
            None => "looking for the camera".to_owned(),
            Some(_) if !is_localized => "not sure of the place".to_owned(),
            Some(estimate) => match estimate.support {
                Support::Map if estimate.is_found => "found from nothing".to_owned(),
                Support::Map => "localized".to_owned(),
                Support::Motion => "localized, carried by motion".to_owned(),
                Support::Odometry => "localized, carried by odometry".to_owned(),
            },
        };
        let reliability = estimate.map_or(0.0, |estimate| estimate.reliability);
        let place = Some(Place { reliability, num_of_map: outcome.fixed.len(), way });
        let world_from_camera = estimate.map(|estimate| estimate.world_from_camera);
        Self { world_from_camera, is_lost: !is_localized, state, place }
    }
}
