//! The scene message: what stays from frame to frame.

use serde_json::{Value, json};
use visloc_locate::{lineup::RunSettings, vision::DropReason};

use crate::{MessageBuilder, MessageKind, StudioError, message::lay_over, tuning, view::world_geometry};

/// What the message is made of.
pub(super) struct Scene<'a> {
    /// Id of the place.
    pub place: &'a str,
    /// Time between two frames.
    pub step_secs: f64,
    /// Map, algorithms, parameters and seed.
    pub settings: &'a RunSettings,
    /// What else can be opened.
    pub others: &'a Value,
}

impl Scene<'_> {
    /// The bytes.
    ///
    /// # Errors
    /// If a parameter cannot be written.
    pub fn message(&self) -> Result<Vec<u8>, StudioError> {
        let mut header = json!({
            "mode": "playground",
            "scene": self.place,
            "scenes": self.others,
            "world": world_geometry(&self.settings.map),
            "step_secs": self.step_secs,
            "drop_reasons": DropReason::ALL.map(DropReason::name),
        });
        lay_over(&mut header, &tuning::scene_fields(self.settings)?);
        Ok(MessageBuilder::new(MessageKind::Scene, &header)?.finish())
    }
}
