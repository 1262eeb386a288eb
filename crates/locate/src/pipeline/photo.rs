//! Where a single photo was taken.

use nalgebra::{Rotation3, Vector3};
use thiserror::Error;
use visloc_core::{
    Frame, RgbImage, RngTree, Timestamp,
    geom::{Camera, CameraFrame, Mount, PlanarPose, Rigid3, Robot, World},
};
use visloc_world::Map;

use super::{FeatureChoice, ImageAnalyzer, PipelineConfig, analyzer::unknown_kind, world_parts::WorldParts};
use crate::{
    ConfigError,
    observation::features::CameraState,
    refine::{Effort, RefinementConfig, SingleImage},
    vision::AnalysisError,
};

/// Downward tilts that are tried if it is not known, radians: from a little above the horizon to steeply down, this far apart.
const PITCHES_RAD: (f64, f64) = (-0.1, 1.0);
const PITCH_STEP_RAD: f64 = 0.07;
/// Heights that are tried if it is not known, meters: from a small robot to a man, each this much larger than the one before.
const HEIGHTS_M: (f64, f64) = (0.25, 2.0);
const HEIGHT_STEP: f64 = 1.15;
/// How exactly a height is known that somebody has measured, as a share.
const KNOWN_HEIGHT: f64 = 0.05;
/// Standard deviation of a photo's tilt and roll against what is supposed, radians: half of the step between two suppositions.
const TILT_RAD: f64 = PITCH_STEP_RAD / 2.0;
/// Suggestions of poses that are weighed, and places that are fitted, in each of the searches: for all supposed cameras together, and at
/// least for each.
const EFFORT_FOR_ALL: Effort = Effort { num_poses: 100_000, num_kept: 500 };
const EFFORT_FOR_EACH: Effort = Effort { num_poses: 2000, num_kept: 16 };
/// Searches that know nothing of each other: what only one of them has found tells how much none of them has.
const NUM_SEARCHES: usize = 2;
/// Places this near to each other are one.
const SAME_M: f64 = 0.25;
const SAME_RAD: f64 = 0.15;
/// Places less probable than this are left out.
const MIN_PROBABILITY: f64 = 0.002;
/// Looks at the photo: the first ones get to know its colors.
const NUM_LOOKS: usize = 2;

/// A photo.
#[derive(Debug, Clone)]
pub struct Photo {
    /// The image.
    pub image: RgbImage,
    /// Its camera.
    pub camera: Camera,
    /// How far the camera looked down, radians, within some degrees; `None` if nobody knows.
    pub pitch_down_rad: Option<f64>,
    /// Height of the camera above the ground, meters; `None` if nobody knows.
    pub height_m: Option<f64>,
}

/// Where a photo may have been taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhotoPose {
    /// Where the camera was.
    pub world_from_camera: Rigid3<World, CameraFrame>,
    /// The place below the camera, and the direction in which it looked.
    pub world_from_view: PlanarPose,
    /// How far it looked down, radians.
    pub pitch_down_rad: f64,
    /// How far it was turned clockwise about its axis, radians.
    pub roll_clockwise_rad: f64,
    /// Height above the ground, meters.
    pub height_m: f64,
    /// How probable it is that the photo was taken here.
    pub probability: f64,
}

impl PhotoPose {
    /// A pose of the camera in a frame with z up, meters.
    pub fn new(world_from_camera: Rigid3<World, CameraFrame>, probability: f64) -> Self {
        let (ahead, right) =
            (world_from_camera.rotate(&Vector3::z()), world_from_camera.rotate(&Vector3::x()));
        let down = world_from_camera.rotate(&Vector3::y());
        let at = world_from_camera.translation();
        Self {
            world_from_camera,
            world_from_view: PlanarPose::new(at.x, at.y, ahead.y.atan2(ahead.x)),
            pitch_down_rad: (-ahead.z).clamp(-1.0, 1.0).asin(),
            roll_clockwise_rad: (-right.z).atan2(-down.z),
            height_m: at.z,
            probability,
        }
    }
}

/// All places that explain a photo.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotoAnswer {
    /// The most probable one first.
    pub poses: Vec<PhotoPose>,
    /// How probable it is that the photo was taken at none of them: at a place that was not found or is hardly probable, or what it shows is
    /// not on the map, or too little.
    pub elsewhere: f64,
}

/// A photo that cannot be located.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PhotoError {
    /// Map or parameters.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The photo is not of its camera's size.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
}

/// Finds all places of a map that explain a photo.
///
/// # Errors
/// If a parameter is out of its range, the map is of a kind that cannot be searched, or the photo is not of its camera's size.
pub fn locate_photo(
    map: &Map,
    config: &PipelineConfig,
    photo: &Photo,
    rng: RngTree,
) -> Result<PhotoAnswer, PhotoError> {
    let config = PipelineConfig { features: FeatureChoice::Rich, ..*config };
    config.check()?;
    let rich = WorldParts::new(map, &config)?.rich.ok_or_else(|| unknown_kind(map))?;
    let mounts = supposed_mounts(photo);
    let (all, each) = (EFFORT_FOR_ALL, EFFORT_FOR_EACH);
    let effort = Effort {
        num_poses: (all.num_poses / mounts.len()).max(each.num_poses),
        num_kept: (all.num_kept / mounts.len()).max(each.num_kept),
    };
    let mut search = SingleImage::new(rich.features, rich.pixels);
    let mut analyzer = ImageAnalyzer::new(map, &config)?;
    let (mut looks, mut draws) = (rng.stream("analysis", 0), rng.stream("photo", 0));
    let log_prior = -(mounts.len() as f64).ln();
    let (mut places, mut found) = (Vec::new(), Vec::new());
    let at = Timestamp::default();
    let mut frame = Frame::new(at, photo.image.clone(), photo.camera, Rigid3::identity());
    for mount in &mounts {
        frame.robot_from_camera = mount.robot_from_camera();
        for _ in 0..NUM_LOOKS {
            analyzer.analyze(&frame, &mut looks)?;
        }
        let config = uncertain(&rich.config, photo, mount);
        for number in 0..NUM_SEARCHES {
            found.clear();
            search.explain(analyzer.percept(), &config, effort, &mut draws, &mut found);
            for explanation in &found {
                let log_evidence = explanation.log_evidence + log_prior;
                let pose = photo_pose(&explanation.camera, &frame.robot_from_camera);
                places.push(Place { pose, log_evidence, found_by: 1 << number });
            }
        }
    }
    let mirrored = |pose: &PlanarPose| search.mirrored(pose);
    Ok(answer(&distinct(places, mirrored), mirrored))
}

/// Cameras that may have taken a photo.
fn supposed_mounts(photo: &Photo) -> Vec<Mount> {
    let steps = |first: f64, last: f64, next: &dyn Fn(f64) -> f64| -> Vec<f64> {
        std::iter::successors(Some(first), |value| Some(next(*value)).filter(|value| *value <= last))
            .collect()
    };
    let pitches = photo.pitch_down_rad.map_or_else(
        || steps(PITCHES_RAD.0, PITCHES_RAD.1, &|pitch| pitch + PITCH_STEP_RAD),
        // What somebody says of it holds within some degrees, and where the horizon is in the image depends on it.
        |pitch| [-0.5, 0.0, 0.5].map(|steps| pitch + steps * PITCH_STEP_RAD).to_vec(),
    );
    let heights = photo.height_m.map_or_else(
        || steps(HEIGHTS_M.0, HEIGHTS_M.1, &|height| height * HEIGHT_STEP),
        |height| vec![height],
    );
    let pairs =
        heights.iter().flat_map(|height_m| pitches.iter().map(move |tilt_rad| (*height_m, *tilt_rad)));
    pairs.map(|(height_m, tilt_rad)| Mount { height_m, tilt_rad, ..Mount::default() }).collect()
}

/// The parameters of the tracks for a camera that is known as far as a photo's is.
fn uncertain(config: &RefinementConfig, photo: &Photo, mount: &Mount) -> RefinementConfig {
    let share = if photo.height_m.is_some() { KNOWN_HEIGHT } else { (HEIGHT_STEP - 1.0) / 2.0 };
    RefinementConfig {
        mount_pitch_rad: TILT_RAD,
        mount_roll_rad: TILT_RAD,
        // The direction in which the camera looks is all that there is to a heading.
        mount_yaw_rad: 0.0,
        raise_bias_m: share * mount.height_m,
        ..*config
    }
}

/// A place that explains a photo.
struct Place {
    pose: PhotoPose,
    log_evidence: f64,
    /// A bit for each search that has found it.
    found_by: u32,
}

/// The best one of all that are at one place, or at mirrored ones.
fn distinct(mut found: Vec<Place>, mirrored: impl Fn(&PlanarPose) -> Option<PlanarPose>) -> Vec<Place> {
    found.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
    let is_near =
        |a: &PlanarPose, b: &PlanarPose| a.distance_m(b) < SAME_M && a.heading_difference_rad(b) < SAME_RAD;
    let mut places: Vec<Place> = Vec::new();
    for place in found {
        let view = place.pose.world_from_view;
        let mirrored = mirrored(&view);
        let known = places.iter_mut().find(|other| {
            let other = &other.pose.world_from_view;
            is_near(other, &view) || mirrored.as_ref().is_some_and(|view| is_near(other, view))
        });
        match known {
            Some(known) => known.found_by |= place.found_by,
            None => places.push(place),
        }
    }
    places
}

fn photo_pose(camera: &CameraState, robot_from_camera: &Rigid3<Robot, CameraFrame>) -> PhotoPose {
    let up = Rigid3::<Robot, Robot>::new(Rotation3::identity(), Vector3::z() * camera.raise_m);
    let turn = Rigid3::new(Rotation3::from_scaled_axis(camera.tilt_rad), Vector3::zeros());
    PhotoPose::new(camera.world_from_robot.to_rigid3() * up * *robot_from_camera * turn, 0.0)
}

/// Probabilities of the places, and of none of them: a place that no search has found is as probable as all that only one has (Good and
/// Turing), and features may belong to nothing. On a symmetric map the photo may have been taken at the mirrored place as well.
fn answer(places: &[Place], mirrored: impl Fn(&PlanarPose) -> Option<PlanarPose>) -> PhotoAnswer {
    let best = places.iter().map(|place| place.log_evidence).fold(0.0, f64::max);
    let weight = |log_evidence: f64| (log_evidence - best).exp();
    let sum = |is_counted: &dyn Fn(&&Place) -> bool| -> f64 {
        places.iter().filter(is_counted).map(|place| weight(place.log_evidence)).sum()
    };
    let not_found = sum(&|place| place.found_by.count_ones() == 1);
    let total = weight(0.0) + sum(&|_| true) + not_found;
    let mut poses = Vec::new();
    for Place { pose, log_evidence, .. } in places {
        let probability = weight(*log_evidence) / total;
        let planar = pose.world_from_view;
        match mirrored(&planar) {
            None => poses.push(PhotoPose { probability, ..*pose }),
            Some(other) => {
                let half_turn: Rigid3<World, World> = other.to_rigid3() * planar.to_rigid3().inverse();
                let turned = PhotoPose::new(half_turn * pose.world_from_camera, 0.0);
                let probability = probability / 2.0;
                poses.extend([*pose, turned].map(|pose| PhotoPose { probability, ..pose }));
            }
        }
    }
    poses.retain(|pose| pose.probability >= MIN_PROBABILITY);
    poses.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let listed: f64 = poses.iter().map(|pose| pose.probability).sum();
    PhotoAnswer { poses, elsewhere: (1.0 - listed).clamp(0.0, 1.0) }
}
