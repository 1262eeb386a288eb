//! Finding a lost camera in any of the maps.

use visloc_core::geom::Camera;

use super::{Located, Locator, Refusal, View};
use crate::{
    config::SlamConfig,
    map::{KeyframeId, Map},
    track::{FrameWork, Incoming, TrackReport, scene_depth},
};

/// Looks for a lost camera.
#[derive(Debug, Clone)]
pub struct Relocator {
    camera: Camera,
    config: SlamConfig,
    locator: Locator,
}

impl Relocator {
    /// Takes over a camera that is known better.
    pub fn set_camera(&mut self, camera: &Camera) {
        self.camera = *camera;
        self.locator.set_camera(camera);
    }

    /// For one camera.
    #[must_use]
    pub fn new(camera: &Camera, config: &SlamConfig) -> Self {
        Self { camera: *camera, config: config.clone(), locator: Locator::new(camera, config) }
    }

    /// Finds more from now on, for those who doubt what is found until they see more of it.
    pub fn doubt(&mut self) {
        self.locator.doubt();
    }

    /// Tries the keyframes of all maps that look most like the image. The place where most landmarks were found is the answer.
    ///
    /// # Errors
    /// The keyframe that looks most like the image and why it is not the place; `None` if nothing looks like it.
    pub fn attempt(
        &self,
        map: &Map,
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> Result<Located, Option<(KeyframeId, Refusal)>> {
        self.attempt_among(map, |_| true, incoming, work)
    }

    /// Tries only some of the keyframes, see [`Relocator::attempt`].
    ///
    /// # Errors
    /// As [`Relocator::attempt`].
    pub fn attempt_among(
        &self,
        map: &Map,
        is_candidate: impl Fn(KeyframeId) -> bool,
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> Result<Located, Option<(KeyframeId, Refusal)>> {
        let view = View::of_image(incoming.pyramid, &self.camera, &self.config.features);
        let ranked = map.index().query(&view);
        let (mut refused, mut best) = (None, None::<Located>);
        let mut is_tried = vec![false; map.num_keyframe_ids()];
        let mut num_tried = 0;
        for candidate in &ranked {
            let id = candidate.keyframe;
            // What is next to a keyframe that was refused would be refused, too.
            if is_tried[id.index()] || !is_candidate(id) {
                continue;
            }
            map.connected(id, 15).iter().for_each(|(near, _)| is_tried[near.index()] = true);
            let searched = map.with_active(map.keyframe(id).map);
            match self.locator.locate(&searched, id, (&view, incoming), work) {
                Ok(located) => best = Some(better(map, best, located)),
                Err(reason) => refused = refused.or(Some((id, reason))),
            }
            num_tried += 1;
            if num_tried >= self.config.relocation.max_tries {
                break;
            }
        }
        best.ok_or(refused)
    }
}

/// Distance up to which two poses are the same place, share of the depth of the scene.
const SAME_PLACE: f64 = 0.2;

/// Of two places where an image may have been taken, the one where more landmarks were found; it remembers the other one.
fn better(map: &Map, first: Option<Located>, second: Located) -> Located {
    let Some(first) = first else { return second };
    let (mut more, less) =
        if second.report.num_matched > first.report.num_matched { (second, first) } else { (first, second) };
    let is_elsewhere = map.keyframe(more.keyframe).map != map.keyframe(less.keyframe).map;
    more.num_elsewhere = more.num_elsewhere.max(less.num_elsewhere);
    if is_elsewhere || are_apart(map, &more.report, &less.report) {
        more.num_elsewhere = more.num_elsewhere.max(less.report.num_matched);
    }
    more
}

/// Whether two poses of one image are different places.
pub(crate) fn are_apart(map: &Map, one: &TrackReport, other: &TrackReport) -> bool {
    let [here, there] = [one, other].map(|report| report.frame.camera_from_world.inverse());
    (here.translation() - there.translation()).norm() > SAME_PLACE * scene_depth(map, &one.frame)
}
