//! A recording computed again.
//!
//! What comes of it goes to a file, not into memory: recordings may be long. The file has a state for each frame of the recording
//! with the algorithms that ran now, and what they expected to see; [`Replay`](super::Replay) lays it over what was recorded.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use serde_json::{Value, json};
use visloc_locate::lineup::Lineup;

use super::draft::Method;
use crate::{
    Message, MessageBuilder, MessageError, MessageKind, StudioError, Update,
    message::lay_over,
    recording::{Recorder, RecordingIndex, row_of},
    view::{LocalizationView, views},
};

/// A file that is removed when nobody needs it any more.
#[derive(Debug)]
pub(super) struct ScratchFile(PathBuf);

impl ScratchFile {
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for ScratchFile {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

/// A recording that is being computed again.
pub(super) struct Recompute {
    index: RecordingIndex,
    method: Method,
    scene: Arc<[u8]>,
    recorder: Recorder,
    file: ScratchFile,
    frame: usize,
}

impl Recompute {
    /// Begins with the first frame of a recording; results go to the file `out`.
    pub fn start(index: RecordingIndex, method: Method, out: PathBuf) -> Result<Self, StudioError> {
        let scene = MessageBuilder::new(MessageKind::Scene, &json!({}))?.finish().into();
        let recorder = Recorder::create(&out)?;
        Ok(Self { index, method, scene, recorder, file: ScratchFile(out), frame: 0 })
    }

    /// Frames that are done, and all.
    pub fn progress(&self) -> (usize, usize) {
        (self.frame, self.index.num_frames())
    }

    /// Computes some frames; whether all are done.
    pub fn advance(&mut self, num_frames: usize) -> Result<bool, StudioError> {
        for _ in 0..num_frames {
            if self.frame == self.index.num_frames() {
                break;
            }
            self.compute()?;
            self.frame += 1;
        }
        Ok(self.frame == self.index.num_frames())
    }

    fn compute(&mut self) -> Result<(), StudioError> {
        let secs = row_of(&self.index.short_state(self.frame)?.header).secs;
        let update = match &mut self.method {
            Method::Robot(lineup) => localized(lineup, &mut self.index, self.frame, secs)?,
            Method::Camera(run) => run.step(&mut self.index, self.frame)?,
        };
        self.recorder.add(&Update { scene: Arc::clone(&self.scene), ..update }, secs, None)?;
        Ok(())
    }

    /// What came of it.
    pub fn finish(self) -> Result<Recomputed, StudioError> {
        let Self { recorder, file, method, .. } = self;
        recorder.finish()?;
        let is_camera = matches!(method, Method::Camera(_));
        Ok(Recomputed { index: RecordingIndex::open(file.path())?, is_camera, _file: file })
    }
}

/// What is to be seen of a frame that algorithms have taken in, but the picture.
fn localized(
    lineup: &mut Lineup,
    index: &mut RecordingIndex,
    number: usize,
    secs: f64,
) -> Result<Update, StudioError> {
    let damaged = || StudioError::input("recording", format!("the input of frame {number} is damaged"));
    let (frame, truth) = index.input(number)?.ok_or_else(damaged)?;
    for contender in lineup.contenders_mut() {
        // A frame that cannot be analyzed is left out, as in a run.
        let _ = contender.step(&frame);
    }
    let contenders = views(lineup);
    let (map, number) = (&lineup.settings().map, number as u64);
    let view = LocalizationView { map, number, secs, frame: &frame, truth, contenders: &contenders };
    let state = view.state(json!({}), None)?.into();
    Ok(Update { scene: Arc::from([]), state, image: Some(view.theories()?.into()) })
}

/// Results beside those of a recording.
#[derive(Debug)]
pub(super) struct Recomputed {
    pub index: RecordingIndex,
    is_camera: bool,
    _file: ScratchFile,
}

impl Recomputed {
    /// The state of a frame with its recorded algorithms, of which `num_kept` stay, and behind them the new ones.
    pub fn lay_over_state(
        &mut self,
        frame: usize,
        recorded: Message,
        num_kept: usize,
    ) -> Result<Message, StudioError> {
        let new = self.index.state(frame)?;
        if self.is_camera {
            return Ok(with_way(&recorded, new)?);
        }
        let mut merged = recorded;
        let others = new.header.get("contenders").and_then(|it| it.as_array()).cloned().unwrap_or_default();
        let num_new = others.len();
        if let Some(all) = merged.header.get_mut("contenders").and_then(|it| it.as_array_mut()) {
            all.truncate(num_kept);
            all.extend(others.into_iter().map(renamed));
        }
        Ok(with_arrays(merged, &new, "individuals", num_kept, num_new)?)
    }

    /// The image of a frame with what the new algorithms expected to see.
    pub fn lay_over_image(
        &mut self,
        frame: usize,
        recorded: &[u8],
        num_kept: usize,
    ) -> Result<Vec<u8>, StudioError> {
        let Some(new) = self.index.image(frame)? else { return Ok(recorded.to_vec()) };
        if self.is_camera {
            return Ok(with_picture(&Message::read(recorded)?, Message::read(&new)?));
        }
        let num_new = crate::recording::row_of(&self.index.short_state(frame)?.header).lanes.len();
        let merged =
            with_arrays(Message::read(recorded)?, &Message::read(&new)?, "theory", num_kept, num_new)?;
        Ok(merged.write())
    }
}

/// The new map with the way that was recorded, and the values of both.
fn with_way(recorded: &Message, mut new: Message) -> Result<Message, MessageError> {
    let mut header = Value::Object(recorded.header.clone());
    let values = |message: &Message| {
        message.header.get("values").and_then(Value::as_array).cloned().unwrap_or_default()
    };
    let both = values(recorded).into_iter().zip(values(&new)).map(|(mut a, mut b)| {
        if let (Some(a), Some(b)) = (a.as_array_mut(), b.as_array_mut()) {
            a.append(b);
        }
        a
    });
    lay_over(&mut header, &json!({ "values": both.collect::<Vec<_>>() }));
    for key in ["facts", "is_lost"] {
        lay_over(&mut header, &json!({ key: new.header.get(key) }));
    }
    let Value::Object(header) = header else { return Ok(new) };
    new.header = header;
    let mut builder = new.into_builder();
    let way = recorded.floats("trajectory").unwrap_or_default();
    builder.floats("recorded", way.into_iter().map(f64::from));
    Message::read(&builder.finish())
}

/// What the new run saw, over the recorded picture.
fn with_picture(recorded: &Message, mut new: Message) -> Vec<u8> {
    new.header.clone_from(&recorded.header);
    new.with_bytes("jpeg", recorded.bytes("jpeg").unwrap_or_default(), &[])
}

/// What the new ones are called beside the recorded ones.
pub(super) fn renamed_name(name: &str) -> String {
    format!("{name}, again")
}

fn renamed(mut contender: serde_json::Value) -> serde_json::Value {
    if let Some(name) = contender.get("name").and_then(|name| name.as_str()).map(renamed_name) {
        contender["name"] = name.into();
    }
    contender
}

/// A message with the numbered arrays of another one, from a number on.
fn with_arrays(
    to: Message,
    from: &Message,
    prefix: &str,
    first: usize,
    count: usize,
) -> Result<Message, MessageError> {
    let mut builder = to.into_builder();
    for i in 0..count {
        let values = from.floats(&format!("{prefix}{i}")).unwrap_or_default();
        builder.floats(&format!("{prefix}{}", first + i), values.into_iter().map(f64::from));
    }
    Message::read(&builder.finish())
}
