//! More pairs, once a pose is about known.

use nalgebra::Point2;
use visloc_core::geom::Camera;

use super::{
    Pair, View,
    pairs::{Known, MOST_DIFFERENT},
};
use crate::{image::level_from_px, lie::CameraFromWorld, map::Map, orb::OrbDescriptor};

/// Pixels of its level along a cell that places are looked up by.
const CELL_PX: f64 = 16.0;

/// Farthest level from the one on which a landmark should be seen: places are described on those around their own.
const LEVELS_APART: f64 = 1.0;

/// The places of one level of an image, by cells.
struct Level {
    level: usize,
    width: usize,
    height: usize,
    /// For each cell where its places begin, and at the end where those of the last one end.
    starts: Vec<u32>,
    places: Vec<u32>,
}

impl Level {
    fn new(level: usize, view: &View, camera: &Camera) -> Self {
        let (width, height) = camera.size_px();
        let cells = |size: u32| (f64::from(size >> level) / CELL_PX) as usize + 1;
        let (width, height) = (cells(width), cells(height));
        let own = || (0_u32..).zip(&view.places).filter(|(_, place)| place.level == level);
        let mut starts = vec![0; width * height + 1];
        let cell = |px: &Point2<f64>| {
            let px = level_from_px(px, level);
            along(px.y, height) * width + along(px.x, width)
        };
        own().for_each(|(_, place)| starts[cell(&place.px) + 1] += 1);
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let (mut next, mut places) = (starts.clone(), vec![0; own().count()]);
        for (number, place) in own() {
            let next = &mut next[cell(&place.px)];
            places[*next as usize] = number;
            *next += 1;
        }
        Self { level, width, height, starts, places }
    }

    /// Places in the cells around a pixel (of level 0).
    fn around(&self, px: &Point2<f64>, radius_px: f64) -> impl Iterator<Item = usize> + use<'_> {
        let px = level_from_px(px, self.level);
        let range = |value: f64, num: usize| along(value - radius_px, num)..=along(value + radius_px, num);
        let columns = range(px.x, self.width);
        range(px.y, self.height).flat_map(move |y| {
            let row = y * self.width;
            let (start, end) = (self.starts[row + columns.start()], self.starts[row + columns.end() + 1]);
            self.places[start as usize..end as usize].iter().map(|place| *place as usize)
        })
    }
}

fn along(value: f64, num: usize) -> usize {
    ((value / CELL_PX).max(0.0) as usize).min(num - 1)
}

/// Finds pairs around a pose.
pub(super) struct Guide<'a> {
    pub view: &'a View,
    camera: &'a Camera,
    levels: Vec<Level>,
}

impl<'a> Guide<'a> {
    /// For the places of an image.
    pub fn new(view: &'a View, camera: &'a Camera) -> Self {
        let num_levels = view.places.iter().map(|place| place.level + 1).max().unwrap_or(0);
        let levels = (0..num_levels).map(|level| Level::new(level, view, camera)).collect();
        Self { view, camera, levels }
    }

    /// Places that look like a landmark (their sizes in pixels differ by a ratio of focal lengths) and lie where a camera with this pose would see it, at most so many pixels of their level away: each
    /// place and each landmark once.
    pub fn pairs_near(
        &self,
        map: &Map,
        (known, focal_ratio): (&Known, f64),
        pose: &CameraFromWorld,
        radius_px: f64,
    ) -> Vec<Pair> {
        let mut best: Vec<Option<Pair>> = vec![None; self.view.places.len()];
        for (index, landmark) in known.ids.iter().enumerate() {
            let point = pose.transform(&map.landmark(*landmark).point_in_world);
            let Ok(px) = self.camera.project(&point) else { continue };
            if !self.camera.contains(&px) {
                continue;
            }
            let size_px = known.sizes[index] * focal_ratio / point.z;
            for (place, distance) in self.near(px, size_px, known.descriptor(index), radius_px) {
                if best[place].is_none_or(|best| distance < best.distance) {
                    best[place] = Some(Pair { place, landmark: *landmark, distance });
                }
            }
        }
        let mut pairs: Vec<Pair> = best.into_iter().flatten().collect();
        pairs.sort_by_key(|pair| (pair.landmark, pair.distance, pair.place));
        pairs.dedup_by_key(|pair| pair.landmark);
        pairs
    }

    /// Places around a pixel that are about as large as a patch (pixels of level 0 for each of its own) and look like it, with their different bits.
    fn near(
        &self,
        px: Point2<f64>,
        size_px: f64,
        descriptor: &OrbDescriptor,
        radius_px: f64,
    ) -> impl Iterator<Item = (usize, u32)> {
        let octaves = size_px.log2();
        let levels = self.levels.iter().filter(move |it| (it.level as f64 - octaves).abs() < LEVELS_APART);
        let places = levels.flat_map(move |it| it.around(&px, radius_px).map(move |place| (it.level, place)));
        places.filter_map(move |(level, place)| {
            let described = &self.view.places[place];
            let reach = radius_px * f64::from(1_u32 << level);
            if (described.px - px).norm_squared() > reach * reach {
                return None;
            }
            let distance = described.descriptor.distance(descriptor);
            (distance <= MOST_DIFFERENT).then_some((place, distance))
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use rand::{Rng as _, RngExt};
    use visloc_core::{Rng, RngTree};

    use super::*;
    use crate::recognize::Described;

    fn descriptor(rng: &mut Rng) -> OrbDescriptor {
        OrbDescriptor::from_words(std::array::from_fn(|_| rng.next_u64()))
    }

    #[test]
    fn places_are_found_where_they_should_be_on_their_level_and_nowhere_else() {
        let mut rng = RngTree::new(4).stream("guide", 0);
        let camera = Camera::pinhole((640, 480), (500.0, 500.0), (319.5, 239.5)).unwrap();
        let (mut view, mut known) = (View::default(), Vec::new());
        for number in 0..120 {
            let level = number % 3;
            let point = Point3::new(rng.random_range(-1.0..1.0), rng.random_range(-0.8..0.8), 2.0);
            let px = camera.project(&point).unwrap();
            let looks = descriptor(&mut rng);
            known.push((point, looks, f64::from(1_u32 << level) * point.z));
            // Every second place is farther from there than is looked for.
            let moved = if number % 2 == 0 { 5.0 } else { 11.0 } * f64::from(1_u32 << level);
            view.places.push(Described {
                px: px + nalgebra::Vector2::new(moved, 0.0),
                level,
                descriptor: looks,
                landmark: None,
            });
        }
        let guide = Guide::new(&view, &camera);
        let found = |radius_px| -> Vec<usize> {
            let nears = known.iter().map(|(point, looks, size)| {
                guide.near(camera.project(point).unwrap(), size / point.z, looks, radius_px)
            });
            nears.flat_map(|near| near.map(|(place, _)| place)).collect()
        };
        assert!(found(8.0).iter().all(|place| place % 2 == 0));
        assert_eq!(found(8.0).len(), 60);
        assert_eq!(found(12.0).len(), 120);
    }
}
