//! Pictures of a run: paths over the field, errors over time.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use visloc_core::{
    PlanarTrajectory, Timestamp,
    eval::{CarriedSpan, EstimateSample, Evaluation, EvaluationOptions, carried_spans},
};
use visloc_locate::LOCALIZED_RELIABILITY;
use visloc_plot::{
    Color, FieldPath, FieldPicture, Ground, Kidnap, Panel, PathPoint, Picture, ReferenceLine, Series, Span,
    TimeSeriesPicture, ValueAxis, field_picture, remove_earlier, time_series,
};
use visloc_world::Map;

/// One algorithm in the pictures.
pub struct Curve<'a> {
    /// In the legend.
    pub label: &'a str,
    /// Its answers.
    pub samples: Vec<EstimateSample>,
    /// Their errors, if there is a truth.
    pub comparison: Option<&'a Evaluation>,
    /// How many individuals were weighed at which time; may be empty.
    pub individuals: Vec<(Timestamp, usize)>,
}

/// Everything that the pictures of a run show.
pub struct RunPictures<'a> {
    /// Above every picture.
    pub title: String,
    /// Below the title.
    pub subtitle: String,
    /// Below the paths; without a map there is no picture of paths.
    pub map: Option<&'a Map>,
    /// Where the robot was; may be empty.
    pub truth: &'a PlanarTrajectory,
    /// The algorithms.
    pub curves: Vec<Curve<'a>>,
}

impl RunPictures<'_> {
    /// Draws all pictures into a folder. Returns the files' names without their ending.
    pub fn save(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        let mut saved = Vec::new();
        if let Some(map) = self.map {
            saved.extend(save(folder, "trajectories", self.paths(map))?);
        }
        saved.extend(save(folder, "errors", Some(self.errors_over_time()))?);
        saved.extend(save(folder, "individuals", self.individuals_over_time())?);
        Ok(saved)
    }

    fn paths(&self, map: &Map) -> Option<Picture> {
        let ground = ground(map)?;
        let spans = carried_spans(self.truth, &EvaluationOptions::default());
        let picture = FieldPicture {
            title: self.title.clone(),
            subtitle: self.subtitle.clone(),
            truth: (!self.truth.poses().is_empty()).then(|| self.truth_path(&spans)),
            estimates: self.curves.iter().enumerate().map(|(i, curve)| estimate_path(i, curve)).collect(),
            kidnaps: spans.iter().filter_map(|span| self.kidnap(span)).collect(),
            start: self.truth.poses().first().map(|pose| pose.world_from_robot),
            ..FieldPicture::default()
        };
        Some(field_picture(ground, &picture))
    }

    fn truth_path(&self, spans: &[CarriedSpan]) -> FieldPath {
        let is_carried = |at: Timestamp| spans.iter().any(|span| span.contains(at));
        let points = self.truth.poses().iter().map(|pose| match is_carried(pose.at) {
            true => PathPoint::gap(),
            false => PathPoint::localized(&pose.world_from_robot),
        });
        FieldPath { label: "truth".to_owned(), color: Color::BLACK, points: points.collect() }
    }

    fn kidnap(&self, span: &CarriedSpan) -> Option<Kidnap> {
        let pose_at = |at| self.truth.nearest(at, 0.1).map(|pose| pose.world_from_robot);
        Some(Kidnap { from: pose_at(span.from)?, to: pose_at(span.until?)? })
    }

    fn errors_over_time(&self) -> Picture {
        let start = self.start();
        let mut panels = Vec::new();
        if self.curves.iter().any(|curve| curve.comparison.is_some()) {
            panels.push(self.position_errors());
            let log = ValueAxis::Log { min: 0.1, max: 180.0 };
            panels.push(self.panel("heading error [deg]", log, |curve| {
                errors(curve, start, |error| error.heading_error_rad.to_degrees().max(0.1))
            }));
        }
        let has_reliability = |curve: &Curve<'_>| curve.samples.iter().any(|s| s.reliability.is_some());
        if !self.curves.iter().any(has_reliability) {
            return self.over_time(panels);
        }
        let mut reliability = self.panel("reliability", ValueAxis::Linear { min: 0.0, max: 1.0 }, |curve| {
            let value = |sample: &EstimateSample| {
                (sample.at.secs_since(start), sample.reliability.unwrap_or(f64::NAN))
            };
            curve.samples.iter().map(value).collect()
        });
        let label = "localized above".to_owned();
        reliability.references.push(ReferenceLine {
            value: LOCALIZED_RELIABILITY,
            label,
            color: Color::GRAY,
        });
        panels.push(reliability);
        self.over_time(panels)
    }

    /// How many individuals were weighed, above the error that they left; `None` if nobody counted them.
    fn individuals_over_time(&self) -> Option<Picture> {
        let counts = self.curves.iter().flat_map(|curve| &curve.individuals).map(|(_, count)| *count);
        let most = counts.max().filter(|most| *most > 0)?;
        let powers = (most as f64).log10().ceil().max(2.0);
        let axis = ValueAxis::Log { min: 10.0, max: 10.0_f64.powf(powers) };
        let start = self.start();
        let mut panels = vec![self.panel("individuals", axis, |curve| {
            let point = |(at, count): &(Timestamp, usize)| {
                (at.secs_since(start), if *count > 0 { *count as f64 } else { f64::NAN })
            };
            curve.individuals.iter().map(point).collect()
        })];
        if self.curves.iter().any(|curve| curve.comparison.is_some()) {
            panels.push(self.position_errors());
        }
        Some(self.over_time(panels))
    }

    fn position_errors(&self) -> Panel {
        let (start, log) = (self.start(), ValueAxis::Log { min: 0.001, max: 10.0 });
        self.panel("position error [m]", log, |curve| {
            errors(curve, start, |error| error.position_error_m.max(0.001))
        })
    }

    /// Time of the first pose.
    fn start(&self) -> Timestamp {
        let start = self.truth.poses().first().map(|pose| pose.at);
        let start = start.or_else(|| self.curves.iter().find_map(|curve| Some(curve.samples.first()?.at)));
        start.unwrap_or_default()
    }

    /// Panels above each other, shaded while the robot is carried.
    fn over_time(&self, panels: Vec<Panel>) -> Picture {
        let start = self.start();
        let end = self.truth.poses().last().map_or(start, |pose| pose.at);
        let spans = carried_spans(self.truth, &EvaluationOptions::default());
        let carried = spans.iter().map(|span| Span {
            start_secs: span.from.secs_since(start),
            end_secs: span.until.unwrap_or(end).secs_since(start),
            label: "carried".to_owned(),
        });
        time_series(&TimeSeriesPicture {
            title: self.title.clone(),
            subtitle: self.subtitle.clone(),
            panels,
            spans: carried.collect(),
            ..TimeSeriesPicture::default()
        })
    }

    fn panel(&self, label: &str, axis: ValueAxis, points: impl Fn(&Curve<'_>) -> Vec<(f64, f64)>) -> Panel {
        let series =
            |(i, curve): (usize, &Curve<'_>)| Series::new(curve.label, Color::series(i), points(curve));
        let series = self.curves.iter().enumerate().map(series).collect();
        Panel { label: label.to_owned(), axis, series, references: Vec::new() }
    }
}

/// What the paths of a map are drawn on; `None` for a kind of map that cannot be drawn.
pub fn ground(map: &Map) -> Option<Ground<'_>> {
    match map {
        Map::Field(field) => Some(field.into()),
        Map::Office(office) => Some(office.into()),
        _ => None,
    }
}

fn estimate_path(index: usize, curve: &Curve<'_>) -> FieldPath {
    let point = |sample: &EstimateSample| {
        let is_localized = sample.reliability.is_none_or(|reliability| reliability > LOCALIZED_RELIABILITY);
        PathPoint { is_localized, ..PathPoint::localized(&sample.world_from_robot) }
    };
    FieldPath {
        label: curve.label.to_owned(),
        color: Color::series(index),
        points: curve.samples.iter().map(point).collect(),
    }
}

fn errors(
    curve: &Curve<'_>,
    start: Timestamp,
    value: impl Fn(&visloc_core::eval::FrameError) -> f64,
) -> Vec<(f64, f64)> {
    let frames = curve.comparison.map_or(&[][..], |comparison| &comparison.frame_errors);
    // The error of a robot in somebody's hands says nothing.
    let value = |frame: &_| if is_carried(frame) { f64::NAN } else { value(frame) };
    frames.iter().map(|frame| (frame.at.secs_since(start), value(frame))).collect()
}

fn is_carried(frame: &visloc_core::eval::FrameError) -> bool {
    frame.is_carried
}

fn save(folder: &Path, name: &str, picture: Option<Picture>) -> Result<Option<PathBuf>> {
    let Some(picture) = picture else {
        remove_earlier(folder, |earlier| earlier == name);
        return Ok(None);
    };
    let path = folder.join(name);
    picture.save(folder, name).with_context(|| format!("{}: cannot draw it", path.display()))?;
    Ok(Some(path))
}
