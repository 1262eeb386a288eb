//! What pages can choose to see.

use serde_json::{Value, json};

use crate::{
    Clock, Engine, Session, StudioError,
    playground::{PLACES, Playground},
};

/// Opens playgrounds.
#[derive(Debug, Clone)]
pub struct Scenes {
    clock: Clock,
    seed: u64,
}

impl Scenes {
    /// Everything that needs no files. `seed` is that of everything random.
    #[must_use]
    pub fn new(clock: Clock, seed: u64) -> Self {
        Self { clock, seed }
    }

    /// The id of what is shown first.
    #[must_use]
    pub fn first(&self) -> String {
        PLACES[0].id.to_owned()
    }

    /// All of them for the page: id, group and label.
    fn list(&self) -> Value {
        let scene = |id: &str, group: &str, label: &str| json!({ "id": id, "group": group, "label": label });
        PLACES.iter().map(|place| scene(place.id, "Playground", place.label)).collect()
    }
}

impl Engine for Scenes {
    fn open(&mut self, scene: &str) -> Result<Box<dyn Session>, StudioError> {
        Ok(Box::new(Playground::new(scene, self.seed, self.clock.clone(), self.list())?))
    }
}
