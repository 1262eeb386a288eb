//! Pictures of runs as SVG and PNG: the field from above with paths, time series, heat maps, surfaces, bars and histograms,
//! and what an image analysis found.
//!
//! Every picture is a plain struct that the caller fills with numbers, labels and colors, and one function that
//! turns it into a [`Picture`]:
//!
//! ```
//! use visloc_plot::{Color, Panel, Series, TimeSeriesPicture, time_series};
//!
//! let errors = (0..70).map(|i| (f64::from(i), 0.05)).collect();
//! let picture = time_series(&TimeSeriesPicture {
//!     title: "Office, 70 s".to_owned(),
//!     panels: vec![Panel {
//!         label: "position error [m]".to_owned(),
//!         series: vec![Series::new("particle filter", Color::BLUE, errors)],
//!         ..Panel::default()
//!     }],
//!     ..TimeSeriesPicture::default()
//! });
//! assert!(picture.svg().starts_with("<svg"));
//! ```
//!
//! Not a number breaks a line; empty data gives an empty panel. The same input gives the same bytes. Text in the PNG
//! is drawn with a font that is part of this crate, so it does not depend on the machine.

mod axis;
mod bar_chart;
mod by_hand;
mod chart;
mod color;
mod error;
mod field;
mod font;
mod group_chart;
mod header;
mod heat_map;
mod histogram;
mod image_picture;
mod line_style;
mod picture;
mod run_chart;
mod scatter;
mod space;
mod surface;
mod svg;
mod table;
mod time_series;

pub use axis::ValueAxis;
pub use bar_chart::{Bar, BarChart, bar_chart};
pub use by_hand::{BY_HAND_PAGE, BY_HAND_SCRIPT, BY_HAND_STYLE, by_hand_page};
pub use chart::ReferenceLine;
pub use color::Color;
pub use error::PlotError;
pub use field::{FieldPath, FieldPicture, Ground, Kidnap, PathPoint, field_picture};
pub use group_chart::{BarSeries, Group, GroupChart};
pub use heat_map::{Grid, HeatMap, PoseMark, heat_map};
pub use histogram::{Histogram, HistogramSeries, histogram};
pub use image_picture::{ImageBoxes, ImageDots, ImageLine, ImagePicture, image_picture};
pub use picture::{Picture, is_of_series, remove_earlier};
pub use run_chart::{RunChart, run_chart};
pub use scatter::{ScatterPicture, ScatterSeries, scatter};
pub use space::{SpacePath, SpaceShape, SpaceViews, space_views};
pub use surface::surface_picture;
pub use svg::base64;
pub use table::{Table, escaped};
pub use time_series::{Mark, Panel, Series, SeriesStyle, Span, TimeSeriesPicture, time_series};
