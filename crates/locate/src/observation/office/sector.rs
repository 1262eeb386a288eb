//! Which lines can be in the image at all: a rough and fast answer for many lines at once.
//!
//! A candidate pose has a hundred lines around it, and a dozen in its image. Whether both ends of a line are beyond the left or
//! the right border is a linear form in the place, so it takes no division, and single precision with some slack will do:
//! what remains is projected exactly.

use std::ops::Range;

use super::{lines::TheoreticalLine, view::View};

/// Lines that are looked at together.
const AT_ONCE: usize = 8;
/// Rounding is smaller than this, pixels times meters.
const SLACK: f32 = 0.2;
/// Rounding of distances from a wall is smaller than this, meters.
const SLACK_M: f32 = 0.001;

/// Ends and normals of lines, one column of numbers each, so that eight lines are tested together.
#[derive(Debug, Clone, Default)]
pub(super) struct LineColumns {
    start_x: Vec<f32>,
    start_y: Vec<f32>,
    end_x: Vec<f32>,
    end_y: Vec<f32>,
    end_height_m: Vec<f32>,
    normal_x: Vec<f32>,
    normal_y: Vec<f32>,
}

/// What lies between the left and the right border of an image, seen from an eye.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sector {
    eye: [f32; 2],
    /// Linear forms of (x, y) from the eye, height, and 1: 0 or more inside of the left border and of the right one.
    borders: [[f32; 4]; 2],
}

impl Sector {
    /// The sector of a view of so many pixels, `margin_px` wider on both sides.
    #[inline]
    pub fn new(view: &View, width_px: f64, margin_px: f64) -> Self {
        let left = view.row(0) + view.row(2) * margin_px;
        let right = view.row(2) * (width_px + margin_px) - view.row(0);
        let borders = [left, right].map(|form| {
            let at_eye = form[0] * view.eye.x + form[1] * view.eye.y + form[3];
            [form[0] as f32, form[1] as f32, form[2] as f32, at_eye as f32]
        });
        Self { eye: [view.eye.x as f32, view.eye.y as f32], borders }
    }
}

impl LineColumns {
    pub fn push(&mut self, line: &TheoreticalLine) {
        self.start_x.push(line.start.x as f32);
        self.start_y.push(line.start.y as f32);
        self.end_x.push(line.end.x as f32);
        self.end_y.push(line.end.y as f32);
        self.end_height_m.push(line.end_height_m as f32);
        self.normal_x.push(line.normal.x as f32);
        self.normal_y.push(line.normal.y as f32);
    }

    /// Visits those of a range of lines, counted from its beginning, that face the eye and may lie in a sector.
    #[inline]
    pub fn visit_in(&self, range: Range<usize>, sector: &Sector, mut visit: impl FnMut(usize)) {
        let columns = [
            &self.start_x[range.clone()],
            &self.start_y[range.clone()],
            &self.end_x[range.clone()],
            &self.end_y[range.clone()],
            &self.end_height_m[range.clone()],
            &self.normal_x[range.clone()],
            &self.normal_y[range],
        ];
        let count = columns[0].len();
        let mut first = 0;
        while first + AT_ONCE <= count {
            let eight: [&[f32; AT_ONCE]; 7] =
                columns.map(|column| column[first..].first_chunk().unwrap_or(&[0.0; AT_ONCE]));
            let mut is_in = [false; AT_ONCE];
            for (i, is_in) in is_in.iter_mut().enumerate() {
                *is_in = sector.may_hold(eight.map(|column| column[i]));
            }
            for (i, is_in) in is_in.into_iter().enumerate() {
                if is_in {
                    visit(first + i);
                }
            }
            first += AT_ONCE;
        }
        for i in first..count {
            if sector.may_hold(columns.map(|column| column[i])) {
                visit(i);
            }
        }
    }
}

impl Sector {
    /// Whether a line faces the eye and is not altogether beyond one of the borders.
    #[inline(always)]
    // A loop over this becomes vector instructions.
    fn may_hold(&self, [start_x, start_y, end_x, end_y, end_height_m, normal_x, normal_y]: [f32; 7]) -> bool {
        let [start_x, start_y] = [start_x - self.eye[0], start_y - self.eye[1]];
        let [end_x, end_y] = [end_x - self.eye[0], end_y - self.eye[1]];
        let faces = -(start_x * normal_x + start_y * normal_y) > -SLACK_M;
        let reaches = |form: &[f32; 4]| {
            let start = form[0] * start_x + form[1] * start_y + form[3];
            let end = form[0] * end_x + form[1] * end_y + form[2] * end_height_m + form[3];
            (start > -SLACK) | (end > -SLACK)
        };
        faces & reaches(&self.borders[0]) & reaches(&self.borders[1])
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Point2, Vector2};
    use rand::RngExt;
    use visloc_core::{RngTree, geom::PlanarPose};

    use super::*;
    use crate::{
        observation::{edge::Eye, features::CameraState},
        vision::FeatureKind,
    };

    /// What is projected into the image is never left out, and most of what is not is.
    #[test]
    fn a_sector_holds_whatever_is_in_the_image() {
        let rng = &mut RngTree::new(5).stream("sector", 0);
        let intrinsics = Matrix3::new(373.3, 0.0, 159.5, 0.0, 373.3, 119.5, 0.0, 0.0, 1.0);
        // Looks ahead and a little down.
        let robot_from_camera = Matrix3::new(0.0, -0.17, 0.985, -1.0, 0.0, 0.0, 0.0, -0.985, -0.17);
        let (mut num_in, mut num_visited) = (0, 0);
        for _ in 0..200 {
            let around = Point2::new(rng.random_range(-90.0..90.0), rng.random_range(-90.0..90.0));
            let mut columns = LineColumns::default();
            let lines: Vec<TheoreticalLine> = (0..43)
                .map(|_| {
                    let mut place = || Vector2::new(rng.random_range(-9.0..9.0), rng.random_range(-9.0..9.0));
                    let (start, end) = (around + place(), around + place());
                    let is_upright = rng.random_bool(0.5);
                    TheoreticalLine {
                        kind: FeatureKind::WallFoot,
                        start,
                        end: if is_upright { start } else { end },
                        end_height_m: if is_upright { 2.0 } else { 0.0 },
                        normal: Vector2::new(0.6, 0.8),
                    }
                })
                .collect();
            lines.iter().for_each(|line| columns.push(line));
            let state = CameraState {
                world_from_robot: PlanarPose::new(around.x, around.y, rng.random_range(-3.0..3.0)),
                tilt_rad: nalgebra::Vector3::new(0.02, -0.01, 0.01),
                raise_m: 0.01,
            };
            let eye = Eye::new(&state, &robot_from_camera, &nalgebra::Vector3::new(0.05, 0.0, 0.45));
            let view = View::tilted(&eye, &intrinsics);
            let mut visited = Vec::new();
            columns.visit_in(0..lines.len(), &Sector::new(&view, 320.0, 8.0), |i| visited.push(i));
            assert!(visited.is_sorted());
            for (i, line) in lines.iter().enumerate() {
                let faces = (view.eye - line.start).dot(&line.normal) > 0.0;
                let is_in =
                    view.project(line).is_some_and(|[a, b]| a.x.max(b.x) > -8.0 && a.x.min(b.x) < 328.0);
                if faces && is_in {
                    assert!(visited.contains(&i), "{line:?}");
                    num_in += 1;
                }
            }
            num_visited += visited.len();
        }
        assert!(num_in > 500 && num_visited < 3 * num_in, "{num_visited} of {num_in}");
    }
}
