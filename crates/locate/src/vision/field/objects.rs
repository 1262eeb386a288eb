//! Robots and balls: what is neither carpet nor line nor goal, stands on the ground, and has the size that its distance demands.
//!
//! A box as large as the thing at the distance of its foot is held against two other explanations, cell by cell: that nothing stands there (a
//! few cells of lines among carpet), and that something larger does (which would go on beside the box). What is above the end of the
//! field tells nothing, since whatever is behind it is no carpet either.

use std::ops::Range;

use nalgebra::{Point2, Point3, Vector2};
use visloc_core::{Frame, geom::Plane};

use super::{
    FieldEnd,
    cells::{CellSums, cell, log_ratio},
};
use crate::vision::{
    DetectedObject, GoalPost, ObjectKind,
    color::{ColorClass, ColorTable, luma},
};

/// Probability that a cell without the carpet's color is darker than the carpet, on a ball (a fifth of most is black) and on a line.
const BALL_IS_DARK: f64 = 0.2;
const LINE_IS_DARK: f64 = 0.01;
/// An object stands at one of a thousand places at most.
const MIN_OBJECT_NATS: f64 = 7.0;
/// Something that goes on on one side is as probable as the object, and is refuted by twenty to one.
const MIN_SIDE_NATS: f64 = 3.0;
/// Of the direction of the camera's optical axis: what joints and gait of a humanoid robot leave open, radians.
const DIRECTION_SIGMA_RAD: f64 = 0.02;
/// Beyond this a robot or ball is too small or too close to the end of the field, meters.
const MAX_ROBOT_M: f64 = 5.0;
const MAX_BALL_M: f64 = 4.0;
/// A ball looks so many times as large as it should: two degrees of tilt move its distance by a fifth at 2 m.
const BALL_SIZES: [f64; 3] = [1.0, 0.8, 1.25];
/// Half widths of legs and torso, meters: of robots about 0.6 m high, and of larger ones or those with their legs apart.
const ROBOT_HALF_WIDTHS_M: [f64; 2] = [0.08, 0.14];
/// From the front of the feet to the middle of a robot, meters.
const FOOT_TO_MIDDLE_M: f64 = 0.06;
/// Of a robot so much is judged from its feet upwards, meters.
const JUDGED_HEIGHT_M: f64 = 0.45;
/// And at least so much: bars of nets and balls are lower.
const MIN_JUDGED_M: f64 = 0.15;
/// A post within this distance across the view explains what seems to be a robot, meters.
const POST_REACH_M: f64 = 0.25;

/// Cells of a box that do not have the carpet's color.
#[derive(Debug, Clone, Copy, Default)]
struct Colors {
    num: f64,
    num_orange: f64,
    /// Darker than the carpet, the orange ones left out.
    num_dark: f64,
    /// Of a goal's color, on a field that has such goals.
    num_goal: f64,
}

impl Colors {
    /// Log of how much better they fit a ball with a dark pattern, or an orange one, than a line or mark, which are nowhere darker than the
    /// carpet.
    fn pattern_nats(&self) -> f64 {
        log_ratio((self.num_orange + self.num_dark, self.num.max(1.0)), BALL_IS_DARK, LINE_IS_DARK)
    }

    fn is_mostly_orange(&self) -> bool {
        self.num_orange > 0.5 * self.num
    }

    fn is_mostly_goal(&self) -> bool {
        self.num_goal > 0.5 * self.num
    }
}

/// An image and what is known about it.
#[derive(Clone, Copy)]
pub(super) struct ObjectView<'a> {
    pub frame: &'a Frame,
    pub table: &'a ColorTable,
    /// Brightness of the carpet, 0 to 255.
    pub carpet_luma: u32,
    pub field_end: &'a FieldEnd,
    pub posts: &'a [GoalPost],
    /// That of the map's ball.
    pub ball_diameter_m: f64,
    /// What is nearer is the robot itself.
    pub own_body_m: f64,
}

/// Finds robots and balls. Keeps its buffers from image to image.
#[derive(Debug, Default)]
pub(super) struct ObjectDetector {
    cells: CellSums,
    candidates: Vec<DetectedObject>,
    objects: Vec<DetectedObject>,
}

/// A foot: the lowest cell of something, and what the camera says about the ground there.
struct Foot {
    /// Middle of the cell's column, and its lower border, cells.
    column: f64,
    row: f64,
    /// Cells of a meter across the view.
    cells_per_m: f64,
    /// Distance along the ground, meters.
    distance_m: f64,
    /// Upright things look so much lower, seen from above.
    upright: f64,
    /// Row of the end of the field, cells.
    end_row: f64,
}

impl ObjectDetector {
    /// Detects in an image whose carpet and end of the field are known.
    pub fn find(&mut self, view: &ObjectView<'_>) -> &[DetectedObject] {
        let ObjectView { frame, table, field_end, posts, .. } = *view;
        let first_row_px = field_end.hull().iter().map(|(_, row)| *row).fold(f64::INFINITY, f64::min);
        self.candidates.clear();
        self.objects.clear();
        self.cells.fill(&frame.image, table, first_row_px);
        for (column, row) in self.cells.feet() {
            let Some(foot) = self.foot(frame, field_end, column, row) else { continue };
            if foot.distance_m < view.own_body_m {
                continue;
            }
            for factor in BALL_SIZES {
                self.candidates.extend(self.ball_at(view, &foot, factor));
            }
            for half_width_m in ROBOT_HALF_WIDTHS_M {
                for shift in [-0.5, 0.0, 0.5] {
                    let column = foot.column + shift * half_width_m * foot.cells_per_m;
                    self.candidates.extend(self.robot_at(view, &Foot { column, ..foot }, half_width_m));
                }
            }
        }
        self.candidates.sort_by(|a, b| b.evidence_nats.total_cmp(&a.evidence_nats));
        for candidate in &self.candidates {
            let is_free = self.objects.iter().all(|object| !overlap(&object.bounds_px, &candidate.bounds_px));
            let is_post = || {
                candidate.kind == ObjectKind::Robot
                    && (posts.iter().any(|post| explains(post, &candidate.in_robot))
                        || self.is_of_goal(view, candidate))
            };
            if is_free && !is_post() {
                self.objects.push(*candidate);
            }
        }
        &self.objects
    }

    /// `None` above the end of the field.
    fn foot(&self, frame: &Frame, field_end: &FieldEnd, column: usize, row: usize) -> Option<Foot> {
        let cell_px = f64::from(self.cells.cell_px);
        let (column, row) = (column as f64 + 0.5, row as f64 + 1.0);
        let px = Point2::new(column * cell_px, row * cell_px);
        let end_row = field_end.row_px(px.x) / cell_px;
        if end_row >= row - 1.0 {
            return None;
        }
        let ground = ground_at(frame, &px, 0.0)?;
        let eye = frame.robot_from_camera.translation();
        let offset = ground - eye.xy();
        let distance_m = offset.coords.norm();
        let axis = frame.robot_from_camera.rotation().column(2).into_owned();
        let depth_m = offset.coords.push(-eye.z).dot(&axis);
        Some(Foot {
            column,
            row,
            cells_per_m: frame.camera.focal_px().0 / depth_m / cell_px,
            distance_m: ground.coords.norm(),
            upright: distance_m / distance_m.hypot(eye.z),
            end_row,
        })
    }

    fn ball_at(&self, view: &ObjectView<'_>, foot: &Foot, factor: f64) -> Option<DetectedObject> {
        let ObjectView { frame, ball_diameter_m: diameter_m, .. } = *view;
        let size = factor * diameter_m * foot.cells_per_m;
        let (x, bottom) = (foot.column, foot.row);
        if foot.distance_m > MAX_BALL_M || size < 2.5 || bottom - 1.5 * size < foot.end_row {
            return None;
        }
        // Its four quarters are filled: a mark on the ground does not reach up there, a line leaves one of them. The twelve tiles around
        // are something else: a line goes on through at least one of them.
        let middle = Point2::new(x, bottom - 0.5 * size);
        let reach = 0.36 * size;
        self.fits(&(x - reach..x + reach), &(middle.y - reach..middle.y + reach))?;
        let tile = |i: f64, j: f64, size: f64| {
            let (left, top) = (middle.x + i * size, middle.y + j * size);
            (left..left + size, top..top + size)
        };
        let nats =
            |(columns, rows): (Range<f64>, Range<f64>)| self.cells.nats(&columns, &rows).unwrap_or(0.0);
        let inner =
            [(-1.0, -1.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 0.0)].map(|(i, j)| nats(tile(i, j, reach)));
        let evidence_nats = inner.iter().sum::<f64>();
        if evidence_nats < MIN_OBJECT_NATS || inner.iter().any(|nats| *nats <= 0.0) {
            return None;
        }
        let colors = self.colors(view, &tile(-0.5, -0.5, 2.0 * reach));
        if colors.pattern_nats() < MIN_SIDE_NATS {
            return None;
        }
        // An orange ball ends where the orange ends, so it may touch a line; another one ends where the carpet begins.
        let is_orange = colors.is_mostly_orange();
        let is_inside = |i: i32, j: i32| (-1..=0).contains(&i) && (-1..=0).contains(&j);
        let is_other = |i: i32, j: i32| {
            let tile = tile(f64::from(i), f64::from(j), 0.54 * size);
            if is_orange {
                !self.colors(view, &tile).is_mostly_orange()
            } else {
                -nats(tile) >= MIN_SIDE_NATS
            }
        };
        if !(-2..2).all(|j| (-2..2).all(|i| is_inside(i, j) || is_other(i, j))) {
            return None;
        }
        let cell_px = f64::from(self.cells.cell_px);
        let in_robot = ground_at(frame, &(middle * cell_px), 0.5 * diameter_m)?;
        let bounds_px = [x - 0.5 * size, bottom - size, x + 0.5 * size, bottom].map(|v| v * cell_px);
        Some(self.object(frame, ObjectKind::Ball, in_robot, bounds_px, evidence_nats))
    }

    /// Counts the colors of a box.
    fn colors(&self, view: &ObjectView<'_>, (columns, rows): &(Range<f64>, Range<f64>)) -> Colors {
        let cells = |range: &Range<f64>, end| cell(range.start, end)..cell(range.end, end);
        let columns = cells(columns, self.cells.width);
        let rows = cells(rows, self.cells.height);
        let mut colors = Colors::default();
        for (row, column) in rows.flat_map(|row| columns.clone().map(move |column| (row, column))) {
            if row >= self.cells.first_row && self.cells.is_other(column, row) {
                let [r, g, b] = self.cells.color(&view.frame.image, column, row);
                let class = view.table.class(r, g, b);
                let is_orange = class == ColorClass::Orange;
                let is_goal = matches!(class, ColorClass::Yellow | ColorClass::Blue);
                colors.num += 1.0;
                colors.num_orange += f64::from(u8::from(is_orange));
                colors.num_goal += f64::from(u8::from(is_goal));
                colors.num_dark += f64::from(u8::from(!is_orange && luma([r, g, b]) < view.carpet_luma));
            }
        }
        colors
    }

    fn robot_at(&self, view: &ObjectView<'_>, foot: &Foot, half_width_m: f64) -> Option<DetectedObject> {
        let (x, bottom, per_m) = (foot.column, foot.row, foot.cells_per_m);
        let upright_m = per_m * foot.upright;
        let top = (bottom - JUDGED_HEIGHT_M * upright_m).max(foot.end_row);
        if foot.distance_m > MAX_ROBOT_M || bottom - top < MIN_JUDGED_M * upright_m {
            return None;
        }
        let half = half_width_m * per_m;
        self.fits(&(x - half..x + half), &(top..bottom))?;
        // All four quarters are filled: legs apart leave the middle free, an arm or a line one of the quarters.
        let middle = 0.5 * (top + bottom);
        let quarter = |columns: Range<f64>, rows: Range<f64>| self.cells.nats(&columns, &rows).unwrap_or(0.0);
        let inner = [
            quarter(x - half..x, top..middle),
            quarter(x..x + half, top..middle),
            quarter(x - half..x, middle..bottom),
            quarter(x..x + half, middle..bottom),
        ];
        let evidence_nats = inner.iter().sum::<f64>();
        // Arms and a stride are wider than the box.
        let (near, far) = (half + 0.06 * per_m, half + 0.18 * per_m);
        let sides = [
            (x - far..x - near, top..bottom),
            (x + near..x + far, top..bottom),
            (x - half..x + half, bottom + 0.02 * upright_m..bottom + 0.12 * upright_m),
        ];
        let is_alone = sides
            .iter()
            .all(|(columns, rows)| self.cells.nats(columns, rows).is_some_and(|nats| -nats >= MIN_SIDE_NATS));
        if evidence_nats < MIN_OBJECT_NATS || inner.iter().any(|nats| *nats <= 0.0) || !is_alone {
            return None;
        }
        let frame = view.frame;
        let cell_px = f64::from(self.cells.cell_px);
        let front = ground_at(frame, &(Point2::new(x, bottom) * cell_px), 0.0)?;
        let in_robot = front + front.coords.normalize() * FOOT_TO_MIDDLE_M;
        let bounds_px = [x - half, top, x + half, bottom].map(|v| v * cell_px);
        Some(self.object(frame, ObjectKind::Robot, in_robot, bounds_px, evidence_nats))
    }

    /// A post that is too near to be seen in whole is named by nobody, but has its color: of a robot that is a jersey at most.
    fn is_of_goal(&self, view: &ObjectView<'_>, candidate: &DetectedObject) -> bool {
        let cell_px = f64::from(self.cells.cell_px);
        let [left, top, right, bottom] = candidate.bounds_px.map(|border| border / cell_px);
        self.colors(view, &(left..right, top..bottom)).is_mostly_goal()
    }

    /// Most boxes fail here, before anything else is looked at.
    fn fits(&self, columns: &Range<f64>, rows: &Range<f64>) -> Option<()> {
        (self.cells.nats(columns, rows)? > 0.0).then_some(())
    }

    /// With the covariance that follows from the direction of the camera and the size of a cell.
    fn object(
        &self,
        frame: &Frame,
        kind: ObjectKind,
        in_robot: Point2<f64>,
        bounds_px: [f64; 4],
        evidence_nats: f64,
    ) -> DetectedObject {
        let eye = frame.robot_from_camera.translation();
        let away = in_robot.coords - eye.xy();
        let distance_m = away.norm().max(1e-3);
        let cell_rad = f64::from(self.cells.cell_px) / frame.camera.focal_px().0;
        let sigma_rad = DIRECTION_SIGMA_RAD.hypot(cell_rad);
        let range_sigma_m = (distance_m.powi(2) + eye.z.powi(2)) / eye.z.max(1e-3) * sigma_rad;
        let across_sigma_m =
            (distance_m * sigma_rad).hypot(if kind == ObjectKind::Robot { FOOT_TO_MIDDLE_M } else { 0.0 });
        let along = away / distance_m;
        let across = Vector2::new(-along.y, along.x);
        let covariance = along * along.transpose() * range_sigma_m.powi(2)
            + across * across.transpose() * across_sigma_m.powi(2);
        DetectedObject { kind, in_robot, covariance, bounds_px, evidence_nats }
    }
}

/// Where the ray of a pixel meets the height, in the robot's frame.
fn ground_at(frame: &Frame, px: &Point2<f64>, height_m: f64) -> Option<Point2<f64>> {
    let direction = frame.robot_from_camera.rotate(&frame.camera.bearing(px));
    let eye =
        Point3::from(frame.robot_from_camera.translation() - nalgebra::Vector3::new(0.0, 0.0, height_m));
    Plane::ground().intersect_ray(&eye, &direction).map(|point| point.xy())
}

fn explains(post: &GoalPost, in_robot: &Point2<f64>) -> bool {
    let (sin, cos) = post.bearing_rad.sin_cos();
    let across_m = in_robot.x * sin - in_robot.y * cos;
    let ahead_m = in_robot.x * cos + in_robot.y * sin;
    ahead_m > 0.0 && across_m.abs() < POST_REACH_M
}

fn overlap(a: &[f64; 4], b: &[f64; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Rotation3, Vector3};
    use visloc_core::{
        RgbImage, RngTree, Timestamp,
        geom::{Camera, CameraFrame, Rigid3, Robot},
    };

    use super::*;
    use crate::vision::field::{FieldAnalysisConfig, FieldAnalyzer};

    const GREEN: [u8; 3] = [60, 140, 80];
    const WHITE: [u8; 3] = [235, 236, 232];
    const DARK: [u8; 3] = [30, 30, 32];

    /// Half a meter above the ground, looking down by 25 degrees.
    fn frame() -> Frame {
        let camera = Camera::pinhole((320, 240), (373.0, 373.0), (159.5, 119.5)).unwrap();
        let (sin, cos) = 25.0_f64.to_radians().sin_cos();
        let rotation = Matrix3::new(0.0, -sin, cos, -1.0, 0.0, 0.0, 0.0, -cos, -sin);
        let robot_from_camera = Rigid3::<Robot, CameraFrame>::new(
            Rotation3::from_matrix_unchecked(rotation),
            Vector3::new(0.0, 0.0, 0.5),
        );
        let mut image = RgbImage::new(320, 240);
        image.data_mut().as_chunks_mut::<3>().0.fill(GREEN);
        Frame::new(Timestamp::default(), image, camera, robot_from_camera)
    }

    /// Paints what lies on the ground.
    fn paint_ground(frame: &mut Frame, color_at: impl Fn(Point2<f64>) -> Option<[u8; 3]>) {
        for y in 0..240 {
            for x in 0..320 {
                let px = Point2::new(f64::from(x), f64::from(y));
                if let Some(color) = ground_at(frame, &px, 0.0).and_then(&color_at) {
                    frame.image.set(x, y, color);
                }
            }
        }
    }

    /// Paints an upright picture of a width and height in meters at a place ahead of and to the left of the robot, by (0 to 1, 0 to 1) from its upper left corner.
    fn paint_upright(
        frame: &mut Frame,
        at: Point2<f64>,
        (width_m, height_m): (f64, f64),
        color_at: impl Fn(f64, f64) -> Option<[u8; 3]>,
    ) {
        const STEPS: u32 = 400;
        for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
            let (u, v) = (f64::from(i) / f64::from(STEPS), f64::from(j) / f64::from(STEPS));
            let point = Point3::new(at.x, at.y + width_m * (0.5 - u), height_m * (1.0 - v));
            let in_camera = frame.robot_from_camera.inverse().transform(&point);
            let Ok(px) = frame.camera.project(&in_camera) else { continue };
            if let (Some(color), true) = (color_at(u, v), frame.camera.contains(&px)) {
                frame.image.set(px.x.round() as u32, px.y.round() as u32, color);
            }
        }
    }

    fn checkered_ball(u: f64, v: f64) -> Option<[u8; 3]> {
        let is_inside = (u - 0.5).hypot(v - 0.5) < 0.5;
        let is_dark = ((u * 4.0) as u32 + (v * 4.0) as u32).is_multiple_of(2);
        is_inside.then_some(if is_dark { DARK } else { WHITE })
    }

    fn detect(frame: &Frame) -> Vec<DetectedObject> {
        let config = FieldAnalysisConfig { detect_objects: true, ..FieldAnalysisConfig::default() };
        let mut analyzer = FieldAnalyzer::new(config).unwrap();
        let rng = &mut RngTree::new(1).stream("analysis", 0);
        analyzer.analyze(frame, rng).unwrap().objects.clone()
    }

    #[test]
    fn a_ball_and_a_robot_are_found_where_they_stand() {
        let (ball, robot) = (Point2::new(1.3, 0.25), Point2::new(1.8, -0.35));
        let mut frame = frame();
        paint_upright(&mut frame, ball, (0.1, 0.1), checkered_ball);
        paint_upright(&mut frame, robot, (0.2, 0.58), |_, _| Some(WHITE));
        let mut found = detect(&frame);
        found.sort_by_key(|object| object.kind);
        assert_eq!(
            found.iter().map(|object| object.kind).collect::<Vec<_>>(),
            [ObjectKind::Robot, ObjectKind::Ball]
        );
        for (object, truth) in found.iter().zip([robot, ball]) {
            assert!((object.in_robot - truth).norm() < 0.1, "{object:?}");
            // What the camera's direction leaves open is more along the view than across.
            assert!(object.covariance[(0, 0)] > 2.0 * object.covariance[(1, 1)], "{object:?}");
        }
    }

    #[test]
    fn objects_are_looked_for_five_times_a_second() {
        let mut frame = frame();
        paint_upright(&mut frame, Point2::new(1.3, 0.25), (0.1, 0.1), checkered_ball);
        let config = FieldAnalysisConfig { detect_objects: true, ..FieldAnalysisConfig::default() };
        let mut analyzer = FieldAnalyzer::new(config).unwrap();
        let rng = &mut RngTree::new(1).stream("analysis", 0);
        for images_per_sec in [5, 30] {
            let start = frame.at + 1.0;
            let mut num_found = 0;
            for i in 0..2 * images_per_sec {
                frame.at = start + f64::from(i) / f64::from(images_per_sec);
                num_found += analyzer.analyze(&frame, rng).unwrap().objects.len();
            }
            assert_eq!(num_found, 10, "{images_per_sec} images a second");
        }
    }

    #[test]
    fn an_orange_ball_may_touch_a_line() {
        let at = Point2::new(1.3, 0.25);
        let orange = |u: f64, v: f64| ((u - 0.5).hypot(v - 0.5) < 0.5).then_some([225, 95, 28]);
        for offset_m in [-0.05, 0.0, 0.05, 0.1] {
            let mut frame = frame();
            paint_ground(&mut frame, |p| ((p.x - at.x - offset_m).abs() < 0.025).then_some(WHITE));
            paint_upright(&mut frame, at, (0.1, 0.1), orange);
            let found = detect(&frame);
            assert_eq!(found.len(), 1, "{offset_m}: {found:?}");
            assert_eq!(found[0].kind, ObjectKind::Ball, "{offset_m}");
            assert!((found[0].in_robot - at).norm() < 0.1, "{offset_m}: {found:?}");
        }
    }

    #[test]
    fn lines_marks_and_walls_are_neither() {
        let cross = |p: Point2<f64>| (p.x - 1.2).abs() < 0.05 && (p.y - 0.2).abs() < 0.05;
        let things: [&dyn Fn(Point2<f64>) -> bool; 5] = [
            &|p| (p.y - 0.1).abs() < 0.025,
            &|p| (p.x - 0.4 * p.y - 1.5).abs() < 0.025,
            &|p| (p.y - 0.1).abs() < 0.025 || (p.x - 1.5).abs() < 0.025,
            &|p| ((p.x - 1.6).hypot(p.y) - 0.4).abs() < 0.025,
            &cross,
        ];
        for (i, thing) in things.iter().enumerate() {
            let mut frame = frame();
            paint_ground(&mut frame, |p| thing(p).then_some(WHITE));
            assert_eq!(detect(&frame), [], "{i}");
        }
        let mut frame = frame();
        paint_upright(&mut frame, Point2::new(2.0, 0.0), (1.2, 0.8), |_, _| Some([150, 150, 150]));
        assert_eq!(detect(&frame), [], "a wall");
    }

    #[test]
    fn a_post_that_fills_the_height_of_the_image_is_no_robot() {
        let yellow = [215, 190, 25];
        for (color, is_robot) in [(yellow, false), (WHITE, true)] {
            let mut frame = frame();
            paint_upright(&mut frame, Point2::new(1.1, 0.1), (0.16, 0.5), |_, _| Some(color));
            let config = FieldAnalysisConfig { detect_objects: true, ..FieldAnalysisConfig::default() };
            let mut analyzer = FieldAnalyzer::new(config).unwrap();
            let percept = analyzer.analyze(&frame, &mut RngTree::new(1).stream("analysis", 0)).unwrap();
            assert!(percept.features.posts.is_empty(), "{:?}", percept.features.posts);
            assert_eq!(!percept.objects.is_empty(), is_robot, "{:?}", percept.objects);
        }
    }

    #[test]
    fn nothing_is_detected_unless_it_is_asked_for() {
        let mut frame = frame();
        paint_upright(&mut frame, Point2::new(1.3, 0.0), (0.1, 0.1), checkered_ball);
        let mut analyzer = FieldAnalyzer::new(FieldAnalysisConfig::default()).unwrap();
        let rng = &mut RngTree::new(1).stream("analysis", 0);
        assert_eq!(analyzer.analyze(&frame, rng).unwrap().objects, []);
    }
}
