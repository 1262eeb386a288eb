//! One update after the other.

use std::sync::Arc;

use serde_json::Value;
use visloc_studio::{
    Message, MessageError, Update,
    recording::{Row, row_of},
};

use super::{
    camera, events, numbers as table,
    plots::{self, Plot},
    read::{lanes, numbers, text},
    robot, space, world,
};
use crate::{Entry, Layout};

/// When something is to be seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Number of the frame, from 0.
    pub frame: u32,
    /// Since the first frame.
    pub secs: f64,
}

/// Turns updates into shapes.
#[derive(Debug, Default)]
pub struct Converter {
    scene: Option<Scene>,
    image: Option<Arc<[u8]>>,
    moments: Vec<Moment>,
    rows: Vec<Row>,
}

/// What stays.
#[derive(Debug)]
struct Scene {
    bytes: Arc<[u8]>,
    lanes: Vec<String>,
    plots: Vec<Plot>,
    layout: Layout,
}

impl Converter {
    /// One that has seen nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// The layout for what has been seen; `None` before the first update.
    pub fn layout(&self) -> Option<&Layout> {
        self.scene.as_ref().map(|scene| &scene.layout)
    }

    /// What there is to see of an update, `secs` after the first one.
    ///
    /// # Errors
    /// If it holds bytes that are no messages.
    pub fn update(&mut self, update: &Update, secs: f64) -> Result<(Moment, Vec<Entry>), MessageError> {
        let state = Message::read(&update.state)?;
        let moment = Moment { frame: u32::try_from(self.rows.len()).unwrap_or(u32::MAX), secs };
        let mut entries = self.follow_scene(update, &state)?;
        let Some(scene) = &self.scene else { return Ok((moment, entries)) };
        let row = Row { secs, ..row_of(&state.header) };
        let is_robot = !scene.lanes.is_empty();
        if is_robot {
            entries.extend(robot::entries(&state, &scene.lanes, &row, self.rows.last()));
            entries.extend(plots::entries(&scene.plots, plots::robot_values(&row)));
        } else {
            entries.extend(space::entries(&state));
            entries.extend(plots::entries(&scene.plots, plots::scene_values(&row)));
        }
        entries.push(table::entry(&state));
        if let Some(bytes) = update.image.as_ref().filter(|bytes| self.image.as_ref() != Some(bytes)) {
            let image = Message::read(bytes)?;
            let shown = if is_robot { camera::robot(&image, &scene.lanes) } else { camera::features(&image) };
            entries.extend(shown);
            self.image = Some(Arc::clone(bytes));
        }
        self.moments.push(moment);
        self.rows.push(row);
        Ok((moment, entries))
    }

    /// Kidnaps, losses, finds and jumps of all that has been seen.
    pub fn events(&self) -> Vec<(Moment, Entry)> {
        events::entries(&self.moments, &self.rows)
    }

    /// What a new scene has to show for the whole recording.
    fn follow_scene(&mut self, update: &Update, state: &Message) -> Result<Vec<Entry>, MessageError> {
        if self.scene.as_ref().is_some_and(|scene| scene.bytes == update.scene) {
            return Ok(Vec::new());
        }
        let message = Message::read(&update.scene)?;
        let lanes = lanes(&state.header);
        let (plots, histories) = if lanes.is_empty() {
            (plots::of_scene(&message), Vec::new())
        } else {
            (plots::of_robot(&lanes), robot::histories(&lanes))
        };
        let places: Vec<_> = plots.iter().map(|plot| plot.place.clone()).collect();
        let header = Value::Object(message.header.clone());
        let title = text(&header, "title").unwrap_or("World");
        let image = update.image.as_ref().map(|bytes| Message::read(bytes)).transpose()?;
        let image_size = image.and_then(|image| numbers(image.header.get("size_px")));
        let layout = Layout::new(title, world::bounds(&message), image_size, histories, &places);
        let mut entries = world::entries(&message);
        entries.push(camera::classes(&message));
        entries.extend(plots.iter().map(Plot::curves));
        self.scene = Some(Scene { bytes: Arc::clone(&update.scene), lanes, plots, layout });
        Ok(entries)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;
    use visloc_studio::{MessageBuilder, MessageKind};

    use super::*;
    use crate::Shape;

    fn bytes(kind: MessageKind, header: &Value) -> Arc<[u8]> {
        MessageBuilder::new(kind, header).unwrap().finish().into()
    }

    fn scene() -> Arc<[u8]> {
        let goal =
            json!({ "color": "#f2c521", "x_m": 3.0, "post_y_m": 0.7, "radius_m": 0.05, "height_m": 0.8 });
        let world = json!({
            "kind": "field", "bounds_m": [-3.7, -2.7, 3.7, 2.7], "line_width_m": 0.05, "circle_radius_m": 0.6,
            "lines": [[-3.0, -2.0, 3.0, -2.0]], "marks": [], "goals": [goal],
        });
        bytes(MessageKind::Scene, &json!({ "title": "Tour", "world": world, "drop_reasons": ["small"] }))
    }

    fn state(x: f64, reliability: f64, height_m: f64) -> Arc<[u8]> {
        let contender = json!({
            "name": "mc", "pose": [x, 0.0, 0.0], "reliability": reliability, "is_localized": reliability > 0.6,
            "hypotheses": [[x, 0.0, 0.0, 0.9], [1.0, 1.0, 0.0, 0.1]], "error": [0.1, 2.0], "quality": 0.5,
            "ms": { "image": 1.0, "pose": 0.5 },
        });
        let truth = json!({ "pose": [x, 0.1, 0.0], "height_m": height_m });
        let header = json!({ "truth": truth, "camera": [0.0, 0.8], "contenders": [contender] });
        let mut message = MessageBuilder::new(MessageKind::State, &header).unwrap();
        message.floats("individuals0", [x, 0.0, 0.0, 0.5, 0.0]);
        message.finish().into()
    }

    fn shapes<'a>(entries: &'a [Entry], path: &str) -> Vec<&'a Shape> {
        entries.iter().filter(|entry| entry.path == path).map(|entry| &entry.shape).collect()
    }

    #[test]
    fn the_world_is_said_once_and_ways_grow() {
        let (mut converter, scene) = (Converter::new(), scene());
        let mut add = |x: f64, height_m: f64, secs: f64| {
            let update = Update { scene: Arc::clone(&scene), state: state(x, 0.9, height_m), image: None };
            converter.update(&update, secs).unwrap().1
        };
        let first = add(0.0, 0.0, 0.0);
        assert_eq!(shapes(&first, "world/map/goal0").len(), 1);
        assert!(shapes(&first, "world/mc/way").is_empty());
        let second = add(0.1, 0.0, 0.1);
        assert!(shapes(&second, "world/map/ground").is_empty());
        let [Shape::Lines { strips, .. }] = shapes(&second, "world/mc/way")[..] else { panic!() };
        assert_eq!(strips[0].len(), 2);
        assert_eq!(shapes(&second, "world/truth/way").len(), 1);
        // Carried, and put down far away: neither is a way.
        let lifted = add(0.2, 0.3, 0.2);
        assert!(shapes(&lifted, "world/truth/way").is_empty());
        let elsewhere = add(2.0, 0.0, 0.3);
        assert!(shapes(&elsewhere, "world/mc/way").is_empty());
        let Some(Shape::Values(errors)) = shapes(&elsewhere, "plots/position-error").first().copied() else {
            panic!()
        };
        assert_eq!(errors[..], [0.1]);
        assert!(converter.layout().is_some());
    }

    #[test]
    fn a_ring_shrinks_with_the_reliability_and_events_are_found() {
        let (mut converter, scene) = (Converter::new(), scene());
        let mut radii = Vec::new();
        for (i, reliability) in [0.0, 0.9, 0.9, 0.9].into_iter().enumerate() {
            let update =
                Update { scene: Arc::clone(&scene), state: state(0.0, reliability, 0.0), image: None };
            let (moment, entries) = converter.update(&update, i as f64).unwrap();
            assert_eq!((moment.frame as usize, moment.secs), (i, i as f64));
            let [Shape::Lines { strips, .. }] = shapes(&entries, "world/mc/pose")[..] else { panic!() };
            radii.push((strips[0][0][0], strips.len()));
        }
        assert!(radii[0].0 > radii[1].0 && radii[0].1 > radii[1].1, "{radii:?}");
        let events = converter.events();
        assert_eq!(events.len(), 1);
        assert_eq!(events[0].0.frame, 1);
    }

    #[test]
    fn a_camera_without_a_map_has_its_own_plots() {
        let plots = json!([{ "title": "Position error", "unit": "m", "series": ["error"] }]);
        let world = json!({ "kind": "space", "bounds_m": [-1.0, -1.0, 1.0, 1.0], "floor_m": -1.0 });
        let scene = bytes(MessageKind::Scene, &json!({ "title": "Room", "world": world, "plots": plots }));
        let header =
            json!({ "values": [[null]], "facts": [["State", "starting"]], "is_lost": false, "number": 0 });
        let mut message = MessageBuilder::new(MessageKind::State, &header).unwrap();
        message.floats("landmarks", [1.0, 2.0, 3.0]);
        message.floats("trajectory", (0..9).map(f64::from));
        let update = Update { scene, state: message.finish().into(), image: None };
        let (_, entries) = Converter::new().update(&update, 0.0).unwrap();
        let [Shape::Curves(_), Shape::Values(values)] = shapes(&entries, "plots/position-error")[..] else {
            panic!()
        };
        assert!(values[0].is_nan());
        let [Shape::Points { places, .. }] = shapes(&entries, "world/slam/landmarks")[..] else { panic!() };
        assert_eq!(places[..], [[1.0, 2.0, 3.0]]);
        let [Shape::Lines { strips, .. }] = shapes(&entries, "world/slam/way")[..] else { panic!() };
        assert_eq!(strips[0].len(), 3);
        let [Shape::Markdown(text)] = shapes(&entries, "numbers")[..] else { panic!() };
        assert!(text.contains("| State | starting |"));
    }

    #[test]
    fn damaged_messages_are_refused() {
        let update = Update { scene: [1].as_slice().into(), state: [2].as_slice().into(), image: None };
        assert!(Converter::new().update(&update, 0.0).is_err());
    }
}
