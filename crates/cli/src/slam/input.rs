//! Where the images of a run come from: a dataset or the simulator.

use anyhow::{Result, bail};
use visloc_base::{CameraTrajectory, ImageSource};
use visloc_data::sequence::{Bound, Sequence, SequenceOptions, SequenceRange, open_sequence};
use visloc_sim::CameraTour;

use crate::args::SlamArgs;

/// Before the name of a simulated sequence.
const SIMULATED: &str = "sim:";

/// Images, and what is known about them.
pub struct SlamInput {
    /// The images.
    pub source: Box<dyn ImageSource>,
    /// Where the camera was.
    pub truth: Option<CameraTrajectory>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Opens what the arguments name.
///
/// # Errors
/// If there is no such sequence, or no camera can be made of its calibration.
pub fn open_input(args: &SlamArgs) -> Result<SlamInput> {
    if let Some(name) = args.sequence.to_str().and_then(|text| text.strip_prefix(SIMULATED)) {
        return open_tour(name, args);
    }
    let range = SequenceRange { start: args.start, end: args.end, stride: args.stride as usize };
    let options = SequenceOptions { range, scale: args.scale, calibration: args.calibration.clone() };
    let Sequence { images, truth, warnings, .. } = open_sequence(&args.sequence, &options)?;
    Ok(SlamInput { source: Box::new(images), truth, warnings })
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn open_tour(name: &str, args: &SlamArgs) -> Result<SlamInput> {
    if args.calibration.is_some() {
        bail!("--calibration: expected a dataset, found {SIMULATED}{name}, whose camera is known");
    }
    if !(0.15..=4.0).contains(&args.scale) {
        bail!("--scale: expected a factor from 0.15 to 4, found {}", args.scale);
    }
    let tour = CameraTour::new(name, args.seed.seed)?;
    let (width, height) = tour.camera().size_px();
    let side = |px: u32| (f64::from(px) * args.scale).round() as u32;
    let rate = tour.frames_per_sec();
    let frame = |bound: Bound| match bound {
        Bound::Frame(frame) => frame,
        Bound::Secs(secs) => (secs * rate).ceil() as usize,
    };
    let num_threads = std::thread::available_parallelism().map_or(1, usize::from);
    let tour = tour
        .with_size((side(width), side(height)))?
        .with_frames(frame(args.start), args.end.map_or(usize::MAX, frame), args.stride as usize)
        .with_threads(num_threads);
    Ok(SlamInput { truth: Some(tour.truth()), source: Box::new(tour), warnings: Vec::new() })
}
