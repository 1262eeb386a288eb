//! Maps as plain numbers, to be kept beyond the program: what is alive, numbered anew.

use std::{borrow::Cow, sync::Arc};

use nalgebra::{Matrix2, Matrix3, Point3, Rotation3, Vector3};
use serde::{Deserialize, Serialize};
use thiserror::Error;
use visloc_core::{
    Timestamp,
    geom::{Camera, Rigid3},
};

use super::{
    Keyframe, KeyframeId, KeyframePicture, Landmark, LandmarkId, Map, MapId, Observation, Observations,
    SessionCamera,
    observations::{CORRELATIONS, LEVEL_BITS, ShortObservation},
    push_tightly,
    store::center,
};
use crate::{
    lie::CameraFromWorld,
    orb::OrbDescriptor,
    recognize::{MOST_DIFFERENT, PlaceIndex, ShortPlace},
};

/// Error of a rotation matrix that is rounding, not damage.
const ROTATION_ERROR: f64 = 1e-6;

/// Maps as plain numbers, but for [their landmarks](Map::stored_landmarks). Keyframes and landmarks are numbered from 0 in their order.
#[derive(Debug, Clone, Default)]
pub struct StoredMap {
    /// The cameras of the keyframes.
    pub cameras: Vec<SessionCamera>,
    /// Keyframes, in order of creation.
    pub keyframes: Vec<StoredKeyframe>,
    /// Their images; `None` where one is lost.
    pub pictures: Vec<Option<KeyframePicture>>,
}

/// A keyframe as plain numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredKeyframe {
    /// When it was taken, by the clock of its session.
    pub at: Timestamp,
    /// Number of its map.
    pub map: u32,
    /// Number of its camera.
    pub camera: u32,
    /// Rotation of its pose, camera from world, column by column.
    pub rotation: [f64; 9],
    /// Translation of its pose, map units.
    pub translation: [f64; 3],
    /// Gradient noise of its levels.
    pub gradient_noise: Vec<f32>,
    /// The keyframe that it has only turned from.
    pub turned_from: Option<u32>,
}

/// A landmark as plain numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredLandmark {
    /// Place, map units.
    pub point: [f64; 3],
    /// Frames in which it should have been seen.
    pub num_visible: u32,
    /// Frames in which it was found.
    pub num_found: u32,
    /// Where keyframes see it; the first is its host.
    pub observations: Vec<StoredObservation>,
}

/// What a keyframe sees of a landmark.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoredObservation {
    /// Number of the keyframe.
    pub keyframe: u32,
    /// Pixel of level 0.
    pub px: [f32; 2],
    /// Level on which it was measured.
    pub level: u8,
    /// Variance of the place along both axes, squared pixels of level 0: the upper half of the bits of a number of 32 bits.
    pub variance_px: [u16; 2],
    /// Their correlation, from -127 to 127 for -127/128 to 127/128.
    pub correlation: i8,
    /// What it looks like; `None` near the border.
    pub descriptor: Option<[u8; 32]>,
}

/// A map that is made of plain numbers, whoever wrote them, bit by bit: what it was made of need not be in memory with it.
#[derive(Debug)]
pub struct Restoring {
    map: Map,
    num_landmarks: usize,
    is_fixed: bool,
}

impl Restoring {
    /// Keyframes without landmarks and images. All are of foreign cameras until [`Map::take_over`] says that one of these is followed.
    ///
    /// # Errors
    /// The first number that no keyframe has.
    pub fn new(cameras: &[SessionCamera], keyframes: &[StoredKeyframe]) -> Result<Self, RestoreError> {
        let cameras: Vec<Arc<SessionCamera>> = cameras.iter().copied().map(Arc::new).collect();
        let mut map = Map::new();
        for (number, keyframe) in keyframes.iter().enumerate() {
            let wrong = |expected| RestoreError::Keyframe { number, expected };
            if !ShortObservation::can_name(KeyframeId(number as u32)) {
                return Err(wrong("fewer keyframes"));
            }
            let camera = cameras.get(keyframe.camera as usize).ok_or(wrong("one of the cameras"))?;
            map.keyframes.push(restored_keyframe(number, keyframe, camera).map_err(wrong)?);
            map.num_maps = map.num_maps.max(keyframe.map + 1);
        }
        Ok(Self { map, num_landmarks: 0, is_fixed: false })
    }

    /// A map that only cameras are looked for in: each look of its landmarks is kept once, which takes less memory. Where mapping goes on, all of them find
    /// more loops.
    #[must_use]
    pub fn of_fixed(self) -> Self {
        Self { is_fixed: true, ..self }
    }

    /// Adds the next landmark.
    ///
    /// # Errors
    /// If it has a number that no landmark has.
    pub fn add_landmark(&mut self, landmark: &StoredLandmark) -> Result<(), RestoreError> {
        let number = self.num_landmarks;
        self.num_landmarks += 1;
        let wrong = |expected| RestoreError::Landmark { number, expected };
        self.map.add_restored(landmark).map_err(wrong)?;
        let mut seen = Cow::Borrowed(&landmark.observations);
        if self.is_fixed {
            keep_looks(seen.to_mut());
        }
        self.map.add_places(LandmarkId(number as u32), &seen);
        Ok(())
    }

    /// Gives a keyframe that there is its image.
    ///
    /// # Panics
    /// If there is no such keyframe.
    pub fn set_picture(&mut self, number: usize, picture: KeyframePicture) {
        self.map.keyframes[number].picture = Some(picture);
    }

    /// The map.
    #[must_use]
    pub fn finish(mut self) -> Map {
        self.map.index_views();
        self.map
    }
}

/// Numbers that are no map.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RestoreError {
    /// A keyframe.
    #[error("keyframe {number}: expected {expected}")]
    Keyframe {
        /// Its number.
        number: usize,
        /// What it should have.
        expected: &'static str,
    },
    /// A landmark.
    #[error("landmark {number}: expected {expected}")]
    Landmark {
        /// Its number.
        number: usize,
        /// What it should have.
        expected: &'static str,
    },
}

impl Map {
    /// The maps as plain numbers, for a camera that is followed now. Candidates and culled keyframes are left out.
    #[must_use]
    #[allow(clippy::cast_possible_truncation)]
    pub fn stored(&self, own: &SessionCamera) -> StoredMap {
        let mut stored = StoredMap::default();
        // In order of their first keyframes.
        let mut maps: Vec<MapId> = Vec::new();
        let number_of = self.stored_numbers();
        for (id, keyframe) in self.all_keyframes() {
            let camera = keyframe.foreign.as_deref().unwrap_or(own);
            let known = stored.cameras.iter().position(|known| known == camera);
            let camera = known.unwrap_or_else(|| {
                stored.cameras.push(*camera);
                stored.cameras.len() - 1
            });
            let map = maps.iter().position(|map| *map == keyframe.map).unwrap_or_else(|| {
                maps.push(keyframe.map);
                maps.len() - 1
            });
            let pose = keyframe.camera_from_world();
            stored.keyframes.push(StoredKeyframe {
                at: keyframe.at,
                map: map as u32,
                camera: camera as u32,
                rotation: std::array::from_fn(|i| pose.rotation()[i]),
                translation: (*pose.translation()).into(),
                gradient_noise: keyframe.gradient_noise.clone(),
                turned_from: self.turned_from(id).and_then(|id| number_of[id.index()]),
            });
            stored.pictures.push(keyframe.picture.clone());
        }
        stored
    }

    /// The converged landmarks as plain numbers, in order of creation.
    pub fn stored_landmarks(&self) -> impl Iterator<Item = StoredLandmark> {
        let number_of = self.stored_numbers();
        let stored = move |(id, landmark): (LandmarkId, &Landmark)| {
            let number_of = |id: KeyframeId| number_of[id.index()];
            let observations = landmark.observations.iter();
            StoredLandmark {
                point: landmark.point_in_world.coords.into(),
                num_visible: landmark.num_visible,
                num_found: landmark.num_found,
                observations: observations
                    .filter_map(|o| Some(self.stored_observation(id, &o, number_of(o.keyframe)?)))
                    .collect(),
            }
        };
        self.all_landmarks().filter(|(_, landmark)| landmark.is_converged()).map(stored)
    }

    /// The numbers of keyframes that are stored.
    fn stored_numbers(&self) -> Vec<Option<u32>> {
        let mut numbers = vec![None; self.num_keyframe_ids()];
        for (number, (id, _)) in (0..).zip(self.all_keyframes()) {
            numbers[id.index()] = Some(number);
        }
        numbers
    }

    #[allow(clippy::cast_possible_truncation)]
    fn stored_observation(&self, id: LandmarkId, seen: &Observation, keyframe: u32) -> StoredObservation {
        let view = self.keyframe(seen.keyframe).view.as_deref();
        let place = view.and_then(|view| view.iter().find(|place| place.landmark == Some(id)));
        let covariance = &seen.covariance_px;
        StoredObservation {
            keyframe,
            px: [seen.px.x as f32, seen.px.y as f32],
            level: seen.level as u8,
            variance_px: [covariance[(0, 0)], covariance[(1, 1)]].map(upper_half),
            correlation: correlation(covariance),
            descriptor: place.map(|place| place.descriptor.to_bytes()),
        }
    }

    fn add_restored(&mut self, stored: &StoredLandmark) -> Result<(), &'static str> {
        if !stored.point.iter().all(|value| value.is_finite()) {
            return Err("a place");
        }
        let id = LandmarkId(self.landmarks.len() as u32);
        let point_in_world = Point3::from(stored.point);
        let mut seen: Vec<(ShortObservation, Arc<SessionCamera>)> =
            Vec::with_capacity(stored.observations.len());
        for stored in &stored.observations {
            let index = stored.keyframe as usize;
            if index >= self.keyframes.len() {
                return Err("keyframes that there are");
            }
            let camera = self.keyframes[index].foreign.as_ref().ok_or("a camera")?;
            let observation = restored_observation(stored, &camera.camera)?;
            if seen.iter().all(|(other, _)| other.keyframe() != observation.keyframe()) {
                seen.push((observation, Arc::clone(camera)));
                push_tightly(Arc::make_mut(&mut self.keyframes[index].landmarks), id);
            }
        }
        if seen.is_empty() {
            return Err("at least one observation");
        }
        self.landmarks.push(Landmark {
            point_in_world,
            observations: Observations::read(&seen),
            filter: None,
            num_visible: stored.num_visible,
            num_found: stored.num_found,
            num_missed: 0,
            made_at: 0,
        });
        Ok(())
    }

    /// Notes what a landmark looks like where keyframes see it.
    fn add_places(&mut self, id: LandmarkId, seen: &[StoredObservation]) {
        for StoredObservation { keyframe, descriptor, .. } in seen {
            // A keyframe sees it once, as it is said first.
            let first = seen.iter().find(|other| other.keyframe == *keyframe);
            let Some((StoredObservation { px, level, .. }, descriptor)) = first.zip(*descriptor) else {
                continue;
            };
            let descriptor = OrbDescriptor::from_bytes(&descriptor);
            let view = self.keyframes[*keyframe as usize].view.get_or_insert_default();
            Arc::make_mut(view).read(ShortPlace { px: *px, level: *level, descriptor, landmark: id });
        }
    }

    /// Lists all keyframes that were described in the index.
    fn index_views(&mut self) {
        for number in 0..self.keyframes.len() {
            let keyframe = &mut self.keyframes[number];
            Arc::make_mut(&mut keyframe.landmarks).shrink_to_fit();
            if let Some(view) = &mut keyframe.view {
                Arc::make_mut(view).shrink();
            }
        }
        let views = (0..).map(KeyframeId).zip(self.keyframes.iter());
        let views = views.filter_map(|(id, keyframe)| Some((id, keyframe.view.as_deref()?)));
        self.index = Arc::new(PlaceIndex::read(views));
    }

    /// Follows a camera from now on: keyframes that a camera with the same calibration took are its own. Answers the camera as these
    /// maps know it.
    pub fn take_over(&mut self, calibrated: &Camera) -> SessionCamera {
        let of_same = |keyframe: &Keyframe| {
            keyframe.foreign.as_deref().filter(|foreign| foreign.calibrated == *calibrated).copied()
        };
        let known = self.keyframes.iter().rev().find_map(of_same);
        let camera = known.unwrap_or(SessionCamera::as_calibrated(calibrated));
        for index in 0..self.keyframes.len() {
            if of_same(&self.keyframes[index]).is_some() {
                self.keyframes[index].foreign = None;
            }
        }
        self.look_through(&camera.camera);
        camera
    }
}

/// Leaves descriptors out that look like one before, those of the first keyframes staying: half of the bits that a pair may differ by. Nobody can tell them
/// apart, since from one keyframe to the next as many change, 28 of them in the median; and what looks like one that is left out by the other half looks
/// like the one that stays.
fn keep_looks(observations: &mut [StoredObservation]) {
    let mut looks: Vec<OrbDescriptor> = Vec::new();
    for descriptor in observations.iter_mut().map(|observation| &mut observation.descriptor) {
        let Some(look) = descriptor.as_ref().map(OrbDescriptor::from_bytes) else { continue };
        if looks.iter().any(|other| other.distance(&look) <= MOST_DIFFERENT / 2) {
            *descriptor = None;
        } else {
            looks.push(look);
        }
    }
}

/// The upper half of the bits of a number, rounded: three digits are enough for a covariance.
#[allow(clippy::cast_possible_truncation)]
fn upper_half(value: f64) -> u16 {
    ((value as f32).to_bits().saturating_add(1 << 15) >> 16) as u16
}

#[allow(clippy::cast_possible_truncation)]
fn correlation(covariance: &Matrix2<f64>) -> i8 {
    let share = covariance[(0, 1)] / (covariance[(0, 0)] * covariance[(1, 1)]).sqrt();
    // Conversion keeps within the range, and makes zero of what is no number.
    (share * CORRELATIONS).round().clamp(1.0 - CORRELATIONS, CORRELATIONS - 1.0) as i8
}

fn restored_keyframe(
    number: usize,
    stored: &StoredKeyframe,
    camera: &Arc<SessionCamera>,
) -> Result<Keyframe, &'static str> {
    let rotation = Matrix3::from_column_slice(&stored.rotation);
    let error = (rotation * rotation.transpose() - Matrix3::identity()).norm();
    // Written so that a value that is no number fails, too.
    if !(error < ROTATION_ERROR && rotation.determinant() > 0.0) {
        return Err("a rotation");
    }
    let is_finite = stored.translation.iter().all(|value| value.is_finite())
        && stored.gradient_noise.iter().all(|value| value.is_finite());
    if !is_finite {
        return Err("finite numbers");
    }
    if stored.map as usize > number {
        return Err("maps that are numbered in order");
    }
    let camera_from_world: CameraFromWorld =
        Rigid3::new(Rotation3::from_matrix_unchecked(rotation), Vector3::from(stored.translation));
    Ok(Keyframe {
        frame: 0,
        at: stored.at,
        foreign: Some(Arc::clone(camera)),
        picture: None,
        view: None,
        map: MapId(stored.map),
        gradient_noise: stored.gradient_noise.clone(),
        landmarks: Arc::default(),
        turned_from: stored.turned_from.filter(|other| (*other as usize) < number).map(KeyframeId),
        odometry: None,
        exposure: None,
        camera_from_world,
        center_in_world: center(&camera_from_world),
        scale: 1.0,
        anchor: None,
        is_given_up: false,
    })
}

fn restored_observation(
    stored: &StoredObservation,
    camera: &Camera,
) -> Result<ShortObservation, &'static str> {
    let short = ShortObservation::from(stored);
    if !camera.contains(&short.px()) || stored.level >> LEVEL_BITS != 0 {
        return Err("places inside of the images");
    }
    let covariance = short.covariance_px();
    let (xx, yy, xy) = (covariance[(0, 0)], covariance[(1, 1)], covariance[(0, 1)]);
    if !(xx > 0.0 && xx * yy > xy * xy && (xx + yy).is_finite()) {
        return Err("places with a covariance");
    }
    Ok(short)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A descriptor of which some bits differ from one without any.
    fn seen(keyframe: u32, bits: std::ops::Range<usize>) -> StoredObservation {
        let mut descriptor = [0; 32];
        bits.for_each(|bit| descriptor[bit / 8] |= 1 << (bit % 8));
        let (px, variance_px) = ([0.0; 2], [0; 2]);
        let descriptor = Some(descriptor);
        StoredObservation { keyframe, px, level: 0, variance_px, correlation: 0, descriptor }
    }

    #[test]
    fn each_look_of_a_landmark_is_kept_once() {
        // The third is like the second, which is left out, but not like the first.
        let all = [seen(0, 0..0), seen(1, 0..32), seen(2, 0..33), seen(3, 20..33), seen(4, 100..150)];
        let mut kept = all.to_vec();
        kept.insert(2, StoredObservation { descriptor: None, ..seen(5, 0..0) });
        keep_looks(&mut kept);
        let described = |seen: &[StoredObservation]| {
            let described = seen.iter().filter(|it| it.descriptor.is_some());
            described.map(|it| it.keyframe).collect::<Vec<_>>()
        };
        assert_eq!(described(&kept), [0, 2, 4]);
        assert_eq!(kept.len(), all.len() + 1, "what keyframes see stays");
        let once = kept.clone();
        keep_looks(&mut kept);
        assert_eq!(kept, once);
    }
}
