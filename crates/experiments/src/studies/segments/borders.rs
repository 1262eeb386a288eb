//! The borders of an image by the simulator's labels.

use nalgebra::Point2;
use visloc_core::geom::{CameraFrame, Plane, Rigid3, Robot};
use visloc_locate::vision::{DoorSide, FeatureKind, office::Labelled};
use visloc_sim::{Label, LabelImage};

/// Kinds of borders in the table.
pub(super) const KINDS: [(FeatureKind, &str); 4] = [
    (FeatureKind::DoorEdge { side: DoorSide::Left, paint: 0 }, "left edges of doors"),
    (FeatureKind::DoorEdge { side: DoorSide::Right, paint: 0 }, "right edges of doors"),
    (FeatureKind::WallFoot, "floor below walls"),
    (FeatureKind::DoorFoot, "floor below doors"),
];
/// How far from a border a line may lie, pixels.
const NEAR_PX: f64 = 2.0;
/// What is nearer to the image's border than this is not asked for: filters need their neighbors, pixels.
const MARGIN_PX: i64 = 6;
/// A line is right if this share of it lies on a border of its kind.
const RIGHT_SHARE: f64 = 0.7;
/// Farther away the analysis does not look, meters.
const RANGE_M: f64 = 12.0;

/// Counts of one kind.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Counts {
    pub lines: u64,
    pub right_lines: u64,
    /// Pixels of borders, and those of them that a line covers.
    pub border_px: u64,
    pub found_px: u64,
}

impl Counts {
    pub fn add(&mut self, other: &Self) {
        self.lines += other.lines;
        self.right_lines += other.right_lines;
        self.border_px += other.border_px;
        self.found_px += other.found_px;
    }

    pub fn precision(&self) -> Option<f64> {
        share(self.right_lines, self.lines)
    }

    pub fn recall(&self) -> Option<f64> {
        share(self.found_px, self.border_px)
    }
}

fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// All borders of an image, kind by kind.
pub(super) struct Borders {
    points: [Vec<Point2<f64>>; KINDS.len()],
    /// Below the horizon and near enough to be asked for.
    is_asked: [Vec<bool>; KINDS.len()],
}

fn index(kind: FeatureKind) -> Option<usize> {
    match kind {
        FeatureKind::DoorEdge { side: DoorSide::Left, .. } => Some(0),
        FeatureKind::DoorEdge { side: DoorSide::Right, .. } => Some(1),
        FeatureKind::WallFoot => Some(2),
        FeatureKind::DoorFoot => Some(3),
        _ => None,
    }
}

impl Borders {
    /// The borders in a label image, for a robot whose camera is really there.
    pub fn new(
        labels: &LabelImage,
        camera: &visloc_core::geom::Camera,
        robot_from_camera: &Rigid3<Robot, CameraFrame>,
    ) -> Self {
        let mut borders = Self { points: Default::default(), is_asked: Default::default() };
        let (width, height) = (i64::from(labels.width()), i64::from(labels.height()));
        for y in MARGIN_PX..height - MARGIN_PX {
            for x in MARGIN_PX..width - MARGIN_PX {
                for (dx, dy) in [(1, 0), (0, 1)] {
                    let (Some(a), Some(b)) = (labels.get(x, y), labels.get(x + dx, y + dy)) else { continue };
                    let Some(kind) = between(a, b, dx == 1) else { continue };
                    let point = Point2::new(x as f64 + 0.5 * dx as f64, y as f64 + 0.5 * dy as f64);
                    borders.points[kind].push(point);
                    // Edges of doors are asked for from the horizon down, like the floor.
                    let distance = distance_m(camera, robot_from_camera, &point);
                    let limit = if kind < 2 { f64::INFINITY } else { RANGE_M };
                    borders.is_asked[kind].push(distance.is_some_and(|distance| distance <= limit));
                }
            }
        }
        borders
    }

    /// Compares the lines of an analysis with the borders.
    pub fn score(&self, lines: &[Labelled], counts: &mut [Counts; KINDS.len()]) {
        for line in lines {
            let Some(kind) = line.kind.and_then(index) else { continue };
            counts[kind].lines += 1;
            counts[kind].right_lines += u64::from(self.is_right(line, kind));
        }
        for (kind, counts) in counts.iter_mut().enumerate() {
            let of_kind = || lines.iter().filter(|line| line.kind.and_then(index) == Some(kind));
            for (point, is_asked) in self.points[kind].iter().zip(&self.is_asked[kind]) {
                if *is_asked {
                    counts.border_px += 1;
                    counts.found_px += u64::from(of_kind().any(|line| is_on(line, point)));
                }
            }
        }
    }

    /// Whether most of a line lies on borders of its kind.
    fn is_right(&self, line: &Labelled, kind: usize) -> bool {
        let num_places = (line.segment.length_px().ceil().max(1.0) as u32).min(400);
        let along = line.segment.end - line.segment.start;
        let on_border = (0..=num_places).filter(|i| {
            let place = line.segment.start + along * (f64::from(*i) / f64::from(num_places));
            self.points[kind].iter().any(|point| (point - place).norm() <= NEAR_PX)
        });
        on_border.count() as f64 >= RIGHT_SHARE * f64::from(num_places + 1)
    }
}

/// What two neighboring pixels have between them, as an index of the kinds.
fn between(a: Label, b: Label, is_beside: bool) -> Option<usize> {
    match (a, b) {
        (Label::Wall, Label::Door) if is_beside => Some(0),
        (Label::Door, Label::Wall) if is_beside => Some(1),
        (Label::Wall, Label::Floor) | (Label::Floor, Label::Wall) => Some(2),
        (Label::Door, Label::Floor) | (Label::Floor, Label::Door) => Some(3),
        _ => None,
    }
}

/// Whether a point lies on a line.
fn is_on(line: &Labelled, point: &Point2<f64>) -> bool {
    let along = line.segment.direction();
    let place = (point - line.segment.start).dot(&along);
    (-NEAR_PX..=line.segment.length_px() + NEAR_PX).contains(&place)
        && line.segment.offset_px(point) <= NEAR_PX
}

/// Distance on the floor of what is seen at a pixel; `None` above the horizon.
fn distance_m(
    camera: &visloc_core::geom::Camera,
    robot_from_camera: &Rigid3<Robot, CameraFrame>,
    px: &Point2<f64>,
) -> Option<f64> {
    let eye = nalgebra::Point3::from(*robot_from_camera.translation());
    let ray = robot_from_camera.rotate(&camera.bearing(px));
    Plane::ground().intersect_ray(&eye, &ray).map(|point| point.x.hypot(point.y))
}
