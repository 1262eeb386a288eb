//! Updates of a running system.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};
use visloc_core::{
    CameraPose, CameraTrajectory, Timestamp,
    geom::{Camera, CameraFrame, Rigid3, World},
};
use visloc_slam::{Slam, SlamFrame, StageTimes};
use visloc_vmap::LOCALIZED_RELIABILITY;

use super::{
    display::Display,
    moment::{Parts, SlamMoment},
    shapes::{camera_axes, candidates, keyframes, landmarks, links, missed, trajectory, xyz},
    told::{Place, Told},
};
use crate::{MessageBuilder, MessageKind, StudioError, Update, message::lay_over};

/// Floor around the first place that is shown without the truth, map units.
const HALF_FLOOR: f64 = 3.0;
/// Floor around the truth, meters.
const MARGIN_M: f64 = 2.5;
/// Links are looked for anew after so many frames.
const LINKS_EVERY: u64 = 10;

/// Shows a system at work.
#[derive(Debug)]
pub struct SlamViewer {
    camera: Camera,
    title: String,
    display: Display,
    /// What the scene message has besides.
    more: Value,
    scene: Option<Arc<[u8]>>,
    links: Vec<f64>,
    first_at: Option<Timestamp>,
    number: u64,
    mapping: StageTimes,
    /// In a map of an earlier session: the floor.
    bounds: Option<([f64; 4], f64)>,
}

impl SlamViewer {
    /// Shows a system for a camera. `more` is a table that is laid over the scene message.
    pub fn new(camera: &Camera, title: &str, truth: Option<CameraTrajectory>, more: Value) -> Self {
        Self {
            camera: *camera,
            title: title.to_owned(),
            display: Display::new(truth),
            more,
            scene: None,
            links: Vec::new(),
            first_at: None,
            number: 0,
            mapping: StageTimes::default(),
            bounds: None,
        }
    }

    /// Shows a camera in a map of an earlier session, with a floor: least x and y, largest x and y, and height.
    pub(super) fn in_map(
        camera: &Camera,
        title: &str,
        display: Display,
        floor: ([f64; 4], f64),
        more: Value,
    ) -> Self {
        Self { display, bounds: Some(floor), ..Self::new(camera, title, None, more) }
    }

    /// Another table is laid over the scene message from now on.
    pub(super) fn change_scene(&mut self, more: Value) {
        (self.more, self.scene) = (more, None);
    }

    /// A place of the map as it is shown.
    pub(super) fn shown(&self, place_in_map: &Vector3<f64>) -> Point3<f64> {
        self.display.point(&Point3::from(*place_in_map))
    }

    /// The system begins anew; numbers of frames and time go on. `more` is laid over the scene message instead of what was.
    pub fn start_anew(&mut self, truth: Option<CameraTrajectory>, more: Value) {
        (self.display, self.more, self.scene) = (Display::new(truth), more, None);
        self.links.clear();
    }

    /// One more place of the truth, where it is told with the images.
    pub(super) fn add_truth(&mut self, pose: CameraPose) {
        self.display.add_truth(pose);
    }

    /// Another truth from now on, of a camera that somebody carries elsewhere.
    pub fn set_truth(&mut self, truth: CameraTrajectory) {
        self.display.set_truth(truth);
    }

    /// What is shown.
    pub(super) fn title(&self) -> &str {
        &self.title
    }

    /// Frames that were taken in.
    pub(super) fn num_frames(&self) -> u64 {
        self.first_at.map_or(0, |_| self.number + 1)
    }

    /// Where the camera was and will be, if that is known.
    pub(super) fn truth(&self) -> Option<&CameraTrajectory> {
        self.display.truth()
    }

    /// Where the camera was, if that is known.
    pub fn world_from_camera(&self, at: Timestamp) -> Option<&Rigid3<World, CameraFrame>> {
        self.display.truth_at(at).map(|pose| &pose.world_from_camera)
    }

    /// Seconds from the first frame to this one.
    pub fn secs(&self, at: Timestamp) -> f64 {
        self.first_at.map_or(0.0, |first| at.secs_since(first))
    }

    /// Takes in a frame; to be called for each one, shown or not.
    pub fn follow(&mut self, slam: &Slam, frame: &SlamFrame<'_>) {
        self.number += u64::from(self.first_at.is_some());
        self.first_at.get_or_insert(frame.at);
        self.display.follow(slam);
        if let Some(mapped) = frame.outcome.mapped.last() {
            self.mapping = mapped.times.clone();
        }
    }

    /// Takes out what there is to see of the last frame; `more` is a table that is laid over the state message.
    ///
    /// # Errors
    /// If the scene cannot be encoded.
    pub fn moment(
        &mut self,
        slam: &Slam,
        frame: &SlamFrame<'_>,
        more: &Value,
    ) -> Result<SlamMoment, StudioError> {
        self.moment_of(slam, frame, &Told::of_slam(frame.outcome), more)
    }

    /// The same of what is told of the frame.
    pub(super) fn moment_of(
        &mut self,
        slam: &Slam,
        frame: &SlamFrame<'_>,
        told: &Told<'_>,
        more: &Value,
    ) -> Result<SlamMoment, StudioError> {
        if self.number.is_multiple_of(LINKS_EVERY) {
            self.links = links(slam.map(), &self.display);
        }
        Ok(SlamMoment {
            scene: self.scene_message()?,
            state: self.state_parts(slam, frame, told, more),
            image: self.image_parts(slam, frame, told),
            pixels: frame.image.clone(),
        })
    }

    /// What there is to see before the first image of a source that lets one wait.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn waiting(&mut self, more: &Value) -> Result<Update, StudioError> {
        let mut header = json!({ "number": 0, "secs": 0.0, "is_waiting": true });
        lay_over(&mut header, more);
        let state = MessageBuilder::new(MessageKind::State, &header)?.finish().into();
        Ok(Update { scene: self.scene_message()?, state, image: None })
    }

    fn scene_message(&mut self) -> Result<Arc<[u8]>, StudioError> {
        if let Some(scene) = &self.scene {
            return Ok(Arc::clone(scene));
        }
        let (bounds, floor_m) = self.bounds();
        let plot = |title: &str, unit: &str, series: &[&str], digits: u8| json!({ "title": title, "unit": unit, "series": series, "digits": digits, "least": 0.01 });
        let mut reliability = plot("Reliability", "", &["reliability"], 2);
        lay_over(&mut reliability, &json!({ "fixed": 1, "threshold": LOCALIZED_RELIABILITY }));
        let [second, third] = match self.bounds {
            Some(_) => [
                reliability,
                plot("Searched, found, of the map", "", &["searched", "found", "of the map"], 0),
            ],
            None => [
                plot("Searched, found", "", &["searched", "found"], 0),
                plot("Points, candidates", "", &["landmarks", "candidates"], 0),
            ],
        };
        let mut header = json!({
            "mode": "slam",
            "title": self.title,
            "world": { "kind": "space", "name": self.title, "bounds_m": bounds, "floor_m": floor_m },
            "plots": [
                plot("Position error", "m", &["error"], 3),
                second,
                third,
                plot("Tracking, mapping", "ms", &["tracking", "mapping"], 2),
            ],
        });
        lay_over(&mut header, &self.more);
        let bytes: Arc<[u8]> = MessageBuilder::new(MessageKind::Scene, &header)?.finish().into();
        self.scene = Some(Arc::clone(&bytes));
        Ok(bytes)
    }

    /// Least x and y, largest x and y, and height of the floor that is drawn.
    fn bounds(&self) -> ([f64; 4], f64) {
        let of_truth = |truth: &CameraTrajectory| {
            let places = truth.poses().iter().map(|pose| *pose.world_from_camera.translation());
            let start = ([f64::MAX, f64::MAX, f64::MIN, f64::MIN], f64::MAX);
            let (b, low) = places.fold(start, |(b, low), p| {
                ([b[0].min(p.x), b[1].min(p.y), b[2].max(p.x), b[3].max(p.y)], low.min(p.z))
            });
            ([b[0] - MARGIN_M, b[1] - MARGIN_M, b[2] + MARGIN_M, b[3] + MARGIN_M], (low - 1.0).min(0.0))
        };
        let unknown = ([-HALF_FLOOR, -HALF_FLOOR, HALF_FLOOR, HALF_FLOOR], -1.0);
        self.bounds.unwrap_or_else(|| self.display.truth().map_or(unknown, of_truth))
    }

    fn state_parts(&self, slam: &Slam, frame: &SlamFrame<'_>, told: &Told<'_>, more: &Value) -> Parts {
        let map = slam.map();
        let points = landmarks(map, &self.display);
        let segments = candidates(map, &self.display);
        let cameras = keyframes(map, &self.display);
        let counts = [points.len() / 3, segments.len() / 6, cameras.len() / 12];
        let error_m = self.error_m(frame, told);
        let [tracking_ms, mapping_ms] =
            [&frame.outcome.tracking, &self.mapping].map(|times| times.total_secs() * 1e3);
        let (searched, found) = frame.outcome.matches;
        let values = match told.place {
            Some(Place { reliability, num_of_map, .. }) => {
                json!([[error_m], [reliability], [searched, found, num_of_map], [tracking_ms, mapping_ms]])
            }
            None => {
                json!([[error_m], [searched, found], [counts[0], counts[1]], [tracking_ms, mapping_ms]])
            }
        };
        let mut header = json!({
            "number": self.number,
            "secs": self.secs(frame.at),
            "is_lost": told.is_lost,
            "values": values,
            "facts": self.facts(frame, told, error_m, counts),
        });
        lay_over(&mut header, more);
        let way = match told.place {
            Some(Place { way, .. }) => way.to_vec(),
            None => trajectory(slam, &self.display),
        };
        let mut arrays = vec![
            ("landmarks", points),
            ("candidates", segments),
            ("keyframes", cameras),
            ("links", self.links.clone()),
            ("trajectory", way),
            ("truth", self.truth_so_far(frame.at)),
        ];
        if let Some(world_from_camera) = &told.world_from_camera {
            arrays.push(("camera", camera_axes(world_from_camera, &self.display)));
        }
        Parts { header, arrays }
    }

    fn error_m(&self, frame: &SlamFrame<'_>, told: &Told<'_>) -> Option<f64> {
        let truth = self.display.truth_at(frame.at).filter(|_| self.display.is_aligned())?;
        let place = self.shown(told.world_from_camera.as_ref()?.translation());
        Some((place - Point3::from(*truth.world_from_camera.translation())).norm())
    }

    fn truth_so_far(&self, at: Timestamp) -> Vec<f64> {
        let Some(truth) = self.display.truth().filter(|_| self.display.is_aligned()) else {
            return Vec::new();
        };
        let past = truth.poses().iter().take_while(|pose| pose.at <= at);
        past.flat_map(|pose| xyz(&Point3::from(*pose.world_from_camera.translation()))).collect()
    }

    /// The table of numbers: rows of texts.
    fn facts(
        &self,
        frame: &SlamFrame<'_>,
        told: &Told<'_>,
        error_m: Option<f64>,
        [num_points, num_segments, num_keyframes]: [usize; 3],
    ) -> Vec<Vec<String>> {
        let row = |label: &str, value: String| vec![label.to_owned(), value];
        let mut rows = vec![
            row("State", told.state.clone()),
            row("Frame", self.number.to_string()),
            row("Landmarks", num_points.to_string()),
            row("Candidates", num_segments.to_string()),
            row("Keyframes", num_keyframes.to_string()),
            row("Searched, found", format!("{}, {}", frame.outcome.matches.0, frame.outcome.matches.1)),
            row("Error", error_m.map_or("\u{2013}".to_owned(), |error| format!("{error:.3} m"))),
        ];
        if let Some(Place { reliability, num_of_map, .. }) = told.place {
            rows.insert(1, row("Reliability", format!("{reliability:.2}")));
            rows.push(row("Of the map", num_of_map.to_string()));
        } else if self.display.is_aligned() {
            rows.push(row("Map unit", format!("{:.3} m", self.display.scale())));
        }
        for (part, times) in [("track", &frame.outcome.tracking), ("map", &self.mapping)] {
            let stage =
                |(name, secs): &(&str, f64)| row(&format!("{part}: {name}"), format!("{:.2} ms", secs * 1e3));
            rows.extend(times.stages().iter().map(stage));
        }
        rows
    }

    fn image_parts(&self, slam: &Slam, frame: &SlamFrame<'_>, told: &Told<'_>) -> Parts {
        let header = json!({ "number": self.number, "size_px": [frame.image.width(), frame.image.height()] });
        let features = &frame.outcome.features;
        let places = |wanted: bool| {
            let chosen = features.iter().filter(move |(_, is_converged)| *is_converged == wanted);
            chosen.flat_map(|(px, _)| [px.x, px.y]).collect()
        };
        let mut arrays = vec![("landmarks", places(true)), ("candidates", places(false))];
        if let Some(world_from_camera) = &told.world_from_camera {
            let camera_from_world = world_from_camera.inverse();
            arrays.push(("missed", missed(slam.map(), &self.camera, &camera_from_world, features)));
        }
        Parts { header, arrays }
    }
}
