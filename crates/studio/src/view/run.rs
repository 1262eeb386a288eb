//! Updates of a run on a recording or a robot: nobody at a page drives it.

use std::sync::Arc;

use serde_json::json;
use visloc_base::{Frame, Timestamp, Truth};
use visloc_vision::DropReason;
use visloc_world::Map;

use super::{ContenderView, LocalizationView, world_geometry};
use crate::{MessageBuilder, MessageKind, StudioError, Update};

/// Shows algorithms at work.
#[derive(Debug)]
pub struct RunViewer {
    map: Map,
    title: String,
    scene: Option<Arc<[u8]>>,
    first_at: Option<Timestamp>,
    num_frames: u64,
}

impl RunViewer {
    /// Shows a run on a map.
    #[must_use]
    pub fn new(map: &Map, title: &str) -> Self {
        Self { map: map.clone(), title: title.to_owned(), scene: None, first_at: None, num_frames: 0 }
    }

    /// What there is to see after a frame, and the seconds since the first one; to be called for each frame that is shown.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn update(
        &mut self,
        frame: &Frame,
        truth: Option<Truth>,
        contenders: &[ContenderView<'_>],
    ) -> Result<(Update, f64), StudioError> {
        let first_at = *self.first_at.get_or_insert(frame.at);
        let secs = frame.at.secs_since(first_at);
        let scene = self.scene_message(contenders)?;
        let view =
            LocalizationView { map: &self.map, number: self.num_frames, secs, frame, truth, contenders };
        self.num_frames += 1;
        let state = view.state(json!({ "is_playing": true }), None)?.into();
        let image = view.image()?.into();
        Ok((Update { scene, state, image: Some(image) }, secs))
    }

    fn scene_message(&mut self, contenders: &[ContenderView<'_>]) -> Result<Arc<[u8]>, StudioError> {
        if let Some(scene) = &self.scene {
            return Ok(Arc::clone(scene));
        }
        let names: Vec<&str> = contenders.iter().map(|contender| contender.name).collect();
        let header = json!({
            "mode": "watch",
            "title": self.title,
            "scene": "run",
            "scenes": [{ "id": "run", "group": "Run", "label": self.title }],
            "world": world_geometry(&self.map),
            "names": names,
            "drop_reasons": DropReason::ALL.map(DropReason::name),
        });
        let bytes: Arc<[u8]> = MessageBuilder::new(MessageKind::Scene, &header)?.finish().into();
        self.scene = Some(Arc::clone(&bytes));
        Ok(bytes)
    }
}
