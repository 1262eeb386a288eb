//! A building with its theoretical lines and what can be seen from where. Worked out once, shared by all models.

use nalgebra::Point2;
use visloc_world::office::Office;

use super::{
    index::{SightIndex, faces, is_seen},
    lines::{TheoreticalLine, theoretical_lines},
    sector::Sector,
    view::View,
};

/// A building, its lines and their index.
#[derive(Debug, Clone)]
pub(super) struct Sights {
    pub office: Office,
    pub lines: Vec<TheoreticalLine>,
    pub index: SightIndex,
}

impl Sights {
    /// Lines that are farther away than `range_m` are not looked at.
    pub fn new(office: &Office, range_m: f64) -> Self {
        let lines = theoretical_lines(office);
        Self { office: office.clone(), index: SightIndex::new(office, &lines, range_m), lines }
    }

    /// Whether a line is seen from an eye: certain lines are, if they face it.
    #[inline]
    pub fn is_visible(
        &self,
        eye: &Point2<f64>,
        line: &TheoreticalLine,
        is_certain: bool,
        walls: &[u32],
    ) -> bool {
        if is_certain {
            return faces(eye, line);
        }
        is_seen(eye, line, walls.iter().map(|i| &self.office.walls()[*i as usize]))
    }

    /// Visits the lines before the camera of a robot at this place, as far as they are not beside an image of so many pixels
    /// with a margin, with their ends in undistorted pixels.
    #[inline]
    pub fn visit_seen(
        &self,
        robot: &Point2<f64>,
        view: &View,
        (width_px, margin_px): (f64, f64),
        mut visit: impl FnMut(&TheoreticalLine, &[Point2<f64>; 2]),
    ) {
        self.index.visit_in_sector(robot, &Sector::new(view, width_px, margin_px), |entry, walls| {
            let line = &self.lines[entry.line as usize];
            if faces(&view.eye, line)
                && let Some(ends) = view.project(line)
                && self.is_visible(&view.eye, line, entry.is_certain, walls)
            {
                visit(line, &ends);
            }
        });
    }
}
