//! Search for a candidate along its epipolar segment.

use nalgebra::{Point2, Point3, Vector2, Vector3};
use visloc_core::geom::{Camera, CameraFrame, Rigid3};

use crate::{
    image::level_from_px,
    map::{Landmark, Map},
    orb::{OrbSearch, Recognition},
    patch::{AlignLimits, SearchPatch, Template},
    track::{Found, Matcher},
};

/// What a search for a candidate found.
#[derive(Debug, Clone, Copy)]
pub enum EpipolarSearch {
    /// The candidate is not in view, or from too near its host to learn anything.
    Unseen,
    /// It should be in view and was not found.
    Missed,
    /// It was found.
    Found {
        /// Where.
        found: Found,
        /// Inverse depth in the host, 1 / map unit.
        inverse_depth: f64,
        /// Standard deviation of that.
        standard_deviation: f64,
    },
}

/// When an alignment at the end of a search counts.
const LIMITS: AlignLimits =
    AlignLimits { max_iterations: 12, max_shift_px: 3.0, max_unexplained: 0.15, noise: 15.0 };
/// Error along the line of a usual match, pixels.
const USUAL_SIGMA_PX: f64 = 0.3;
/// Most places that are compared.
const MAX_STEPS: usize = 150;
/// Length of a segment up to which alignment alone finds the place, pixels of the level.
const SHORT_PX: f64 = 3.0;

impl Matcher<'_> {
    /// Looks for a candidate within two standard deviations of its inverse depth.
    #[must_use]
    pub fn search_epipolar(&self, map: &Map, candidate: &Landmark) -> EpipolarSearch {
        let host = candidate.host();
        let motion = self.camera_from_world * map.keyframe(host.keyframe).camera_from_world().inverse();
        let line = Line::new(self.camera, &motion, &host.ray);
        let Some(filter) = &candidate.filter else { return EpipolarSearch::Unseen };
        let (far, near) = filter.interval();
        let mean = filter.inverse_depth();
        let Some(slope) = line.slope(mean) else { return EpipolarSearch::Unseen };
        let matcher = Self { limits: LIMITS, ..*self };
        if matcher.project(&candidate.point_in_world).is_none() && line.num_inside(far, near) == 0 {
            return EpipolarSearch::Unseen;
        }
        // A measurement worse than what is known is not worth a search.
        if USUAL_SIGMA_PX > 1.5 * slope * filter.standard_deviation() {
            return EpipolarSearch::Unseen;
        }
        let Some((template, warp)) = matcher.template(map, candidate) else {
            return EpipolarSearch::Unseen;
        };
        let level = warp.current_level;
        let is_short = line.length_px(far, near).is_some_and(|px| px < SHORT_PX * f64::from(1_u32 << level));
        let start = match (is_short, &self.recognition) {
            (true, _) => line.px(far).zip(line.px(near)).map(|(a, b)| nalgebra::center(&a, &b)),
            (false, Recognition::Patches) => self.best_pixel_on_line(&template, level, &line, (far, near)),
            (false, Recognition::Orb(search)) => {
                self.best_corner_on_line((map, candidate), (search, level), &line, (far, near))
            }
        };
        let found = start.and_then(|px| matcher.find_from(&template, level, &px));
        let Some(found) = found else { return EpipolarSearch::Missed };
        let Some(inverse_depth) = line.inverse_depth_of(&found.ray) else { return EpipolarSearch::Missed };
        let Some((px, slope)) = line.px(inverse_depth).zip(line.slope(inverse_depth)) else {
            return EpipolarSearch::Missed;
        };
        let level_px = f64::from(1_u32 << level);
        // The alignment may leave the line; a true match does not.
        if (px - found.px).norm() > 2.0 * level_px || slope < 1e-9 {
            return EpipolarSearch::Missed;
        }
        let Some(direction) = line.direction(inverse_depth) else { return EpipolarSearch::Missed };
        let sigma_px = direction.dot(&(found.covariance_px * direction)).sqrt();
        EpipolarSearch::Found { found, inverse_depth, standard_deviation: sigma_px / slope }
    }

    /// The corner near the segment that looks most like the candidate; pixel of level 0.
    fn best_corner_on_line(
        &self,
        (map, candidate): (&Map, &Landmark),
        (search, level): (&OrbSearch, usize),
        line: &Line<'_>,
        (far, near): (f64, f64),
    ) -> Option<Point2<f64>> {
        let descriptor = self.descriptor(map, candidate, search)?;
        let px: Vec<Point2<f64>> = line
            .steps(far, near, PIECE_PX)
            .filter_map(|inverse_depth| line.px(inverse_depth))
            .filter(|px| self.camera.contains(px))
            .collect();
        let found = self.pyramid.best_near(&descriptor, (&px, level), search).ok()?;
        let is_clear = f64::from(found.distance) <= MAX_ORB_RATIO * f64::from(found.second_distance);
        is_clear.then_some(found.px)
    }

    /// The best place on the segment, pixel of level 0.
    fn best_pixel_on_line(
        &self,
        template: &Template,
        level: usize,
        line: &Line<'_>,
        (far, near): (f64, f64),
    ) -> Option<Point2<f64>> {
        let scale = 1.0 / f64::from(1_u32 << level);
        let patch = SearchPatch::new(template);
        let image = self.pyramid.level(level);
        let limit = LIMITS.noise.max(2.0 * LIMITS.max_unexplained * patch.variance());
        let mut best: Option<(f32, Point2<f64>)> = None;
        let mut second = f32::MAX;
        let mut last = (usize::MAX, usize::MAX);
        for inverse_depth in line.steps(far, near, 0.8 / scale) {
            let Some(px) = line.px(inverse_depth) else { continue };
            let at = level_from_px(&px, level);
            if at.x < 0.0 || at.y < 0.0 {
                continue;
            }
            // Rounded; nothing is negative here.
            let pixel = ((at.x + 0.5) as usize, (at.y + 0.5) as usize);
            if pixel == last {
                continue;
            }
            last = pixel;
            let Some(score) = patch.zmssd(image, pixel.0, pixel.1) else { continue };
            match best {
                Some((least, place)) if score < least => {
                    if (place - px).norm() * scale > 3.0 {
                        second = least;
                    }
                    best = Some((score, px));
                }
                Some((_, place)) if (place - px).norm() * scale > 3.0 => second = second.min(score),
                Some(_) => {}
                None => best = Some((score, px)),
            }
        }
        let (score, px) = best.filter(|(score, _)| *score < limit)?;
        // Two places that look the same: better to wait for a shorter segment.
        (score <= 0.7 * second).then_some(px)
    }
}

/// Length of the straight pieces in which a line is searched for corners, pixels.
const PIECE_PX: f64 = 24.0;
/// Largest ratio of the distances of the best ORB corner and the best elsewhere; above, it is better to wait for a shorter
/// segment.
const MAX_ORB_RATIO: f64 = 0.85;

/// The image of a host's ray in another view.
struct Line<'a> {
    camera: &'a Camera,
    /// The ray, turned to the other view.
    turned_ray: Vector3<f64>,
    /// Where the host is in the other view, map units.
    host: &'a Vector3<f64>,
}

impl<'a> Line<'a> {
    fn new(camera: &'a Camera, motion: &'a Rigid3<CameraFrame, CameraFrame>, ray: &Vector3<f64>) -> Self {
        Self { camera, turned_ray: motion.rotate(ray), host: motion.translation() }
    }

    /// The point at an inverse depth, divided by the depth.
    #[inline]
    fn point(&self, inverse_depth: f64) -> Point3<f64> {
        Point3::from(self.turned_ray + self.host * inverse_depth)
    }

    #[inline]
    fn px(&self, inverse_depth: f64) -> Option<Point2<f64>> {
        self.camera.project(&self.point(inverse_depth)).ok()
    }

    /// Distance between the images of two inverse depths, pixels.
    fn length_px(&self, far: f64, near: f64) -> Option<f64> {
        Some(nalgebra::distance(&self.px(far)?, &self.px(near)?))
    }

    /// Pixels per unit of inverse depth.
    fn slope(&self, inverse_depth: f64) -> Option<f64> {
        let (_, by_point) = self.camera.project_with_jacobian(&self.point(inverse_depth)).ok()?;
        Some((by_point * self.host).norm())
    }

    /// Direction in which the image moves with inverse depth, of length 1.
    fn direction(&self, inverse_depth: f64) -> Option<Vector2<f64>> {
        let (_, by_point) = self.camera.project_with_jacobian(&self.point(inverse_depth)).ok()?;
        (by_point * self.host).try_normalize(1e-12)
    }

    /// How many of a few places on the segment are inside the image.
    fn num_inside(&self, far: f64, near: f64) -> usize {
        let inside = |i: &u32| {
            let inverse_depth = far + (near - far) * f64::from(*i) / 4.0;
            self.px(inverse_depth).is_some_and(|px| self.camera.contains(&px))
        };
        (0..5).filter(inside).count()
    }

    /// Inverse depths from far to near whose images are about `step_px` apart.
    fn steps(&self, far: f64, near: f64, step_px: f64) -> impl Iterator<Item = f64> {
        let mut length = 0.0;
        let mut last = None;
        for i in 0..=8 {
            let px = self.px(far + (near - far) * f64::from(i) / 8.0).filter(|px| self.camera.contains(px));
            if let (Some(a), Some(b)) = (last, px) {
                let step: f64 = nalgebra::distance(&a, &b);
                length += step;
            }
            last = px;
        }
        let num = ((length / step_px).ceil() as usize).clamp(4, MAX_STEPS);
        // The image of a ray moves fastest where depth is small; equal steps in x / z need unequal ones in 1 / z.
        let z = self.turned_ray.z;
        let tz = self.host.z;
        let warp = move |s: f64| {
            let (z0, z1) = (z + tz * far, z + tz * near);
            if z0 <= 1e-6 || z1 <= 1e-6 { s } else { s * z0 / (z1 + s * (z0 - z1)) }
        };
        (0..=num).map(move |i| far + (near - far) * warp(i as f64 / num as f64))
    }

    /// Inverse depth at which the image is nearest to a ray.
    fn inverse_depth_of(&self, ray: &Vector3<f64>) -> Option<f64> {
        // (r + t / d) x ray = 0, in the least-squares sense.
        let a = self.turned_ray.cross(ray);
        let b = self.host.cross(ray);
        let inverse_depth = -a.dot(&b) / b.norm_squared();
        (inverse_depth.is_finite() && inverse_depth > 0.0).then_some(inverse_depth)
    }
}
