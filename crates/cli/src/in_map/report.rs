//! What came of a camera in a map.

use std::{io::Write, path::Path};

use anyhow::{Context, Result};
use serde::Serialize;
use visloc_core::{CameraPose, CameraTrajectory, Timestamp, files::NewFile, median, quantile};
use visloc_plot::{Color, SpacePath, SpaceViews, space_views};
use visloc_vmap::{CameraEstimate, ScaleSource, Support, VisualMap};

use crate::report::{FindingReport, SkippedReport};

/// Largest difference of stamps that belong together, seconds.
const TOLERANCE_SECS: f64 = 0.01;
/// First line of the table of estimates. Seconds, map units (meters where the scale is known), radians.
const HEADER: &str =
    "t,x,y,z,qx,qy,qz,qw,map,reliability,sigma_x,sigma_y,sigma_z,sigma_angle,localized,carried,found";

/// One image.
#[derive(Debug, Clone, Copy)]
pub struct MapRecord {
    /// When.
    pub at: Timestamp,
    /// What is known then.
    pub estimate: Option<CameraEstimate>,
    /// Time that it took, seconds of the processor.
    pub secs: f64,
}

impl MapRecord {
    fn localized(&self) -> Option<&CameraEstimate> {
        self.estimate.as_ref().filter(|estimate| estimate.is_localized())
    }
}

/// What `--json` has.
#[derive(Debug, Serialize)]
pub struct InMapReport {
    /// The source.
    pub source: String,
    /// The map.
    pub map: String,
    /// What a unit of length is.
    pub unit: &'static str,
    /// Images that were used.
    pub frames: usize,
    /// Share of them in which the camera was localized, 0 to 1.
    pub localized: f64,
    /// Share of them in which the camera was localized though its image shows hardly anything of the map: carried on by what it has seen
    /// since.
    pub carried_by_motion: f64,
    /// The same, carried on by the odometry of a robot.
    pub carried_by_odometry: f64,
    /// How often the camera was found from nothing.
    pub found: usize,
    /// From the first image to the first place, seconds.
    pub first_after_s: Option<f64>,
    /// Time of an image, milliseconds of the processor: median and longest.
    pub median_ms: Option<f64>,
    /// See above.
    pub max_ms: Option<f64>,
    /// Against the truth, where map and truth have the same frame.
    pub error: Option<InMapError>,
    /// The same of the images in which the camera was carried on alone.
    pub carried_error: Option<InMapError>,
    /// Why so little was localized; empty if enough was.
    pub diagnosis: Vec<FindingReport>,
    /// What was left out.
    pub skipped: SkippedReport,
    /// Why the source ended early.
    pub broken: Option<String>,
}

/// Errors of the localized images.
#[derive(Debug, Serialize)]
pub struct InMapError {
    /// Localized images with a truth.
    pub compared: usize,
    /// Median of the position, meters.
    pub median_m: f64,
    /// 95 % are below, meters.
    pub p95_m: f64,
    /// Largest, meters.
    pub max_m: f64,
    /// Median of the orientation, degrees.
    pub median_deg: f64,
}

/// The numbers of a run.
pub fn summarize(
    names: (&str, &str),
    map: &VisualMap,
    records: &[MapRecord],
    truth: Option<&CameraTrajectory>,
    skipped: SkippedReport,
    broken: Option<String>,
) -> InMapReport {
    let share = |num: usize| num as f64 / records.len().max(1) as f64;
    let localized: Vec<&CameraEstimate> = records.iter().filter_map(MapRecord::localized).collect();
    let rests_on = |support| localized.iter().filter(|estimate| estimate.support == support).count();
    let mut times: Vec<f64> = records.iter().map(|record| record.secs * 1e3).collect();
    times.sort_by(f64::total_cmp);
    let first = records.first().zip(localized.first()).map(|(start, first)| first.at.secs_since(start.at));
    InMapReport {
        source: names.0.to_owned(),
        map: names.1.to_owned(),
        unit: unit(map),
        frames: records.len(),
        localized: share(localized.len()),
        carried_by_motion: share(rests_on(Support::Motion)),
        carried_by_odometry: share(rests_on(Support::Odometry)),
        found: records.iter().filter(|r| r.estimate.is_some_and(|e| e.is_found)).count(),
        first_after_s: first,
        median_ms: quantile(&times, 0.5),
        max_ms: times.last().copied(),
        error: truth.and_then(|truth| error(map, &localized, truth)),
        carried_error: truth.and_then(|truth| {
            let carried: Vec<&CameraEstimate> =
                localized.iter().copied().filter(|estimate| estimate.is_carried()).collect();
            error(map, &carried, truth)
        }),
        diagnosis: Vec::new(),
        skipped,
        broken,
    }
}

/// What a length of the largest map is measured in.
pub fn unit(map: &VisualMap) -> &'static str {
    if is_metric(map) { "m" } else { "map units" }
}

/// Whether the lengths of the largest map are meters.
pub fn is_metric(map: &VisualMap) -> bool {
    map.largest().is_some_and(|largest| map.scale(largest).source != ScaleSource::Unknown)
}

/// Against the truth, if a map was aligned to its frame.
fn error(map: &VisualMap, localized: &[&CameraEstimate], truth: &CameraTrajectory) -> Option<InMapError> {
    let of_one = |estimate: &&CameraEstimate| {
        if map.scale(estimate.map).source != ScaleSource::Aligned {
            return None;
        }
        let truth = truth.nearest(estimate.at, TOLERANCE_SECS)?.world_from_camera;
        let apart = truth.inverse() * estimate.world_from_camera;
        Some((apart.translation().norm(), apart.rotation_angle_rad().to_degrees()))
    };
    let errors: Vec<(f64, f64)> = localized.iter().filter_map(of_one).collect();
    let mut meters: Vec<f64> = errors.iter().map(|e| e.0).collect();
    meters.sort_by(f64::total_cmp);
    Some(InMapError {
        compared: errors.len(),
        median_m: quantile(&meters, 0.5)?,
        p95_m: quantile(&meters, 0.95)?,
        max_m: *meters.last()?,
        median_deg: median(errors.iter().map(|e| e.1))?,
    })
}

/// The poses of localized images.
pub fn trajectory(records: &[MapRecord]) -> Vec<CameraPose> {
    let localized = records.iter().filter_map(MapRecord::localized);
    localized.map(|e| CameraPose { at: e.at, world_from_camera: e.world_from_camera }).collect()
}

/// Writes a line for each image in which something is known.
pub fn write_estimates(path: &Path, records: &[MapRecord]) -> Result<()> {
    let write = || -> std::io::Result<()> {
        let mut out = NewFile::create(path)?;
        writeln!(out, "{HEADER}")?;
        for estimate in records.iter().filter_map(|record| record.estimate.as_ref()) {
            let place = estimate.world_from_camera.translation();
            let [qx, qy, qz, qw] = estimate.world_from_camera.quaternion_xyzw();
            let turned = estimate.world_from_camera.rotation();
            let of_place = turned * estimate.covariance.fixed_view::<3, 3>(0, 0) * turned.transpose();
            let sigma = |i: usize| of_place[(i, i)].max(0.0).sqrt();
            let angle = (3..6).map(|i| estimate.covariance[(i, i)]).sum::<f64>().max(0.0).sqrt();
            writeln!(
                out,
                "{},{:.6},{:.6},{:.6},{qx:.7},{qy:.7},{qz:.7},{qw:.7},{},{:.4},{:.6},{:.6},{:.6},{angle:.6},{},{},{}",
                estimate.at,
                place.x,
                place.y,
                place.z,
                estimate.map.index(),
                estimate.reliability,
                sigma(0),
                sigma(1),
                sigma(2),
                u8::from(estimate.is_localized()),
                u8::from(estimate.is_carried()),
                u8::from(estimate.is_found)
            )?;
        }
        out.finish()
    };
    write().with_context(|| path.display().to_string())
}

/// Draws the way over the map, from above and aside.
pub fn draw(folder: &Path, title: &str, map: &VisualMap, records: &[MapRecord]) -> Result<()> {
    let Some(largest) = map.largest() else { return Ok(()) };
    let is_up = map.is_level(largest);
    let place = |point: &nalgebra::Vector3<f64>| {
        // A frame of its own has x to the right, y down and z ahead.
        if is_up { [point.x, point.y, point.z] } else { [point.x, point.z, -point.y] }
    };
    let shown = map.map.with_active(largest);
    let landmarks = shown.landmarks().map(|(_, landmark)| place(&landmark.point_in_world.coords));
    let taught = shown.keyframes().map(|(_, keyframe)| place(&keyframe.center_in_world().coords));
    let of_map = |carried: bool| {
        let wanted = records.iter().filter_map(MapRecord::localized);
        let wanted = wanted.filter(move |e| e.map == largest && e.is_carried() == carried);
        wanted.map(|e| place(e.world_from_camera.translation())).collect()
    };
    let mut paths = vec![SpacePath::cloud("map", Color::GRAY, landmarks.collect())];
    if !records.is_empty() {
        paths.push(SpacePath::cloud("camera", Color::BLUE, of_map(false)));
        paths.push(SpacePath::cloud("carried on by motion", Color::ORANGE, of_map(true)));
    }
    // Thin, so it is seen where the camera went the same way.
    paths.push(SpacePath::line("way when it was taught", Color::BLUISH_GREEN, taught.collect()));
    paths.retain(|path| !path.points.is_empty());
    let names = if is_up { ["x", "y", "height"] } else { ["x", "ahead", "height"] };
    let views = SpaceViews {
        title: title.to_owned(),
        names: names.map(str::to_owned),
        unit: unit(map).to_owned(),
        paths,
        shows_clouds: true,
        ..SpaceViews::default()
    };
    let [above, side] = space_views(&views);
    above.save(folder, "map")?;
    side.save(folder, "map-side")?;
    Ok(())
}
