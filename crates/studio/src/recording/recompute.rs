//! A recording computed again.
//!
//! What comes of it goes to a file, not into memory: recordings may be long. The file has a state for each frame of the recording
//! with the algorithms that ran now, and what they expected to see; [`Replay`](super::Replay) lays it over what was recorded.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use serde_json::json;

use super::{index::RecordingIndex, recorder::Recorder, timeline::row_of};
use crate::{
    Clock, Message, MessageBuilder, MessageKind, StudioError, Update,
    tuning::{Lineup, RunSettings},
    view::LocalizationView,
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
    lineup: Lineup,
    clock: Clock,
    scene: Arc<[u8]>,
    recorder: Recorder,
    file: ScratchFile,
    frame: usize,
}

impl Recompute {
    /// Begins with the first frame of the recording at `path`; results go to the file `out`.
    ///
    /// # Errors
    /// If the recording does not hold its input, a parameter is wrong, or the file cannot be made.
    pub fn start(
        path: &Path,
        settings: RunSettings,
        clock: Clock,
        out: PathBuf,
    ) -> Result<Self, StudioError> {
        let index = RecordingIndex::open(path)?;
        if !index.has_input() {
            return Err(StudioError::command(
                "recompute",
                "a recording with its input (visloc localize --record, or one made in the studio)",
                "none in some of the frames",
            ));
        }
        let lineup = Lineup::new(settings)?;
        let scene = MessageBuilder::new(MessageKind::Scene, &json!({}))?.finish().into();
        let recorder = Recorder::create(&out)?;
        Ok(Self { index, lineup, clock, scene, recorder, file: ScratchFile(out), frame: 0 })
    }

    /// Frames that are done, and all.
    pub fn progress(&self) -> (usize, usize) {
        (self.frame, self.index.num_frames())
    }

    /// Computes some frames; whether all are done.
    ///
    /// # Errors
    /// If the recording cannot be read any more or the results not be written.
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
        let secs = row_of(&self.index.state(self.frame)?.header).secs;
        let (frame, truth) = self.index.input(self.frame)?.ok_or_else(|| {
            StudioError::input("recording", format!("the input of frame {} is damaged", self.frame))
        })?;
        for contender in self.lineup.contenders_mut() {
            // A frame that cannot be analyzed is left out, as in a run.
            let _ = contender.step(&frame, &self.clock);
        }
        let contenders = self.lineup.views();
        let view = LocalizationView {
            map: &self.lineup.settings().map,
            number: self.frame as u64,
            secs,
            frame: &frame,
            truth,
            contenders: &contenders,
        };
        let state = view.state(json!({}), None)?.into();
        let image = Some(view.theories()?.into());
        self.recorder.add(&Update { scene: Arc::clone(&self.scene), state, image }, secs, None)?;
        Ok(())
    }

    /// What came of it.
    ///
    /// # Errors
    /// If the results cannot be completed.
    pub fn finish(self) -> Result<Recomputed, StudioError> {
        let Self { recorder, file, .. } = self;
        recorder.finish()?;
        Ok(Recomputed { index: RecordingIndex::open(file.path())?, _file: file })
    }
}

/// Results beside those of a recording.
#[derive(Debug)]
pub(super) struct Recomputed {
    pub index: RecordingIndex,
    _file: ScratchFile,
}

impl Recomputed {
    /// The state of a frame with its recorded algorithms, of which `num_kept` stay, and behind them the new ones.
    ///
    /// # Errors
    /// If the results cannot be read any more.
    pub fn lay_over_state(
        &mut self,
        frame: usize,
        recorded: Message,
        num_kept: usize,
    ) -> Result<Message, StudioError> {
        let new = self.index.state(frame)?;
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
    ///
    /// # Errors
    /// If the results cannot be read any more.
    pub fn lay_over_image(
        &mut self,
        frame: usize,
        recorded: &[u8],
        num_kept: usize,
    ) -> Result<Vec<u8>, StudioError> {
        let Some(new) = self.index.image(frame)? else { return Ok(recorded.to_vec()) };
        let num_new = super::timeline::row_of(&self.index.state(frame)?.header).lanes.len();
        let merged =
            with_arrays(Message::read(recorded)?, &Message::read(&new)?, "theory", num_kept, num_new)?;
        Ok(merged.write())
    }
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
) -> Result<Message, crate::MessageError> {
    let mut builder = to.into_builder();
    for i in 0..count {
        let values = from.floats(&format!("{prefix}{i}")).unwrap_or_default();
        builder.floats(&format!("{prefix}{}", first + i), values.into_iter().map(f64::from));
    }
    Message::read(&builder.finish())
}
