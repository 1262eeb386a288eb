//! Finding a landmark in an image whose pose is about known.

use nalgebra::{Matrix2, Point2, Point3, Vector3};
use visloc_core::geom::Camera;

use crate::{
    image::{Pyramid, level_from_px, px_from_level},
    lie::CameraFromWorld,
    map::{KeyframeId, Landmark, Map, Observation},
    orb::{NoOrbMatch, OrbDescriptor, OrbSearch, Recognition},
    patch::{AlignLimits, PatchWarp, SearchPatch, Template, WarpGeometry, align},
};

/// A landmark that was found.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    /// Pixel of level 0.
    pub px: Point2<f64>,
    /// The same on the plane z = 1, without distortion.
    pub ray: Vector3<f64>,
    /// Level on which it was measured.
    pub level: usize,
    /// Covariance of the place, squared pixels of level 0.
    pub covariance_px: Matrix2<f64>,
}

impl Found {
    /// As an observation of a keyframe.
    #[must_use]
    pub fn in_keyframe(&self, keyframe: KeyframeId) -> Observation {
        let Self { px, ray, level, covariance_px } = *self;
        Observation { keyframe, px, ray, level, covariance_px }
    }
}

/// One image to search, with its pose.
#[derive(Debug, Clone, Copy)]
pub struct Matcher<'a> {
    /// The camera of the image.
    pub camera: &'a Camera,
    /// The image.
    pub pyramid: &'a Pyramid,
    /// About its pose.
    pub camera_from_world: CameraFromWorld,
    /// When an alignment counts.
    pub limits: AlignLimits,
    /// Levels on which landmarks are searched.
    pub num_levels: usize,
    /// How landmarks are recognized.
    pub recognition: Recognition,
    /// The keyframe as which landmarks are searched; without, each as that one which sees it most as it is seen here.
    pub seen_by: Option<KeyframeId>,
}

/// Least cosine of the turn between two views of a landmark that look the same. A patch is taken to face the keyframe that it is from: found from
/// elsewhere it is beside its place, in corridors by 0.08 px (one standard deviation) within a degree of turn and by 0.3 px at ten to fourteen.
const ALIKE_COS: f64 = 0.99;
/// Pixels between a place and the border of the image for it to be searched.
const BORDER_PX: f64 = 5.0;

impl Matcher<'_> {
    /// Pixel where a point should be; `None` outside of the image.
    #[inline]
    #[must_use]
    pub fn project(&self, point_in_world: &Point3<f64>) -> Option<Point2<f64>> {
        let px = self.camera.project(&self.camera_from_world.transform(point_in_world)).ok()?;
        let (width, height) = self.camera.size_px();
        let is_inside = px.x >= BORDER_PX
            && px.y >= BORDER_PX
            && px.x < f64::from(width) - BORDER_PX
            && px.y < f64::from(height) - BORDER_PX;
        is_inside.then_some(px)
    }

    /// Whether a landmark would be searched as it looks from nearly the same direction.
    #[must_use]
    pub fn sees_alike(&self, map: &Map, landmark: &Landmark) -> bool {
        let from = |center: &Point3<f64>| (landmark.point_in_world - center).normalize();
        let here = from(&Point3::from(*self.camera_from_world.inverse().translation()));
        self.reference(map, landmark).is_some_and(|reference| {
            here.dot(&from(map.keyframe(reference.keyframe).center_in_world())) >= ALIKE_COS
        })
    }

    /// The landmark's patch as it should look here, and its level.
    #[must_use]
    pub fn template(&self, map: &Map, landmark: &Landmark) -> Option<(Template, PatchWarp)> {
        let reference = self.reference(map, landmark)?;
        let keyframe = map.keyframe(reference.keyframe);
        let pose = keyframe.camera_from_world();
        let geometry = WarpGeometry {
            camera: self.camera,
            reference_camera: keyframe.camera(self.camera),
            reference_px: reference.px,
            reference_ray: reference.ray,
            reference_level: reference.level,
            reference_depth: pose.transform(&landmark.point_in_world).z,
            current_from_reference: self.camera_from_world * pose.inverse(),
        };
        let warp = PatchWarp::new(&geometry, self.num_levels.min(self.pyramid.num_levels()))?;
        let template = warp.take(&*keyframe.pyramid()?, &reference.px, &keyframe.gradient_noise)?;
        Some((template, warp))
    }

    /// Finds a landmark near where it should be: by alignment on its level. With ORB, from the corner that looks like it; where
    /// there is no corner (they are not found again in every image), from the predicted place.
    #[must_use]
    pub fn find(&self, map: &Map, landmark: &Landmark) -> Option<Found> {
        let predicted = self.project(&landmark.point_in_world)?;
        let (template, warp) = self.template(map, landmark)?;
        let level = warp.current_level;
        let start = match &self.recognition {
            Recognition::Patches => predicted,
            Recognition::Orb(search) => {
                let descriptor = self.descriptor(map, landmark, search)?;
                match self.pyramid.best_near(&descriptor, (&[predicted], level), search) {
                    Ok(found) => found.px,
                    Err(NoOrbMatch::NoCorner) => predicted,
                    Err(NoOrbMatch::NoneAlike) => return None,
                }
            }
        };
        self.find_from(&template, level, &start)
    }

    /// As [`Matcher::find`], after a search of all pixels (with ORB, all corners) within a radius (pixels of the level).
    #[must_use]
    pub fn find_within(&self, map: &Map, landmark: &Landmark, radius: usize) -> Option<Found> {
        let predicted = self.project(&landmark.point_in_world)?;
        let (template, warp) = self.template(map, landmark)?;
        let level = warp.current_level;
        let start = match &self.recognition {
            Recognition::Patches => self.best_pixel(&template, level, &predicted, radius)?,
            Recognition::Orb(search) => {
                let descriptor = self.descriptor(map, landmark, search)?;
                let wide = OrbSearch { margin_px: radius as f64, ..*search };
                self.pyramid.best_near(&descriptor, (&[predicted], level), &wide).ok()?.px
            }
        };
        self.find_from(&template, level, &start)
    }

    /// The ORB descriptor of a landmark, in the keyframe whose view is most like this one.
    #[must_use]
    pub fn descriptor(&self, map: &Map, landmark: &Landmark, search: &OrbSearch) -> Option<OrbDescriptor> {
        let reference = self.reference(map, landmark)?;
        let pyramid = map.keyframe(reference.keyframe).pyramid()?;
        pyramid.describe(reference.level, &reference.px, search)
    }

    /// The pixel around which the image is most like a patch; pixel of level 0.
    fn best_pixel(
        &self,
        template: &Template,
        level: usize,
        predicted: &Point2<f64>,
        radius: usize,
    ) -> Option<Point2<f64>> {
        let patch = SearchPatch::new(template);
        let image = self.pyramid.level(level);
        let center = level_from_px(predicted, level);
        let (cx, cy) = (center.x.round() as usize, center.y.round() as usize);
        let limit = self.limits.noise.max(2.0 * self.limits.max_unexplained * patch.variance());
        let mut best = (limit, None);
        for y in cy.saturating_sub(radius)..=cy + radius {
            for x in cx.saturating_sub(radius)..=cx + radius {
                if let Some(score) = patch.zmssd(image, x, y).filter(|score| *score < best.0) {
                    best = (score, Some((x, y)));
                }
            }
        }
        let (x, y) = best.1?;
        Some(px_from_level(&Point2::new(x as f64, y as f64), level))
    }

    /// Aligns a patch that should be near a pixel of level 0.
    #[must_use]
    pub fn find_from(&self, template: &Template, level: usize, start_px: &Point2<f64>) -> Option<Found> {
        let aligned =
            align(template, self.pyramid.level(level), &level_from_px(start_px, level), &self.limits)?;
        let px = px_from_level(&aligned.at, level);
        let covariance_px = aligned.covariance * f64::from(1_u32 << (2 * level));
        Some(Found { px, ray: self.camera.bearing(&px), level, covariance_px })
    }

    /// The observation whose view is most like this one: the oldest of those that look from nearly the same direction and
    /// distance, so that errors do not add up from one keyframe to the next; else the nearest in direction.
    fn reference(&self, map: &Map, landmark: &Landmark) -> Option<Observation> {
        let center = Point3::from(*self.camera_from_world.inverse().translation());
        let view = landmark.point_in_world - center;
        let distance = view.norm();
        let mut best: Option<(f64, usize)> = None;
        let is_wanted = |id: &KeyframeId| self.seen_by.is_none_or(|keyframe| *id == keyframe);
        let seen = landmark.observations.keyframes().enumerate();
        for (index, id) in seen.filter(|(_, id)| is_wanted(id)) {
            let keyframe = map.keyframe(id);
            if keyframe.picture.is_none() {
                continue;
            }
            let other = landmark.point_in_world - keyframe.center_in_world();
            let other_distance = other.norm();
            let cos = view.dot(&other) / (distance * other_distance);
            let octaves = (distance / other_distance).log2().abs();
            if cos > 0.97 && octaves < 0.5 {
                return Some(landmark.observations.at(index));
            }
            let score = cos - 0.2 * octaves;
            if best.is_none_or(|(most, _)| score > most) {
                best = Some((score, index));
            }
        }
        // Beyond 60 degrees nothing looks the same.
        best.filter(|(score, _)| *score > 0.5).map(|(_, index)| landmark.observations.at(index))
    }
}

/// Whitening of a residual on the plane z = 1, of a place with a covariance in pixels.
#[must_use]
pub fn whitening(focal_px: f64, covariance_px: &Matrix2<f64>) -> Matrix2<f64> {
    let root = covariance_px.cholesky().and_then(|c| c.l().try_inverse());
    root.unwrap_or_else(Matrix2::identity) * focal_px
}
