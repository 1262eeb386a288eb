//! What a place looks like.

use nalgebra::Point2;
use visloc_core::{GrayImage, geom::Camera};

use crate::{
    config::FeatureConfig,
    feature::CornerGrid,
    image::{Pyramid, doubled},
    map::{KeyframeId, LandmarkId, Map, push_tightly},
    mapping::corners_in_two_passes,
    orb::{BoxSums, OrbDescriptor},
};

/// Most corners of an image that are described.
const MOST_CORNERS: usize = 1000;
/// How much denser, on each axis, corners are looked for than where landmarks are made: which corner of a cell is the best one depends
/// on light and view, and the landmark may be another one.
const DENSER: f64 = 1.5;

/// A place of an image with its descriptor.
#[derive(Debug, Clone, Copy)]
pub struct Described {
    /// Pixel of level 0.
    pub px: Point2<f64>,
    /// Level on which it was described; below 0 that of an enlarged image.
    pub level: i32,
    /// Its descriptor.
    pub descriptor: OrbDescriptor,
    /// In a keyframe: the landmark that is seen there. It may have been removed since.
    pub landmark: Option<LandmarkId>,
}

/// A place of a keyframe in less memory, as exact as files keep it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShortPlace {
    pub px: [f32; 2],
    pub level: u8,
    pub descriptor: OrbDescriptor,
    pub landmark: LandmarkId,
}

/// The described places of one image: in a keyframe in order of its landmarks, in another image the best corner of each cell.
#[derive(Debug, Clone, Default)]
pub struct View {
    described: Vec<Described>,
    /// Those of a keyframe, which has no others.
    short: Vec<ShortPlace>,
}

impl From<Vec<Described>> for View {
    fn from(described: Vec<Described>) -> Self {
        Self { described, short: Vec::new() }
    }
}

impl View {
    /// Adds a place of a keyframe that is read with its map.
    pub(crate) fn read(&mut self, place: ShortPlace) {
        push_tightly(&mut self.short, place);
    }

    /// Lets go of the memory that was set aside for growing.
    pub(crate) fn shrink(&mut self) {
        self.short.shrink_to_fit();
    }

    /// How many places there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.described.len() + self.short.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One of the places.
    ///
    /// # Panics
    /// If there are not so many.
    #[must_use]
    pub fn at(&self, index: usize) -> Described {
        match self.short.get(index) {
            None => self.described[index - self.short.len()],
            Some(ShortPlace { px, level, descriptor, landmark }) => Described {
                px: px.map(f64::from).into(),
                level: i32::from(*level),
                descriptor: *descriptor,
                landmark: Some(*landmark),
            },
        }
    }

    /// All places.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = Described> + ExactSizeIterator + '_ {
        (0..self.len()).map(|index| self.at(index))
    }

    /// The descriptors of all places.
    pub fn descriptors(&self) -> impl Iterator<Item = &OrbDescriptor> {
        let described = self.described.iter().map(|place| &place.descriptor);
        self.short.iter().map(|place| &place.descriptor).chain(described)
    }

    /// The same with other numbers of the landmarks.
    pub(crate) fn renumbered(&self, number: impl Fn(LandmarkId) -> LandmarkId) -> Self {
        let mut renumbered = self.clone();
        for place in &mut renumbered.described {
            place.landmark = place.landmark.map(&number);
        }
        renumbered.short.iter_mut().for_each(|place| place.landmark = number(place.landmark));
        renumbered
    }

    /// Of the landmarks that a keyframe sees.
    #[must_use]
    pub fn of_keyframe(map: &Map, id: KeyframeId) -> Self {
        let keyframe = map.keyframe(id);
        let Some(pyramid) = keyframe.pyramid() else { return Self::default() };
        let described = |landmark: &LandmarkId| {
            let observation = map.landmark(*landmark).observation_in(id)?;
            let level = observation.level;
            let place = |x, y| OrbDescriptor::new(pyramid.level(level), x, y);
            let Described { px, descriptor, .. } = describe(&observation.px, level as i32, None, place)?;
            let px = [px.x as f32, px.y as f32];
            Some(ShortPlace { px, level: level as u8, descriptor, landmark: *landmark })
        };
        let short = keyframe.landmarks.iter().filter_map(described).collect();
        let mut view = Self { described: Vec::new(), short };
        view.shrink();
        view
    }

    /// Of the corners of an image, each as it looks from here, from half and from twice the distance.
    #[must_use]
    pub fn of_image(pyramid: &Pyramid, camera: &Camera, features: &FeatureConfig) -> Self {
        Self::of_coarse_image(pyramid, 0, camera, features)
    }

    /// The same for an image whose pixels are larger, by some octaves, than those of the images that it is compared with: what these show
    /// on their finest levels is described in this image enlarged.
    #[must_use]
    pub(super) fn of_coarse_image(
        pyramid: &Pyramid,
        octaves: i32,
        camera: &Camera,
        features: &FeatureConfig,
    ) -> Self {
        let grid = CornerGrid::new(camera.size_px(), features.cell_px / DENSER);
        let corners = corners_in_two_passes(pyramid, &grid, features);
        let mut enlarged: Vec<GrayImage> = Vec::new();
        for _ in 0..octaves {
            enlarged.push(doubled(enlarged.last().unwrap_or(pyramid.level(0))));
        }
        let image = |level: i32| match usize::try_from(level) {
            Ok(level) => pyramid.level(level),
            Err(_) => &enlarged[(-1 - level) as usize],
        };
        // A corner of the image itself may be one of a finer level that does not show.
        let levels = |level: usize| {
            let finest = if level == 0 { -octaves } else { level as i32 - 1 };
            finest..(level + 2).min(pyramid.num_levels()) as i32
        };
        let searched = -octaves..levels(features.search_levels.saturating_sub(1)).end;
        let sums: Vec<BoxSums> = searched.map(|level| BoxSums::new(image(level))).collect();
        let described = corners
            .iter()
            .take(MOST_CORNERS)
            .flat_map(|corner| levels(corner.level).map(|level| (corner.px, level)))
            .filter_map(|(px, level)| {
                let place =
                    |x, y| OrbDescriptor::with_sums(image(level), &sums[(level + octaves) as usize], x, y);
                describe(&px, level, None, place)
            });
        described.collect::<Vec<_>>().into()
    }
}

fn describe(
    px: &Point2<f64>,
    level: i32,
    landmark: Option<LandmarkId>,
    descriptor_at: impl Fn(usize, usize) -> Option<OrbDescriptor>,
) -> Option<Described> {
    let on_level = |px: f64| ((px + 0.5) * f64::from(-level).exp2() - 0.5).round().max(0.0) as usize;
    let (x, y) = (on_level(px.x), on_level(px.y));
    let descriptor = descriptor_at(x, y)?;
    Some(Described { px: *px, level, descriptor, landmark })
}
