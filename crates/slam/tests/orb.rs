//! ORB corners on a rendered image and the same image seen turned, enlarged and darker.

#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use nalgebra::{Point2, Rotation2};
use visloc_core::{GrayImage, Source};
use visloc_io::sequence::{SequenceRange, open_tum};
use visloc_slam::{
    image::Pyramid,
    orb::{OrbCorners, OrbSearch},
};

const THRESHOLD: u8 = 10;

fn rendered() -> GrayImage {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip");
    open_tum(&folder, SequenceRange::default()).unwrap().next_item().unwrap().unwrap().image
}

/// The pixel where a place of the plain image is seen.
struct View {
    turn: Rotation2<f64>,
    scale: f64,
    center: Point2<f64>,
}

impl View {
    fn new(image: &GrayImage, degrees: f64, scale: f64) -> Self {
        let center = Point2::new(image.width() as f64 / 2.0, image.height() as f64 / 2.0);
        Self { turn: Rotation2::new(degrees.to_radians()), scale, center }
    }

    fn place(&self, px: &Point2<f64>) -> Point2<f64> {
        self.center + self.turn * (px - self.center) * self.scale
    }

    fn image(&self, plain: &GrayImage) -> GrayImage {
        let mut out = GrayImage::new(plain.width(), plain.height());
        for y in 0..plain.height() {
            for x in 0..plain.width() {
                let seen = Point2::new(x as f64, y as f64);
                let from = self.center + self.turn.inverse() * (seen - self.center) / self.scale;
                out.data_mut()[y * plain.width() + x] = (0.8 * bilinear(plain, &from)) as u8;
            }
        }
        out
    }
}

fn bilinear(image: &GrayImage, at: &Point2<f64>) -> f64 {
    let (x, y) =
        (at.x.clamp(0.0, image.width() as f64 - 1.001), at.y.clamp(0.0, image.height() as f64 - 1.001));
    let (left, top) = (x as usize, y as usize);
    let (fx, fy) = (x - left as f64, y - top as f64);
    let value = |dx, dy| f64::from(image.get(left + dx, top + dy));
    (1.0 - fy) * ((1.0 - fx) * value(0, 0) + fx * value(1, 0))
        + fy * ((1.0 - fx) * value(0, 1) + fx * value(1, 1))
}

/// Of the corners seen again within 2 px, the share that a search within 12 px finds by their descriptors.
fn recall(plain: &Pyramid, view: &View) -> (usize, f64) {
    let turned = Pyramid::new(view.image(plain.level(0)), 3);
    let search = OrbSearch { threshold: THRESHOLD, max_distance: 100, margin_px: 12.0 };
    let (width, height) = (plain.level(0).width() as f64, plain.level(0).height() as f64);
    let seen_again: Vec<Point2<f64>> = turned.orb(THRESHOLD).iter().map(|(_, px)| px).collect();
    let (mut repeated, mut found) = (0, 0);
    for (level, px) in plain.orb(THRESHOLD).iter() {
        let place = view.place(&px);
        let is_inside = place.x > 40.0 && place.y > 40.0 && place.x < width - 40.0 && place.y < height - 40.0;
        let limit = 2.0 * f64::from(1_u32 << level);
        if !is_inside || !seen_again.iter().any(|other| (other - place).norm() < limit) {
            continue;
        }
        repeated += 1;
        let descriptor = plain.describe(level, &px, &search).unwrap();
        // Where the search begins is off by some pixels, as a prediction is.
        let start = [place + nalgebra::Vector2::new(4.0, -3.0)];
        let best = turned.best_near(&descriptor, (&start, level), &search);
        found += usize::from(best.is_ok_and(|found| (found.px - place).norm() < 2.0 * limit));
    }
    (repeated, found as f64 / repeated.max(1) as f64)
}

#[test]
fn repeated_corners_are_found_by_their_descriptors() {
    let plain = Pyramid::new(rendered(), 3);
    for (degrees, scale, least) in
        [(0.0, 1.0, 0.95), (10.0, 1.0, 0.75), (90.0, 1.0, 0.75), (25.0, 1.15, 0.65)]
    {
        let view = View::new(plain.level(0), degrees, scale);
        let (repeated, recall) = recall(&plain, &view);
        assert!(repeated >= 30, "{degrees} degrees, {scale}: {repeated} corners");
        assert!(recall >= least, "{degrees} degrees, {scale}: {recall:.2} of {repeated}");
    }
}

#[test]
fn corners_are_those_of_the_finest_levels_and_each_is_the_strongest_around() {
    let plain = Pyramid::new(rendered(), 5);
    let corners: &OrbCorners = plain.orb(THRESHOLD);
    assert!(corners.len() > 100, "{}", corners.len());
    let all: Vec<(usize, Point2<f64>)> = corners.iter().collect();
    for (i, (level, px)) in all.iter().enumerate() {
        assert!(*level < 3);
        let step = f64::from(1_u32 << level);
        let is_neighbor =
            |other: &(usize, Point2<f64>)| other.0 == *level && (other.1 - px).amax() <= 1.01 * step;
        assert!(!all[..i].iter().any(is_neighbor));
    }
    assert_eq!(corners.num_described(), 0);
}
