//! The corners of one image, found and described when they are asked for.

use std::sync::OnceLock;

use nalgebra::Point2;
use visloc_core::GrayImage;

use super::{ORB_MARGIN_PX, OrbDescriptor};
use crate::{
    feature::{FastCorner, detect_fast, fast_score},
    image::{level_from_px, px_from_level},
};

/// How a landmark is recognized where its place is not known to a few pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Recognition {
    /// By its patch, wherever it may be.
    Patches,
    /// By the descriptors of corners.
    Orb(OrbSearch),
}

/// How corners are compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbSearch {
    /// FAST threshold of the corners, gray levels.
    pub threshold: u8,
    /// Most different bits of a match.
    pub max_distance: u32,
    /// Distance of a corner from where it should be, pixels of its level.
    pub margin_px: f64,
}

/// The corner that a search found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbMatch {
    /// Pixel of level 0.
    pub px: Point2<f64>,
    /// Different bits.
    pub distance: u32,
    /// Different bits of the best corner elsewhere.
    pub second_distance: u32,
}

/// Corners of some levels of an image, each described when it is first compared.
#[derive(Debug, Clone)]
pub struct OrbCorners {
    levels: Vec<LevelCorners>,
}

/// Corners of one level, row by row.
#[derive(Debug, Clone)]
struct LevelCorners {
    corners: Vec<FastCorner>,
    /// Index of the first corner of each row, and the number of corners at the end.
    row_starts: Vec<u32>,
    descriptors: Vec<OnceLock<OrbDescriptor>>,
}

/// Corners nearer to the best than this are the same place, pixels of their level.
const SAME_PLACE_PX: f64 = 3.0;

impl OrbCorners {
    /// Detects the corners of the levels, finest first; of neighboring ones the strongest.
    #[must_use]
    pub fn new(levels: &[GrayImage], threshold: u8) -> Self {
        Self { levels: levels.iter().map(|image| LevelCorners::new(image, threshold)).collect() }
    }

    /// How many corners there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.levels.iter().map(|level| level.corners.len()).sum()
    }

    /// Whether there are no corners.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many of them were described so far.
    #[must_use]
    pub fn num_described(&self) -> usize {
        let described = |level: &LevelCorners| level.descriptors.iter().filter(|d| d.get().is_some()).count();
        self.levels.iter().map(described).sum()
    }

    /// All corners: level and pixel of level 0.
    pub fn iter(&self) -> impl Iterator<Item = (usize, Point2<f64>)> {
        self.levels.iter().enumerate().flat_map(|(level, corners)| {
            corners.corners.iter().map(move |corner| (level, px_from_level(&at(corner), level)))
        })
    }

    /// The descriptor of a place of the image that the corners are of, on one level. Kept if it is a corner.
    #[must_use]
    pub fn describe(&self, image: &GrayImage, level: usize, px: &Point2<f64>) -> Option<OrbDescriptor> {
        let place = level_from_px(px, level);
        let (x, y) = (place.x.round().max(0.0), place.y.round().max(0.0));
        let corner = FastCorner { x: x as u32, y: y as u32 };
        let known = self.levels.get(level).and_then(|corners| Some((corners, corners.find(corner)?)));
        match known {
            Some((corners, index)) => Some(*corners.descriptor(image, index)),
            None => OrbDescriptor::new(image, corner.x as usize, corner.y as usize),
        }
    }

    /// The corner most like a descriptor around a line (pixels of level 0, at least one), on a level and its neighbors.
    /// `images` are the levels of the image. The line may bend; a single place is a line of one point. `Err` says
    /// whether there were corners at all.
    ///
    /// # Errors
    /// If no corner near the line is alike.
    pub fn best_near(
        &self,
        images: &[GrayImage],
        descriptor: &OrbDescriptor,
        (line, level): (&[Point2<f64>], usize),
        search: &OrbSearch,
    ) -> Result<OrbMatch, NoOrbMatch> {
        let mut best = Best::default();
        let levels = level.saturating_sub(1)..(level + 2).min(self.levels.len());
        for (number, corners) in levels.clone().zip(&self.levels[levels]) {
            let image = &images[number];
            let same_px = SAME_PLACE_PX * f64::from(1_u32 << number);
            let mut start = line.first().map(|px| level_from_px(px, number));
            for end in line.iter().skip(1).chain(line.last().filter(|_| line.len() == 1)) {
                let end = level_from_px(end, number);
                let piece = (start.unwrap_or(end), end);
                corners.for_each_near(piece, search.margin_px, |index, place| {
                    let distance = corners.descriptor(image, index).distance(descriptor);
                    best.offer(px_from_level(&place, number), distance, same_px);
                });
                start = Some(end);
            }
        }
        match best.found {
            None => Err(NoOrbMatch::NoCorner),
            Some((distance, px)) if distance <= search.max_distance => {
                Ok(OrbMatch { px, distance, second_distance: best.second })
            }
            Some(_) => Err(NoOrbMatch::NoneAlike),
        }
    }
}

/// Why no corner was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoOrbMatch {
    /// There is no corner where the landmark should be.
    NoCorner,
    /// No corner there looks like it.
    NoneAlike,
}

/// The best so far, and the best elsewhere.
struct Best {
    found: Option<(u32, Point2<f64>)>,
    second: u32,
}

impl Default for Best {
    fn default() -> Self {
        Self { found: None, second: u32::MAX }
    }
}

impl Best {
    fn offer(&mut self, px: Point2<f64>, distance: u32, same_px: f64) {
        let Some((least, place)) = self.found else {
            self.found = Some((distance, px));
            return;
        };
        let is_elsewhere = (place - px).norm() > same_px;
        if distance < least {
            if is_elsewhere {
                self.second = least;
            }
            self.found = Some((distance, px));
        } else if is_elsewhere {
            self.second = self.second.min(distance);
        }
    }
}

impl LevelCorners {
    fn new(image: &GrayImage, threshold: u8) -> Self {
        let mut all = Vec::new();
        detect_fast(image, threshold, &mut all);
        let corners = strongest(image, &all, threshold);
        let mut row_starts = Vec::with_capacity(image.height() + 1);
        let mut next = 0;
        for row in 0..=image.height() {
            while corners.get(next).is_some_and(|corner: &FastCorner| (corner.y as usize) < row) {
                next += 1;
            }
            row_starts.push(next as u32);
        }
        let descriptors = corners.iter().map(|_| OnceLock::new()).collect();
        Self { corners, row_starts, descriptors }
    }

    fn row(&self, row: usize) -> std::ops::Range<usize> {
        match (self.row_starts.get(row), self.row_starts.get(row + 1)) {
            (Some(start), Some(end)) => *start as usize..*end as usize,
            _ => 0..0,
        }
    }

    fn find(&self, wanted: FastCorner) -> Option<usize> {
        self.row(wanted.y as usize).find(|index| self.corners[*index].x == wanted.x)
    }

    /// Corners keep the margin of descriptors, so there is one.
    fn descriptor(&self, image: &GrayImage, index: usize) -> &OrbDescriptor {
        let FastCorner { x, y } = self.corners[index];
        self.descriptors[index].get_or_init(|| {
            OrbDescriptor::new(image, x as usize, y as usize).unwrap_or_else(OrbDescriptor::none)
        })
    }

    /// Corners within a distance of a segment, all in pixels of the level.
    fn for_each_near(
        &self,
        (a, b): (Point2<f64>, Point2<f64>),
        margin_px: f64,
        mut take: impl FnMut(usize, Point2<f64>),
    ) {
        let along = b - a;
        let length2 = along.norm_squared();
        let rows = (a.y.min(b.y) - margin_px).ceil().max(0.0) as usize
            ..=(a.y.max(b.y) + margin_px).floor().clamp(0.0, self.row_starts.len() as f64) as usize;
        let (left, right) = (a.x.min(b.x) - margin_px, a.x.max(b.x) + margin_px);
        for index in rows.flat_map(|row| self.row(row)) {
            let place = at(&self.corners[index]);
            if place.x < left || place.x > right {
                continue;
            }
            let share = if length2 > 0.0 { ((place - a).dot(&along) / length2).clamp(0.0, 1.0) } else { 0.0 };
            if (place - (a + along * share)).norm_squared() <= margin_px * margin_px {
                take(index, place);
            }
        }
    }
}

fn at(corner: &FastCorner) -> Point2<f64> {
    Point2::new(f64::from(corner.x), f64::from(corner.y))
}

/// Corners that are stronger than their eight neighbors and far enough from the border to be described.
fn strongest(image: &GrayImage, corners: &[FastCorner], threshold: u8) -> Vec<FastCorner> {
    let (width, height) = (image.width(), image.height());
    let mut scores = vec![0_u16; width * height];
    for corner in corners {
        scores[corner.y as usize * width + corner.x as usize] = fast_score(image, *corner, threshold);
    }
    let is_kept = |corner: &&FastCorner| {
        let (x, y) = (corner.x as usize, corner.y as usize);
        let is_inside = x >= ORB_MARGIN_PX
            && y >= ORB_MARGIN_PX
            && x + ORB_MARGIN_PX < width
            && y + ORB_MARGIN_PX < height;
        if !is_inside {
            return false;
        }
        let middle = y * width + x;
        let score = scores[middle];
        // Of equals the first is kept.
        let before = [middle - width - 1, middle - width, middle - width + 1, middle - 1];
        let after = [middle + 1, middle + width - 1, middle + width, middle + width + 1];
        before.iter().all(|other| scores[*other] < score) && after.iter().all(|other| scores[*other] <= score)
    };
    corners.iter().filter(is_kept).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bright squares of 8 px on dark ground, each with a speck of its own inside.
    fn squares() -> GrayImage {
        let mut image = GrayImage::new(200, 120);
        for (i, (left, top)) in [(30, 40), (80, 40), (130, 40), (80, 80)].into_iter().enumerate() {
            for y in 0..8 {
                for x in 0..8 {
                    image.data_mut()[(top + y) * 200 + left + x] = 120 + 30 * i as u8 + 4 * (x * i) as u8;
                }
            }
        }
        image
    }

    const SEARCH: OrbSearch = OrbSearch { threshold: 10, max_distance: 100, margin_px: 6.0 };

    #[test]
    fn corners_are_described_only_where_they_are_compared() {
        let images = [squares()];
        let corners = OrbCorners::new(&images, 10);
        assert!(corners.len() >= 12, "{}", corners.len());
        let all: Vec<(usize, Point2<f64>)> = corners.iter().collect();
        let (_, px) = all.iter().min_by(|a, b| a.1.x.total_cmp(&b.1.x)).copied().unwrap();
        let descriptor = corners.describe(&images[0], 0, &px).unwrap();
        assert_eq!(corners.num_described(), 1);
        let found = corners.best_near(&images, &descriptor, (&[px], 0), &SEARCH).unwrap();
        assert_eq!((found.px, found.distance), (px, 0));
        let near = all.iter().filter(|(_, other)| (other - px).norm() <= 6.0).count();
        assert_eq!(corners.num_described(), near);
    }

    #[test]
    fn a_bent_line_is_searched_and_a_place_without_corners_says_so() {
        let images = [squares()];
        let corners = OrbCorners::new(&images, 10);
        let target = corners.iter().map(|(_, px)| px).max_by(|a, b| a.y.total_cmp(&b.y)).unwrap();
        let descriptor = corners.describe(&images[0], 0, &target).unwrap();
        let line =
            [Point2::new(20.0, 30.0), Point2::new(60.0, 70.0), target + nalgebra::Vector2::new(5.0, 3.0)];
        assert_eq!(corners.best_near(&images, &descriptor, (&line, 0), &SEARCH).unwrap().px, target);
        let empty = [Point2::new(180.0, 20.0)];
        let nothing = corners.best_near(&images, &descriptor, (&empty, 0), &SEARCH);
        assert_eq!(nothing, Err(NoOrbMatch::NoCorner));
        let outside = [Point2::new(-500.0, 1e6)];
        assert_eq!(
            corners.best_near(&images, &descriptor, (&outside, 0), &SEARCH),
            Err(NoOrbMatch::NoCorner)
        );
        let strict = OrbSearch { max_distance: 0, ..SEARCH };
        let other = corners.iter().map(|(_, px)| px).min_by(|a, b| a.x.total_cmp(&b.x)).unwrap();
        let found = corners.best_near(&images, &descriptor, (&[other], 0), &strict);
        assert_eq!(found, Err(NoOrbMatch::NoneAlike));
    }
}
