//! Shows a recording.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use serde_json::{Value, json};
use visloc_core::Clock;
use visloc_locate::lineup::MAX_ALGORITHMS;

use super::{
    draft::{Clocks, Draft},
    recompute::{Recompute, Recomputed, renamed_name},
};
use crate::{
    Command, Message, MessageBuilder, MessageKind, Session, StudioError, Update,
    message::lay_over,
    playback::Playback,
    recording::{Lane, RecordingError, RecordingIndex, Row, annotate, row_of},
};

/// Frames are at least so far apart when a recording is played, seconds.
const MIN_STEP_SECS: f64 = 1e-3;
/// A gap in a recording is waited for no longer than this, seconds.
const MAX_STEP_SECS: f64 = 1.0;
/// Frames that are computed again before the next picture.
const FRAMES_A_STEP: usize = 8;

/// A recording that is played, stepped and scrubbed, and computed again with other parameters.
pub struct Replay {
    path: PathBuf,
    folder: PathBuf,
    clocks: Clocks,
    id: String,
    label: String,
    scenes: Value,
    index: RecordingIndex,
    rows: Vec<Row>,
    frame: usize,
    playback: Playback,
    /// Scene of a frame; forgotten when anything in it changes.
    scene: Option<(usize, Arc<[u8]>)>,
    /// Algorithms and parameters for computing it again; none if the recording does not say what it was made with.
    draft: Option<Draft>,
    computing: Option<Recompute>,
    recomputed: Option<Recomputed>,
    recorded_rows: Vec<Row>,
    /// Algorithms that were computed again.
    num_new: usize,
}

impl Replay {
    /// Opens a recording; `id` and `scenes` are told to the pages.
    ///
    /// # Errors
    /// If it is none or cannot be read.
    pub fn open(path: &Path, id: &str, scenes: Value) -> Result<Self, StudioError> {
        let mut index = RecordingIndex::open(path)?;
        let rows = rows_of(&mut index)?;
        let damage = index.damage().map_or("", |_| " (incomplete)");
        let label = path.file_name().map(|name| name.to_string_lossy().into_owned() + damage);
        // Settings of another version are told when somebody wants to compute with them.
        let draft = Draft::of_scene(&index.scene(0)?.header);
        Ok(Self {
            path: path.to_path_buf(),
            folder: std::env::temp_dir(),
            clocks: Clocks { robot: Clock::still(), camera: Clock::still() },
            id: id.to_owned(),
            label: label.unwrap_or_default(),
            scenes,
            recorded_rows: rows.clone(),
            rows,
            index,
            frame: 0,
            playback: Playback::default(),
            scene: None,
            draft,
            computing: None,
            recomputed: None,
            num_new: 0,
        })
    }

    /// Where results of computing again are kept meanwhile, instead of the system's folder for such files; and the clocks that
    /// measure algorithms and the stages of SLAM.
    #[must_use]
    pub fn with_scratch(self, folder: &Path, robot: Clock, camera: Clock) -> Self {
        Self { folder: folder.to_path_buf(), clocks: Clocks { robot, camera }, ..self }
    }

    /// How many frames it has.
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
        // Nobody takes what was recorded into their hands, and parameters that nothing is computed with are not to be set.
        for key in ["has_hands", "is_brief", "pipeline", "presets", "preset"] {
            header.remove(key);
        }
        let mut header = Value::Object(header);
        if let Some(draft) = &self.draft {
            lay_over(&mut header, &draft.scene_fields()?);
        }
        let names: Vec<&str> = self.rows[self.frame].lanes.iter().map(|lane| lane.name.as_str()).collect();
        let recording = json!({
            "label": self.label,
            "lanes": names,
            "annotations": annotate(&self.rows),
            "can_recompute": self.draft.is_some() && self.index.has_input(),
            "is_recomputed": self.recomputed.is_some(),
        });
        lay_over(&mut header, &json!({ "recording": recording }));
        if self.recomputed.is_some() {
            double_series(&mut header);
        }
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
        let pose = |row: &Row, lane: usize| row.lanes.get(lane).map_or([f64::NAN; 3], |lane| lane.pose);
        message.floats("places", rows.iter().flat_map(|row| row.truth.unwrap_or([f64::NAN; 3])));
        for lane in 0..self.rows[self.frame].lanes.len() {
            message.floats(&format!("lane{lane}"), rows.iter().flat_map(|row| lane_values(row, lane)));
            message.floats(&format!("pose{lane}"), rows.iter().flat_map(|row| pose(row, lane)));
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

    fn state_message(&mut self, more: Option<&Value>) -> Result<Vec<u8>, StudioError> {
        let mut state: Message = self.index.state(self.frame)?;
        let num_kept = self.num_kept();
        if let Some(recomputed) = &mut self.recomputed {
            state = recomputed.lay_over_state(self.frame, state, num_kept)?;
        }
        for key in ["controls", "notice", "recorder"] {
            state.header.remove(key);
        }
        let progress = self.computing.as_ref().map(Recompute::progress);
        let mut now = json!({
            "number": self.frame,
            "num_frames": self.num_frames(),
            "recomputing": progress.map(|(done, all)| json!({ "done": done, "all": all })),
        });
        lay_over(&mut now, &self.playback.fields());
        lay_over(&mut now, more.unwrap_or(&Value::Null));
        if let Value::Object(now) = now {
            state.header.extend(now);
        }
        Ok(state.write())
    }

    fn image_message(&mut self) -> Result<Option<Arc<[u8]>>, StudioError> {
        let Some(image) = self.index.image(self.frame)? else { return Ok(None) };
        let num_kept = self.num_kept();
        Ok(Some(match &mut self.recomputed {
            Some(recomputed) => recomputed.lay_over_image(self.frame, &image, num_kept)?.into(),
            None => image.into(),
        }))
    }

    /// How many recorded algorithms are shown beside the new ones.
    fn num_kept(&self) -> usize {
        let num_recorded = self.recorded_rows[self.frame].lanes.len();
        let num_shown = self.rows[self.frame].lanes.len();
        let num_new = self.recomputed.as_ref().map_or(0, |_| self.num_new);
        num_recorded.min(num_shown.saturating_sub(num_new))
    }

    fn recompute(&mut self, seed: u64) -> Result<(), StudioError> {
        let draft = self.draft.as_mut().ok_or_else(|| {
            StudioError::command(
                "recompute",
                "a recording that says what it was made with",
                "another one, or one of another version",
            )
        })?;
        draft.set_seed(seed)?;
        let mut index = RecordingIndex::open(&self.path)?;
        let method = draft.start(&mut index, &self.clocks)?;
        self.drop_recomputed();
        let file = format!(".recomputed-{}-{}.mcap", std::process::id(), self.id);
        let out = self.folder.join(file);
        self.computing = Some(Recompute::start(index, method, out)?);
        self.playback.pause();
        Ok(())
    }

    /// Back to what was recorded.
    fn drop_recomputed(&mut self) {
        (self.computing, self.recomputed, self.scene) = (None, None, None);
        self.rows.clone_from(&self.recorded_rows);
    }

    fn compute_on(&mut self) -> Result<(), StudioError> {
        let Some(computing) = &mut self.computing else { return Ok(()) };
        match computing.advance(FRAMES_A_STEP) {
            Ok(false) => return Ok(()),
            Ok(true) => {}
            Err(error) => {
                self.computing = None;
                return Err(error);
            }
        }
        let Some(computing) = self.computing.take() else { return Ok(()) };
        let mut recomputed = computing.finish()?;
        for (row, new) in self.rows.iter_mut().zip(rows_of(&mut recomputed.index)?) {
            row.lanes.truncate(MAX_ALGORITHMS - new.lanes.len().min(MAX_ALGORITHMS));
            self.num_new = new.lanes.len();
            for (values, more) in row.values.iter_mut().zip(new.values) {
                values.extend(more);
            }
            if new.lanes.is_empty() {
                row.is_lost = new.is_lost;
            }
            row.lanes
                .extend(new.lanes.into_iter().map(|lane| Lane { name: renamed_name(&lane.name), ..lane }));
        }
        (self.recomputed, self.scene) = (Some(recomputed), None);
        Ok(())
    }
}

/// Plots of a recording that was computed again show both: after the recorded series their counterparts.
fn double_series(header: &mut Value) {
    let plots = header.get_mut("plots").and_then(Value::as_array_mut).into_iter().flatten();
    for series in plots.filter_map(|plot| plot.get_mut("series")?.as_array_mut()) {
        let more: Vec<Value> =
            series.iter().filter_map(Value::as_str).map(|name| renamed_name(name).into()).collect();
        series.extend(more);
    }
}

/// All frames in short.
fn rows_of(index: &mut RecordingIndex) -> Result<Vec<Row>, RecordingError> {
    (0..index.num_frames()).map(|frame| Ok(row_of(&index.short_state(frame)?.header))).collect()
}

impl Session for Replay {
    fn handle(&mut self, command: &Command) -> Result<(), StudioError> {
        match command {
            Command::Play {} => {
                // From the end it begins again.
                if self.frame == self.last() {
                    self.frame = 0;
                }
                self.playback.play();
            }
            Command::Step {} => {
                self.playback.pause();
                self.frame = (self.frame + 1).min(self.last());
            }
            Command::Seek { frame } => {
                self.playback.pause();
                self.frame = (*frame).min(self.last());
            }
            Command::Reset { .. } => self.frame = 0,
            Command::Recompute { seed } => self.recompute(*seed)?,
            Command::Recorded {} => self.drop_recomputed(),
            command if self.playback.handle(command)? => {}
            command => {
                if let Some(draft) = &mut self.draft
                    && draft.handle(command)?
                {
                    self.scene = None;
                    return Ok(());
                }
                return Err(StudioError::command("command", "one for a recording", command.name()));
            }
        }
        Ok(())
    }

    fn step_secs(&self) -> Option<f64> {
        if self.computing.is_some() {
            return Some(0.0);
        }
        let next = self.rows.get(self.frame + 1)?;
        let secs = (next.secs - self.rows[self.frame].secs).clamp(MIN_STEP_SECS, MAX_STEP_SECS);
        self.playback.wait_secs(secs)
    }

    fn step(&mut self) -> Result<(), StudioError> {
        if self.computing.is_some() {
            return self.compute_on();
        }
        self.frame = (self.frame + 1).min(self.last());
        if self.frame == self.last() {
            self.playback.pause();
        }
        Ok(())
    }

    fn update(&mut self, more: Option<&Value>) -> Result<Update, StudioError> {
        let scene = self.scene_message()?;
        let state = self.state_message(more)?.into();
        let image = self.image_message()?;
        Ok(Update { scene, state, image })
    }
}
