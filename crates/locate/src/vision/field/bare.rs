//! Patches of ground that show nothing but carpet: no line of the map can be there.

use nalgebra::Point2;
use visloc_core::geom::Camera;

use super::{
    cells::GROUND_IS_OTHER,
    scan::{Run, ScanLine},
};
use crate::vision::{BareGround, color::ColorClass};

/// What scan lines show of each patch of an image.
#[derive(Debug, Default)]
pub(super) struct BarePatches {
    patch_px: u32,
    width: usize,
    /// Pixels of the carpet's color and all that were looked at, row by row.
    counts: Vec<(u32, u32)>,
    is_bare: Vec<bool>,
}

impl BarePatches {
    /// Begins an image.
    pub fn begin(&mut self, (width_px, height_px): (u32, u32), patch_px: u32) {
        self.patch_px = patch_px.max(1);
        self.width = width_px.div_ceil(self.patch_px) as usize;
        self.counts.clear();
        self.counts.resize(self.width * height_px.div_ceil(self.patch_px) as usize, (0, 0));
    }

    /// Takes in a scan line.
    pub fn add(&mut self, line: &ScanLine, runs: &[Run]) {
        for run in runs {
            let is_carpet = u32::from(run.class == ColorClass::Green);
            let mut from = run.start;
            while from < run.end {
                let to = run.end.min((from / self.patch_px + 1) * self.patch_px);
                let (column, row) = line.pixel(from);
                let patch = (row / self.patch_px) as usize * self.width + (column / self.patch_px) as usize;
                let (carpet, all) = &mut self.counts[patch];
                *carpet += is_carpet * (to - from);
                *all += to - from;
                from = to;
            }
        }
    }

    /// The patches below a row that show nothing but carpet, with all around them.
    pub fn finish(&mut self, camera: &Camera, first_row_px: u32, bare: &mut BareGround) {
        bare.patch_px = f64::from(self.patch_px);
        bare.middles.clear();
        // Single pixels of noise are less than a line.
        let is_bare = |&(carpet, all): &(u32, u32)| {
            all > 0 && f64::from(all - carpet) <= GROUND_IS_OTHER * f64::from(all)
        };
        self.is_bare.clear();
        self.is_bare.extend(self.counts.iter().map(is_bare));
        let (width, height) = (self.width, self.is_bare.len() / self.width.max(1));
        let middle = |i: usize| (i as f64 + 0.5) * bare.patch_px - 0.5;
        let first_row = 1 + (first_row_px / self.patch_px) as usize;
        for row in first_row..height.saturating_sub(1) {
            for column in 1..width.saturating_sub(1) {
                let mut around = (row - 1..=row + 1).flat_map(|row| {
                    let first = row * width + column - 1;
                    &self.is_bare[first..=first + 2]
                });
                if around.all(|is_bare| *is_bare) {
                    let px = Point2::new(middle(column), middle(row));
                    bare.middles.push(camera.ideal_px(&px));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::field::scan::Direction;

    /// Rows of carpet, with something white at the given places.
    fn bare(is_white: impl Fn(u32, u32) -> bool) -> Vec<(u32, u32)> {
        let camera = Camera::pinhole((80, 60), (90.0, 90.0), (39.5, 29.5)).unwrap();
        let mut patches = BarePatches::default();
        patches.begin(camera.size_px(), 5);
        for row in 0..60 {
            let line = ScanLine { direction: Direction::Horizontal, fixed: row, from: 0, to: 80, spacing: 1 };
            let class = |x: u32| if is_white(x, row) { ColorClass::White } else { ColorClass::Green };
            let run = |x: u32| Run { class: class(x), start: x, end: x + 1, green_luma: 90, white_luma: 140 };
            patches.add(&line, &(0..80).map(run).collect::<Vec<_>>());
        }
        let mut bare = BareGround::default();
        patches.finish(&camera, 20, &mut bare);
        assert!((bare.patch_px - 5.0).abs() < 1e-12);
        bare.middles.iter().map(|px| (px.x as u32, px.y as u32)).collect()
    }

    #[test]
    fn ground_is_bare_where_neither_a_line_nor_the_border_of_the_image_is_near() {
        let all = bare(|_, _| false);
        assert_eq!((all[0], *all.last().unwrap(), all.len()), ((7, 27), (72, 52), 14 * 6));
        let beside = bare(|x, _| (38..40).contains(&x));
        assert!(beside.iter().all(|(x, _)| x.abs_diff(39) > 5), "{beside:?}");
        assert!(beside.iter().any(|(x, _)| x.abs_diff(39) < 11), "{beside:?}");
        assert_eq!(bare(|x, y| x % 10 == 3 && y % 10 == 3), all, "specks are no line");
    }
}
