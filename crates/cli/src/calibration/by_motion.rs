//! A camera from its own images, without a board.

use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;
use visloc_core::{Timestamp, geom::Camera};
use visloc_io::camera_file::{CameraFormat, CameraToml, write_camera};
use visloc_slam::{SelfCalibration, SelfCalibrator, SlamConfig};

use super::source::{NamedImage, Taking, open_images};
use crate::{
    args::CalibrateArgs,
    host::{host, stop_at_signals},
    report::save_json,
    run::{Progress, Saving, write_text},
    say,
};

/// Images of a video or camera: twenty seconds of most.
const TAKING: Taking = Taking {
    apart_secs: 0.0,
    most: 600,
    advice: "move the camera sideways and turn it, where there is texture and without jerks",
};
/// Of the random choices of following: any will do.
const SEED: u64 = 1;
/// Images a second of a folder without times.
const USUAL_RATE_HZ: f64 = 30.0;

/// The result for other programs.
#[derive(Serialize)]
struct MotionReport {
    camera: CameraToml,
    quality: Quality,
}

/// How well the camera is known.
#[derive(Serialize)]
struct Quality {
    /// Where the camera comes from: `motion`.
    source: &'static str,
    /// Standard deviation of the focal length, share of it.
    focal_deviation: f64,
    /// Images that there were.
    num_images: usize,
    /// Those in which the camera was followed.
    num_tracked: usize,
    /// Those of them that the camera was estimated from.
    num_keyframes: usize,
}

/// Runs `visloc calibrate` without a board.
pub fn calibrate_by_motion(args: &CalibrateArgs) -> Result<()> {
    if args.report.is_some() {
        bail!(
            "--report: expected a board (--size CxR), found none; without one there are no corners to draw"
        );
    }
    if args.model.is_some() {
        bail!(
            "--model: expected a board (--size CxR), found none; without one the lens has two radial coefficients"
        );
    }
    stop_at_signals();
    let pictures = open_images(&args.source, &args.options, TAKING)?;
    let done = calibrate_from(args, &pictures.images);
    pictures.end(done)
}

fn calibrate_from(args: &CalibrateArgs, images: &[NamedImage]) -> Result<()> {
    let mut calibrator = SelfCalibrator::default();
    for (i, image) in images.iter().take(TAKING.most).enumerate() {
        let at = image.at.unwrap_or_else(|| Timestamp::from_secs(i as f64 / USUAL_RATE_HZ));
        calibrator.add(at, image.read()?).with_context(|| image.origin())?;
    }
    say::note!("no board (--size): the camera is found from its own motion, which takes some seconds");
    let progress = Progress::new(None);
    let goes_on = || {
        progress.advance();
        !host().was_interrupted()
    };
    let found = calibrator.calibrate(&SlamConfig::default(), SEED, goes_on);
    progress.clear();
    let found = found.map_err(|error| anyhow!("{}: {error}", args.source))?;
    print(&found, calibrator.num_images());
    let mut saving = Saving::default();
    let head = format!(
        "Camera from its own motion, written by visloc calibrate: the focal length is known to {:.1} %. Lengths in pixels; \
         the center of the top-left pixel is (0, 0).",
        100.0 * found.focal_deviation
    );
    let write = |camera: &Camera, format| write_camera(camera, format, &head).map_err(|error| anyhow!(error));
    saving.write("camera", args.out.as_deref(), |path| {
        write_text(path, &write(&found.camera, CameraFormat::Toml)?)
    });
    saving.write("CameraInfo", args.ros.as_deref(), |path| {
        write_text(path, &write(&found.camera, CameraFormat::Ros)?)
    });
    let report = MotionReport {
        camera: CameraToml::from(&found.camera),
        quality: Quality {
            source: "motion",
            focal_deviation: found.focal_deviation,
            num_images: calibrator.num_images(),
            num_tracked: found.num_tracked,
            num_keyframes: found.num_keyframes,
        },
    };
    saving.save_if(args.json.json.as_deref(), |path| save_json(path, &report));
    saving.end()
}

fn print(found: &SelfCalibration, num_images: usize) {
    let camera = &found.camera;
    let ((width, height), (focal, _), (cx, cy)) = (camera.size_px(), camera.focal_px(), camera.center_px());
    let distortion = camera.distortion();
    let radial = distortion.coefficients();
    say::line!(
        "{num_images} images of {width} x {height} px, {} followed, {} of them used",
        found.num_tracked,
        found.num_keyframes
    );
    say::line!("  fx, fy  {focal:.1} +- {:.1} px", focal * found.focal_deviation);
    say::line!("  cx, cy  {cx:.1}, {cy:.1} px");
    say::line!("  k1, k2  {:.4}, {:.4}", radial[0], radial[1]);
    say::line!("a board tells more: visloc calibrate --help");
}
