//! Shows a recording.

use std::{path::Path, sync::Arc};

use serde_json::{Value, json};

use super::{
    annotations::annotate,
    index::{RecordingError, RecordingIndex},
    timeline::{Row, row_of},
};
use crate::{Command, Message, MessageBuilder, MessageKind, Session, StudioError, Update};

/// Frames are at least so far apart when a recording is played, seconds.
const MIN_STEP_SECS: f64 = 1e-3;
/// A gap in a recording is waited for no longer than this, seconds.
const MAX_STEP_SECS: f64 = 1.0;
/// Fastest pace, as multiple of reality.
const MAX_SPEED: f64 = 16.0;

/// A recording that is played, stepped and scrubbed.
#[derive(Debug)]
pub struct Replay {
    id: String,
    label: String,
    scenes: Value,
    index: RecordingIndex,
    rows: Vec<Row>,
    frame: usize,
    is_playing: bool,
    speed: f64,
    scene: Option<(usize, Arc<[u8]>)>,
}

impl Replay {
    /// Opens a recording; `id` and `scenes` are told to the pages.
    ///
    /// # Errors
    /// If it is none or cannot be read.
    pub fn open(path: &Path, id: &str, scenes: Value) -> Result<Self, StudioError> {
        let mut index = RecordingIndex::open(path)?;
        let rows: Result<Vec<Row>, RecordingError> =
            (0..index.num_frames()).map(|frame| Ok(row_of(&index.state(frame)?.header))).collect();
        let label = path.file_name().map(|name| name.to_string_lossy().into_owned());
        Ok(Self {
            id: id.to_owned(),
            label: label.unwrap_or_default(),
            scenes,
            rows: rows?,
            index,
            frame: 0,
            is_playing: true,
            speed: 1.0,
            scene: None,
        })
    }

    /// How many frames it has.
    #[must_use]
    pub fn num_frames(&self) -> usize {
        self.rows.len()
    }

    fn last(&self) -> usize {
        self.rows.len() - 1
    }

    /// The recorded scene with the course of the whole recording.
    fn scene_message(&mut self) -> Result<Arc<[u8]>, StudioError> {
        if let Some((frame, scene)) = &self.scene
            && self.index.has_same_scene(*frame, self.frame)
        {
            return Ok(Arc::clone(scene));
        }
        let mut header = self.index.scene(self.frame)?.header;
        let recorded_mode = header.insert("mode".to_owned(), json!("replay"));
        header.insert("recorded_mode".to_owned(), recorded_mode.unwrap_or_default());
        header.insert("scene".to_owned(), json!(self.id));
        header.insert("scenes".to_owned(), self.scenes.clone());
        let names: Vec<&str> = self.rows[self.frame].lanes.iter().map(|lane| lane.name.as_str()).collect();
        header.insert(
            "recording".to_owned(),
            json!({ "label": self.label, "lanes": names, "annotations": annotate(&self.rows) }),
        );
        let mut message = MessageBuilder::new(MessageKind::Scene, &header)?;
        self.add_course(&mut message);
        let bytes: Arc<[u8]> = message.finish().into();
        self.scene = Some((self.frame, Arc::clone(&bytes)));
        Ok(bytes)
    }

    /// All rows as arrays; NaN where nothing is known.
    fn add_course(&self, message: &mut MessageBuilder) {
        let rows = &self.rows;
        message.floats("secs", rows.iter().map(|row| row.secs));
        message.floats("carried", rows.iter().map(|row| f64::from(u8::from(row.is_carried))));
        let lane_values = |row: &Row, lane: usize| {
            row.lanes.get(lane).map_or([f64::NAN; 5], |lane| {
                let error_m = lane.error_m.unwrap_or(f64::NAN);
                [error_m, lane.reliability, lane.quality, lane.ms[0], lane.ms[0] + lane.ms[1]]
            })
        };
        for lane in 0..self.rows[self.frame].lanes.len() {
            message.floats(&format!("lane{lane}"), rows.iter().flat_map(|row| lane_values(row, lane)));
        }
        for plot in 0..self.rows[self.frame].values.len() {
            let width = self.rows[self.frame].values[plot].len();
            let value = |row: &Row, i: usize| {
                row.values.get(plot).and_then(|values| *values.get(i)?).unwrap_or(f64::NAN)
            };
            message.floats(
                &format!("plot{plot}"),
                rows.iter().flat_map(|row| (0..width).map(move |i| value(row, i))),
            );
        }
    }

    fn state_message(&mut self, notice: Option<&str>) -> Result<Vec<u8>, StudioError> {
        let mut state: Message = self.index.state(self.frame)?;
        for (key, value) in [
            ("number", json!(self.frame)),
            ("num_frames", json!(self.num_frames())),
            ("is_playing", json!(self.is_playing)),
            ("speed", json!(self.speed)),
            ("notice", json!(notice)),
        ] {
            state.header.insert(key.to_owned(), value);
        }
        state.header.remove("controls");
        Ok(state.write())
    }
}

impl Session for Replay {
    fn handle(&mut self, command: &Command) -> Result<(), StudioError> {
        match command {
            Command::Play {} => {
                // From the end it begins again.
                if self.frame == self.last() {
                    self.frame = 0;
                }
                self.is_playing = true;
            }
            Command::Pause {} => self.is_playing = false,
            Command::Step {} => {
                self.is_playing = false;
                self.frame = (self.frame + 1).min(self.last());
            }
            Command::Seek { frame } => {
                self.is_playing = false;
                self.frame = (*frame).min(self.last());
            }
            Command::Speed { factor } if (0.0..=MAX_SPEED).contains(factor) => self.speed = *factor,
            Command::Reset { .. } => self.frame = 0,
            command => {
                return Err(StudioError::command("command", "one for a recording", format!("{command:?}")));
            }
        }
        Ok(())
    }

    fn step_secs(&self) -> Option<f64> {
        let next = self.rows.get(self.frame + 1).filter(|_| self.is_playing)?;
        let secs = (next.secs - self.rows[self.frame].secs).clamp(MIN_STEP_SECS, MAX_STEP_SECS);
        Some(if self.speed > 0.0 { secs / self.speed } else { 0.0 })
    }

    fn step(&mut self) -> Result<(), StudioError> {
        self.frame = (self.frame + 1).min(self.last());
        self.is_playing = self.is_playing && self.frame < self.last();
        Ok(())
    }

    fn update(&mut self, notice: Option<&str>) -> Result<Update, StudioError> {
        let scene = self.scene_message()?;
        let state = self.state_message(notice)?.into();
        let image = self.index.image(self.frame)?.map(Into::into);
        Ok(Update { scene, state, image })
    }
}
