//! Updates of a run on a recording or a robot: nobody at a page drives it.

use std::sync::Arc;

use serde_json::{Value, json};
use visloc_core::{Frame, Timestamp, Truth};
use visloc_locate::{lineup::Lineup, vision::DropReason};
use visloc_world::Map;

use super::{ContenderView, LocalizationView, views, world_geometry};
use crate::{MessageBuilder, MessageKind, StudioError, Update, message::lay_over, tuning};

/// Shows algorithms at work.
#[derive(Debug)]
pub struct RunViewer {
    title: String,
    /// What the scene message has besides.
    more: Value,
    /// With the number of changes of the lineup that it shows.
    scene: Option<(u64, Arc<[u8]>)>,
    first_at: Option<Timestamp>,
    num_frames: u64,
}

impl RunViewer {
    /// Shows a run.
    pub fn new(title: &str) -> Self {
        let more = json!({
            "mode": "watch",
            "scene": "run",
            "scenes": [{ "id": "run", "group": "Run", "label": title }],
        });
        Self { title: title.to_owned(), more, scene: None, first_at: None, num_frames: 0 }
    }

    /// With a table that is laid over the scene message.
    #[must_use]
    pub fn with(mut self, more: &Value) -> Self {
        lay_over(&mut self.more, more);
        self
    }

    /// Takes out what there is to see after a frame, which is shared; to be called for each frame that is shown. `more` is a
    /// table that is laid over the state message.
    ///
    /// # Errors
    /// If the scene cannot be encoded.
    pub fn moment(
        &mut self,
        frame: &Arc<Frame>,
        truth: Option<Truth>,
        lineup: &Lineup,
        more: &Value,
    ) -> Result<RunMoment, StudioError> {
        let first_at = *self.first_at.get_or_insert(frame.at);
        let mut state = json!({ "is_playing": true });
        lay_over(&mut state, more);
        Ok(RunMoment {
            scene: self.scene_message(lineup)?,
            map: Arc::clone(&lineup.settings().map),
            number: self.num_frames,
            secs: frame.at.secs_since(first_at),
            frame: Arc::clone(frame),
            truth,
            contenders: views(lineup),
            more: state,
        })
    }

    /// What there is to see before the first frame of a source that lets one wait.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn waiting(&mut self, lineup: &Lineup, more: &Value) -> Result<Update, StudioError> {
        let mut header = json!({ "number": 0, "secs": 0.0, "is_waiting": true, "contenders": [] });
        lay_over(&mut header, more);
        let state = MessageBuilder::new(MessageKind::State, &header)?.finish().into();
        Ok(Update { scene: self.scene_message(lineup)?, state, image: None })
    }

    /// One more frame; the next update is another moment.
    pub fn next_frame(&mut self) {
        self.num_frames += 1;
    }

    fn scene_message(&mut self, lineup: &Lineup) -> Result<Arc<[u8]>, StudioError> {
        let num_changes = lineup.num_changes();
        if let Some((_, scene)) = self.scene.as_ref().filter(|(shown, _)| *shown == num_changes) {
            return Ok(Arc::clone(scene));
        }
        let mut header = json!({
            "title": self.title,
            "world": world_geometry(&lineup.settings().map),
            "drop_reasons": DropReason::ALL.map(DropReason::name),
        });
        lay_over(&mut header, &tuning::scene_fields(lineup.settings())?);
        lay_over(&mut header, &self.more);
        let bytes: Arc<[u8]> = MessageBuilder::new(MessageKind::Scene, &header)?.finish().into();
        self.scene = Some((num_changes, Arc::clone(&bytes)));
        Ok(bytes)
    }
}

/// A moment of a run, copied, so that messages can be made of it while the run goes on.
pub struct RunMoment {
    scene: Arc<[u8]>,
    map: Arc<Map>,
    number: u64,
    secs: f64,
    frame: Arc<Frame>,
    truth: Option<Truth>,
    contenders: Vec<ContenderView>,
    more: Value,
}

impl RunMoment {
    /// Since the first frame.
    pub fn secs(&self) -> f64 {
        self.secs
    }

    /// The messages. `image` is the one of this frame, if it has been made before.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn update(self, image: Option<Arc<[u8]>>) -> Result<Update, StudioError> {
        let view = LocalizationView {
            map: &self.map,
            number: self.number,
            secs: self.secs,
            frame: &self.frame,
            truth: self.truth,
            contenders: &self.contenders,
        };
        let image = match image {
            Some(image) => image,
            None => view.image()?.into(),
        };
        Ok(Update { scene: self.scene, state: view.state(self.more, None)?.into(), image: Some(image) })
    }
}
