//! Where keyframes see a landmark: as measured, or as short as a file has it.

use std::sync::Arc;

use nalgebra::{Matrix2, Point2, Vector3};
use visloc_core::geom::Camera;

use super::{KeyframeId, SessionCamera, StoredObservation};
use crate::shutter::Exposure;

/// Where a keyframe sees a landmark.
#[derive(Debug, Clone, Copy)]
pub struct Observation {
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// Pixel of level 0.
    pub px: Point2<f64>,
    /// The same on the plane z = 1 of the camera, without distortion.
    pub ray: Vector3<f64>,
    /// Level on which it was measured.
    pub level: usize,
    /// Covariance of the place, squared pixels of level 0.
    pub covariance_px: Matrix2<f64>,
}

/// An observation as it is kept: a map of many rooms consists of little else. Single precision is a ten-thousandth of a pixel; of a covariance the root
/// is kept, so that it stays one where it is long and thin.
#[derive(Debug, Clone, Copy)]
struct MeasuredObservation {
    seen_in: SeenIn,
    px: [f32; 2],
    ray: [f32; 2],
    /// Lower triangle, row by row.
    root_px: [f32; 3],
}

/// A keyframe and a level of its image in one number: so many keyframes nobody makes in a month.
#[derive(Debug, Clone, Copy)]
struct SeenIn(u32);

/// Bits of a level: an image of 2^16 px has no more halvings.
pub(super) const LEVEL_BITS: u32 = 4;

impl SeenIn {
    fn new(keyframe: KeyframeId, level: usize) -> Self {
        Self(keyframe.0 << LEVEL_BITS | level as u32)
    }

    fn keyframe(self) -> KeyframeId {
        KeyframeId(self.0 >> LEVEL_BITS)
    }

    fn level(self) -> usize {
        self.0 as usize % (1 << LEVEL_BITS)
    }

    fn with(self, keyframe: KeyframeId) -> Self {
        Self::new(keyframe, self.level())
    }
}

impl From<Observation> for MeasuredObservation {
    fn from(observation: Observation) -> Self {
        let Observation { keyframe, px, ray, level, covariance_px } = observation;
        let (xx, xy, yy) = (covariance_px.m11, covariance_px.m12, covariance_px.m22);
        let x = xx.sqrt();
        let across = if x > 0.0 { xy / x } else { 0.0 };
        let y = (yy - across * across).max(0.0).sqrt();
        Self {
            seen_in: SeenIn::new(keyframe, level),
            px: [px.x as f32, px.y as f32],
            ray: plane_of(&ray),
            root_px: [x, across, y].map(|root| root as f32),
        }
    }
}

impl MeasuredObservation {
    fn get(&self) -> Observation {
        let [x, y] = self.ray.map(f64::from);
        let [xx, xy, yy] = self.root_px.map(f64::from);
        Observation {
            keyframe: self.keyframe(),
            px: self.px.map(f64::from).into(),
            ray: Vector3::new(x, y, 1.0),
            level: self.seen_in.level(),
            covariance_px: Matrix2::new(xx * xx, xx * xy, xx * xy, xy * xy + yy * yy),
        }
    }

    fn keyframe(&self) -> KeyframeId {
        self.seen_in.keyframe()
    }

    fn ray_through(&self, camera: &Camera) -> [f32; 2] {
        plane_of(&camera.bearing(&self.px.map(f64::from).into()))
    }
}

fn plane_of(ray: &Vector3<f64>) -> [f32; 2] {
    [ray.x as f32, ray.y as f32]
}

/// Steps of a correlation.
pub(super) const CORRELATIONS: f64 = 128.0;

/// An observation in half of the memory, as far as files keep it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShortObservation {
    px: [f32; 2],
    variance_px: [u16; 2],
    /// [`SeenIn`], and in the lowest eight bits the correlation.
    seen_in: u32,
}

impl From<&StoredObservation> for ShortObservation {
    fn from(stored: &StoredObservation) -> Self {
        let StoredObservation { keyframe, px, level, variance_px, correlation, .. } = *stored;
        Self { px, variance_px, seen_in: 0 }
            .with(SeenIn::new(KeyframeId(keyframe), usize::from(level)), correlation)
    }
}

impl ShortObservation {
    /// Whether a short observation can name a keyframe: of more than a million, the last ones are too many.
    pub fn can_name(keyframe: KeyframeId) -> bool {
        keyframe.0 >> (u32::BITS - i8::BITS - LEVEL_BITS) == 0
    }

    fn with(self, seen_in: SeenIn, correlation: i8) -> Self {
        Self { seen_in: seen_in.0 << i8::BITS | u32::from(correlation.cast_unsigned()), ..self }
    }

    fn seen_in(&self) -> SeenIn {
        SeenIn(self.seen_in >> i8::BITS)
    }

    fn correlation(&self) -> i8 {
        self.seen_in as i8
    }

    pub fn keyframe(&self) -> KeyframeId {
        self.seen_in().keyframe()
    }

    pub fn px(&self) -> Point2<f64> {
        Point2::new(f64::from(self.px[0]), f64::from(self.px[1]))
    }

    pub fn covariance_px(&self) -> Matrix2<f64> {
        let [xx, yy] = self.variance_px.map(|half| f64::from(f32::from_bits(u32::from(half) << 16)));
        let xy = f64::from(self.correlation()) / CORRELATIONS * (xx * yy).sqrt();
        Matrix2::new(xx, xy, xy, yy)
    }

    fn through(&self, camera: &Camera) -> Observation {
        let px = self.px();
        Observation {
            keyframe: self.keyframe(),
            px,
            ray: camera.bearing(&px),
            level: self.seen_in().level(),
            covariance_px: self.covariance_px(),
        }
    }
}

/// Where keyframes see a landmark, in order of the observations; the first keyframe is its host. A large map consists of little else, so
/// those of a map that was read stay short until one is changed.
#[derive(Debug, Clone)]
pub struct Observations(Kept);

#[derive(Debug, Clone)]
enum Kept {
    Measured(Box<[MeasuredObservation]>),
    /// All through one camera.
    Short(Arc<SessionCamera>, Box<[ShortObservation]>),
}

impl From<Vec<Observation>> for Observations {
    fn from(observations: Vec<Observation>) -> Self {
        Self(Kept::Measured(observations.into_iter().map(MeasuredObservation::from).collect()))
    }
}

impl Observations {
    /// Of a map that was read, each with its camera.
    pub(super) fn read(observations: &[(ShortObservation, Arc<SessionCamera>)]) -> Self {
        match observations {
            [(_, camera), more @ ..] if more.iter().all(|(_, other)| Arc::ptr_eq(camera, other)) => {
                Self(Kept::Short(Arc::clone(camera), observations.iter().map(|(short, _)| *short).collect()))
            }
            _ => {
                let observations =
                    observations.iter().map(|(short, camera)| short.through(&camera.camera).into());
                Self(Kept::Measured(observations.collect()))
            }
        }
    }

    /// How many there are.
    #[inline]
    #[must_use]
    pub fn len(&self) -> usize {
        match &self.0 {
            Kept::Measured(observations) => observations.len(),
            Kept::Short(_, observations) => observations.len(),
        }
    }

    /// Whether there is none.
    #[inline]
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One of them.
    ///
    /// # Panics
    /// If there are not so many.
    #[inline]
    #[must_use]
    pub fn at(&self, index: usize) -> Observation {
        match &self.0 {
            Kept::Measured(observations) => observations[index].get(),
            Kept::Short(camera, observations) => observations[index].through(&camera.camera),
        }
    }

    /// The keyframe of one of them, see [`Observations::at`].
    ///
    /// # Panics
    /// If there are not so many.
    #[inline]
    #[must_use]
    pub fn keyframe_at(&self, index: usize) -> KeyframeId {
        match &self.0 {
            Kept::Measured(observations) => observations[index].keyframe(),
            Kept::Short(_, observations) => observations[index].keyframe(),
        }
    }

    /// All of them.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = Observation> + '_ {
        (0..self.len()).map(|index| self.at(index))
    }

    /// The keyframes, which takes less time than all of the observations.
    pub fn keyframes(&self) -> impl DoubleEndedIterator<Item = KeyframeId> + '_ {
        (0..self.len()).map(|index| self.keyframe_at(index))
    }

    /// What a keyframe sees.
    #[must_use]
    pub fn of(&self, keyframe: KeyframeId) -> Option<Observation> {
        self.keyframes().position(|other| other == keyframe).map(|index| self.at(index))
    }

    /// Whether the rays of these keyframes are those of this camera.
    pub(super) fn are_through(&self, camera: &Camera, is_own: impl Fn(KeyframeId) -> bool) -> bool {
        match &self.0 {
            Kept::Short(by, observations) => {
                by.camera == *camera || !observations.iter().any(|it| is_own(it.keyframe()))
            }
            Kept::Measured(observations) => {
                let mut own = observations.iter().filter(|it| is_own(it.keyframe()));
                own.all(|it| it.ray == it.ray_through(camera))
            }
        }
    }

    /// Makes the rays of these keyframes anew.
    pub(super) fn look_through(&mut self, camera: &Camera, is_own: impl Fn(KeyframeId) -> bool) {
        for observation in self.change().iter_mut().filter(|it| is_own(it.keyframe())) {
            observation.ray = observation.ray_through(camera);
        }
    }

    /// Moves what a keyframe sees to where it is once its image has been put right.
    pub(super) fn put_right(&mut self, keyframe: KeyframeId, left: &Exposure, camera: &Camera) {
        for observation in self.change().iter_mut().filter(|it| it.keyframe() == keyframe) {
            let px = left.px_at_once(&observation.px.map(f64::from).into(), camera);
            observation.px = [px.x as f32, px.y as f32];
            observation.ray = observation.ray_through(camera);
        }
    }

    /// The same with other numbers of the keyframes.
    pub(super) fn renumbered(&self, number: impl Fn(KeyframeId) -> KeyframeId) -> Self {
        let mut renumbered = self.clone();
        if !self.keyframes().all(|keyframe| ShortObservation::can_name(number(keyframe))) {
            renumbered.change();
        }
        match &mut renumbered.0 {
            Kept::Measured(observations) => {
                observations.iter_mut().for_each(|it| it.seen_in = it.seen_in.with(number(it.keyframe())));
            }
            Kept::Short(_, observations) => {
                for it in observations {
                    *it = it.with(it.seen_in().with(number(it.keyframe())), it.correlation());
                }
            }
        }
        renumbered
    }

    /// Adds one. A map consists of little else, so no room is made for more.
    pub(super) fn push(&mut self, observation: Observation) {
        let kept = self.change();
        let mut observations = std::mem::take(kept).into_vec();
        observations.reserve_exact(1);
        observations.push(observation.into());
        *kept = observations.into();
    }

    /// Takes out what a keyframe sees.
    pub(super) fn remove(&mut self, keyframe: KeyframeId) {
        let kept = self.change();
        let mut observations = std::mem::take(kept).into_vec();
        observations.retain(|observation| observation.keyframe() != keyframe);
        *kept = observations.into();
    }

    /// To be changed.
    fn change(&mut self) -> &mut Box<[MeasuredObservation]> {
        if let Kept::Short(..) = &self.0 {
            self.0 = Kept::Measured(self.iter().map(MeasuredObservation::from).collect());
        }
        match &mut self.0 {
            Kept::Measured(observations) => observations,
            Kept::Short(..) => unreachable!("it was measured just now"),
        }
    }
}

/// Adds to a list that grows for hours: room is made for an eighth more, and not for as much again.
pub(crate) fn push_tightly<T>(list: &mut Vec<T>, item: T) {
    if list.len() == list.capacity() {
        list.reserve_exact(2 + list.len() / 8);
    }
    list.push(item);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_covariance_stays_one_however_thin_it_is() {
        let (along, across): (f64, f64) = (1e4, 1e-6);
        let (sin, cos) = 0.7_f64.sin_cos();
        let xy = (along - across) * sin * cos;
        let thin = Matrix2::new(
            along * cos * cos + across * sin * sin,
            xy,
            xy,
            along * sin * sin + across * cos * cos,
        );
        let observation = Observation {
            keyframe: KeyframeId(3),
            px: nalgebra::Point2::new(611.25, 17.5),
            ray: Vector3::new(0.25, -0.125, 1.0),
            level: 3,
            covariance_px: thin,
        };
        let kept = Observations::from(vec![observation]).at(0);
        assert_eq!((kept.px, kept.ray, kept.level), (observation.px, observation.ray, 3));
        let root = kept.covariance_px.cholesky().unwrap();
        let error = (root.determinant() / (along * across) - 1.0).abs();
        assert!(error < 1e-4, "{error}");
    }

    #[test]
    fn short_ones_are_what_they_are_when_measured() {
        let camera = Camera::pinhole((640, 480), (500.0, 510.0), (320.0, 240.0)).unwrap();
        let session = || Arc::new(SessionCamera::as_calibrated(&camera));
        let short = |keyframe: u32| {
            ShortObservation::from(&StoredObservation {
                keyframe,
                px: [100.3 + keyframe as f32, 7.7],
                variance_px: [0x3e80, 0x3f01],
                correlation: -77,
                level: 2,
                descriptor: None,
            })
        };
        let (one, other) = (session(), session());
        let of_one = Observations::read(&[4, 2, 9].map(|id| (short(id), Arc::clone(&one))));
        let of_two = Observations::read(&[(short(4), Arc::clone(&one)), (short(2), other), (short(9), one)]);
        for (one, two) in of_one.iter().zip(of_two.iter()) {
            assert_eq!((one.keyframe, one.px, one.level), (two.keyframe, two.px, two.level));
            assert!((one.ray - two.ray).norm() < 1e-7, "{} is not {}", one.ray, two.ray);
            let off = one.covariance_px - two.covariance_px;
            assert!(off.norm() < 1e-7 * one.covariance_px.norm(), "{off}");
        }
        assert_eq!(of_one.of(KeyframeId(2)).map(|it| it.ray), Some(camera.bearing(&short(2).px())));
        let behind_a_million = |id: KeyframeId| KeyframeId(id.0 + (1 << 20));
        let renumbered = of_one.renumbered(behind_a_million);
        assert_eq!(
            renumbered.keyframes().collect::<Vec<_>>(),
            [4, 2, 9].map(|id| behind_a_million(KeyframeId(id)))
        );
        let mut changed = of_one.renumbered(|id| KeyframeId(id.0 + 1));
        assert_eq!(changed.keyframes().collect::<Vec<_>>(), [5, 3, 10].map(KeyframeId));
        changed.remove(KeyframeId(3));
        assert_eq!((changed.len(), of_one.len(), changed.of(KeyframeId(3)).is_none()), (2, 3, true));
    }
}
