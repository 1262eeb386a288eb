//! Image analysis of a building from inside: borders of doors and of the floor.
//!
//! Source: 2017 section 5.3.1. Data flow: `segments` or `contours` (two detectors) find straight edges -> `label` looks at
//! the colors on both sides, as `light` shows them in white light -> `fusion` joins what belongs together -> [`OfficeAnalyzer`] cuts at the horizon and keeps the
//! pixels where the lines cross a `grid`.

mod analyzer;
mod colors;
mod config;
mod contours;
mod fusion;
mod gray;
mod grid;
mod label;
mod light;
mod segment;
mod segments;

pub use analyzer::OfficeAnalyzer;
pub use colors::{OfficeColors, OfficeTable, SurfaceClass};
pub use config::{OfficeAnalysisConfig, OfficeFilters, SegmentDetector};
pub use contours::ContourDetector;
pub use label::Labelled;
pub use segment::EdgeSegment;
pub use segments::GradientDetector;
