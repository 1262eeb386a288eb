//! The analysis of one image, step by step.

use nalgebra::{Point2, Vector2};
use visloc_core::{Frame, Rng, geom::Horizon, settings::check_ranges};

use super::{
    ContourDetector, EdgeSegment, GradientDetector, Labelled, OfficeAnalysisConfig, OfficeColors,
    OfficeTable, SegmentDetector, fusion::fuse, grid::Grid, label::label, light::LightColor,
};
use crate::{
    ConfigError,
    vision::{
        AnalysisError, BorderPixel, DoorSide, DropReason, DroppedPixel, FeatureKind, FeaturePixel, Percept,
        ground_distance_m,
    },
};

/// Rows above the horizon that are still looked at, so that an edge at the horizon is seen whole, pixels.
const ROWS_ABOVE_HORIZON: f64 = 6.0;
/// Border pixels that are handed on for the refinement at most.
const MAX_BORDERS: usize = 120;

/// Finds pixels on borders of doors and of the floor. Keeps its buffers from image to image.
#[derive(Debug, Clone)]
pub struct OfficeAnalyzer {
    config: OfficeAnalysisConfig,
    table: OfficeTable,
    light: LightColor,
    gradient: GradientDetector,
    contour: ContourDetector,
    segments: Vec<EdgeSegment>,
    lines: Vec<Labelled>,
    doors: Vec<FeaturePixel>,
    floor: Vec<FeaturePixel>,
    percept: Percept,
}

impl OfficeAnalyzer {
    /// An analyzer for a building of the given colors.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn new(config: OfficeAnalysisConfig, colors: &OfficeColors) -> Result<Self, ConfigError> {
        check_ranges(&config)?;
        Ok(Self::with_checked(config, OfficeTable::new(colors), LightColor::white(colors)))
    }

    /// The same analyzer for another camera.
    #[must_use]
    pub fn anew(&self) -> Self {
        Self::with_checked(self.config, self.table.clone(), self.light.clone())
    }

    fn with_checked(config: OfficeAnalysisConfig, table: OfficeTable, light: LightColor) -> Self {
        Self {
            config,
            table,
            light,
            gradient: GradientDetector::default(),
            contour: ContourDetector::default(),
            segments: Vec::new(),
            lines: Vec::new(),
            doors: Vec::new(),
            floor: Vec::new(),
            percept: Percept::default(),
        }
    }

    /// Analyzes the image of a frame. `rng` decides which pixels the random discard takes out.
    ///
    /// # Errors
    /// If the image has another size than its camera calibration, or the camera's pose on the robot is not finite.
    pub fn analyze(&mut self, frame: &Frame, rng: &mut Rng) -> Result<&Percept, AnalysisError> {
        self.percept.begin(frame)?;
        let scale = (f64::from(frame.image.width()) / 320.0).max(1.0);
        let view = View::new(frame);
        self.find_lines(frame, &view, scale);
        self.collect_pixels(&view, scale);
        self.keep_some(rng);
        Ok(&self.percept)
    }

    /// The last percept.
    pub fn percept(&self) -> &Percept {
        &self.percept
    }

    /// The lines of the last image that were kept: labelled, joined and long enough.
    pub fn lines(&self) -> &[Labelled] {
        &self.lines
    }

    /// Red, green and blue of the light, as the images of late show it; green is 1.
    pub fn light_color(&self) -> [f64; 3] {
        self.light.rgb()
    }

    /// All straight edges of the last image, as the detector found them.
    pub fn segments(&self) -> &[EdgeSegment] {
        &self.segments
    }

    /// Edges, labels, fusion, and the filters on whole lines.
    fn find_lines(&mut self, frame: &Frame, view: &View<'_>, scale: f64) {
        let config = self.config;
        let first_row = if config.filters.horizon { view.first_row() } else { 0 };
        self.segments.clear();
        let (step, length_px) = (config.min_step, config.min_segment_px * scale);
        match config.detector {
            SegmentDetector::Gradient => {
                self.gradient.detect(&frame.image, first_row, step, length_px, &mut self.segments);
            }
            SegmentDetector::Contour => {
                self.contour.detect(&frame.image, first_row, step, length_px, &mut self.segments);
            }
        }
        self.lines.clear();
        if config.light_follow > 0.0 {
            self.light.update(&frame.image, &self.segments, config.light_follow);
        }
        let class_of = |rgb| self.table.class(self.light.in_white(rgb));
        let (percept, lines) = (&mut self.percept, &mut self.lines);
        for edge in &self.segments {
            label(&frame.image, &class_of, edge, config.min_wall_share, |segment, kind| {
                let reason = match kind {
                    None => Some(DropReason::UnknownColors),
                    Some(kind) if config.filters.upright => {
                        let lean_deg = view.lean_deg(&segment);
                        if kind.is_door_edge() {
                            (lean_deg > config.max_lean_deg).then_some(DropReason::NotUpright)
                        } else {
                            (lean_deg < config.min_floor_lean_deg).then_some(DropReason::Upright)
                        }
                    }
                    Some(_) => None,
                };
                match reason {
                    Some(reason) => drop_line(percept, kind, &segment, reason),
                    None => lines.push(Labelled { segment, kind }),
                }
            });
        }
        fuse(&mut self.lines, config.max_gap_px * scale);
        if config.filters.short {
            let (percept, min_px) = (&mut self.percept, config.min_line_px * scale);
            self.lines.retain(|line| {
                let is_long = line.segment.length_px() >= min_px;
                if !is_long {
                    drop_line(percept, line.kind, &line.segment, DropReason::TooShort);
                }
                is_long
            });
        }
    }

    /// Pixels of all lines, below the horizon and near enough.
    fn collect_pixels(&mut self, view: &View<'_>, scale: f64) {
        let config = &self.config;
        let grid = Grid {
            first_row_px: view.horizon_row(),
            last_row_px: f64::from(view.frame.image.height()),
            cell_px: [config.min_cell_px * scale, config.max_cell_px * scale],
        };
        self.doors.clear();
        self.floor.clear();
        for line in &self.lines {
            let Some(kind) = line.kind else { continue };
            grid.crossings(&line.segment, |px| {
                let ideal_px = view.frame.camera.ideal_px(&px);
                let pixel = FeaturePixel { px, ideal_px, kind };
                let is_above = view.horizon.is_above(&ideal_px);
                let is_far =
                    || !ground_distance_m(view.frame, &px).is_some_and(|d| d <= config.max_distance_m);
                let is_dropped = if kind.is_door_edge() {
                    config.filters.horizon && is_above
                } else {
                    is_above || is_far()
                };
                if is_dropped {
                    let reason = DropReason::BeyondHorizon;
                    self.percept.dropped.push(DroppedPixel { px, kind, reason });
                } else if kind.is_door_edge() {
                    self.doors.push(pixel);
                } else {
                    self.floor.push(pixel);
                }
            });
        }
    }

    /// Random discard and quality.
    fn keep_some(&mut self, rng: &mut Rng) {
        let Self { percept, config, doors, floor, .. } = self;
        let found = doors.len() + floor.len();
        let thinning = found.div_ceil(MAX_BORDERS).max(1);
        percept.borders.extend(doors.iter().chain(floor.iter()).step_by(thinning).map(border));
        for (pixels, max) in [(&mut *doors, config.max_door_pixels), (&mut *floor, config.max_floor_pixels)] {
            percept.keep(pixels, config.filters.random_discard.then_some(max), rng);
        }
        let share = doors.len() as f64 / config.full_quality_pixels as f64;
        percept.quality = share.min(1.0);
        percept.is_informative = !doors.is_empty();
    }
}

/// A pixel with the side on which its door, or the floor, lies.
fn border(pixel: &FeaturePixel) -> BorderPixel {
    let inward = match pixel.kind {
        FeatureKind::DoorEdge { side: DoorSide::Left, .. } => Vector2::x(),
        FeatureKind::DoorEdge { side: DoorSide::Right, .. } => -Vector2::x(),
        _ => Vector2::y(),
    };
    BorderPixel { ideal_px: pixel.ideal_px, inward, kind: pixel.kind }
}

fn drop_line(percept: &mut Percept, kind: Option<FeatureKind>, segment: &EdgeSegment, reason: DropReason) {
    let px = nalgebra::center(&segment.start, &segment.end);
    percept.dropped.push(DroppedPixel { px, kind: kind.unwrap_or(FeatureKind::UnknownLine), reason });
}

/// Where the camera looks.
struct View<'a> {
    frame: &'a Frame,
    horizon: Horizon,
}

impl<'a> View<'a> {
    fn new(frame: &'a Frame) -> Self {
        Self { frame, horizon: Horizon::new(&frame.camera, &frame.robot_from_camera) }
    }

    /// Row of the horizon in the middle of the image.
    fn horizon_row(&self) -> f64 {
        let (width, height) = self.frame.camera.size_px();
        self.horizon.row_px(0.5 * f64::from(width)).unwrap_or(0.0).clamp(0.0, f64::from(height))
    }

    /// The first row that can hold something below the horizon.
    fn first_row(&self) -> usize {
        let (width, height) = self.frame.camera.size_px();
        let rows = [0.0, f64::from(width)].map(|column| self.horizon.row_px(column).unwrap_or(0.0));
        (rows[0].min(rows[1]) - ROWS_ABOVE_HORIZON).clamp(0.0, f64::from(height)) as usize
    }

    /// How far the plane of a segment's two rays leans from the vertical, degrees: 0 for the picture of an upright edge.
    fn lean_deg(&self, segment: &EdgeSegment) -> f64 {
        let ray = |px: &Point2<f64>| self.frame.robot_from_camera.rotate(&self.frame.camera.bearing(px));
        let normal = ray(&segment.start).cross(&ray(&segment.end));
        (normal.z.abs() / normal.norm().max(1e-12)).min(1.0).asin().to_degrees()
    }
}
