//! Corners followed from one image through the next ones.

use std::sync::Arc;

use nalgebra::{Matrix2, Point2};

use crate::{
    feature::{Corner, gradient_noise},
    image::{Pyramid, level_from_px, px_from_level},
    mapping::corner_covariance,
    patch::{AlignLimits, Template, align},
};

/// One corner that is followed.
#[derive(Debug, Clone)]
pub struct Track {
    /// Number among the corners at the start.
    pub number: usize,
    /// Where it was in the first image, pixels of level 0.
    pub first_px: Point2<f64>,
    /// Where it is in the newest image, pixels of level 0.
    pub px: Point2<f64>,
    /// Level on which it was found.
    pub level: usize,
    /// Covariance of `px`, squared pixels of level 0.
    pub covariance_px: Matrix2<f64>,
    /// Its patch on each level of the first image; `None` where it reaches over the border.
    templates: Vec<Option<Template>>,
}

/// Largest variance of a place that is followed, squared pixels of its level.
const MOST_VARIANCE: f64 = 0.25;

/// Follows corners by aligning their patches of the *first* image, so that errors do not add up.
///
/// Source: Lucas and Kanade, "An iterative image registration technique", 1981; Bouguet 2001 for the pyramid.
#[derive(Debug, Clone)]
pub struct Follower {
    first: Arc<Pyramid>,
    tracks: Vec<Track>,
}

const LIMITS: AlignLimits =
    AlignLimits { max_iterations: 15, max_shift_px: 4.0, max_unexplained: 0.25, noise: 30.0 };

impl Follower {
    /// Starts with the corners of an image.
    #[must_use]
    pub fn new(first: Arc<Pyramid>, corners: &[Corner]) -> Self {
        let noise = gradient_noise(&first, usize::MAX);
        let tracks = corners.iter().enumerate().map(|(number, corner)| {
            let template = |level| {
                Template::from_image(first.level(level), &level_from_px(&corner.px, level), noise[level])
            };
            let templates = (0..first.num_levels()).map(template).collect();
            Track {
                number,
                first_px: corner.px,
                px: corner.px,
                level: corner.level,
                covariance_px: corner_covariance(corner.level),
                templates,
            }
        });
        let tracks = tracks.collect();
        Self { first, tracks }
    }

    /// Follows all corners into the next image and forgets those that are lost. `predict` tells where a corner is likely to
    /// have moved from its last place.
    pub fn follow(&mut self, next: &Pyramid, predict: impl Fn(&Point2<f64>) -> Point2<f64>) {
        self.tracks.retain_mut(|track| {
            let found =
                follow_one(track, next, predict(&track.px)).or_else(|| follow_one(track, next, track.px));
            found.map(|(px, covariance_px)| (track.px, track.covariance_px) = (px, covariance_px)).is_some()
        });
    }

    /// Corners that are not lost.
    #[must_use]
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }

    /// The first image.
    #[must_use]
    pub fn first(&self) -> &Arc<Pyramid> {
        &self.first
    }

    /// Median distance of the corners from their first places, pixels; 0 without corners.
    #[must_use]
    pub fn median_shift_px(&self) -> f64 {
        let mut shifts: Vec<f64> =
            self.tracks.iter().map(|track| (track.px - track.first_px).norm()).collect();
        shifts.sort_by(f64::total_cmp);
        shifts.get(shifts.len() / 2).copied().unwrap_or(0.0)
    }
}

fn follow_one(track: &Track, next: &Pyramid, predicted: Point2<f64>) -> Option<(Point2<f64>, Matrix2<f64>)> {
    let mut px = predicted;
    let mut covariance_px = track.covariance_px;
    for level in (track.level..next.num_levels().min(track.templates.len())).rev() {
        let image = next.level(level);
        let found = track.templates[level]
            .as_ref()
            .and_then(|template| align(template, image, &level_from_px(&px, level), &LIMITS));
        match found {
            // On an edge, the place along it is a guess: worse than none for the start.
            Some(aligned)
                if level == track.level
                    && aligned.covariance.symmetric_eigenvalues().max() > MOST_VARIANCE =>
            {
                return None;
            }
            Some(aligned) => {
                px = px_from_level(&aligned.at, level);
                covariance_px = aligned.covariance * f64::from(1_u32 << (2 * level));
            }
            // Coarse levels help to get near; only the corner's own level decides.
            None if level > track.level => {}
            None => return None,
        }
    }
    Some((px, covariance_px))
}
