//! The analysis of one image, step by step.

use nalgebra::Point2;
use visloc_core::{Frame, Rng, Timestamp, geom::Horizon};
use visloc_world::field::GoalColor;

use super::{
    FieldAnalysisConfig, FieldEnd, GoalBlob, Obstacle,
    bare::BarePatches,
    blobs::{BlobFinder, Feet},
    carpet::Carpet,
    edges::{Edge, edges_of_runs},
    features::{self, FeatureDetector},
    isolation::goes_on,
    objects::{ObjectDetector, ObjectView},
    obstacles::ObstacleFinder,
    scan::{Direction, Run, ScanLine, horizon_row, layout, scan_line},
};
use crate::{
    ConfigError,
    vision::{
        AnalysisError, BorderPixel, DropReason, DroppedPixel, FeatureKind, FeaturePixel, Percept, blur_px,
        color::{ColorClass, ColorTable},
        ground_distance_m, px_in,
    },
};

/// Obstacles and goals reach so far beyond what was found of them, pixels of an image 320 px wide.
const MARGIN_PX: u32 = 2;
/// Between two searches for robots and balls, seconds: a fifth, since images do not come exactly in time a little less.
const LEAST_LOOK_SECS: f64 = 0.18;

/// Finds border pixels of lines and goals. Keeps its buffers and what the carpet looks like from image to image.
#[derive(Debug)]
pub struct FieldAnalyzer {
    config: FieldAnalysisConfig,
    table: ColorTable,
    carpet: Carpet,
    lines: Vec<ScanLine>,
    runs: Vec<Run>,
    edges: Vec<Edge>,
    line_pixels: Vec<FeaturePixel>,
    goal_pixels: Vec<FeaturePixel>,
    line_borders: Vec<BorderPixel>,
    goal_borders: Vec<BorderPixel>,
    field_end: FieldEnd,
    blobs: BlobFinder,
    obstacles: ObstacleFinder,
    bare: BarePatches,
    features: FeatureDetector,
    objects: ObjectDetector,
    looked_at: Option<Timestamp>,
    percept: Percept,
}

impl FieldAnalyzer {
    /// An analyzer with checked parameters.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn new(config: FieldAnalysisConfig) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self::with_checked(config))
    }

    /// The same analyzer for another camera, of whose images it has learned nothing.
    #[must_use]
    pub fn anew(&self) -> Self {
        Self::with_checked(self.config)
    }

    fn with_checked(config: FieldAnalysisConfig) -> Self {
        Self {
            config,
            table: ColorTable::new(&config.colors, config.goal_colors),
            carpet: Carpet::default(),
            lines: Vec::new(),
            runs: Vec::new(),
            edges: Vec::new(),
            line_pixels: Vec::new(),
            goal_pixels: Vec::new(),
            line_borders: Vec::new(),
            goal_borders: Vec::new(),
            field_end: FieldEnd::default(),
            blobs: BlobFinder::default(),
            obstacles: ObstacleFinder::default(),
            bare: BarePatches::default(),
            features: FeatureDetector::default(),
            objects: ObjectDetector::default(),
            looked_at: None,
            percept: Percept::default(),
        }
    }

    /// Analyzes the image of a frame. `rng` decides which pixels the random discard takes out.
    ///
    /// # Errors
    /// If the image has another size than its camera calibration, or the camera's pose on the robot is not finite.
    pub fn analyze(&mut self, frame: &Frame, rng: &mut Rng) -> Result<&Percept, AnalysisError> {
        self.percept.begin(frame)?;
        let horizon = Horizon::new(&frame.camera, &frame.robot_from_camera);
        let ground_m = |x, y| ground_distance_m(frame, &Point2::new(f64::from(x), f64::from(y)));
        self.carpet.look(&frame.image, &mut self.table, ground_m);
        self.scan(frame, &horizon);
        self.filter(frame, &horizon);
        self.find_features(frame);
        self.find_objects(frame);
        self.keep_some(rng);
        Ok(&self.percept)
    }

    /// The last percept.
    pub fn percept(&self) -> &Percept {
        &self.percept
    }

    /// The end of the field in the last image.
    pub fn field_end(&self) -> &FieldEnd {
        &self.field_end
    }

    /// Goal blobs of the last image, valid or not.
    pub fn goal_blobs(&self) -> &[GoalBlob] {
        self.blobs.blobs()
    }

    /// Obstacles of the last image.
    pub fn obstacles(&self) -> &[Obstacle] {
        self.obstacles.obstacles()
    }

    fn scan(&mut self, frame: &Frame, horizon: &Horizon) {
        let (image, camera) = (&frame.image, &frame.camera);
        layout(&self.config, camera.size_px(), horizon, &mut self.lines);
        self.edges.clear();
        self.blobs.clear();
        self.obstacles.clear();
        self.features.clear();
        self.bare.begin(camera.size_px(), px_in(image.width(), self.config.column_step_px) / 2);
        let composite = &self.config.composite;
        let white = self.table.white_threshold(self.carpet.luma());
        let (focal_px, scale) = (camera.focal_px().0, f64::from(blur_px(image.width())));
        for line in &self.lines {
            let carpet_luma = self.carpet.luma_at(line.pixel(line.from).1, image.height());
            scan_line(image, &self.table, line, carpet_luma, &mut self.runs);
            self.bare.add(line, &self.runs);
            let first_edge = self.edges.len();
            edges_of_runs(image, line, &self.runs, &mut self.edges);
            match line.direction {
                Direction::Horizontal => {
                    self.blobs.add_row(line, &self.runs);
                    let blur_px = px_in(image.width(), 1);
                    let edges = &mut self.edges[first_edge..];
                    self.blobs.mark_upright(edges, self.config.max_post_slope, blur_px);
                    if composite.is_on {
                        self.features.add_row(line, &self.runs, white, composite);
                    }
                }
                Direction::Vertical => {
                    let distance = |px: &Point2<f64>| ground_distance_m(frame, px);
                    self.obstacles.add_column(&self.config, line, &self.runs, (focal_px, scale), distance);
                }
            }
        }
        let step = px_in(image.width(), self.config.field_end_step_px);
        let line_width_m = self.config.line_width_m;
        let line_px = |column: u32, row: u32| {
            let distance_m = ground_distance_m(frame, &Point2::new(f64::from(column), f64::from(row)));
            distance_m.map_or(0, |distance_m| {
                thickness_px(frame, Direction::Vertical, line_width_m, distance_m).ceil() as u32
            })
        };
        let first_row = horizon_row(horizon, camera.size_px());
        self.bare.finish(camera, first_row, &mut self.percept.bare_ground);
        self.field_end.find((image, &self.table), step, first_row, line_px);
        let feet = Feet { frame, table: &self.table, diameter_m: composite.post_diameter_m };
        self.blobs.finish(&self.config, camera.size_px(), &self.field_end, &feet);
        self.obstacles.finish(&self.config, (focal_px, scale), &self.field_end);
    }

    fn filter(&mut self, frame: &Frame, horizon: &Horizon) {
        self.line_pixels.clear();
        self.goal_pixels.clear();
        self.line_borders.clear();
        self.goal_borders.clear();
        let view = features::GroundView::new(frame, &self.table);
        for edge in &self.edges {
            let is_line = edge.kind == FeatureKind::FieldLine;
            // Most edges of curtains and walls end here, before anything is computed for them.
            if is_line && self.config.filters.beside_carpet && !edge.is_beside_carpet {
                let reason = DropReason::NotBesideCarpet;
                self.percept.dropped.push(DroppedPixel { px: edge.px, kind: edge.kind, reason });
                continue;
            }
            let ideal_px = frame.camera.ideal_px(&edge.px);
            let reason = if is_line {
                self.line_drop_reason(frame, edge, horizon.is_above(&ideal_px))
            } else {
                self.goal_drop_reason(frame, edge, horizon.is_above(&ideal_px))
            };
            if let Some(reason) = reason {
                self.percept.dropped.push(DroppedPixel { px: edge.px, kind: edge.kind, reason });
                continue;
            }
            let pixel = FeaturePixel { px: edge.px, ideal_px, kind: edge.kind };
            let border = BorderPixel { ideal_px, inward: edge.inward(), kind: edge.kind };
            if is_line {
                self.line_pixels.push(pixel);
                self.line_borders.push(border);
                if self.config.composite.is_on {
                    self.features.add_border(&view, edge, ideal_px, edge.white_luma);
                }
            } else {
                self.goal_pixels.push(pixel);
                self.goal_borders.push(border);
            }
        }
    }

    /// Composite features, from what the filters let pass.
    fn find_features(&mut self, frame: &Frame) {
        let Self { features: detector, table, config, field_end, blobs, percept, goal_borders, .. } = self;
        if !config.composite.is_on {
            percept.features.clear();
            return;
        }
        let margin = px_in(frame.image.width(), MARGIN_PX);
        let is_goal = |color, px| {
            let kind =
                if color == GoalColor::Yellow { FeatureKind::YellowGoal } else { FeatureKind::BlueGoal };
            blobs.is_in_valid_blob(kind, px, margin)
        };
        let view = features::GroundView::new(frame, table);
        detector.finish(&view, config, field_end, is_goal, &mut percept.features);
        goal_borders.extend_from_slice(detector.post_borders());
    }

    /// Robots and balls, which the posts that were found are not. They are told to others five times a second, so more often is of no use.
    fn find_objects(&mut self, frame: &Frame) {
        let Self { objects, table, config, field_end, percept, carpet, looked_at, .. } = self;
        percept.objects.clear();
        let is_time = looked_at.is_none_or(|before| frame.at.secs_since(before).abs() >= LEAST_LOOK_SECS);
        if config.detect_objects && is_time {
            *looked_at = Some(frame.at);
            percept.objects.extend_from_slice(objects.find(&ObjectView {
                frame,
                table,
                carpet_luma: carpet.luma(),
                field_end,
                posts: &percept.features.posts,
                ball_diameter_m: config.ball_diameter_m,
                own_body_m: config.own_body_distance_m,
            }));
        }
    }

    fn line_drop_reason(&self, frame: &Frame, edge: &Edge, is_above: bool) -> Option<DropReason> {
        let switches = &self.config.filters;
        if switches.isolated && self.is_isolated(frame, edge) {
            return Some(DropReason::Isolated);
        }
        // Without a ground point a line pixel is of no use, so this part of the filter has no switch.
        let distance_m = if is_above { None } else { ground_distance_m(frame, &edge.px) };
        let Some(distance_m) = distance_m else { return Some(DropReason::BeyondHorizon) };
        if switches.too_thin
            && f64::from(edge.run_px) < self.min_thickness_px(frame, edge.direction, distance_m)
        {
            return Some(DropReason::TooThin);
        }
        if switches.horizon && distance_m > self.config.max_line_distance_m {
            return Some(DropReason::BeyondHorizon);
        }
        if switches.own_body && distance_m < self.config.own_body_distance_m {
            return Some(DropReason::OwnBody);
        }
        if switches.field_end && edge.px.y < self.field_end.row_px(edge.px.x) {
            return Some(DropReason::BeyondFieldEnd);
        }
        let margin = px_in(frame.image.width(), MARGIN_PX);
        let in_obstacle = || self.obstacles.obstacles().iter().any(|o| o.contains(edge.inside_px, margin));
        (switches.obstacles && in_obstacle()).then_some(DropReason::InObstacle)
    }

    fn goal_drop_reason(&self, frame: &Frame, edge: &Edge, is_above: bool) -> Option<DropReason> {
        let switches = &self.config.filters;
        let is_post_or_bar = match edge.direction {
            Direction::Horizontal => edge.is_upright,
            Direction::Vertical => is_above,
        };
        if switches.post_or_bar && !is_post_or_bar {
            return Some(DropReason::NotPostOrBar);
        }
        if switches.isolated && self.is_isolated(frame, edge) {
            return Some(DropReason::Isolated);
        }
        let is_near = |d: f64| d < self.config.own_body_distance_m;
        if switches.own_body && ground_distance_m(frame, &edge.px).is_some_and(is_near) {
            return Some(DropReason::OwnBody);
        }
        let margin = px_in(frame.image.width(), MARGIN_PX);
        let is_in_blob = || self.blobs.is_in_valid_blob(edge.kind, edge.inside_px, margin);
        (switches.goal_blobs && !is_in_blob()).then_some(DropReason::NotInGoalBlob)
    }

    /// Shortest run that can be a line at this distance. Lines at an angle are longer.
    fn min_thickness_px(&self, frame: &Frame, direction: Direction, distance_m: f64) -> f64 {
        let thickness_px = thickness_px(frame, direction, self.config.line_width_m, distance_m);
        // Runs are whole pixels, so one pixel less is always possible.
        self.config.min_thickness_share * thickness_px - 1.0
    }

    /// Fewer than the wanted number of the eight neighbors have the pixel's color, or, with learned colors, a thin line does not go on.
    fn is_isolated(&self, frame: &Frame, edge: &Edge) -> bool {
        let image = &frame.image;
        let class = |x, y| self.table.class_beside_carpet(image.get(x, y), edge.white_luma);
        if self.table.is_learned() && edge.kind == FeatureKind::FieldLine {
            let size_px = (image.width(), image.height());
            return !goes_on(edge, size_px, |x, y| class(x, y) == ColorClass::White);
        }
        let step = px_in(image.width(), 1);
        let (x, y) = edge.inside_px;
        if x < step || y < step || x + step >= image.width() || y + step >= image.height() {
            return false; // the ring is cut by the border: not enough to judge
        }
        let own = class(x, y);
        let (left, right, above, below) = (x - step, x + step, y - step, y + step);
        let ring = [
            (left, above),
            (x, above),
            (right, above),
            (left, y),
            (right, y),
            (left, below),
            (x, below),
            (right, below),
        ];
        let same = ring.iter().filter(|(x, y)| class(*x, *y) == own).count();
        (same as u32) < self.config.min_neighbors
    }

    /// Random discard and quality.
    fn keep_some(&mut self, rng: &mut Rng) {
        let Self { percept, config, line_pixels, goal_pixels, line_borders, goal_borders, blobs, .. } = self;
        blobs.perceived(&mut percept.blobs);
        thin_out(line_borders, config.max_line_borders, &mut percept.borders);
        thin_out(goal_borders, config.max_goal_borders, &mut percept.borders);
        for (pixels, max) in
            [(&mut *line_pixels, config.max_line_pixels), (&mut *goal_pixels, config.max_goal_pixels)]
        {
            percept.keep(pixels, config.filters.random_discard.then_some(max), rng);
        }
        let min_lines = config.min_informative_lines.unwrap_or(0);
        let lines_suffice = min_lines > 0 && line_pixels.len() >= min_lines;
        percept.is_informative = !goal_pixels.is_empty() || lines_suffice;
        percept.quality = quality(config, line_pixels.len(), goal_pixels.len());
    }
}

/// How thick a line is at this distance: one across the view on a vertical scan line, one along the view on a horizontal one.
fn thickness_px(frame: &Frame, direction: Direction, line_width_m: f64, distance_m: f64) -> f64 {
    let height_m = frame.robot_from_camera.translation().z;
    let slant_m = distance_m.hypot(height_m);
    let (fx, fy) = frame.camera.focal_px();
    match direction {
        Direction::Horizontal => fx * line_width_m / slant_m,
        Direction::Vertical => fy * line_width_m * height_m / (slant_m * slant_m),
    }
}

/// Appends at most `max` of the pixels, evenly spread over their order, which is that of the scan lines.
fn thin_out(pixels: &[BorderPixel], max: usize, out: &mut Vec<BorderPixel>) {
    let count = pixels.len().min(max);
    out.extend((0..count).map(|i| pixels[i * pixels.len() / count]));
}

/// Quality of an image, 0 to 1. Source: 2010 section 4.3.3.
fn quality(config: &FieldAnalysisConfig, num_lines: usize, num_goals: usize) -> f64 {
    let part = |base: f64, gain: f64, n: usize, max: usize| {
        if n == 0 { 0.0 } else { base + gain * (n as f64 / max as f64).min(1.0) }
    };
    part(0.2, 0.2, num_lines, config.max_line_pixels) + part(0.2, 0.4, num_goals, config.max_goal_pixels)
}
