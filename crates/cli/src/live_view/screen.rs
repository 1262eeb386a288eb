//! Field, numbers and camera side by side.

use visloc_world::{Map, field::Field};

use super::{
    Event,
    camera::camera_rows,
    field::FieldMap,
    panel::{PANEL_COLUMNS, event_lines, status_lines},
};
use crate::run::FrameView;

/// Below this size a terminal shows plain lines instead.
pub const MIN_COLUMNS: usize = 72;
/// The same for the rows.
pub const MIN_ROWS: usize = 18;

/// Between field and panel.
const GAP: &str = "  ";
const MIN_EVENT_LINES: usize = 4;
/// Less than this is too small to recognize anything.
const MIN_CAMERA_ROWS: usize = 9;
/// A full panel of an image with sides of 4 to 3.
const MAX_CAMERA_ROWS: usize = PANEL_COLUMNS * 3 / 8;

/// Draws all lines of the live view.
pub struct Screen {
    field: FieldMap,
}

impl Screen {
    /// A screen for a terminal of a size.
    pub fn new(map: &Map, columns: usize, rows: usize) -> Option<Self> {
        let field = field_of(map)?;
        if columns < MIN_COLUMNS || rows < MIN_ROWS {
            return None;
        }
        let max_columns = columns - PANEL_COLUMNS - GAP.len() - 1;
        Some(Self { field: FieldMap::new(field, max_columns, rows - 2) })
    }

    /// The lines after a frame, always equally many.
    pub fn draw(&self, view: &FrameView<'_>, events: &[Event], real_time_factor: f64) -> Vec<String> {
        let mut panel = status_lines(view, real_time_factor);
        let num_rows = self.field.num_rows().max(panel.len() + MIN_EVENT_LINES);
        let num_free = num_rows - panel.len();
        let camera_height = num_free.saturating_sub(MIN_EVENT_LINES + 2).min(MAX_CAMERA_ROWS);
        let has_camera = camera_height >= MIN_CAMERA_ROWS;
        if has_camera {
            let image = &view.frame.image;
            panel.push(String::new());
            panel.extend(camera_rows(image, camera_height * 8 / 3, camera_height));
        }
        panel.push(String::new());
        panel.extend(event_lines(events, num_rows.saturating_sub(panel.len())));
        let field = self.field.draw(view);
        let blank = " ".repeat(field.first().map_or(0, |row| console::measure_text_width(row)));
        let line = |i: usize| {
            let left = field.get(i).unwrap_or(&blank);
            let right = panel.get(i).map_or("", String::as_str);
            format!("{left}{GAP}{right}")
        };
        (0..num_rows).map(line).collect()
    }
}

fn field_of(map: &Map) -> Option<&Field> {
    match map {
        Map::Field(field) => Some(field),
        _ => None,
    }
}
