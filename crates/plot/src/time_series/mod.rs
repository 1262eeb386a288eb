//! Values over time in stacked panels.

mod draw;
mod input;
mod lines;

pub use draw::time_series;
pub use input::{Mark, Panel, Series, SeriesStyle, Span, TimeSeriesPicture};
