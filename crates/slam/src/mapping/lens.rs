//! What the calibration of the camera lacks, estimated from the map: of its lens, and how long it takes to expose an image.
//!
//! A focal length that is off by half a percent, or a rectified image that is still a little curved, hardly shows in a single
//! image. But the depths of landmarks at the border of the image are wrong with it, all in the same direction, and each turn
//! changes the scale of the map: by a quarter in a single turn of a car. The same views tell what is wrong: no depths make
//! them agree.
//!
//! Rows that are exposed one after the other bend the map in the same way wherever the camera turns, see [`crate::Exposure`].
//!
//! Source for what a lens does to drives: Cvisic, Markovic and Petrovic, "Recalibrating the KITTI dataset camera setup for improved
//! odometry accuracy", 2021.

use nalgebra::{Point2, Vector2};
use visloc_core::{
    geom::{Camera, Distortion},
    median,
};

use super::adjust::{CHI2, adjust_all, collect};
use crate::{
    config::MappingConfig,
    map::{KeyframeId, LandmarkId, Map, SessionCamera},
    shutter::Readout,
    solve::{Bundle, BundleLens, BundleObservation, BundleSettings},
    track::focal_px,
};

/// Standard deviation of what a calibration leaves of the first radial coefficient. Other values of the camera are not
/// estimated: a camera that goes ahead tells the focal length and the principal point from depths and its own turns too badly.
/// What rectified images keep of it nobody has measured.
const SIGMA_RECTIFIED: f64 = 0.02;
/// The same where the calibration has a lens: it was fitted to pictures of a board, whose corners tell it to some thousandths.
const SIGMA_CALIBRATED: f64 = 0.003;
/// Standard deviation of the readout of cameras of which nothing is known, seconds: rows that are exposed one after the other take most of the time between
/// two images, which most cameras make 30 a second of.
const SIGMA_READOUT: f64 = 0.02;
/// Step of numeric derivatives by parameters of a lens.
pub(crate) const STEP: f64 = 1e-4;
/// Keyframes with which a map is settled for the first time: fewest that the lens is estimated from.
pub(super) const FIRST_SETTLED_AT: usize = 10;
/// Growth of the number of keyframes after which the map is settled again.
const WAIT: f64 = 1.25;
/// The same if nothing has changed.
const SETTLED_WAIT: f64 = 1.4;
/// Change of the scale, in logarithms, that counts as none.
const SETTLED: f64 = 0.01;
/// Keyframes beyond which it is believed to be known: the whole map would have to move with it.
const MOST_KEYFRAMES: usize = 120;
/// Least gain in squared residuals for which the calibration is taken to be wrong, in units of what is usual for one landmark: the errors of a
/// landmark in several keyframes are alike, so that each landmark counts once.
const LEAST_GAIN: f64 = 15.0;

/// Keeps a map and the lens that it was seen through in agreement.
#[derive(Debug, Clone)]
pub struct LensEstimator {
    /// As calibrated.
    calibrated: Camera,
    change: f64,
    readout: Readout,
    /// Keyframes at which it is estimated next.
    next_at: usize,
}

impl LensEstimator {
    /// For a camera as calibrated.
    pub fn new(calibrated: &Camera) -> Self {
        Self { calibrated: *calibrated, change: 0.0, readout: Readout::default(), next_at: FIRST_SETTLED_AT }
    }

    /// For a camera that an earlier session knows better than its calibration does, and a map that was settled then.
    pub fn resume(known: &SessionCamera, num_keyframes: usize) -> Self {
        let SessionCamera { calibrated, camera, readout } = known;
        let first = |camera: &Camera| camera.distortion().coefficients().first().copied().unwrap_or(0.0);
        let next_at = FIRST_SETTLED_AT.max((num_keyframes as f64 * SETTLED_WAIT).ceil() as usize);
        Self {
            calibrated: *calibrated,
            change: first(camera) - first(calibrated),
            readout: *readout,
            next_at,
        }
    }

    /// How long the camera takes to expose an image.
    pub fn readout(&self) -> Readout {
        self.readout
    }

    /// Starts over with a new map; what is known of the lens stays.
    pub fn restart(&mut self) {
        self.next_at = FIRST_SETTLED_AT;
    }

    /// Adjusts the whole map, and the lens or the readout with it if that explains the views clearly better. The camera as it is known now; `None` if
    /// it is not yet time to.
    pub fn settle(&mut self, map: &mut Map, camera: &Camera, config: &MappingConfig) -> Option<Camera> {
        // A map that is fixed cannot move with the lens.
        if map.has_fixed() {
            return None;
        }
        let free: Vec<KeyframeId> = map.keyframes().map(|(id, _)| id).collect();
        if free.len() < self.next_at || free.len() > MOST_KEYFRAMES {
            return None;
        }
        let before: Vec<Vec<(LandmarkId, f64)>> = free.iter().map(|id| depths(map, *id)).collect();
        let (mut has_changed, mut camera) = (false, *camera);
        map.put_right(&self.readout, &camera);
        let expected = (-self.change, sigma_of(&self.calibrated));
        if config.adjust_lens
            && let Some(views) = Views::of(map, &free, &camera, expected)
        {
            if let Some(readout) = self.better_readout(map, &views, &camera) {
                self.readout = readout;
                map.put_right(&readout, &camera);
                has_changed = true;
            } else if let Some(better) = self.better_lens(map, &views) {
                (has_changed, camera) = (true, better);
            }
        }
        adjust_all(map, config, focal_px(&camera));
        let growth: Vec<(KeyframeId, f64)> =
            free.iter().zip(&before).map(|(id, before)| (*id, growth(map, *id, before))).collect();
        for (id, factor) in &growth {
            map.note_growth(*id, *factor);
        }
        let wait = match (has_changed, growth.iter().all(|(_, factor)| factor.ln().abs() < SETTLED)) {
            (false, true) => SETTLED_WAIT,
            // What was left out as wrong and what was found where it should be were so for the lens of before.
            (true, false) => 1.0,
            _ => WAIT,
        };
        self.next_at = ((free.len() as f64 * wait).ceil() as usize).max(free.len() + 1);
        Some(camera)
    }

    /// The camera as it explains the map clearly better; the map is seen through it then. Once the calibration has proved to be wrong, every
    /// further estimate counts: what it is compared with is no better founded.
    fn better_lens(&mut self, map: &mut Map, views: &Views) -> Option<Camera> {
        let least_gain = if self.change == 0.0 { LEAST_GAIN } else { 0.0 };
        let change = views.with_lens.lens.first()?.change;
        if !views.is_gain((views.cost, views.cost_with_lens), least_gain) {
            return None;
        }
        let total = self.change + change;
        let camera = changed(&self.calibrated, total)?;
        self.change = total;
        map.look_through(&camera);
        Some(camera)
    }

    /// How long the camera takes to expose an image, if that explains the views clearly better than what was taken for it, and better than any
    /// lens does: a camera that turns one way sees about the same through another lens and column by column.
    fn better_readout(&self, map: &Map, views: &Views, camera: &Camera) -> Option<Readout> {
        let mut bundle = views.with_lens.clone();
        let num_of_lens = bundle.lens.len();
        let by_readout = |(observation, px): (&BundleObservation, &Option<Point2<f64>>)| {
            let exposure = map.keyframe(views.keyframes[observation.camera]).exposure;
            let ray = observation.ray.push(1.0);
            exposure.zip(*px).map_or_else(Default::default, |(it, px)| it.ray_by_readout(&px, &ray, camera))
        };
        let by_readout: Vec<[Vector2<f64>; 2]> =
            bundle.observations.iter().zip(&views.px).map(by_readout).collect();
        for axis in 0..2 {
            bundle.lens.push(BundleLens {
                change: 0.0,
                expected: -self.readout.0[axis],
                sigma: SIGMA_READOUT,
                // What is seen has gone on with the scene: it would be less far if the camera took less long.
                ray_by_change: by_readout.iter().map(|by| -by[axis]).collect(),
                size_by_change: Vec::new(),
            });
        }
        let cost = bundle.solve(&settings()).last_cost;
        let change = Vector2::from_fn(|axis, _| bundle.lens[num_of_lens + axis].change);
        views.is_gain((views.cost_with_lens, cost), LEAST_GAIN).then_some(Readout(self.readout.0 + change))
    }
}

/// A camera whose first radial coefficient is changed; `None` if there is no such lens.
fn changed(camera: &Camera, change: f64) -> Option<Camera> {
    let distortion = match camera.distortion() {
        Distortion::None => Distortion::RadialTangential([change, 0.0, 0.0, 0.0, 0.0]),
        Distortion::RadialTangential([k1, k2, p1, p2, k3]) => {
            Distortion::RadialTangential([k1 + change, k2, p1, p2, k3])
        }
        Distortion::KannalaBrandt([k1, k2, k3, k4]) => Distortion::KannalaBrandt([k1 + change, k2, k3, k4]),
        _ => return None,
    };
    Camera::checked(camera.size_px(), camera.focal_px(), camera.center_px(), distortion).ok()
}

/// All that the keyframes of a map see, adjusted with the lens.
struct Views {
    keyframes: Vec<KeyframeId>,
    /// Pixel of each observation; `None` for what another camera sees, which does not depend on this one.
    px: Vec<Option<Point2<f64>>>,
    /// Adjusted together with the lens, if it is one that can change.
    with_lens: Bundle,
    /// What is left of the squared residuals then.
    cost_with_lens: f64,
    /// The same with the lens as it is known.
    cost: f64,
}

impl Views {
    /// The change of the lens that is expected comes with its standard deviation.
    fn of(
        map: &Map,
        keyframes: &[KeyframeId],
        camera: &Camera,
        (expected, sigma): (f64, f64),
    ) -> Option<Self> {
        let (mut bundle, index) = collect(map, keyframes, focal_px(camera));
        let px = |o: &BundleObservation| {
            let (landmark, keyframe) = (map.landmark(index.landmarks[o.point]), index.keyframes[o.camera]);
            let observation = landmark.observation_in(keyframe)?;
            Some(map.keyframe(keyframe).foreign.is_none().then_some(observation.px))
        };
        let px = bundle.observations.iter().map(px).collect::<Option<Vec<_>>>()?;
        let cost = bundle.clone().solve(&settings()).last_cost;
        if let Some(ray_by_change) = derivatives(&bundle, camera, &px) {
            let size_by_change = Vec::new();
            bundle.lens.push(BundleLens { change: 0.0, expected, sigma, ray_by_change, size_by_change });
        }
        let cost_with_lens = bundle.solve(&settings()).last_cost;
        Some(Self { keyframes: index.keyframes, px, with_lens: bundle, cost_with_lens, cost })
    }

    /// Whether the squared residuals have become less by so much, in units of what is usual for one landmark.
    fn is_gain(&self, (before, after): (f64, f64), least: f64) -> bool {
        before - after > least * before / self.with_lens.points.len().max(1) as f64
    }
}

fn settings() -> BundleSettings {
    BundleSettings { max_iterations: 10, huber: CHI2.sqrt() }
}

fn sigma_of(calibrated: &Camera) -> f64 {
    match calibrated.distortion() {
        Distortion::None => SIGMA_RECTIFIED,
        _ => SIGMA_CALIBRATED,
    }
}

/// Derivatives of the ray of each observation by the change of the lens.
fn derivatives(bundle: &Bundle, camera: &Camera, px: &[Option<Point2<f64>>]) -> Option<Vec<Vector2<f64>>> {
    let camera = changed(camera, STEP)?;
    let of_one = |(observation, px): (&BundleObservation, &Option<Point2<f64>>)| {
        px.map_or_else(Vector2::zeros, |px| (camera.bearing(&px).xy() - observation.ray) / STEP)
    };
    Some(bundle.observations.iter().zip(px).map(of_one).collect())
}

/// Landmarks of a keyframe with their depths.
fn depths(map: &Map, id: KeyframeId) -> Vec<(LandmarkId, f64)> {
    let keyframe = map.keyframe(id);
    let depth = |id: &LandmarkId| {
        let landmark = map.landmark(*id);
        let depth = keyframe.camera_from_world().transform(&landmark.point_in_world).z;
        (landmark.is_converged() && depth > 0.0).then_some((*id, depth))
    };
    keyframe.landmarks.iter().filter_map(depth).collect()
}

/// Median factor by which the landmarks of a keyframe have gone away from it.
fn growth(map: &Map, id: KeyframeId, before: &[(LandmarkId, f64)]) -> f64 {
    let keyframe = map.keyframe(id);
    let factor = |(id, before): &(LandmarkId, f64)| {
        let landmark = map.landmark(*id);
        let depth = keyframe.camera_from_world().transform(&landmark.point_in_world).z;
        (landmark.is_alive() && depth > 0.0).then_some(depth / before)
    };
    median(before.iter().filter_map(factor)).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Matrix2, Point3, Vector6};
    use rand::RngExt;
    use visloc_core::{GrayImage, RngTree, Timestamp, gaussian};

    use super::*;
    use crate::{
        image::Pyramid,
        lie::{CameraFromWorld, exp},
        map::{LandmarkState, NewKeyframe, Observation},
        mapping::DepthFilter,
        shutter::Exposure,
    };

    const SIGMA_PX: f64 = 0.3;

    fn camera() -> Camera {
        Camera::pinhole((640, 480), (525.0, 525.0), (319.5, 239.5)).unwrap()
    }

    /// A map of a wall with boxes before it, from a camera that shakes while it goes by and whose images are exposed with a readout.
    fn map_of(readout: &Readout, seed: u64) -> Map {
        let (camera, mut rng) = (camera(), RngTree::new(seed).stream("readout", 0));
        let pyramid = Arc::new(Pyramid::new(GrayImage::new(640, 480), 1));
        let mut map = Map::new();
        let points: Vec<Point3<f64>> = (0..400)
            .map(|_| {
                let [x, y, z] = [(-3.0..6.0), (-2.0..2.0), (2.5..5.0)].map(|range| rng.random_range(range));
                Point3::new(x, y, z)
            })
            .collect();
        let mut landmarks = vec![None; points.len()];
        for i in 0..FIRST_SETTLED_AT {
            let motion = Vector6::from_fn(|i, _| rng.random_range(-1.0..1.0) * if i < 3 { 0.1 } else { 0.8 });
            let way = Vector6::new(-0.2 * i as f64, 0.05, 0.0, 0.0, 0.04 * (i % 3) as f64, 0.0);
            let camera_from_world = exp(&way) * CameraFromWorld::identity();
            let keyframe = map.add_keyframe(NewKeyframe {
                frame: i,
                at: Timestamp::from_secs(i as f64),
                pyramid: Arc::clone(&pyramid),
                camera_from_world,
                turned_from: None,
                odometry: None,
            });
            map.set_exposure(keyframe, Some(Exposure { motion, readout: Readout::default() }));
            // Its lengths are in depths of the scene.
            let exposure = Exposure { motion, readout: *readout };
            for (point, landmark) in points.iter().zip(&mut landmarks) {
                let Ok(px) = camera.project(&camera_from_world.transform(point)) else { continue };
                if !camera.contains(&px) {
                    continue;
                }
                let px = exposure.px_seen(&px, &camera).map(|v| v + gaussian(&mut rng, SIGMA_PX));
                let covariance_px = Matrix2::identity() * SIGMA_PX * SIGMA_PX;
                let observation =
                    Observation { keyframe, px, ray: camera.bearing(&px), level: 0, covariance_px };
                match landmark {
                    Some(id) => map.add_observation(*id, observation),
                    None => {
                        let depth = camera_from_world.transform(point).z;
                        let filter = DepthFilter::new(1.0 / depth, 0.01);
                        *landmark = Some(map.add_landmark(observation, filter, LandmarkState::Converged));
                    }
                }
            }
        }
        map
    }

    #[test]
    fn the_time_from_the_first_row_to_the_last_is_found_and_images_are_put_right() {
        let camera = camera();
        for seed in 1..=3 {
            for readout in [Vector2::new(0.0, 0.025), Vector2::new(-0.02, 0.0)].map(Readout) {
                let mut map = map_of(&readout, seed);
                let mut lens = LensEstimator::new(&camera);
                assert!(lens.settle(&mut map, &camera, &MappingConfig::default()).is_some());
                let error = (lens.readout().0 - readout.0).norm();
                assert!(error < 0.002, "seed {seed}: {:?} for {readout:?}", lens.readout());
                let is_right = |exposure: Exposure| exposure.readout == lens.readout();
                assert!(map.keyframes().all(|(_, keyframe)| keyframe.exposure.is_some_and(is_right)));
                // What is seen is where it would have been.
                let (true_map, mut errors) = (map_of(&Readout::default(), seed), Vec::new());
                for ((id, landmark), (_, other)) in map.landmarks().zip(true_map.landmarks()) {
                    let pairs = landmark.observations.iter().zip(other.observations.iter());
                    assert!(landmark.is_alive(), "{id:?}");
                    errors.extend(
                        pairs.filter(|(a, b)| a.keyframe == b.keyframe).map(|(a, b)| (a.px - b.px).norm()),
                    );
                }
                let usual = median(errors).unwrap();
                assert!(usual < SIGMA_PX, "seed {seed}: {usual} px");
            }
        }
    }

    #[test]
    fn a_camera_that_exposes_all_at_once_is_taken_for_one() {
        let camera = camera();
        for seed in 1..=10 {
            let mut lens = LensEstimator::new(&camera);
            lens.settle(&mut map_of(&Readout::default(), seed), &camera, &MappingConfig::default()).unwrap();
            assert!(lens.readout().is_at_once(), "seed {seed}: {:?}", lens.readout());
        }
    }

    #[test]
    fn a_change_can_be_taken_back_and_is_refused_where_no_lens_has_it() {
        let camera = Camera::pinhole((640, 480), (525.0, 525.0), (319.5, 239.5)).unwrap();
        let bent = changed(&camera, 0.02).unwrap();
        let corner = Point2::new(0.0, 0.0);
        assert!((bent.bearing(&corner) - camera.bearing(&corner)).norm() > 5e-3);
        assert_eq!(changed(&bent, -0.02).unwrap(), camera);
        assert!(changed(&camera, -1000.0).is_none());
    }
}
