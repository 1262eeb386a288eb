//! Curves over time.

use serde_json::Value;
use visloc_studio::{Message, recording::Row};

use super::read::{list, slug, text};
use crate::{Color, Entry, Shape, layout::PlotPlace};

/// A plot and the names of its curves.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plot {
    pub place: PlotPlace,
    curves: Vec<(String, Color)>,
}

impl Plot {
    fn new(title: &str, unit: &str, range: Option<[f64; 2]>, curves: Vec<(String, Color)>) -> Self {
        let path = format!("plots/{}", slug(title));
        let title = if unit.is_empty() { title.to_owned() } else { format!("{title}, {unit}") };
        Self { place: PlotPlace { title, path, range }, curves }
    }

    /// Names and colors of the curves, for the whole recording.
    pub fn curves(&self) -> Entry {
        Entry::always(&*self.place.path, Shape::Curves(self.curves.clone()))
    }
}

/// Plots of algorithms on a known map.
pub(super) fn of_robot(lanes: &[String]) -> Vec<Plot> {
    let each = |_: &str| -> Vec<(String, Color)> {
        lanes.iter().enumerate().map(|(i, lane)| (lane.clone(), Color::lane(i))).collect()
    };
    let ms = lanes.iter().enumerate().flat_map(|(i, lane)| {
        [(format!("{lane}: all"), Color::lane(i)), (format!("{lane}: image"), Color::lane(i).dimmed(0.6))]
    });
    let share = Some([0.0, 1.0]);
    vec![
        Plot::new("Position error", "m", None, each("error")),
        Plot::new("Reliability", "", share, each("reliability")),
        Plot::new("Image quality", "", share, each("quality")),
        Plot::new("Time", "ms", None, ms.collect()),
    ]
}

/// Values of all plots of [`of_robot`].
pub(super) fn robot_values(row: &Row) -> Vec<Vec<f64>> {
    let each = |value: &dyn Fn(&visloc_studio::recording::Lane) -> f64| row.lanes.iter().map(value).collect();
    let ms = row.lanes.iter().flat_map(|lane| [lane.ms[0] + lane.ms[1], lane.ms[0]]);
    vec![
        each(&|lane| lane.error_m.unwrap_or(f64::NAN)),
        each(&|lane| lane.reliability),
        each(&|lane| lane.quality),
        ms.collect(),
    ]
}

/// Plots that the scene itself names.
pub(super) fn of_scene(scene: &Message) -> Vec<Plot> {
    let plot = |plot: &Value| {
        let names = list(plot.get("series")).filter_map(Value::as_str);
        let curves = names.enumerate().map(|(i, name)| (name.to_owned(), Color::lane(i + 1)));
        let title = text(plot, "title").unwrap_or("values");
        Plot::new(title, text(plot, "unit").unwrap_or_default(), None, curves.collect())
    };
    list(scene.header.get("plots")).map(plot).collect()
}

/// Values of all plots of [`of_scene`].
pub(super) fn scene_values(row: &Row) -> Vec<Vec<f64>> {
    row.values.iter().map(|plot| plot.iter().map(|value| value.unwrap_or(f64::NAN)).collect()).collect()
}

/// The values of a moment.
pub(super) fn entries(plots: &[Plot], values: Vec<Vec<f64>>) -> impl Iterator<Item = Entry> {
    plots.iter().zip(values).map(|(plot, values)| Entry::now(&*plot.place.path, Shape::Values(values)))
}
