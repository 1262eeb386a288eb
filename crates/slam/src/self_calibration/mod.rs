//! A camera that nobody has calibrated, from images that it took while it moved: it follows itself with a guess, and what was seen is
//! adjusted together with the guess, until one agrees with the other.
//!
//! Sources: Triggs et al., "Bundle adjustment: a modern synthesis", 1999, section 2 (parameters of the camera beside those of the
//! scene); Pollefeys, Koch and Van Gool, "Self-calibration and metric reconstruction in spite of varying and unknown intrinsic
//! camera parameters", 1999 (what makes it possible).

mod fit;

use std::collections::BTreeMap;

use thiserror::Error;
use visloc_core::{GrayImage, Timestamp, geom::Camera};

use self::fit::{Fit, Lens, fit};
use crate::{
    Slam,
    config::{ConfigError, SlamConfig},
    image::halved,
};

/// Focal lengths that compete at first, in longer sides of the image: each stands for those up to an eighth more or less. They are
/// views of 103 to 43 degrees.
const STARTS: [f64; 6] = [0.4, 0.5, 0.63, 0.8, 1.0, 1.26];
/// Images that they compete on.
const NUM_AT_START: usize = 250;
/// Most times that the camera is followed anew with what was found, and that rays are made anew in between.
const MAX_ROUNDS: usize = 16;
/// Change in the logarithm of the focal length below which it is found.
const SETTLED: f64 = 2e-3;
/// Largest standard deviation of the focal length, share of it, with which a camera is of use: places are off by about as much of their distances.
const MOST_DEVIATION: f64 = 0.03;
/// Fewest keyframes that tell a lens.
const LEAST_KEYFRAMES: usize = 3;
/// Larger images are taken at half their size and less, pixels: what they tell more of a lens is not worth the time.
const MOST_PIXELS: usize = 600_000;

/// A camera that was found from its own images.
#[derive(Debug, Clone, PartialEq)]
pub struct SelfCalibration {
    /// The camera: square pixels, two radial coefficients.
    pub camera: Camera,
    /// Standard deviation of the focal length, share of it, for images whose errors are as alike as those of these.
    pub focal_deviation: f64,
    /// Images in which the camera was followed.
    pub num_tracked: usize,
    /// Those of them that the camera was estimated from.
    pub num_keyframes: usize,
}

/// Why images do not tell their camera.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SelfCalibrationError {
    /// A parameter of SLAM is out of range.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The images have different sizes, or one that no camera has.
    #[error("expected images of one size, found {0} x {1} and {2} x {3} px")]
    Sizes(usize, usize, usize, usize),
    /// The camera was hardly followed.
    #[error(
        "the camera can be followed in {num_tracked} of {num_images} images, and {num_keyframes} of these are far enough apart: expected at least \
         {LEAST_KEYFRAMES}; move it sideways and turn it where there is texture, without jerks"
    )]
    TooLittle {
        /// Images.
        num_images: usize,
        /// Those in which it was followed.
        num_tracked: usize,
        /// Keyframes.
        num_keyframes: usize,
    },
    /// Who asked for it no longer waits.
    #[error("ended before the camera was found")]
    Ended,
    /// Cameras of other focal lengths would have seen about the same.
    #[error(
        "cameras of focal lengths from {0:.0} to {1:.0} px would have seen about the same; turn the camera while it moves, by a quarter of a circle or more"
    )]
    Uncertain(f64, f64),
}

/// Takes images of a video one after the other, and tells the camera in the end.
#[derive(Debug, Default)]
pub struct SelfCalibrator {
    images: Vec<(Timestamp, GrayImage)>,
    size_px: Option<(usize, usize)>,
    num_halved: u32,
}

impl SelfCalibrator {
    /// Takes the next image.
    ///
    /// # Errors
    /// If it has another size than those before.
    pub fn add(&mut self, at: Timestamp, image: GrayImage) -> Result<(), SelfCalibrationError> {
        let size = (image.width(), image.height());
        let (width, height) = *self.size_px.get_or_insert(size);
        if (width, height) != size {
            return Err(SelfCalibrationError::Sizes(width, height, size.0, size.1));
        }
        let mut image = image;
        self.num_halved = 0;
        while image.width() * image.height() > MOST_PIXELS {
            image = halved(&image);
            self.num_halved += 1;
        }
        self.images.push((at, image));
        Ok(())
    }

    /// How many images it has.
    #[must_use]
    pub fn num_images(&self) -> usize {
        self.images.len()
    }

    /// Finds focal length, principal point and distortion. It takes about as long as following the camera ten times; after each image it asks
    /// whether to go on.
    ///
    /// # Errors
    /// If the images do not tell them, or if it was not to go on.
    pub fn calibrate(
        &self,
        config: &SlamConfig,
        seed: u64,
        mut goes_on: impl FnMut() -> bool,
    ) -> Result<SelfCalibration, SelfCalibrationError> {
        let mut config = config.clone();
        config.mapping.adjust_lens = false;
        let Some((_, first)) = self.images.first() else { return Err(self.too_little((0, 0))) };
        let size_px = (first.width() as u32, first.height() as u32);
        let side = f64::from(size_px.0.max(size_px.1));
        let mut best: Result<Round, (usize, usize)> = Err((0, 0));
        for share in STARTS {
            let at_start = &self.images[..self.images.len().min(NUM_AT_START)];
            let round = follow(at_start, &config, seed, Lens::new(size_px, share * side), &mut goes_on)?;
            best = match (best, round) {
                (Ok(best), Ok(round)) => Ok(if round.num_found > best.num_found { round } else { best }),
                (Err(best), Err(counts)) => Err(best.max(counts)),
                (best, round) => best.or(round),
            };
        }
        let mut round = best.map_err(|counts| self.too_little(counts))?;
        // How far the focal length is from what it was, one round after the other.
        let mut changes: Vec<f64> = Vec::new();
        for _ in 0..MAX_ROUNDS {
            let before = round.fit.lens;
            round = follow(&self.images, &config, seed, before, &mut goes_on)?
                .map_err(|counts| self.too_little(counts))?;
            let change = round.fit.lens.log_focal() - before.log_focal();
            changes.iter_mut().for_each(|earlier| *earlier += change);
            changes.push(change);
            if change.abs() < SETTLED {
                changes = vec![change];
                break;
            }
        }
        // What did not come to rest is not known better than it has changed in the second half of the rounds.
        let lately = changes[changes.len() / 2..].iter();
        let focal_deviation =
            round.fit.focal_deviation.hypot(lately.fold(0.0, |most, change| most.max(change.abs())));
        let camera = round.fit.lens.camera().and_then(|camera| self.enlarged(&camera));
        match camera {
            Some(camera) if focal_deviation <= MOST_DEVIATION => Ok(SelfCalibration {
                camera,
                focal_deviation,
                num_tracked: round.num_tracked,
                num_keyframes: round.num_keyframes,
            }),
            _ => {
                let focal_px = round.fit.lens.log_focal().exp() * f64::from(1 << self.num_halved);
                let factor = (2.0 * focal_deviation).exp();
                Err(SelfCalibrationError::Uncertain(focal_px / factor, focal_px * factor))
            }
        }
    }

    /// The camera of the images as they came. Pixels have their centers at integers.
    fn enlarged(&self, camera: &Camera) -> Option<Camera> {
        let (width, height) = self.size_px?;
        let factor = f64::from(1 << self.num_halved);
        let ((fx, fy), (cx, cy)) = (camera.focal_px(), camera.center_px());
        let center = |c: f64| (c + 0.5) * factor - 0.5;
        let size_px = (width as u32, height as u32);
        Camera::checked(size_px, (fx * factor, fy * factor), (center(cx), center(cy)), camera.distortion())
            .ok()
    }

    fn too_little(&self, (num_tracked, num_keyframes): (usize, usize)) -> SelfCalibrationError {
        SelfCalibrationError::TooLittle { num_images: self.images.len(), num_tracked, num_keyframes }
    }
}

/// What following the camera with a lens told.
struct Round {
    fit: Fit,
    num_tracked: usize,
    num_keyframes: usize,
    /// Landmarks found in all images together: the better the lens agrees with what is seen, the more.
    num_found: usize,
}

/// Follows the camera with a lens, and estimates that anew; if that cannot be done, how many images were tracked and how many of them are keyframes.
fn follow(
    images: &[(Timestamp, GrayImage)],
    config: &SlamConfig,
    seed: u64,
    lens: Lens,
    goes_on: &mut impl FnMut() -> bool,
) -> Result<Result<Round, (usize, usize)>, SelfCalibrationError> {
    let Some(camera) = lens.camera() else { return Ok(Err((0, 0))) };
    let mut slam = Slam::new(&camera, config, seed)?;
    let mut num_found = 0;
    for (at, image) in images {
        if !goes_on() {
            return Err(SelfCalibrationError::Ended);
        }
        num_found += slam.add_frame(*at, image.clone()).map_or(0, |outcome| outcome.matches.1);
    }
    slam.finish();
    let mut num_poses = BTreeMap::new();
    slam.trajectory().iter().for_each(|pose| *num_poses.entry(pose.map).or_insert(0) += 1);
    let largest = num_poses.into_iter().max_by_key(|(_, num)| *num);
    let Some((map, num_tracked)) = largest else { return Ok(Err((0, 0))) };
    let mut map = slam.map().with_active(map);
    let num_keyframes = map.keyframes().count();
    let fit = (num_keyframes >= LEAST_KEYFRAMES).then(|| fit(&mut map, lens)).flatten();
    Ok(fit
        .map(|fit| Round { fit, num_tracked, num_keyframes, num_found })
        .ok_or((num_tracked, num_keyframes)))
}
