//! What a picture of a surface shows.

use crate::{Grid, PoseMark};

/// Values over the ground as heights.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePicture {
    /// Large, at the top.
    pub title: String,
    /// Below the title.
    pub subtitle: String,
    /// Quantity and unit, beside the vertical axis.
    pub value_label: String,
    /// The values. A large grid is drawn with fewer, larger cells, each as high as the highest value in it.
    pub grid: Grid,
    /// Values of the ends of the vertical axis; without it the smallest and the largest.
    pub range: Option<(f64, f64)>,
    /// Places with a name, drawn as pins that stand on the surface.
    pub marks: Vec<PoseMark>,
    /// How far the viewer has walked around the ground counter-clockwise, from the side of negative y, degrees, 0 to 90.
    pub azimuth_deg: f64,
    /// How steeply the viewer looks down, degrees, 0 to 90.
    pub elevation_deg: f64,
}

impl Default for SurfacePicture {
    /// Nothing, seen from a corner.
    fn default() -> Self {
        Self {
            title: String::new(),
            subtitle: String::new(),
            value_label: String::new(),
            grid: Grid::default(),
            range: None,
            marks: Vec::new(),
            azimuth_deg: 25.0,
            elevation_deg: 40.0,
        }
    }
}
