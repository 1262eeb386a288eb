//! The corners of one image on their way through the next ones, and what they tell.

use std::sync::Arc;

use nalgebra::{Matrix2, Point2, Rotation3};
use visloc_core::{Rng, Timestamp, geom::Camera};

use super::{Follower, PendingStart, Sight, TwoViewMotion, VerifiedStart, ViewRays};
use crate::{
    backfill::MOST_WAITING,
    image::Pyramid,
    lie::CameraFromWorld,
    map::{LandmarkId, LandmarkState, Map, NewKeyframe, Observation},
    mapping::{DepthFilter, corner_covariance},
    odometry::OdomPose,
    solve::{PoseObservation, Rejection, robust_pose},
    track::{Incoming, focal_px, whitening},
};

/// Corners by their number, where they were found, and the covariance of that; pixels of level 0.
pub type Places = Vec<(usize, Point2<f64>, Matrix2<f64>)>;

/// Corners of one image on their way.
#[derive(Debug, Clone)]
pub(super) struct Attempt {
    pub follower: Follower,
    /// Number and time of the first frame.
    pub number: usize,
    pub at: Timestamp,
    /// Where the odometry has the camera in the first frame.
    pub odometry: Option<OdomPose>,
    pub num_corners: usize,
    /// Corners found in the first frame after that.
    pub num_followable: Option<usize>,
    /// The frame that was looked at last.
    pub last: Arc<Pyramid>,
    /// For each frame since: its number and the corners found in it.
    pub history: Vec<(usize, Places)>,
    /// Motions that explained the frame before.
    pub hints: Vec<TwoViewMotion>,
    /// An earlier start that waits for more parallax to prove it.
    pub pending: Option<PendingStart>,
    /// Number of the first frame, of this attempt or one before it, that had one motion which explains it.
    pub explained_since: Option<usize>,
}

impl Attempt {
    /// Whether waiting for a motion that is known better begins to cost something, in a frame that one motion explains: frames that wait
    /// get their poses afterwards, as many as are kept. What is wrong after that tracking will tell.
    pub fn has_waited_enough(&mut self, number: usize) -> bool {
        number - *self.explained_since.get_or_insert(number) >= MOST_WAITING
    }

    /// Depth of each corner in the first camera, by its number.
    pub fn depths(&self, start: &VerifiedStart) -> Vec<Option<f64>> {
        let mut depths = vec![None; self.num_corners];
        for (track, point) in self.follower.tracks().iter().zip(&start.points) {
            depths[track.number] = point.map(|point| point.z);
        }
        depths
    }

    /// Rays of the corners that are still followed: in the first frame, in some on the way, and in the last.
    pub fn views(&self, camera: &Camera) -> Vec<ViewRays> {
        const MOST_BETWEEN: usize = 6;
        let tracks = self.follower.tracks();
        let sight = |px: &Point2<f64>, covariance_px| Sight { ray: camera.bearing(px), covariance_px };
        let first =
            tracks.iter().map(|track| Some(sight(&track.first_px, corner_covariance(track.level)))).collect();
        let mut views: Vec<ViewRays> = vec![first];
        let num = self.history.len();
        let step = num.div_ceil(MOST_BETWEEN + 1).max(1);
        // Counted from the end, so that the last frame is one of them.
        for (_, places) in self.history.iter().rev().step_by(step).collect::<Vec<_>>().into_iter().rev() {
            let mut rays = vec![None; self.num_corners];
            for (track, px, covariance_px) in places {
                rays[*track] = Some(sight(px, *covariance_px));
            }
            views.push(tracks.iter().map(|track| rays[track.number]).collect());
        }
        views
    }

    /// A map of both keyframes with a landmark for each point, and the numbers of the landmarks' corners.
    pub fn build(
        &self,
        camera: &Camera,
        start: &VerifiedStart,
        incoming: &Incoming<'_>,
    ) -> (Map, Vec<(LandmarkId, usize)>) {
        let mut map = Map::new();
        let first = map.add_keyframe(NewKeyframe {
            frame: self.number,
            at: self.at,
            pyramid: Arc::clone(self.follower.first()),
            camera_from_world: CameraFromWorld::identity(),
            turned_from: None,
            odometry: self.odometry,
        });
        let turn = Rotation3::from_matrix_unchecked(*start.last_from_first.rotation());
        let second = map.add_keyframe(NewKeyframe {
            frame: incoming.number,
            at: incoming.at,
            pyramid: Arc::clone(incoming.pyramid),
            camera_from_world: CameraFromWorld::new(turn, *start.last_from_first.translation()),
            turned_from: None,
            odometry: incoming.odometry,
        });
        let mut landmarks = Vec::new();
        for (track, point) in self.follower.tracks().iter().zip(&start.points) {
            let Some(point) = point else { continue };
            let observation = |keyframe, px: Point2<f64>, covariance_px| Observation {
                keyframe,
                px,
                ray: camera.bearing(&px),
                level: track.level,
                covariance_px,
            };
            let filter = DepthFilter::new(1.0 / point.z, 0.05 / point.z);
            let id = map.add_landmark(
                observation(first, track.first_px, corner_covariance(track.level)),
                filter,
                LandmarkState::Converged,
            );
            map.add_observation(id, observation(second, track.px, track.covariance_px));
            landmarks.push((id, track.number));
        }
        (map, landmarks)
    }

    /// Poses of the frames on the way, from where the corners were in them.
    pub fn poses_between(
        &self,
        (camera, least_inliers): (&Camera, usize),
        map: &Map,
        landmarks: &[(LandmarkId, usize)],
        rng: &mut Rng,
    ) -> Vec<(usize, CameraFromWorld)> {
        let mut landmark_of = vec![None; self.num_corners];
        for (id, track) in landmarks {
            landmark_of[*track] = Some(*id);
        }
        let rejection = Rejection { max_hypotheses: None, has_robust_weights: true };
        let mut pose = CameraFromWorld::identity();
        let mut poses = Vec::new();
        let (_, before_last) =
            self.history.split_last().map_or((None, &[][..]), |(last, rest)| (Some(last), rest));
        for (number, places) in before_last {
            let observation = |(track, px, _): &(usize, Point2<f64>, Matrix2<f64>)| {
                let landmark = map.landmark(landmark_of[*track]?);
                let weight = whitening(focal_px(camera), &(Matrix2::identity() * 0.25));
                let ray = camera.bearing(px);
                landmark.is_alive().then(|| PoseObservation::of_point(landmark.point_in_world, ray, weight))
            };
            let observations: Vec<PoseObservation> = places.iter().filter_map(observation).collect();
            let robust = robust_pose(&pose, None, (&observations, rejection), rng);
            if robust.num_inliers * 2 >= observations.len() && robust.num_inliers >= least_inliers {
                pose = robust.camera_from_world;
                poses.push((*number, pose));
            }
        }
        poses
    }
}
