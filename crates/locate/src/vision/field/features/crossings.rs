//! Where scan lines cross a line: the middle between its two borders.

use nalgebra::{Point2, Vector2};

use super::view::GroundView;
use crate::vision::field::{edges::Edge, scan::Direction};

/// How far the middle of a run may lie from the center line, pixels of an image up to 640 px wide.
const CENTER_NOISE_PX: f64 = 0.7;
/// How far the width of a line may be off for other reasons, as a share.
const WIDTH_SLACK: f64 = 0.35;

/// A white run whose both ends passed the filters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// Middle of the run on the ground: on the center line if the run crosses a straight line.
    pub ground: Point2<f64>,
    /// The image of that place, free of distortion.
    pub px: Point2<f64>,
    /// From one end of the run to the other, on the ground, meters.
    pub chord: Vector2<f64>,
    /// Length of the run, pixels.
    pub run_px: f64,
    pub direction: Direction,
    /// Row or column of the scan line, pixels.
    pub line_px: f64,
    /// Luma that is white beside this carpet.
    pub white: u32,
}

impl Crossing {
    /// Width of a line of this direction on the ground that is crossed so, meters.
    pub fn width_m(&self, along: &Vector2<f64>) -> f64 {
        along.perp(&self.chord).abs() / along.norm().max(1e-9)
    }

    /// Whether that is the width of a line, as well as blurred borders and a direction taken from so many pixels tell,
    /// both in pixels of an image up to 640 px wide: `blur` pixels of this image are one.
    pub fn fits_width(&self, along: &Vector2<f64>, along_px: f64, (line_width_m, blur): (f64, f64)) -> bool {
        let ratio = self.width_m(along) / line_width_m;
        let turn = CENTER_NOISE_PX / along_px.max(1.0);
        // Blur makes thin lines wider by a pixel, whole pixels make others narrower by one.
        let pixel = blur * ratio.max(1.0) / self.run_px;
        let slack = WIDTH_SLACK + pixel + turn * self.chord.norm() / line_width_m;
        (ratio - 1.0).abs() < slack
    }
}

/// Collects crossings while the filters go over the borders.
#[derive(Debug, Default)]
pub(super) struct Crossings {
    pub all: Vec<Crossing>,
    /// The first end of a run.
    open: Option<(Point2<f64>, Edge)>,
}

impl Crossings {
    pub fn clear(&mut self) {
        self.all.clear();
        self.open = None;
    }

    /// Takes a border of a line that passed the filters, in the order of the scan lines.
    pub fn add(&mut self, view: &GroundView, edge: &Edge, ideal_px: Point2<f64>, white: u32) {
        if edge.is_start {
            self.open = Some((ideal_px, *edge));
            return;
        }
        let Some((start_px, start)) = self.open.take() else { return };
        if (start.direction, start.run_px, line_px(&start)) != (edge.direction, edge.run_px, line_px(edge)) {
            return;
        }
        let (Some(a), Some(b)) = (view.ground(&start_px), view.ground(&ideal_px)) else { return };
        let ground = nalgebra::center(&a, &b);
        let Some(px) = view.px(&ground) else { return };
        self.all.push(Crossing {
            ground,
            px,
            chord: b - a,
            run_px: f64::from(edge.run_px),
            direction: edge.direction,
            line_px: f64::from(line_px(edge)),
            white,
        });
    }
}

/// Row or column of the scan line of an edge.
fn line_px(edge: &Edge) -> u32 {
    match edge.direction {
        Direction::Vertical => edge.inside_px.0,
        Direction::Horizontal => edge.inside_px.1,
    }
}
