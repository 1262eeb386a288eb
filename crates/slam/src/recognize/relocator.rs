//! Finding a lost camera in any of the maps.

use visloc_core::geom::Camera;

use super::{Located, Locator, Refusal, View};
use crate::{
    config::SlamConfig,
    map::{KeyframeId, Map},
    track::{FrameWork, Incoming},
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

    /// Tries the keyframes of all maps that look most like the image.
    ///
    /// # Errors
    /// The keyframe that looks most like the image and why it is not the place; `None` if nothing looks like it.
    pub fn attempt(
        &self,
        map: &Map,
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> Result<Located, Option<(KeyframeId, Refusal)>> {
        let view = View::of_image(incoming.pyramid, &self.camera, &self.config.features);
        let ranked = map.index().query(&view);
        let mut refused = None;
        let mut tried: Vec<KeyframeId> = Vec::new();
        for candidate in &ranked {
            if tried.len() >= self.config.relocation.max_tries {
                break;
            }
            let id = candidate.keyframe;
            // What is next to a keyframe that was refused would be refused, too.
            if tried.iter().any(|other| map.connected(*other, 15).iter().any(|(near, _)| *near == id)) {
                continue;
            }
            tried.push(id);
            let searched = map.with_active(map.keyframe(id).map);
            match self.locator.locate(&searched, id, (&view, incoming), work) {
                Ok(located) => return Ok(located),
                Err(reason) => refused = refused.or(Some((id, reason))),
            }
        }
        Err(refused)
    }
}
