//! A run of SLAM, or in a map of SLAM, that people watch and steer.

use anyhow::Result;
use serde_json::{Value, json};
use visloc_slam::SlamConfig;
use visloc_studio::{Command, StudioError, slam::SlamSettings};

use super::broadcast::Broadcast;

/// What people may change.
pub(super) struct Steered {
    pub title: String,
    settings: SlamSettings,
    seed: u64,
    /// Whether it runs in a map of an earlier session.
    is_in_map: bool,
}

/// What a command asks of the run itself.
pub(super) enum Asked {
    Save,
    /// To begin anew, with what the scene message then has besides.
    Anew(Value),
}

impl Steered {
    /// A run with these parameters.
    pub fn new(title: &str, config: &SlamConfig, seed: u64, is_in_map: bool) -> Result<Self> {
        Ok(Self { title: title.to_owned(), settings: SlamSettings::of(config)?, seed, is_in_map })
    }

    /// Obeys what came from pages; parameters and seed if the run is to begin anew.
    pub fn obey(
        &mut self,
        broadcast: &mut Broadcast,
        mut act: impl FnMut(&mut Broadcast, Asked) -> Result<()>,
    ) -> Option<(SlamConfig, u64)> {
        let mut is_new = false;
        for command in broadcast.commands() {
            let done = self.take(&command).and_then(|asked| {
                is_new |= matches!(asked, Asked::Anew(_));
                act(broadcast, asked)
            });
            if let Err(error) = done {
                broadcast.tell(&format!("{error:#}"));
            }
        }
        is_new.then(|| (self.settings.config().clone(), self.seed))
    }

    fn take(&mut self, command: &Command) -> Result<Asked> {
        match command {
            Command::Save {} => return Ok(Asked::Save),
            Command::Reset { seed } => self.seed = *seed,
            Command::Forget {} => {}
            command => match self.settings.changed(command)? {
                Some(settings) => self.settings = settings,
                None => {
                    let expected = "one for a run: parameters, reset, save, pause";
                    return Err(StudioError::command("command", expected, command.name()).into());
                }
            },
        }
        Ok(Asked::Anew(self.fields()?))
    }

    /// What the scene message has besides.
    pub fn fields(&self) -> Result<Value> {
        let mut fields = if self.is_in_map {
            self.settings.scene_fields_in_map()?
        } else {
            self.settings.scene_fields()?
        };
        let scenes = json!([{ "id": "run", "group": "Run", "label": self.title }]);
        let own = json!({ "mode": "watch", "scene": "run", "scenes": scenes, "seed": self.seed });
        if let (Some(fields), Some(own)) = (fields.as_object_mut(), own.as_object()) {
            fields.extend(own.clone());
        }
        Ok(fields)
    }
}
