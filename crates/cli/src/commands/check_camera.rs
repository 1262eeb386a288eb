//! `visloc check-camera`.

use anyhow::{Result, bail};
use serde::Serialize;
use visloc_calib::{CameraCheck, Severity, check_camera};
use visloc_core::geom::Camera;
use visloc_io::camera_file::read_camera;

use crate::{
    args::CheckCameraArgs,
    calibration::{NamedImage, NamedImages, OF_BOARD, end, open_images},
    report::save_json,
    say,
};

/// Most images that are looked at: more tell little more about edges.
const MAX_IMAGES: usize = 40;

#[derive(Serialize)]
struct CheckReport {
    verdict: String,
    findings: Vec<FindingReport>,
    /// Pictures that cannot be read, and why.
    left_out: Vec<String>,
}

#[derive(Serialize)]
struct FindingReport {
    subject: String,
    severity: String,
    message: String,
}

/// Runs the command.
pub fn execute(args: &CheckCameraArgs) -> Result<()> {
    let camera = read_camera(&args.camera)?;
    let pictures = match &args.source {
        Some(source) => open_images(source, &args.options, OF_BOARD)?,
        None => NamedImages::default(),
    };
    let done = check(args, &camera, &pictures.images);
    end(done, pictures.damage)
}

fn check(args: &CheckCameraArgs, camera: &Camera, all: &[NamedImage]) -> Result<()> {
    let mut images = Vec::new();
    let mut left_out = Vec::new();
    if let Some(source) = &args.source {
        let step = all.len().div_ceil(MAX_IMAGES);
        for image in all.iter().step_by(step) {
            match image.read() {
                Ok(pixels) => images.push(pixels),
                Err(error) => left_out.push(say::one_line(&error.context(image.origin()))),
            }
        }
        left_out.iter().for_each(|reason| say::line!("left out: {reason}"));
        if images.is_empty() {
            bail!("{source}: expected pictures, none can be read");
        }
    }
    let check = check_camera(camera, &images);
    for finding in &check.findings {
        say::line!("{:<8} {:<16} {}", finding.severity.to_string(), finding.subject, finding.message);
    }
    if let Some(path) = &args.json.json {
        save_json(path, &report(&check, left_out))?;
    }
    if check.severity() == Severity::Wrong {
        bail!("{}: the calibration cannot be right for these images", args.camera.display());
    }
    Ok(())
}

fn report(check: &CameraCheck, left_out: Vec<String>) -> CheckReport {
    let finding = |f: &visloc_calib::Finding| FindingReport {
        subject: f.subject.to_owned(),
        severity: f.severity.to_string(),
        message: f.message.clone(),
    };
    CheckReport {
        verdict: check.severity().to_string(),
        findings: check.findings.iter().map(finding).collect(),
        left_out,
    }
}
