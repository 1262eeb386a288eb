//! The observation model: pixels against the theoretical lines near a pose.

use std::sync::Arc;

use nalgebra::{Matrix3x4, Point2, Point3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use visloc_core::{Rng, geom::PlanarPose, settings::check_ranges};
use visloc_world::office::Office;

use super::{
    lines::TheoreticalLine,
    propose::Clues,
    sights::{Sights, Window},
    view::View,
};
use crate::{
    ConfigError, ObservationModel, Region,
    observation::projection::{combine, projection},
    vision::{FeatureKind, Percept},
};

visloc_core::with_defaults! {
    /// Parameters of the observation model of a building.
    #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct OfficeModelConfig {
        /// Distance in the image at which a pixel agrees with nothing (`D`), pixels of an image 320 px wide. The documents have
        /// 50; places that look alike differ by a few pixels, and a smaller distance tells them apart sooner.
        #[schemars(range(max = 1e6), extend("exclusiveMinimum" = 0.0))]
        pub max_distance_px: f64 = 15.0,
        /// Lines that are farther away are not looked at, meters.
        #[schemars(range(min = 0.5, max = 100.0))]
        pub range_m: f64 = 13.0,
    }
}

/// Pixels of a percept that are weighed at most. More of them are thinned out evenly.
const MAX_PIXELS: usize = 128;

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
    sights: Arc<Sights>,
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
        check_ranges(config)?;
        Ok(Self {
            config: *config,
            sights: Arc::new(Sights::new(office, config.range_m)),
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
    pub fn office(&self) -> &Office {
        &self.sights.office
    }

    /// What can be seen from where, for other models of the same building.
    pub(super) fn sights(&self) -> &Arc<Sights> {
        &self.sights
    }

    /// The theoretical image: visits each line that is seen from a pose with its ends in undistorted pixels.
    pub fn theoretical_image(
        &self,
        world_from_robot: &PlanarPose,
        mut visit: impl FnMut(FeatureKind, [Point2<f64>; 2]),
    ) {
        let view = View::new(world_from_robot, &self.ideal_from_robot, &self.eye_in_robot);
        let any = |_: &TheoreticalLine| true;
        self.sights.visit_seen(&world_from_robot.position(), &view, &self.window(), any, |line, ends| {
            visit(line.kind, *ends);
        });
    }

    /// What comes near enough to the image to be near any pixel.
    #[inline]
    fn window(&self) -> Window {
        Window { size_px: self.size_px, margin_px: self.max_distance_px }
    }

    /// Sums of the pixel distances of doors and of the floor, and how many pixels there are of each.
    #[inline]
    fn distances(&self, world_from_robot: &PlanarPose) -> [(f64, usize); 2] {
        let view = View::new(world_from_robot, &self.ideal_from_robot, &self.eye_in_robot);
        let max2 = (self.max_distance_px * self.max_distance_px) as f32;
        let mut smallest2 = [max2; MAX_PIXELS];
        let group = |line: &TheoreticalLine| self.groups.iter().find(|group| group.kind == line.kind);
        let is_wanted = |line: &TheoreticalLine| group(line).is_some();
        self.sights.visit_seen(
            &world_from_robot.position(),
            &view,
            &self.window(),
            is_wanted,
            |line, ends| {
                if let Some(group) = group(line) {
                    let pixels = group.from..group.to;
                    nearer(ends, &self.u[pixels.clone()], &self.v[pixels.clone()], &mut smallest2[pixels]);
                }
            },
        );
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
fn nearer([start, end]: &[Point2<f64>; 2], u: &[f32], v: &[f32], smallest2: &mut [f32]) {
    let (x, y) = (start.x as f32, start.y as f32);
    let (dx, dy) = ((end.x - start.x) as f32, (end.y - start.y) as f32);
    let inverse_length2 = 1.0 / (dx * dx + dy * dy).max(1e-6);
    for ((u, v), smallest2) in u.iter().zip(v).zip(smallest2) {
        let (px, py) = (u - x, v - y);
        let t = ((px * dx + py * dy) * inverse_length2).clamp(0.0, 1.0);
        let (off_x, off_y) = (px - t * dx, py - t * dy);
        let off2 = off_x * off_x + off_y * off_y;
        *smallest2 = if off2 < *smallest2 { off2 } else { *smallest2 };
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
        if !self.sights.office.free_space().contains(world_from_robot.x_m, world_from_robot.y_m) {
            return 0.0;
        }
        let [doors, floor] = self.distances(world_from_robot);
        combine(self.max_distance_px, doors, floor)
    }

    fn region(&self) -> Region {
        let [min, max] = self.sights.office.free_space().bounds_m();
        Region { min_x_m: min.x, max_x_m: max.x, min_y_m: min.y, max_y_m: max.y }
    }

    fn sample(&self, rng: &mut Rng) -> PlanarPose {
        self.clues.anywhere(&self.sights.office, rng)
    }

    fn max_jump_m(&self) -> f64 {
        2.0 // as on a field
    }

    fn propose(&self, rng: &mut Rng) -> PlanarPose {
        self.clues.propose(&self.sights.office, rng)
    }

    fn propose_heading(&self, x_m: f64, y_m: f64, rng: &mut Rng) -> f64 {
        let (entries, _) = self.sights.index.around(x_m, y_m);
        let num = entries.len();
        let line = |i: usize| &self.sights.lines[entries[i].line as usize];
        self.clues.propose_heading((x_m, y_m), num, line, rng)
    }
}
