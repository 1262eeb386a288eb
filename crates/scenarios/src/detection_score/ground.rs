//! Scores of what lies on the ground: lines, junctions, circle, marks.

use std::f64::consts::TAU;

use nalgebra::Point2;
use visloc_core::geom::angle;
use visloc_locate::vision::JunctionKind;
use visloc_world::field::{FieldJunction, Segment};

use super::{
    TOLERANCE_PX,
    counts::{DetectionScore, share},
    scene::{RANGE_M, Scene},
};

/// A line ends at the outer border of the line that it meets, and blur adds to that, meters.
const BEYOND_END_M: f64 = 0.15;
/// Largest error of a right junction's direction, radians.
const TOLERANCE_RAD: f64 = 0.35;
/// Penalty marks farther away are not asked for, meters.
const MARK_RANGE_M: f64 = 2.5;
/// Visible length of a line that must be found, meters.
const MIN_LINE_M: f64 = 0.5;
/// Share of the circle in the image from which it must be found.
const MIN_CIRCLE_SHARE: f64 = 0.3;

impl Scene<'_> {
    /// Ends and middle of a line lie on one line of the map.
    fn line_of(&self, ends_px: &[Point2<f64>; 2]) -> Option<usize> {
        let is_on = |line: &Segment| {
            let beyond = (line.end - line.start).normalize() * BEYOND_END_M;
            let line = Segment { start: line.start - beyond, end: line.end + beyond };
            ends_px.iter().all(|px| {
                let at = self.ground(px);
                at.is_some_and(|at| self.off_px(px, &line.nearest_point(&at)) < TOLERANCE_PX)
            })
        };
        self.field.lines().iter().position(is_on)
    }

    pub fn score_lines(&self, score: &mut DetectionScore) {
        let mut found = vec![false; self.field.lines().len()];
        for line in &self.percept.features.lines {
            score.num_found += 1;
            if let Some(i) = self.line_of(&line.ends_px) {
                found[i] = true;
                score.num_right += 1;
                let middle_px = nalgebra::center(&line.ends_px[0], &line.ends_px[1]);
                let nearest =
                    self.ground(&middle_px).map(|at| (self.field.lines()[i].nearest_point(&at) - at).norm());
                score.errors_m.extend(nearest);
            }
        }
        for (line, found) in self.field.lines().iter().zip(found) {
            let along = line.end - line.start;
            let count = (along.norm() / 0.05).ceil();
            let mut visible_m = 0.0;
            let mut i = 0.0;
            while i <= count {
                visible_m += if self.is_visible(&(line.start + along * (i / count))) { 0.05 } else { 0.0 };
                i += 1.0;
            }
            if visible_m >= MIN_LINE_M {
                score.num_visible += 1;
                score.num_recalled += usize::from(found);
            }
        }
    }

    pub fn score_junctions(&self, kind: JunctionKind, score: &mut DetectionScore) {
        let on_map = self.field.junctions();
        let on_map: Vec<_> = on_map.iter().filter(|j| j.arms.len() == kind.num_arms()).collect();
        let mut found = vec![false; on_map.len()];
        for junction in self.percept.features.junctions.iter().filter(|j| j.kind == kind) {
            score.num_found += 1;
            let quarter = if kind == JunctionKind::X { TAU / 4.0 } else { TAU };
            let is_it = |j: &&FieldJunction| {
                let expected = j.direction().y.atan2(j.direction().x);
                let turn = angle::difference(junction.direction_rad + self.truth.yaw_rad, expected);
                let turn = turn - (turn / quarter).round() * quarter;
                self.off_px(&junction.at_px, &j.at) < TOLERANCE_PX && turn.abs() < TOLERANCE_RAD
            };
            if let Some(i) = on_map.iter().position(is_it) {
                found[i] = true;
                score.num_right += 1;
                score.errors_m.extend(self.error_m(&junction.at_px, &on_map[i].at));
            }
        }
        for (junction, found) in on_map.iter().zip(found) {
            if self.is_visible(&junction.at) && !junction.is_on_circle {
                score.num_visible += 1;
                score.num_recalled += usize::from(found);
            }
        }
    }

    pub fn score_circle(&self, score: &mut DetectionScore) {
        let center = Point2::origin();
        let mut is_right = false;
        if let Some(circle) = &self.percept.features.circle {
            // The center itself may be out of the image: it is taken there as the robot saw it.
            let px = self.reported_px(&circle.center_in_robot);
            let error_m = px.and_then(|px| self.error_m(&px, &center));
            is_right = px.is_some_and(|px| self.off_px(&px, &center) < TOLERANCE_PX)
                || error_m.is_some_and(|m| m < 0.1);
            score.num_found += 1;
            score.num_right += usize::from(is_right);
            if is_right {
                score.errors_m.extend(error_m);
            }
        }
        let radius_m = self.field.circle_radius_m();
        let visible = (0..36).filter(|i| {
            let (sin, cos) = (f64::from(*i) / 36.0 * TAU).sin_cos();
            self.is_in_image(&Point2::new(radius_m * cos, radius_m * sin), 4.0)
        });
        if share(visible.count(), 36) >= MIN_CIRCLE_SHARE && self.distance_m(&center) < RANGE_M {
            score.num_visible += 1;
            score.num_recalled += usize::from(is_right);
        }
    }

    pub fn score_halfway(&self, score: &mut DetectionScore) {
        let Some(halfway_rad) = self.percept.features.circle.and_then(|circle| circle.halfway_rad) else {
            return;
        };
        let turn = angle::difference(2.0 * (halfway_rad + self.truth.yaw_rad), TAU / 2.0).abs() / 2.0;
        score.num_found += 1;
        score.num_right += usize::from(turn < TOLERANCE_RAD);
    }

    pub fn score_marks(&self, score: &mut DetectionScore) {
        let d = self.field.dimensions();
        let x = d.length_m / 2.0 - d.penalty_mark_from_goal_line_m;
        let on_map = [Point2::new(x, 0.0), Point2::new(-x, 0.0)];
        let mut found = [false; 2];
        for mark in &self.percept.features.marks {
            score.num_found += 1;
            if let Some(i) = on_map.iter().position(|at| self.off_px(&mark.at_px, at) < TOLERANCE_PX) {
                found[i] = true;
                score.num_right += 1;
                score.errors_m.extend(self.error_m(&mark.at_px, &on_map[i]));
            }
        }
        for (at, found) in on_map.iter().zip(found) {
            if self.is_visible(at) && self.distance_m(at) < MARK_RANGE_M {
                score.num_visible += 1;
                score.num_recalled += usize::from(found);
            }
        }
    }
}
