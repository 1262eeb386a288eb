//! The observation model: pixels against the theoretical lines near a pose.

use nalgebra::{Matrix3x4, Point2, Point3, Vector2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_base::Rng;
use visloc_geom::PlanarPose;
use visloc_vision::{FeatureKind, Percept};
use visloc_world::office::Office;

use super::{
    index::{SightIndex, faces, is_seen},
    lines::{TheoreticalLine, theoretical_lines},
    propose::Clues,
};
use crate::{ConfigError, ObservationModel, Region, observation::field::projection, require};

/// Parameters of the observation model of a building.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OfficeModelConfig {
    /// Distance in the image at which a pixel agrees with nothing (`D`), pixels of an image 320 px wide. The documents have
    /// 50; places that look alike differ by a few pixels, and a smaller distance tells them apart sooner.
    pub max_distance_px: f64,
    /// Lines that are farther away are not looked at, meters.
    pub range_m: f64,
}

impl Default for OfficeModelConfig {
    fn default() -> Self {
        Self { max_distance_px: 15.0, range_m: 13.0 }
    }
}

impl OfficeModelConfig {
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let d = self.max_distance_px;
        require(d > 0.0 && d.is_finite(), "office.observation.max_distance_px", "above 0", d)?;
        let range = self.range_m;
        require((0.5..=100.0).contains(&range), "office.observation.range_m", "0.5 to 100", range)
    }
}

/// Pixels of a percept that are weighed at most. More of them are thinned out evenly.
const MAX_PIXELS: usize = 128;
/// What is nearer to the camera's plane than this is cut off, meters.
const NEAR_M: f64 = 0.05;

/// Pixels of one kind, as a range of the model's columns.
#[derive(Debug, Clone, Copy)]
struct Group {
    kind: FeatureKind,
    from: usize,
    to: usize,
}

/// Likelihood of poses inside a building.
#[derive(Debug, Clone)]
pub struct OfficeObservationModel {
    config: OfficeModelConfig,
    office: Office,
    lines: Vec<TheoreticalLine>,
    index: SightIndex,
    /// Undistorted pixels, sorted by kind.
    u: Vec<f32>,
    v: Vec<f32>,
    groups: Vec<Group>,
    clues: Clues,
    eye_in_robot: Point3<f64>,
    ideal_from_robot: Matrix3x4<f64>,
    size_px: (f64, f64),
    max_distance_px: f64,
}

impl OfficeObservationModel {
    /// The model of a building; works out what can be seen from where.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn new(office: &Office, config: &OfficeModelConfig) -> Result<Self, ConfigError> {
        config.check()?;
        let lines = theoretical_lines(office);
        Ok(Self {
            config: *config,
            office: office.clone(),
            index: SightIndex::new(office, &lines, config.range_m),
            lines,
            u: Vec::new(),
            v: Vec::new(),
            groups: Vec::new(),
            clues: Clues::default(),
            eye_in_robot: Point3::origin(),
            ideal_from_robot: Matrix3x4::identity(),
            size_px: (320.0, 240.0),
            max_distance_px: config.max_distance_px,
        })
    }

    /// The building.
    #[must_use]
    pub fn office(&self) -> &Office {
        &self.office
    }

    /// The theoretical image: visits each line that is seen from a pose with its ends in undistorted pixels.
    pub fn theoretical_image(
        &self,
        world_from_robot: &PlanarPose,
        mut visit: impl FnMut(FeatureKind, [Point2<f64>; 2]),
    ) {
        let view = View::new(world_from_robot, &self.ideal_from_robot, &self.eye_in_robot);
        let (entries, walls) = self.index.around(world_from_robot.x_m, world_from_robot.y_m);
        for entry in entries {
            let line = &self.lines[entry.line as usize];
            if self.is_visible(&view.eye, line, entry.is_certain, walls)
                && let Some(ends) = view.project(line)
                && self.is_in_image(&ends)
            {
                visit(line.kind, ends);
            }
        }
    }

    #[inline]
    fn is_visible(&self, eye: &Point2<f64>, line: &TheoreticalLine, is_certain: bool, walls: &[u32]) -> bool {
        if is_certain {
            return faces(eye, line);
        }
        is_seen(eye, line, walls.iter().map(|i| &self.office.walls()[*i as usize]))
    }

    /// Whether a projected line comes near enough to the image to be near any pixel.
    #[inline]
    fn is_in_image(&self, [a, b]: &[Point2<f64>; 2]) -> bool {
        let (width, height) = self.size_px;
        let margin = self.max_distance_px;
        a.x.max(b.x) > -margin
            && a.x.min(b.x) < width + margin
            && a.y.max(b.y) > -margin
            && a.y.min(b.y) < height + margin
    }

    /// Sums of the pixel distances of doors and of the floor, and how many pixels there are of each.
    #[inline]
    fn distances(&self, world_from_robot: &PlanarPose) -> [(f64, usize); 2] {
        let view = View::new(world_from_robot, &self.ideal_from_robot, &self.eye_in_robot);
        let max2 = (self.max_distance_px * self.max_distance_px) as f32;
        let mut smallest2 = [max2; MAX_PIXELS];
        let (entries, walls) = self.index.around(world_from_robot.x_m, world_from_robot.y_m);
        for entry in entries {
            let line = &self.lines[entry.line as usize];
            let Some(group) = self.groups.iter().find(|group| group.kind == line.kind) else { continue };
            if !faces(&view.eye, line) {
                continue;
            }
            let Some(ends) = view.project(line) else { continue };
            if self.is_in_image(&ends) && self.is_visible(&view.eye, line, entry.is_certain, walls) {
                let pixels = group.from..group.to;
                nearer(&ends, &self.u[pixels.clone()], &self.v[pixels.clone()], &mut smallest2[pixels]);
            }
        }
        let mut sums = [(0.0, 0), (0.0, 0)];
        for group in &self.groups {
            let sum = &mut sums[usize::from(!group.kind.is_door_edge())];
            for distance2 in &smallest2[group.from..group.to] {
                sum.0 += f64::from(distance2.sqrt());
            }
            sum.1 += group.to - group.from;
        }
        sums
    }
}

/// Squared distances of pixels from a segment, where they are smaller than what is known.
#[inline]
#[allow(clippy::cast_possible_truncation)]
fn nearer([start, end]: &[Point2<f64>; 2], u: &[f32], v: &[f32], smallest2: &mut [f32]) {
    let (x, y) = (start.x as f32, start.y as f32);
    let (dx, dy) = ((end.x - start.x) as f32, (end.y - start.y) as f32);
    let inverse_length2 = 1.0 / (dx * dx + dy * dy).max(1e-6);
    for ((u, v), smallest2) in u.iter().zip(v).zip(smallest2) {
        let (px, py) = (u - x, v - y);
        let t = ((px * dx + py * dy) * inverse_length2).clamp(0.0, 1.0);
        let (off_x, off_y) = (px - t * dx, py - t * dy);
        *smallest2 = smallest2.min(off_x * off_x + off_y * off_y);
    }
}

impl ObservationModel for OfficeObservationModel {
    fn condition_on(&mut self, percept: &Percept) {
        self.ideal_from_robot = projection(&percept.camera, &percept.robot_from_camera);
        self.eye_in_robot = Point3::from(*percept.robot_from_camera.translation());
        let (width, height) = percept.camera.size_px();
        self.size_px = (f64::from(width), f64::from(height));
        self.max_distance_px = self.config.max_distance_px * (self.size_px.0 / 320.0).max(1.0);
        self.clues.collect(percept);
        self.u.clear();
        self.v.clear();
        self.groups.clear();
        let thinning = percept.pixels.len().div_ceil(MAX_PIXELS).max(1);
        let kept = || percept.pixels.iter().step_by(thinning);
        for pixel in kept() {
            if self.groups.iter().any(|group| group.kind == pixel.kind) {
                continue;
            }
            let from = self.u.len();
            for same in kept().filter(|same| same.kind == pixel.kind) {
                self.u.push(same.ideal_px.x as f32);
                self.v.push(same.ideal_px.y as f32);
            }
            self.groups.push(Group { kind: pixel.kind, from, to: self.u.len() });
        }
    }

    fn has_evidence(&self) -> bool {
        !self.u.is_empty()
    }

    fn likelihood(&self, world_from_robot: &PlanarPose) -> f64 {
        if !self.office.free_space().contains(world_from_robot.x_m, world_from_robot.y_m) {
            return 0.0;
        }
        let [doors, floor] = self.distances(world_from_robot);
        #[allow(clippy::cast_precision_loss)]
        let of = |(sum, count): (f64, usize)| (1.0 - sum / (count as f64 * self.max_distance_px)).max(0.0);
        match (doors.1, floor.1) {
            (0, 0) => 0.0,
            (_, 0) => of(doors),
            (0, _) => of(floor),
            _ => 0.5 * (of(doors) + of(floor)),
        }
    }

    fn region(&self) -> Region {
        let [min, max] = self.office.free_space().bounds_m();
        Region { min_x_m: min.x, max_x_m: max.x, min_y_m: min.y, max_y_m: max.y }
    }

    fn sample(&self, rng: &mut Rng) -> PlanarPose {
        self.clues.anywhere(&self.office, rng)
    }

    fn max_jump_m(&self) -> f64 {
        2.0 // as on a field
    }

    fn propose(&self, rng: &mut Rng) -> PlanarPose {
        self.clues.propose(&self.office, rng)
    }

    fn propose_heading(&self, x_m: f64, y_m: f64, rng: &mut Rng) -> f64 {
        let (entries, _) = self.index.around(x_m, y_m);
        let num = entries.len();
        let line = |i: usize| &self.lines[entries[i].line as usize];
        self.clues.propose_heading((x_m, y_m), num, line, rng)
    }
}

/// What is seen from a pose: worked out once for each pose, used for each line.
#[derive(Debug, Clone, Copy)]
struct View {
    eye: Point2<f64>,
    /// Projection of points of the world to homogeneous undistorted pixels.
    ideal_from_world: Matrix3x4<f64>,
}

impl View {
    #[inline]
    fn new(pose: &PlanarPose, ideal_from_robot: &Matrix3x4<f64>, eye_in_robot: &Point3<f64>) -> Self {
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let (x, y) = (pose.x_m, pose.y_m);
        let mut ideal_from_world = *ideal_from_robot;
        for r in 0..3 {
            let (a, b) = (ideal_from_robot[(r, 0)], ideal_from_robot[(r, 1)]);
            let (turned_a, turned_b) = (a * cos - b * sin, a * sin + b * cos);
            ideal_from_world[(r, 0)] = turned_a;
            ideal_from_world[(r, 1)] = turned_b;
            ideal_from_world[(r, 3)] -= turned_a * x + turned_b * y;
        }
        let eye = Vector2::new(
            cos * eye_in_robot.x - sin * eye_in_robot.y,
            sin * eye_in_robot.x + cos * eye_in_robot.y,
        );
        Self { eye: Point2::new(x, y) + eye, ideal_from_world }
    }

    /// Both ends of a line in undistorted pixels, the part behind the camera cut off; `None` if all of it is.
    #[inline]
    fn project(&self, line: &TheoreticalLine) -> Option<[Point2<f64>; 2]> {
        let p = &self.ideal_from_world;
        let row = |r: usize, at: &Point2<f64>, z: f64| {
            p[(r, 0)] * at.x + p[(r, 1)] * at.y + p[(r, 2)] * z + p[(r, 3)]
        };
        let start_w = row(2, &line.start, 0.0);
        let end_w = row(2, &line.end, line.end_height_m);
        if start_w < NEAR_M && end_w < NEAR_M {
            return None;
        }
        let start = [row(0, &line.start, 0.0), row(1, &line.start, 0.0), start_w];
        let end = [row(0, &line.end, line.end_height_m), row(1, &line.end, line.end_height_m), end_w];
        let start_cut = if start_w < NEAR_M { cut(&end, &start) } else { start };
        let end_cut = if end_w < NEAR_M { cut(&start, &end) } else { end };
        let pixel = |h: &[f64; 3]| Point2::new(h[0] / h[2], h[1] / h[2]);
        Some([pixel(&start_cut), pixel(&end_cut)])
    }
}

/// The point between one that lies ahead and one that does not, on the near plane.
#[inline]
fn cut(ahead: &[f64; 3], behind: &[f64; 3]) -> [f64; 3] {
    let t = (ahead[2] - NEAR_M) / (ahead[2] - behind[2]);
    [0, 1, 2].map(|i| ahead[i] + t * (behind[i] - ahead[i]))
}
