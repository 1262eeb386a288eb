//! A camera from its own images, without a board.

use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;
use visloc_core::{Timestamp, geom::Camera};
use visloc_io::{
    camera_file::{CameraFormat, CameraToml, write_camera},
    sequence::SequenceRange,
    sources::{OpenImages, SourceAddress, SourceOption, SourceOptions, open_images},
};
use visloc_slam::{SelfCalibration, SelfCalibrator, SlamConfig};

use super::source::{NamedImage, Taking, each_image, each_in_stream, end};
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
    is_spread: false,
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
    say::note!("no board (--size): the camera is found from its own motion, which takes some seconds");
    let mut taken = Taken::default();
    let damage =
        each_image(&args.source, &args.options, TAKING, &mut |image| taken.take(image.origin(), image))?;
    let is_live = SourceAddress::parse(&args.source).is_ok_and(|address| address.kind().is_live);
    let done = taken
        .find(is_live)
        .with_context(|| args.source.clone())
        .and_then(|found| finish(args, &found, taken.calibrator.num_images()));
    end(done, damage)
}

/// Opens the images of a calibrated camera. Where nothing says what camera took them, it is found from its own motion first.
///
/// # Errors
/// If there is no such source, it has no use for an option, or its camera is not known and its images do not tell it.
pub fn open_images_or_find_camera(source: &str, options: &SourceOptions) -> Result<OpenImages> {
    let lacking = match open_images(source, options, host()) {
        Err(error) if error.lacks_camera() && !SourceAddress::parse(source)?.kind().is_live => error,
        opened => return Ok(opened?),
    };
    say::note!(
        "nothing says what camera took these images (--camera): it is found from its own motion, which takes some seconds"
    );
    let range = SequenceRange { stride: 1, ..options.range };
    let mut pictures = SourceOptions { range, scale: None, ..options.clone() };
    pictures.honored_elsewhere.push(SourceOption::Scale);
    let mut taken = Taken::default();
    let damage = each_in_stream(source, &pictures, TAKING, &mut |image| taken.take(image.origin(), image))?;
    let num_images = taken.calibrator.num_images();
    let found = match (taken.find(false), damage) {
        // The source is to blame, not what it shows.
        (Err(_), Some(damage)) if num_images == 0 => return Err(damage),
        (Err(error), damage) => {
            damage.iter().for_each(|damage| say::note!("{damage}"));
            return Err(error.context(lacking.to_string()));
        }
        (Ok(found), _) => found,
    };
    print(&found, num_images);
    say::note!(
        "visloc calibrate {} --out camera.toml keeps this camera, and --camera camera.toml spares the time",
        say::typed(source)
    );
    let mut options = options.clone();
    options.usual.camera = Some(found.camera);
    Ok(open_images(source, &options, host())?)
}

/// Images that a camera is found from.
#[derive(Default)]
struct Taken {
    calibrator: SelfCalibrator,
}

impl Taken {
    /// The first ones are enough.
    fn take(&mut self, origin: String, image: NamedImage) -> Result<()> {
        let num_images = self.calibrator.num_images();
        if num_images == TAKING.most {
            return Ok(());
        }
        let at = image.at.unwrap_or_else(|| Timestamp::from_secs(num_images as f64 / USUAL_RATE_HZ));
        self.calibrator.add(at, image.into_pixels()?).context(origin)
    }

    /// The first signal ends it, unless it is the one that has ended a live source.
    fn find(&self, is_live: bool) -> Result<SelfCalibration> {
        let progress = Progress::new(None);
        let was_ended = is_live && host().is_stopped();
        let goes_on = || {
            progress.advance();
            let goes_on = was_ended || !host().is_stopped();
            if !goes_on {
                host().note_interruption();
            }
            goes_on
        };
        let found = self.calibrator.calibrate(&SlamConfig::default(), SEED, goes_on);
        progress.clear();
        Ok(found?)
    }
}

fn finish(args: &CalibrateArgs, found: &SelfCalibration, num_images: usize) -> Result<()> {
    print(found, num_images);
    say::line!("a board tells more: visloc calibrate --help");
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
            num_images,
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
}
