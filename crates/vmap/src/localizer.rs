//! Where a camera is in a map that was made before.

use nalgebra::{Matrix6, Rotation3};
use visloc_core::{
    Clock, GrayFrame, Timestamp,
    geom::{Camera, CameraFrame, Rigid3, World},
};
use visloc_slam::{
    ConfigError, FrameError, FrameOutcome, Schedule, Slam, SlamConfig, TrackingState,
    lie::adjoint,
    map::{Map, MapId},
    mapping::MapErrors,
    odometry::{CameraMotion, OdomFromCamera, deviations},
    track::Quality,
};

use crate::{
    ScaleSource, VisualMap,
    evidence::{Evidence, Hypothesis, LEAST_OF_MAP},
    image::packing_beside,
};

/// From this reliability on a camera counts as localized, as a robot on a drawn map does.
pub const LOCALIZED_RELIABILITY: f64 = 0.6;
/// Way by visual motion after which half of the reliability is gone, in depths of the scene.
const CARRIED_HALF_DEPTHS: f64 = 30.0;
/// Standard deviation of a way by visual motion, share of its length.
const DRIFT: f64 = 0.01;
/// Distance from where it is expected that a camera is not followed over, share of the depth of the scene: the image has shifted by more than a
/// fifth of its focal length.
const JUMP: f64 = 0.2;
/// The same where odometry says how far the camera has moved.
const JUMP_BY_ODOMETRY: f64 = 0.05;
/// Distance by odometry after which half of the reliability is gone, meters.
const CARRIED_HALF_M: f64 = 3.0;

/// What is known of a camera at one moment.
#[derive(Debug, Clone, Copy)]
pub struct CameraEstimate {
    /// When.
    pub at: Timestamp,
    /// The map.
    pub map: MapId,
    /// Where the camera is, in the frame and unit of the map.
    pub world_from_camera: Rigid3<World, CameraFrame>,
    /// Covariance over a twist in the frame of the camera: translation first, map units and radians. What the map is off by around here is
    /// in it, see [`MapErrors`]; what its frame and its unit of length are off by as a whole is not.
    pub covariance: Matrix6<f64>,
    /// How far the pose can be trusted, 0 to 1; localized above [`LOCALIZED_RELIABILITY`].
    pub reliability: f64,
    /// What the image says of the place.
    pub support: Support,
    /// Whether the camera was found from nothing in this image.
    pub is_found: bool,
}

/// What a pose in a map rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// The image shows landmarks of the map.
    Map,
    /// It shows landmarks that were added since the map was seen last: the pose is carried on by visual motion.
    Motion,
    /// It shows too little: the pose is carried on by the robot's odometry.
    Odometry,
}

impl CameraEstimate {
    /// Whether the camera counts as localized.
    pub fn is_localized(&self) -> bool {
        self.reliability >= LOCALIZED_RELIABILITY
    }

    /// The same after an image that shows another place, which is the right one with some probability: never both are.
    fn disputed_by(mut self, probability: f64) -> Self {
        let own = self.reliability;
        self.reliability = own * (1.0 - probability) / (1.0 - own * probability);
        self
    }

    /// Whether the image shows nothing of the map.
    pub fn is_carried(&self) -> bool {
        self.support != Support::Map
    }
}

/// The way by odometry since an image showed the place. It ends where the odometry is interrupted: a robot in the air is elsewhere then.
#[derive(Debug, Clone, Copy)]
struct WaySince {
    seen: CameraEstimate,
    odom_from_seen: OdomFromCamera,
    odom_from_camera: OdomFromCamera,
    length_m: f64,
    turn_rad: f64,
}

impl WaySince {
    fn new(seen: CameraEstimate, odom_from_camera: OdomFromCamera) -> Self {
        let odom_from_seen = odom_from_camera;
        Self { seen, odom_from_seen, odom_from_camera, length_m: 0.0, turn_rad: 0.0 }
    }

    fn go_on(self, odom_from_camera: OdomFromCamera) -> Self {
        let step: CameraMotion = self.odom_from_camera.inverse() * odom_from_camera;
        Self {
            odom_from_camera,
            length_m: self.length_m + step.translation().norm(),
            turn_rad: self.turn_rad + step.rotation_angle_rad(),
            ..self
        }
    }
}

/// The last image whose landmarks of the map tell the place better than the motion since another one does.
#[derive(Debug, Clone, Copy)]
struct InMap {
    /// What is known of it, with the errors of the map.
    shown: CameraEstimate,
    last: Rigid3<World, CameraFrame>,
    /// Way by visual motion since, map units.
    way: f64,
}

impl InMap {
    fn go_on(self, place: Rigid3<World, CameraFrame>) -> Self {
        let step = (place.translation() - self.last.translation()).norm();
        Self { last: place, way: self.way + step, ..self }
    }
}

/// Finds a camera in a map and follows it there. What the map has stays as it is; where it shows too little, landmarks that are added
/// beside it carry the pose on.
#[derive(Debug)]
pub struct MapLocalizer {
    slam: Slam,
    /// What speaks for the place where the camera is followed.
    evidence: Evidence,
    /// What the last image showed, if it showed a place. As in all below, its covariance is that in an exact map.
    followed: Option<CameraEstimate>,
    last: Option<CameraEstimate>,
    errors: MapErrors,
    in_map: Option<InMap>,
    /// The last estimate with them.
    stated: Option<CameraEstimate>,
    /// Way by visual motion since an image showed the map, map units.
    visual_way: f64,
    way: Option<WaySince>,
    meters_per_unit: Option<f64>,
    outcome: Option<FrameOutcome>,
}

impl MapLocalizer {
    /// For one camera in a map. Where the scale of the map is known, odometry carries the pose on. The seed fixes every random choice.
    ///
    /// # Errors
    /// If a parameter is out of range, or the map is empty.
    pub fn new(
        map: &Map,
        meters_per_unit: Option<f64>,
        camera: &Camera,
        config: &SlamConfig,
        seed: u64,
    ) -> Result<Self, ConfigError> {
        if map.all_keyframes().next().is_none() {
            let (expected, found) = ("at least one keyframe".to_owned(), "none".to_owned());
            return Err(ConfigError::Relation { key: "map", expected, found });
        }
        let mut slam = Slam::around_fixed_map(map.clone(), camera, config, seed, Schedule::Sequential)?;
        slam.set_packing(packing_beside(map));
        let errors = MapErrors::of(slam.map(), camera);
        Ok(Self {
            slam,
            evidence: Evidence::default(),
            followed: None,
            last: None,
            errors,
            in_map: None,
            stated: None,
            visual_way: 0.0,
            way: None,
            meters_per_unit,
            outcome: None,
        })
    }

    /// For one camera in the maps of a file, see [`MapLocalizer::new`]: in meters if the scale of the largest is known.
    ///
    /// # Errors
    /// If a parameter is out of range, or there is no map.
    pub fn in_map(
        map: &VisualMap,
        camera: &Camera,
        config: &SlamConfig,
        seed: u64,
    ) -> Result<Self, ConfigError> {
        let scale = map.largest().map(|largest| map.scale(largest).source).unwrap_or_default();
        let meters_per_unit = (scale != ScaleSource::Unknown).then_some(1.0);
        Self::new(&map.map, meters_per_unit, camera, config, seed)
    }

    /// Measures times with a clock.
    pub fn set_clock(&mut self, clock: Clock) {
        self.slam.set_clock(clock);
    }

    /// The system below, to look at its map.
    pub fn slam(&self) -> &Slam {
        &self.slam
    }

    /// Takes the next image. `None` where nothing is known of the place. Odometry that is not finite counts as none.
    ///
    /// # Errors
    /// If the image cannot be used; it is left out.
    pub fn step(&mut self, frame: GrayFrame) -> Result<Option<CameraEstimate>, FrameError> {
        let GrayFrame { at, image, odom_from_camera, .. } = frame;
        let odom_from_camera = odom_from_camera.filter(OdomFromCamera::is_finite);
        let outcome = self.slam.add_frame_of_robot(at, image, self.in_units(odom_from_camera))?;
        self.way = self.way.zip(odom_from_camera).map(|(way, now)| way.go_on(now));
        let carried = self.way.and_then(|way| self.carried(at, &way));
        let seen = self.seen(at, &outcome, carried);
        // Where an image shows another place than odometry says, a place that is in doubt does not count against one that is known better.
        let disputing = seen.zip(carried).filter(|(seen, carried)| {
            !seen.is_localized() && seen.reliability < carried.reliability && self.jumps(seen, carried)
        });
        self.followed = seen;
        self.last = match disputing {
            Some((seen, carried)) => Some(carried.disputed_by(seen.reliability)),
            None => {
                if let Some(seen) = &seen {
                    self.add_errors(seen, &outcome);
                }
                let known = seen.zip(odom_from_camera);
                self.way = known.map(|(seen, now)| WaySince::new(seen, now)).or(self.way);
                seen.or(carried)
            }
        };
        self.slam.set_doubt(seen.is_some_and(|seen| !seen.is_localized()));
        self.outcome = Some(outcome);
        self.stated = self.last.map(|last| self.with_errors(last));
        Ok(self.stated)
    }

    /// Takes note of what an image tells with the errors of the map: by the landmarks of the map that it shows or, where those are few, by the
    /// motion since an image that showed more.
    fn add_errors(&mut self, seen: &CameraEstimate, outcome: &FrameOutcome) {
        let place = seen.world_from_camera;
        self.in_map = self.in_map.filter(|_| !seen.is_found).map(|in_map| in_map.go_on(place));
        let pose = (self.slam.camera(), &place.inverse());
        let shown = self.errors.covariance(self.slam.map(), &outcome.fixed, pose);
        let of_place = |covariance: &Matrix6<f64>| covariance.fixed_view::<3, 3>(0, 0).trace();
        let moved = of_place(&self.with_errors(*seen).covariance);
        if let Some(covariance) = shown.filter(|shown| self.in_map.is_none() || of_place(shown) <= moved) {
            self.in_map =
                Some(InMap { shown: CameraEstimate { covariance, ..*seen }, last: place, way: 0.0 });
        }
    }

    /// An estimate with the errors of the map.
    fn with_errors(&self, mut estimate: CameraEstimate) -> CameraEstimate {
        let Some(InMap { shown, way, .. }) = self.in_map.filter(|it| it.shown.map == estimate.map) else {
            return estimate;
        };
        if shown.at == estimate.at {
            return CameraEstimate { covariance: shown.covariance, ..estimate };
        }
        let moves = adjoint(&(estimate.world_from_camera.inverse() * shown.world_from_camera));
        estimate.covariance += moves * shown.covariance * moves.transpose();
        for i in 0..3 {
            estimate.covariance[(i, i)] += DRIFT.powi(2) * (way.powi(2) - self.visual_way.powi(2)).max(0.0);
        }
        estimate
    }

    /// The pose by odometry in the unit of the map; `None` if that is not known.
    fn in_units(&self, odom_from_camera: Option<OdomFromCamera>) -> Option<OdomFromCamera> {
        let units_per_meter = 1.0 / self.meters_per_unit?;
        odom_from_camera.map(|pose| {
            let turn = Rotation3::from_matrix_unchecked(*pose.rotation());
            Rigid3::new(turn, pose.translation() * units_per_meter)
        })
    }

    /// What the last image came to in the system below; `None` before the first one.
    pub fn outcome(&self) -> Option<&FrameOutcome> {
        self.outcome.as_ref()
    }

    /// What is known since the last image; `None` where nothing is known of the place.
    pub fn estimate(&self) -> Option<&CameraEstimate> {
        self.stated.as_ref()
    }

    /// All places where the camera may be, the most probable first: where places look alike there are several.
    pub fn hypotheses(&self) -> Vec<Hypothesis> {
        let place = |it: &CameraEstimate, probability| {
            let CameraEstimate { map, world_from_camera, .. } = *it;
            Hypothesis { map, world_from_camera, probability }
        };
        let mut places = Vec::new();
        if let Some(seen) = &self.followed {
            places.push(place(seen, self.evidence.probability()));
            places.extend(self.evidence.elsewhere(&seen.world_from_camera));
        }
        if let Some(last) = &self.last
            && self.followed.is_none_or(|seen| self.jumps(&seen, last))
        {
            places.push(place(last, last.reliability));
        }
        places.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        places
    }

    /// What an image tells that was tracked.
    fn seen(
        &mut self,
        at: Timestamp,
        outcome: &FrameOutcome,
        carried: Option<CameraEstimate>,
    ) -> Option<CameraEstimate> {
        let TrackingState::Tracking(quality) = outcome.state else { return None };
        let pose = outcome.camera_from_world.filter(|_| quality != Quality::Bad)?;
        let (covariance, map) = outcome.covariance.zip(outcome.map)?;
        let world_from_camera = pose.inverse();
        let shows_map = outcome.is_relocalized || outcome.fixed.len() >= LEAST_OF_MAP;
        let support = if shows_map { Support::Map } else { Support::Motion };
        let is_found = outcome.is_relocalized;
        let mut seen =
            CameraEstimate { at, map, world_from_camera, covariance, reliability: 0.0, support, is_found };
        // A few landmarks may fit at two places: whoever jumps, or is found where odometry does not say, has to be recognized anew.
        let expected = if is_found { carried } else { self.followed.or(carried) };
        if expected.map_or(is_found, |expected| self.jumps(&seen, &expected)) {
            self.evidence = Evidence::default();
        }
        self.evidence.add(outcome, &world_from_camera);
        seen.reliability = self.evidence.reliability();
        self.visual_way = match self.followed {
            Some(last) if !shows_map => {
                self.visual_way
                    + (world_from_camera.translation() - last.world_from_camera.translation()).norm()
            }
            _ => 0.0,
        };
        if self.visual_way > 0.0 {
            for i in 0..3 {
                seen.covariance[(i, i)] += (DRIFT * self.visual_way).powi(2);
            }
            seen.reliability *= (-self.visual_way / (CARRIED_HALF_DEPTHS * self.depth()?)).exp2();
        }
        Some(seen)
    }

    /// Whether a camera cannot have come from where it is expected.
    fn jumps(&self, now: &CameraEstimate, expected: &CameraEstimate) -> bool {
        let apart = (now.world_from_camera.translation() - expected.world_from_camera.translation()).norm();
        let sigma = expected.covariance.fixed_view::<3, 3>(0, 0).trace().max(0.0).sqrt();
        let share = if expected.support == Support::Odometry { JUMP_BY_ODOMETRY } else { JUMP };
        now.map != expected.map || self.depth().is_some_and(|depth| apart > share * depth + 3.0 * sigma)
    }

    /// Depth of the scene, map units.
    fn depth(&self) -> Option<f64> {
        let (keyframe, _) = self.slam.frames().last()?.place?;
        self.slam.map().depth_of(keyframe)
    }

    /// The place that was seen last, moved on by odometry.
    fn carried(&self, at: Timestamp, way: &WaySince) -> Option<CameraEstimate> {
        let units_per_meter = 1.0 / self.meters_per_unit?;
        let seen_from_camera: CameraMotion = way.odom_from_seen.inverse() * way.odom_from_camera;
        let (meters, radians) = deviations(way.length_m, way.turn_rad);
        let mut covariance = way.seen.covariance;
        for i in 0..3 {
            covariance[(i, i)] += (meters * units_per_meter).powi(2);
            covariance[(i + 3, i + 3)] += radians * radians;
        }
        let turn = Rotation3::from_matrix_unchecked(*seen_from_camera.rotation());
        let step = Rigid3::new(turn, seen_from_camera.translation() * units_per_meter);
        Some(CameraEstimate {
            at,
            world_from_camera: way.seen.world_from_camera * step,
            covariance,
            reliability: way.seen.reliability * (-way.length_m / CARRIED_HALF_M).exp2(),
            support: Support::Odometry,
            is_found: false,
            ..way.seen
        })
    }
}
