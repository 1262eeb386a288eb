//! What a picture of values over time shows.

use crate::{Color, ReferenceLine, ValueAxis};

/// Panels above each other with one axis of time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TimeSeriesPicture {
    /// Large, at the top.
    pub title: String,
    /// Below the title.
    pub subtitle: String,
    /// Below the horizontal axis, if it is not a time in seconds.
    pub x_label: String,
    /// From top to bottom.
    pub panels: Vec<Panel>,
    /// Shaded in all panels, for instance while the robot is carried.
    pub spans: Vec<Span>,
    /// Vertical lines through all panels, for instance kidnaps.
    pub marks: Vec<Mark>,
    /// Shown range of time, seconds; without it everything is shown.
    pub range_secs: Option<(f64, f64)>,
    /// Height of each panel, pixels; without it 140.
    pub panel_px: Option<f64>,
}

/// One panel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panel {
    /// Quantity and unit, for instance `position error [m]`.
    pub label: String,
    /// Range of the values.
    pub axis: ValueAxis,
    /// Later ones are drawn over earlier ones.
    pub series: Vec<Series>,
    /// Horizontal lines.
    pub references: Vec<ReferenceLine>,
}

/// Values over time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// In the legend. Series of several panels with the same label and color share one entry.
    pub label: String,
    /// Of line or points.
    pub color: Color,
    /// Line or points.
    pub style: SeriesStyle,
    /// Seconds and value in order of time. Not a number breaks the line.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// A line.
    pub fn new(label: &str, color: Color, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.to_owned(), color, style: SeriesStyle::Line, points }
    }
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SeriesStyle {
    /// Connected.
    #[default]
    Line,
    /// A dot for each value.
    Points,
}

/// A shaded span of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Where it starts, seconds.
    pub start_secs: f64,
    /// Where it ends, seconds.
    pub end_secs: f64,
    /// In the legend, once for all spans of the same label.
    pub label: String,
}

/// A moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// When, seconds.
    pub at_secs: f64,
    /// Above the panels.
    pub label: String,
}
