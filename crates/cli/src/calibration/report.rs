//! The result as JSON, TOML and Markdown.

use std::fmt::Write as _;

use anyhow::{Context, Result};
use serde::Serialize;
use visloc_calib::{Calibration, Coverage};
use visloc_io::camera_file::CameraToml;

use super::Detected;

/// All numbers.
#[derive(Debug, Serialize)]
pub struct CalibrationReport {
    /// The camera.
    pub camera: CameraToml,
    /// How good it is.
    pub quality: Quality,
    /// Each picture that was used.
    pub views: Vec<ViewReport>,
    /// Pictures that were not.
    pub left_out: Vec<LeftOut>,
    /// What the pictures cover.
    pub coverage: CoverageReport,
}

/// How well a camera is known.
#[derive(Debug, Serialize)]
pub struct Quality {
    /// Root of the mean squared distance of a corner, pixels.
    pub rms_px: f64,
    /// Median distance, pixels.
    pub median_px: f64,
    /// Standard deviation of a corner along an axis, pixels.
    pub corner_noise_px: f64,
    /// Pictures.
    pub num_views: usize,
    /// Corners.
    pub num_corners: usize,
    /// Corners that were left out.
    pub num_outliers: usize,
    /// Standard deviation of each parameter.
    pub standard_deviations: toml::Table,
}

/// One picture.
#[derive(Debug, Serialize)]
pub struct ViewReport {
    name: String,
    corners: usize,
    rms_px: f64,
    tilt_deg: f64,
    distance_m: f64,
}

/// A picture that was not used.
#[derive(Debug, Serialize)]
pub struct LeftOut {
    name: String,
    reason: String,
}

/// What the pictures cover.
#[derive(Debug, Serialize)]
pub struct CoverageReport {
    columns: usize,
    rows: usize,
    corners: Vec<usize>,
    covered: f64,
    next: Vec<String>,
}

impl CalibrationReport {
    /// Of a calibration.
    pub fn new(found: &Calibration, coverage: &Coverage, detected: &Detected) -> Self {
        let dropped = found.dropped.iter().map(|view| (view.name.clone(), view.reason.to_string()));
        let left_out = detected.rejected.iter().cloned().chain(dropped);
        let view = |view: &visloc_calib::View| ViewReport {
            name: view.name.clone(),
            corners: view.corners.iter().filter(|c| !c.is_outlier).count(),
            rms_px: view.rms_px(),
            tilt_deg: view.tilt_rad().to_degrees(),
            distance_m: view.camera_from_board.transform(&found.board.center_in_board()).coords.norm(),
        };
        Self {
            camera: CameraToml::from(&found.camera),
            quality: quality(found),
            views: found.views.iter().map(view).collect(),
            left_out: left_out.map(|(name, reason)| LeftOut { name, reason }).collect(),
            coverage: CoverageReport {
                columns: coverage.cells.0,
                rows: coverage.cells.1,
                corners: coverage.counts.clone(),
                covered: coverage.covered,
                next: coverage.advice.iter().map(ToString::to_string).collect(),
            },
        }
    }
}

fn quality(found: &Calibration) -> Quality {
    let deviations = found.parameters.iter();
    Quality {
        rms_px: found.rms_px,
        median_px: found.median_px,
        corner_noise_px: found.corner_noise_px,
        num_views: found.views.len(),
        num_corners: found.num_corners(),
        num_outliers: found.num_outliers(),
        standard_deviations: deviations.map(|p| (p.name.to_owned(), p.standard_deviation.into())).collect(),
    }
}

/// The camera's own file, with its quality.
pub fn camera_toml(found: &Calibration) -> Result<String> {
    #[derive(Serialize)]
    struct File {
        #[serde(flatten)]
        camera: CameraToml,
        quality: Quality,
    }
    let file = File { camera: CameraToml::from(&found.camera), quality: quality(found) };
    let text = toml::to_string(&file).context("the camera's file")?;
    Ok(format!(
        "# Calibration of a camera, written by visloc calibrate. Lengths in pixels; the center of the top-left\n# pixel is (0, 0).\n{text}"
    ))
}

/// The report that the pictures belong to.
pub fn markdown(source: &str, report: &CalibrationReport) -> String {
    let CalibrationReport { camera, quality, views, left_out, coverage } = report;
    let mut text = format!(
        "# Calibration from {source}\n\n{} pictures, {} corners ({} left out). Reprojection error **{:.3} px** RMS, {:.3} px median.\n\n\
         | model | size | fx, fy | cx, cy | distortion |\n|---|---|---|---|---|\n| {} | {} x {} px | {:.3}, {:.3} | {:.3}, {:.3} | {} |\n",
        quality.num_views,
        quality.num_corners,
        quality.num_outliers,
        quality.rms_px,
        quality.median_px,
        camera.model,
        camera.size_px[0],
        camera.size_px[1],
        camera.focal_px[0],
        camera.focal_px[1],
        camera.center_px[0],
        camera.center_px[1],
        camera.distortion.iter().map(|k| format!("{k:.6}")).collect::<Vec<_>>().join(", ")
    );
    text += "\n## What the pictures cover\n\n![corners of all pictures](coverage.png)\n\n";
    for next in &coverage.next {
        let _ = writeln!(text, "* next: {next}");
    }
    text += "\n## Residuals\n\nThey should look like noise: no pattern in the arrows, a round cloud around zero.\n\n\
             ![arrows from the projected to the seen corner](vectors.png)\n\n![all residuals](residuals.png)\n\n![distances](distances.png)\n\n\
             ## The board as it was found\n\n![corners in the worst picture](corners.png)\n\n";
    text += "| picture | corners | RMS, px | tilt, deg | distance, m |\n|---|---|---|---|---|\n";
    for view in views {
        let _ = writeln!(
            text,
            "| {} | {} | {:.3} | {:.0} | {:.2} |",
            view.name, view.corners, view.rms_px, view.tilt_deg, view.distance_m
        );
    }
    for picture in left_out {
        let _ = writeln!(text, "| {} | left out: {} | | | |", picture.name, picture.reason);
    }
    text
}
