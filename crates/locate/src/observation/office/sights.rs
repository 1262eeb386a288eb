//! A building with its theoretical lines and what can be seen from where. Worked out once, shared by all models.

use nalgebra::Point2;
use visloc_world::office::Office;

use super::{
    index::SightIndex,
    lines::{TheoreticalLine, theoretical_lines},
    sector::Sector,
    shadows::{faces, part_seen},
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

    /// Visits what is seen before the camera of a robot at this place of the lines that are wanted, as far as it comes into the
    /// window, with its ends in undistorted pixels.
    #[inline]
    pub fn visit_seen(
        &self,
        robot: &Point2<f64>,
        view: &View,
        window: &Window,
        is_wanted: impl Fn(&TheoreticalLine) -> bool,
        mut visit: impl FnMut(&TheoreticalLine, &[Point2<f64>; 2]),
    ) {
        let sector = Sector::new(view, window.size_px.0, window.margin_px);
        self.index.visit_in_sector(robot, &sector, |entry, walls| {
            let line = &self.lines[entry.line as usize];
            if !(is_wanted(line) && faces(&view.eye, line)) {
                return;
            }
            let Some(ends) = view.project(line).filter(|ends| window.may_show(ends)) else { return };
            if entry.is_certain {
                return visit(line, &ends);
            }
            let walls = walls.iter().map(|i| &self.office.walls()[*i as usize]);
            match part_seen(&view.eye, line, walls) {
                Some([0.0, 1.0]) => visit(line, &ends),
                Some(part) => {
                    let line = line.part(part);
                    if let Some(ends) = view.project(&line).filter(|ends| window.may_show(ends)) {
                        visit(&line, &ends);
                    }
                }
                None => {}
            }
        });
    }
}

/// An image and how far beside it lines matter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    /// Width and height, pixels.
    pub size_px: (f64, f64),
    pub margin_px: f64,
}

impl Window {
    /// Whether a projected line may come into it.
    #[inline]
    pub fn may_show(&self, [a, b]: &[Point2<f64>; 2]) -> bool {
        let (width, height) = self.size_px;
        let margin = self.margin_px;
        a.x.max(b.x) > -margin
            && a.x.min(b.x) < width + margin
            && a.y.max(b.y) > -margin
            && a.y.min(b.y) < height + margin
    }
}
