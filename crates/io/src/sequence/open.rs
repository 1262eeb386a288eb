//! Opening a dataset: layout, camera, images in a range, truth.

use std::path::{Path, PathBuf};

use nalgebra::Point2;
use visloc_core::{
    CameraTrajectory, SkippedInput,
    geom::{Camera, Distortion, MAX_IMAGE_SIDE_PX},
};

use super::{
    Calibration, FileSequence, ImageFile, SequenceRange,
    layouts::{Contents, LAYOUTS, Layout, instead_of_images},
    read_calibration,
};
use crate::{
    FileError,
    image_codec::{image_size, read_gray_image},
};

visloc_core::with_defaults! {
    /// How a sequence is opened.
    /// By default everything as it is.
    #[derive(Debug, Clone, PartialEq)]
    pub struct SequenceOptions {
        /// Which images are used.
        pub range: SequenceRange = SequenceRange::default(),
        /// Size of the images that are handed out, as a factor.
        pub scale: Option<f64> = None,
        /// Longer side of an image that is handed out as it is, pixels, if no scale is asked for: larger ones are shrunk by the least whole
        /// number that brings them below.
        pub most_side_px: Option<u32> = None,
        /// Calibration to use instead of the dataset's.
        pub calibration: Option<PathBuf> = None,
        /// Camera of a dataset that does not say what its camera is.
        pub camera: Option<Camera> = None,
        /// Images a second of a plain folder, over what its calibration or the names of its images say; above 0.
        pub rate_hz: Option<f64> = None,
        /// Key of the layout (see [`sequence_layouts`]); recognized if absent.
        pub layout: Option<&'static str> = None,
    }
}

/// Smallest and largest factor for the size of images.
pub const SCALES: (f64, f64) = (0.05, 4.0);
/// Longest side of images that SLAM is best at, pixels (for [`SequenceOptions::most_side_px`]): corners of larger ones move farther from one
/// image to the next than they are looked for, and what they tell more is not worth the time.
pub const MOST_SLAM_SIDE_PX: u32 = 1600;
/// Shortest side of an image that was resized, pixels.
const MIN_SCALED_PX: u32 = 16;
/// A pause so many times as long as usual is a gap.
const GAP_FACTOR: f64 = 5.0;

/// A dataset that is ready to be read.
#[derive(Debug)]
pub struct Sequence {
    /// Its images.
    pub images: FileSequence,
    /// True poses of the camera, if they are known.
    pub truth: Option<CameraTrajectory>,
    /// Name of the layout that was recognized.
    pub layout: &'static str,
    /// What the user should know: gaps, a calibration that can hardly be right, a truth that cannot be used.
    pub warnings: Vec<String>,
}

/// The images of a dataset and what it says about them; nothing of the images has been read.
#[derive(Debug)]
pub struct Listing {
    /// Images in the range, in order of time.
    pub images: Vec<ImageFile>,
    /// The user's calibration or the dataset's, and its file; or why there is none.
    pub calibration: Result<(Calibration, PathBuf), FileError>,
    /// True poses of the camera, if they are known.
    pub truth: Option<CameraTrajectory>,
    /// Name of the layout that was recognized.
    pub layout: &'static str,
    /// What was left out.
    pub skipped: Vec<SkippedInput>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Lists the dataset in a folder; its layout is recognized. A missing calibration is no error here.
///
/// # Errors
/// If there is no known layout or no image in the range.
pub fn list_sequence(folder: &Path, options: &SequenceOptions) -> Result<Listing, FileError> {
    let layout = recognize(folder, options.layout)?;
    let mut contents = (layout.read)(folder)?;
    let calibration = choose(folder, options, &mut contents);
    let Contents { images, skipped, truth, warnings, .. } = contents;
    if images.is_empty() {
        let reason = format!("expected images ({}), found none that can be listed", layout.mark);
        return Err(FileError::form(folder, reason));
    }
    let num_all = images.len();
    let images = match options.rate_hz {
        Some(_) if layout.key != "images" => {
            let reason = format!(
                "--fps: expected a folder of images without times, found {}, which has them; leave it out",
                layout.name
            );
            return Err(FileError::form(folder, reason));
        }
        Some(rate_hz) => at_a_rate(images, rate_hz),
        None => images,
    };
    let length_secs = images.first().zip(images.last()).map_or(0.0, |(a, b)| b.at.secs_since(a.at));
    let images = options.range.select(images);
    if images.is_empty() {
        let reason = format!(
            "expected a range within the sequence of {num_all} images, found none of them; it is {length_secs:.1} s long"
        );
        return Err(FileError::form(folder, reason));
    }
    Ok(Listing { images, calibration, truth, layout: layout.name, skipped, warnings })
}

/// Opens the dataset in a folder; its layout is recognized.
///
/// # Errors
/// If there is no known layout, no calibration or an impossible one, no image in the range, or none that can be read.
pub fn open_sequence(folder: &Path, options: &SequenceOptions) -> Result<Sequence, FileError> {
    if let Some(scale) = options.scale.filter(|scale| !(SCALES.0..=SCALES.1).contains(scale)) {
        let reason = format!("expected a scale from {} to {}, found {scale:?}", SCALES.0, SCALES.1);
        return Err(FileError::form(folder, reason));
    }
    let mut listing = list_sequence(folder, options)?;
    let size_px = listing.begin_with_usual_size(folder)?;
    let Listing { images, calibration, truth, layout, skipped, mut warnings } = listing;
    let (calibration, calibration_file) = calibration?;
    let camera = fit_calibration(&calibration, size_px, &calibration_file, &mut warnings)?;
    let handed_out = resized(&camera, options.scale, options.most_side_px, &mut warnings)
        .map_err(|reason| FileError::form(folder, reason))?;
    warnings.extend(gaps(&images));
    let images = FileSequence::new(camera, images, SequenceRange::default(), skipped);
    let images = images.resized(handed_out);
    Ok(Sequence { images, truth, layout, warnings })
}

/// The camera of the images that are handed out, by the scale that is asked for or the longer side that is enough
/// (see [`SequenceOptions`]).
///
/// # Errors
/// If what comes out would be no image: what was expected and what would come out.
pub(crate) fn resized(
    camera: &Camera,
    scale: Option<f64>,
    most_side_px: Option<u32>,
    warnings: &mut Vec<String>,
) -> Result<Camera, String> {
    let (width, height) = camera.size_px();
    let factor = most_side_px.map_or(1, |most| width.max(height).div_ceil(most.max(1)));
    let scaled = camera.scaled(scale.unwrap_or(1.0 / f64::from(factor)));
    let (to_width, to_height) = scaled.size_px();
    let is_image =
        [to_width, to_height].iter().all(|side| (MIN_SCALED_PX..=MAX_IMAGE_SIDE_PX).contains(side));
    match scale {
        None if factor == 1 || !is_image => Ok(*camera),
        None => {
            warnings.push(format!(
                "images of {width} x {height} px are used at {to_width} x {to_height} (--scale 1: as they are)"
            ));
            Ok(scaled)
        }
        Some(scale) if scale == 1.0 || is_image => Ok(scaled),
        Some(scale) => Err(format!(
            "--scale {scale:?}: images of {width} x {height} px would become {to_width} x {to_height}, expected sides from \
             {MIN_SCALED_PX} to {MAX_IMAGE_SIDE_PX} px"
        )),
    }
}

/// Opens a folder of the TUM layout, or any other that is known, without its truth.
///
/// # Errors
/// As [`open_sequence`].
pub fn open_tum(folder: &Path, range: SequenceRange) -> Result<FileSequence, FileError> {
    Ok(open_sequence(folder, &SequenceOptions { range, ..SequenceOptions::default() })?.images)
}

/// Images that follow each other so many times a second.
fn at_a_rate(images: Vec<ImageFile>, rate_hz: f64) -> Vec<ImageFile> {
    let stamped = |(i, image): (u32, ImageFile)| ImageFile {
        at: visloc_core::Timestamp::from_secs(f64::from(i) / rate_hz),
        ..image
    };
    (0..).zip(images).map(stamped).collect()
}

/// The layout of a folder: the one that is asked for, or the first that fits.
fn recognize(folder: &Path, wanted: Option<&str>) -> Result<&'static Layout, FileError> {
    // Who may not look into a folder finds nothing there.
    if std::fs::metadata(folder).map_err(FileError::io(folder))?.is_dir() {
        std::fs::read_dir(folder.join(".")).map_err(FileError::io(folder))?;
    }
    let is_wanted = |layout: &&Layout| wanted.is_none_or(|key| key == layout.key);
    let mut layouts = LAYOUTS.iter().filter(is_wanted);
    layouts.find(|layout| (layout.is_here)(folder)).ok_or_else(|| {
        let layouts = LAYOUTS.iter().filter(is_wanted);
        let marks: Vec<String> = layouts.map(|l| format!("{} ({})", l.mark, l.name)).collect();
        let found = if marks.len() == 1 { "it is not there" } else { "found none of them" };
        let instead = instead_of_images(folder);
        FileError::form(folder, format!("expected a dataset: {}; {found}{instead}", marks.join(", ")))
    })
}

/// Keys and names of the layouts that are known.
pub fn sequence_layouts() -> impl Iterator<Item = (&'static str, &'static str)> {
    LAYOUTS.iter().map(|layout| (layout.key, layout.name))
}

/// The user's calibration or the dataset's, and its file.
fn choose(
    folder: &Path,
    options: &SequenceOptions,
    contents: &mut Contents,
) -> Result<(Calibration, PathBuf), FileError> {
    if let Some(file) = &options.calibration {
        return Ok((read_calibration(file)?, file.clone()));
    }
    if let Some(error) = contents.calibration_error.take() {
        return Err(error);
    }
    // Some layouts have one camera for all copies, in no file.
    let has_file = !contents.calibration_file.as_os_str().is_empty();
    let file = if has_file { contents.calibration_file.clone() } else { folder.to_path_buf() };
    let own = contents.calibration.take().or_else(|| options.camera.as_ref().map(Calibration::of));
    let looked_for = || {
        file.file_name()
            .filter(|_| has_file)
            .map_or("camera.yaml".into(), |name| name.to_string_lossy().into_owned())
    };
    let calibration =
        own.ok_or_else(|| FileError::NoCamera { path: folder.to_path_buf(), looked_for: looked_for() })?;
    Ok((calibration, file))
}

impl Listing {
    /// Leaves out images at the beginning that have another size than most, and says which size the others have, width and height in
    /// pixels: one odd image must not decide for all.
    ///
    /// # Errors
    /// If no image can be read.
    pub(crate) fn begin_with_usual_size(&mut self, folder: &Path) -> Result<(u32, u32), FileError> {
        let first = first_size(folder, &self.images)?;
        let calibrated = self.calibration.as_ref().ok().and_then(|(calibration, _)| calibration.size_px);
        if calibrated == Some(first) {
            return Ok(first);
        }
        let sizes: Vec<Option<(u32, u32)>> =
            self.images.iter().map(|image| image_size(&image.path)).collect();
        let count = |size: (u32, u32)| sizes.iter().filter(|other| **other == Some(size)).count();
        // Those of the calibration's shape before all others; the first of those that are as frequent.
        let rank = |size: (u32, u32)| (calibrated.is_some_and(|of| is_same_shape(of, size)), count(size));
        let mut known: Vec<(u32, u32)> = Vec::new();
        for size in sizes.iter().flatten() {
            if !known.contains(size) {
                known.push(*size);
            }
        }
        let usual = known.into_iter().rev().max_by_key(|size| rank(*size)).unwrap_or(first);
        let num_odd = sizes.iter().take_while(|size| **size != Some(usual)).count();
        let reason = |size: Option<(u32, u32)>| match size {
            Some((width, height)) => {
                format!("expected {} x {} px as most have, found {width} x {height}", usual.0, usual.1)
            }
            None => "expected an image, found none that can be read".to_owned(),
        };
        let odd = self.images.drain(..num_odd).zip(&sizes);
        self.skipped.extend(odd.map(|(image, size)| SkippedInput {
            at: Some(image.at),
            origin: image.path.display().to_string(),
            reason: reason(*size),
        }));
        Ok(usual)
    }
}

/// Whether two sizes are those of the same picture in two resolutions.
fn is_same_shape(of: (u32, u32), other: (u32, u32)) -> bool {
    let ratio = f64::from(other.0) / f64::from(of.0);
    (f64::from(of.1) * ratio - f64::from(other.1)).abs() <= 1.0
}

/// Width and height of the first image that can be read.
fn first_size(folder: &Path, images: &[ImageFile]) -> Result<(u32, u32), FileError> {
    let mut first_error = None;
    for image in images {
        match read_gray_image(&image.path) {
            Ok(image) => return Ok((image.width() as u32, image.height() as u32)),
            Err(error) => {
                first_error.get_or_insert_with(|| error.to_string());
            }
        }
    }
    let error = first_error.unwrap_or_default();
    let reason =
        format!("expected images, found none of {} that can be read; the first: {error}", images.len());
    Err(FileError::form(folder, reason))
}

/// The camera for images of a size. A calibration for the same picture in another resolution is converted, which is worth a warning.
///
/// # Errors
/// If the calibration is for a picture of another shape, of which nobody knows how it was cropped or turned, or no camera has these
/// values.
pub fn fit_calibration(
    calibration: &Calibration,
    size_px: (u32, u32),
    path: &Path,
    warnings: &mut Vec<String>,
) -> Result<Camera, FileError> {
    let other_px = calibration.size_px.filter(|expected| *expected != size_px);
    let camera = match other_px {
        None => calibration.camera(size_px, path)?,
        Some(expected) => {
            let ratio = f64::from(size_px.0) / f64::from(expected.0);
            let is_same_picture = (f64::from(expected.1) * ratio - f64::from(size_px.1)).abs() <= 1.0;
            let difference = format!(
                "the calibration is for images of {} x {} px, these have {} x {}",
                expected.0, expected.1, size_px.0, size_px.1
            );
            if !is_same_picture {
                let is_turned = is_same_shape((expected.1, expected.0), size_px);
                let why = if is_turned {
                    "turned by a quarter; turn the images back, or calibrate with images that are turned so"
                } else {
                    "cropped or another camera; calibrate with these images"
                };
                let reason = format!("{difference}: {why}");
                return Err(FileError::form(path, reason));
            }
            warnings.push(format!("{difference}; it is converted by the factor {ratio:.4}"));
            calibration.camera(expected, path)?.scaled_to(size_px)
        }
    };
    warnings.extend(unlikely(&camera));
    Ok(camera)
}

/// What can hardly be right about a camera.
fn unlikely(camera: &Camera) -> Vec<String> {
    let ((width, height), (fx, fy), (cx, cy)) = (camera.size_px(), camera.focal_px(), camera.center_px());
    let (width, height) = (f64::from(width), f64::from(height));
    let mut warnings = Vec::new();
    if !(0.0..width).contains(&cx) || !(0.0..height).contains(&cy) {
        warnings.push(format!(
            "wrong calibration? the principal point ({cx:.1}, {cy:.1}) is outside of the image of {width} x {height} px"
        ));
    }
    if !(0.8..=1.25).contains(&(fx / fy)) {
        warnings
            .push(format!("wrong calibration? fx is {fx:.1} px and fy {fy:.1}: pixels are nearly square"));
    }
    let (left, right) = (Point2::new(0.0, height / 2.0), Point2::new(width, height / 2.0));
    let view_deg = camera.bearing(&left).angle(&camera.bearing(&right)).to_degrees();
    let max_view_deg =
        if matches!(camera.distortion(), Distortion::KannalaBrandt(_)) { 175.0 } else { 140.0 };
    if !(8.0..=max_view_deg).contains(&view_deg) {
        warnings.push(format!(
            "wrong calibration? with fx = {fx:.1} px the camera sees {view_deg:.0} degrees across"
        ));
    }
    warnings
}

/// Pauses between images.
fn gaps(images: &[ImageFile]) -> Option<String> {
    let steps: Vec<f64> = images.windows(2).map(|pair| pair[1].at.secs_since(pair[0].at)).collect();
    let mut sorted = steps.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = *sorted.get(sorted.len() / 2)?;
    let longest = *sorted.last()?;
    let num_gaps = steps.iter().filter(|step| **step > GAP_FACTOR * usual).count();
    let place = steps.iter().position(|step| *step == longest)?;
    let at = images[place].at;
    let long = format!("{longest:.2} s instead of {usual:.3}");
    match num_gaps {
        0 => None,
        1 => Some(format!("a gap in the images: {long}, after image {place} at {at}")),
        _ => Some(format!(
            "{num_gaps} gaps in the images; the longest, {long}, is after image {place} at {at}"
        )),
    }
}
