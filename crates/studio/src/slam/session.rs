//! SLAM in the studio.

use std::{path::PathBuf, sync::Arc};

use serde_json::{Value, json};
use visloc_core::{Clock, GrayFrame};
use visloc_slam::{FrameOutcome, PRESETS};

use super::{
    images::{Images, SequenceSource},
    parameters::SlamSettings,
    system::{Start, System},
    taught::{Job, TaughtMaps},
};
use crate::{
    Command, Session, StudioError, Update, message::lay_over, playback::Playback, recording::Input,
    source::Fed,
};

/// Time between images until two of them tell it, seconds.
const USUAL_STEP_SECS: f64 = 0.05;
/// A gap in a sequence is waited for no longer than this, seconds.
const MAX_STEP_SECS: f64 = 0.5;
/// How often a source that has nothing is asked again, seconds.
const POLL_SECS: f64 = 0.004;

/// A running system.
struct Running {
    images: Images,
    system: System,
    last: Option<(GrayFrame, Option<FrameOutcome>)>,
    /// The message of the last frame's image.
    image: Option<Arc<[u8]>>,
}

/// SLAM, or a camera in the map of an earlier session, on a sequence that is played and stepped.
pub struct SlamSession {
    from: SequenceSource,
    job: Job,
    /// Where maps are saved, and where they are known then.
    shelf: Option<(PathBuf, TaughtMaps)>,
    /// What was saved last, for the page.
    saved: Value,
    more: Value,
    clock: Clock,
    seed: u64,
    settings: SlamSettings,
    running: Running,
    step_secs: f64,
    playback: Playback,
    is_over: bool,
    has_news: bool,
}

impl SlamSession {
    /// Opens a sequence; `more` is laid over the scene message, `clock` measures stages.
    ///
    /// # Errors
    /// If there is no such sequence.
    pub fn open(
        from: SequenceSource,
        job: Job,
        more: Value,
        clock: Clock,
        seed: u64,
    ) -> Result<Self, StudioError> {
        let settings = SlamSettings::preset(PRESETS[0].name)?;
        let running = Running::start((&from, &job), &more, clock.clone(), seed, &settings)?;
        let mut session = Self {
            from,
            job,
            shelf: None,
            saved: Value::Null,
            more,
            clock,
            seed,
            settings,
            running,
            step_secs: USUAL_STEP_SECS,
            playback: Playback::default(),
            is_over: false,
            has_news: false,
        };
        session.step()?;
        Ok(session)
    }

    /// Maps can be saved into a folder, and are known to others then.
    #[must_use]
    pub fn with_shelf(self, folder: PathBuf, taught: TaughtMaps) -> Self {
        Self { shelf: Some((folder, taught)), ..self }
    }

    /// Saves the map so far.
    fn save(&mut self) -> Result<(), StudioError> {
        let nothing = |found: &str| StudioError::command("map", "one that is being made", found);
        let (folder, taught) = self.shelf.as_ref().ok_or_else(|| nothing("no place to save it"))?;
        let Job::Teach(known) = &self.job else { return Err(nothing("one that stays as it is")) };
        let made =
            self.running.system.taught(known.as_deref(), self.seed).ok_or_else(|| nothing("none yet"))?;
        let (num_keyframes, num_landmarks) = (
            made.0.map.all_keyframes().count(),
            made.0.map.landmarks().filter(|(_, it)| it.is_converged()).count(),
        );
        let number = taught.save(folder, made, &self.from)?;
        let file = taught.all()[number].path.display().to_string();
        self.saved = json!({ "file": file, "number": number, "num_keyframes": num_keyframes, "num_landmarks": num_landmarks });
        Ok(())
    }

    /// From the beginning.
    fn restart(&mut self, seed: u64, settings: SlamSettings) -> Result<(), StudioError> {
        let what = (&self.from, &self.job);
        self.running = Running::start(what, &self.more, self.clock.clone(), seed, &settings)?;
        (self.seed, self.settings) = (seed, settings);
        self.is_over = false;
        self.playback.play();
        self.step()
    }

    fn end(&mut self) {
        self.is_over = true;
        self.playback.pause();
    }

    /// Whether images come by themselves: then what is not taken at once is out of date.
    fn is_live(&self) -> bool {
        matches!(self.from, SequenceSource::Other(_, _, true))
    }

    fn take(&mut self, frame: GrayFrame) -> Result<(), StudioError> {
        let Running { system, last, image, .. } = &mut self.running;
        let outcome = system.take(&frame)?;
        if let Some((before, _)) = last {
            self.step_secs = frame.at.secs_since(before.at).clamp(0.0, MAX_STEP_SECS);
        }
        *last = Some((frame, outcome));
        *image = None;
        self.has_news = true;
        Ok(())
    }
}

impl Running {
    fn start(
        (from, job): (&SequenceSource, &Job),
        more: &Value,
        clock: Clock,
        seed: u64,
        settings: &SlamSettings,
    ) -> Result<Self, StudioError> {
        let (images, truth, title) = Images::open(from, seed)?;
        let mut fields = match job {
            Job::Teach(None) => settings.scene_fields()?,
            Job::Teach(Some(_)) | Job::Find(_) => settings.scene_fields_in_map()?,
        };
        lay_over(&mut fields, &json!({ "seed": seed, "has_hands": images.hands().is_some() }));
        lay_over(&mut fields, more);
        let (camera, config) = (images.camera(), settings.config());
        let start = Start { camera, title: &title, truth, job, config, seed, clock, fields };
        Ok(Self { system: System::start(start)?, images, last: None, image: None })
    }
}

impl Session for SlamSession {
    fn handle(&mut self, command: &Command) -> Result<(), StudioError> {
        match command {
            Command::Play {} if self.is_over => self.restart(self.seed, self.settings.clone())?,
            Command::Step {} => {
                self.playback.pause();
                self.step()?;
            }
            Command::Reset { seed } => self.restart(*seed, self.settings.clone())?,
            Command::Kidnap { robot: None, .. } if self.running.images.kidnap() => {}
            Command::Cover { is_on } if self.running.images.cover(*is_on) => {}
            Command::Save {} => self.save()?,
            command if self.playback.handle(command)? => {}
            command => {
                let Some(settings) = self.settings.changed(command)? else {
                    return Err(StudioError::command("command", "one for a camera", command.name()));
                };
                self.restart(self.seed, settings)?;
            }
        }
        Ok(())
    }

    fn step_secs(&self) -> Option<f64> {
        if self.is_over {
            return None;
        }
        if self.is_live() || self.running.last.is_none() {
            return Some(POLL_SECS);
        }
        self.playback.wait_secs(self.step_secs)
    }

    fn step(&mut self) -> Result<(), StudioError> {
        self.has_news = false;
        let (next, truth) = self.running.images.poll();
        if let Some(truth) = truth {
            self.running.system.set_truth(truth);
        }
        match next {
            Fed::Item(_) if self.is_live() && !self.playback.is_playing() && self.running.last.is_some() => {
                Ok(())
            }
            Fed::Item(frame) => self.take(frame),
            Fed::NotYet => Ok(()),
            Fed::End => {
                self.end();
                self.has_news = true;
                Ok(())
            }
            Fed::Failed(error) => {
                self.end();
                Err(StudioError::input("sequence", error))
            }
        }
    }

    fn has_news(&self) -> bool {
        self.has_news
    }

    fn update(&mut self, aside: Option<&Value>) -> Result<Update, StudioError> {
        let hands = self.running.images.hands();
        let mut more = json!({
            "seed": self.seed,
            "taught": self.saved,
            "controls": hands.map(|(is_covered, is_held)| json!({ "is_covered": is_covered, "is_held": is_held })),
        });
        lay_over(&mut more, &self.playback.fields());
        lay_over(&mut more, aside.unwrap_or(&Value::Null));
        let Running { system, last, image, .. } = &mut self.running;
        if let Some((frame, outcome)) = last
            && let Some(moment) = system.moment(frame, outcome.as_ref(), &more)?
        {
            let update = moment.update(image.take())?;
            image.clone_from(&update.image);
            return Ok(update);
        }
        system.viewer().waiting(&more)
    }

    fn input(&self) -> Option<Input<'_>> {
        let Running { images, last, system, .. } = &self.running;
        let (frame, _) = last.as_ref()?;
        let world_from_camera = system.world_from_camera(frame.at);
        Some(Input::Camera { at: frame.at, image: &frame.image, camera: images.camera(), world_from_camera })
    }
}
