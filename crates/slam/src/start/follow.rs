//! Corners followed from one image through the next ones.

use std::sync::Arc;

use nalgebra::{Matrix2, Point2};
use visloc_core::median;

use super::local_warp::{Moved, local_warps};
use crate::{
    feature::{Corner, gradient_noise},
    image::{Pyramid, level_from_px, px_from_level},
    mapping::corner_covariance,
    patch::{AlignLimits, PatchWarp, Template, align},
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
    /// Its patch of the first image on each level where it is searched, as it looks by now.
    templates: Vec<LevelTemplate>,
    /// The warp of `templates`: pixels of now per pixel of the first image.
    warp: Matrix2<f64>,
}

/// A patch for one level of the newest image; no patch where it reaches over the border.
#[derive(Debug, Clone)]
struct LevelTemplate {
    level: usize,
    template: Option<Template>,
}

/// Largest variance of a place that is followed, squared pixels of its level.
const MOST_VARIANCE: f64 = 0.25;
/// Change of the warp from which on the patches are taken anew: at a patch's edge, a tenth of a pixel.
const STALE_WARP: f64 = 0.025;

/// Follows corners by aligning their patches of the *first* image, so that errors do not add up.
///
/// Source: Lucas and Kanade, "An iterative image registration technique", 1981; Bouguet 2001 for the pyramid.
#[derive(Debug, Clone)]
pub struct Follower {
    first: Arc<Pyramid>,
    /// Mean squared gradient of noise on each level of the first image.
    noise: Vec<f32>,
    tracks: Vec<Track>,
}

const LIMITS: AlignLimits =
    AlignLimits { max_iterations: 15, max_shift_px: 4.0, max_unexplained: 0.25, noise: 30.0 };

impl Follower {
    /// Starts with the corners of an image.
    #[must_use]
    pub fn new(first: Arc<Pyramid>, corners: &[Corner]) -> Self {
        let noise = gradient_noise(&first, usize::MAX);
        let tracks = corners.iter().enumerate().map(|(number, corner)| Track {
            number,
            first_px: corner.px,
            px: corner.px,
            level: corner.level,
            covariance_px: corner_covariance(corner.level),
            templates: plain_templates(&first, corner, &noise),
            warp: Matrix2::identity(),
        });
        let tracks = tracks.collect();
        Self { first, noise, tracks }
    }

    /// Follows all corners into the next image and forgets those that are lost. `predict` tells where a corner is likely to
    /// have moved from its last place.
    pub fn follow(&mut self, next: &Pyramid, predict: impl Fn(&Point2<f64>) -> Point2<f64>) {
        self.tracks.retain_mut(|track| {
            let found =
                follow_one(track, next, predict(&track.px)).or_else(|| follow_one(track, next, track.px));
            found.map(|(px, covariance_px)| (track.px, track.covariance_px) = (px, covariance_px)).is_some()
        });
        self.warp_templates(next.num_levels());
    }

    /// Takes the patches anew whose surroundings have been turned or stretched.
    fn warp_templates(&mut self, num_levels: usize) {
        let moved: Vec<Moved> = self.tracks.iter().map(|track| (track.first_px, track.px)).collect();
        for (track, warp) in self.tracks.iter_mut().zip(local_warps(&moved)) {
            if (warp - track.warp).norm() < STALE_WARP {
                continue;
            }
            track.warp = warp;
            if let Some(templates) = warped_templates(&self.first, track, &self.noise, num_levels) {
                track.templates = templates;
            }
        }
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
        median(self.tracks.iter().map(|track| (track.px - track.first_px).norm())).unwrap_or(0.0)
    }
}

/// The patches of a corner as they are, from its own level to the coarsest.
fn plain_templates(first: &Pyramid, corner: &Corner, noise: &[f32]) -> Vec<LevelTemplate> {
    let template = |level| {
        let template =
            Template::from_image(first.level(level), &level_from_px(&corner.px, level), noise[level]);
        LevelTemplate { level, template }
    };
    (corner.level..first.num_levels()).map(template).collect()
}

/// The patches of a corner under its warp, from the level that shows it as its own level did to the coarsest. `None` if
/// nothing can be seen of it any more.
fn warped_templates(
    first: &Pyramid,
    track: &Track,
    noise: &[f32],
    num_levels: usize,
) -> Option<Vec<LevelTemplate>> {
    let mut warp = PatchWarp::from_matrix(&track.warp, track.level, num_levels)?;
    let mut templates = Vec::with_capacity(num_levels);
    loop {
        let template = warp.take(first, &track.first_px, noise);
        templates.push(LevelTemplate { level: warp.current_level, template });
        let Some(coarser) = warp.coarser(num_levels) else { return Some(templates) };
        warp = coarser;
    }
}

fn follow_one(track: &Track, next: &Pyramid, predicted: Point2<f64>) -> Option<(Point2<f64>, Matrix2<f64>)> {
    let mut px = predicted;
    let mut covariance_px = track.covariance_px;
    let finest = track.templates.first()?.level;
    for LevelTemplate { level, template } in track.templates.iter().rev() {
        let image = next.level(*level);
        let found = template
            .as_ref()
            .and_then(|template| align(template, image, &level_from_px(&px, *level), &LIMITS));
        match found {
            // On an edge, the place along it is a guess: worse than none for the start.
            Some(aligned)
                if *level == finest && aligned.covariance.symmetric_eigenvalues().max() > MOST_VARIANCE =>
            {
                return None;
            }
            Some(aligned) => {
                px = px_from_level(&aligned.at, *level);
                covariance_px = aligned.covariance * f64::from(1_u32 << (2 * level));
            }
            // Coarse levels help to get near; only the finest one decides.
            None if *level > finest => {}
            None => return None,
        }
    }
    Some((px, covariance_px))
}
