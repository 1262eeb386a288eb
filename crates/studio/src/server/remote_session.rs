//! A robot elsewhere as something to watch here.

use std::{sync::Arc, thread};

use serde_json::Value;
use visloc_core::Clock;

use super::{hub::Hub, remote::Remote};
use crate::{Command, Message, Session, StudioError, Update};

/// How often it is looked whether something has come, seconds.
const POLL_SECS: f64 = 0.005;

/// The robot's scene, and what is made of it.
struct Scene {
    theirs: Arc<[u8]>,
    ours: Arc<[u8]>,
}

/// Shows what a robot elsewhere publishes, and takes commands there.
pub struct RemoteSession {
    /// Between the thread that holds the link and this session.
    link: Arc<Hub>,
    id: String,
    scenes: Value,
    shown: Option<Arc<Update>>,
    has_news: bool,
    scene: Option<Scene>,
}

impl RemoteSession {
    /// Opens the link, on a thread of its own; `id` and `scenes` are told to the pages. `log` gets what the person who runs the program
    /// should know.
    ///
    /// # Errors
    /// If there is no thread.
    pub fn open(
        remote: Remote,
        id: &str,
        scenes: Value,
        clock: Clock,
        log: impl Fn(&str) + Send + Sync + 'static,
    ) -> Result<Self, StudioError> {
        let (link, commands) = Hub::new(clock, log);
        remote.announce(&link)?;
        let hub = Arc::clone(&link);
        let watch = move || {
            if let Err(error) = remote.watch(&hub, &commands) {
                hub.complain(&error.to_string());
            }
        };
        let thread = thread::Builder::new().name("studio-link".to_owned()).spawn(watch);
        thread.map_err(|error| StudioError::input("link", error))?;
        Ok(Self { link, id: id.to_owned(), scenes, shown: None, has_news: false, scene: None })
    }

    /// The robot's scene among what can be opened here.
    fn scene_message(&mut self, scene: &Arc<[u8]>) -> Result<Arc<[u8]>, StudioError> {
        if let Some(known) = self.scene.as_ref().filter(|known| Arc::ptr_eq(&known.theirs, scene)) {
            return Ok(Arc::clone(&known.ours));
        }
        let mut message = Message::read(scene)?;
        message.header.insert("scene".to_owned(), self.id.clone().into());
        message.header.insert("scenes".to_owned(), self.scenes.clone());
        message.header.insert("mode".to_owned(), "watch".into());
        let ours: Arc<[u8]> = message.write().into();
        self.scene = Some(Scene { theirs: Arc::clone(scene), ours: Arc::clone(&ours) });
        Ok(ours)
    }
}

impl Drop for RemoteSession {
    fn drop(&mut self) {
        self.link.close();
    }
}

impl Session for RemoteSession {
    fn handle(&mut self, command: &Command) -> Result<(), StudioError> {
        self.link.take(command.clone());
        Ok(())
    }

    fn step_secs(&self) -> Option<f64> {
        Some(POLL_SECS)
    }

    fn step(&mut self) -> Result<(), StudioError> {
        let latest = self.link.latest();
        self.has_news = match (&latest, &self.shown) {
            (Some(latest), Some(shown)) => !Arc::ptr_eq(latest, shown),
            (latest, _) => latest.is_some(),
        };
        self.shown = latest;
        Ok(())
    }

    fn has_news(&self) -> bool {
        self.has_news
    }

    fn update(&mut self, more: Option<&Value>) -> Result<Update, StudioError> {
        let latest = self.shown.clone().or_else(|| self.link.latest());
        let latest = latest.ok_or_else(|| StudioError::input("link", "expected an update, found none"))?;
        let scene = self.scene_message(&latest.scene)?;
        let aside = more.and_then(Value::as_object).into_iter().flatten();
        let aside: Vec<_> = aside.filter(|(_, value)| !value.is_null()).collect();
        let mut state = Arc::clone(&latest.state);
        if !aside.is_empty() {
            let mut message = Message::read(&state)?;
            message.header.extend(aside.into_iter().map(|(key, value)| (key.clone(), value.clone())));
            state = message.write().into();
        }
        Ok(Update { scene, state, image: latest.image.clone() })
    }
}
