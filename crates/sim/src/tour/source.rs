//! The pictures of a tour, one after the other.

use std::collections::VecDeque;

use rand::RngExt as _;
use rayon::prelude::*;
use thiserror::Error;
use visloc_core::{
    CameraPose, CameraTrajectory, GrayFrame, GrayImage, ImageSource, RngTree, Source, SourceError,
    SourceStatus, geom::Camera,
};

use super::{
    TOURS, TourKind,
    path::{COVERED_SECS, duration_secs, pose},
    place::Place,
};
use crate::{
    render::{CameraMotion, Renderer, Sensor, Shot},
    scenario::FIRST_STAMP,
    scene::Surface,
};

const FRAMES_PER_SEC: f64 = 20.0;
const SHUTTER_SECS: f64 = 0.008;
/// What is left of the light while the camera is covered.
const COVERED_GAIN: f32 = 0.003;

/// Why there is no such tour.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum TourError {
    /// The name is not known.
    #[error("{found}: expected a tour of a camera: {known}")]
    Name {
        /// What was asked for.
        found: String,
        /// All names.
        known: String,
    },
    /// No camera has such a size.
    #[error("images of {0} x {1} px: expected both from 80 to 4096")]
    Size(u32, u32),
}

/// A picture by its number in time, and that of the place on the way where it is taken: after a kidnap they differ.
#[derive(Debug, Clone, Copy)]
struct Stamp {
    at: usize,
    place: usize,
}

impl Stamp {
    fn secs(self) -> f64 {
        self.at as f64 / FRAMES_PER_SEC
    }

    fn place_secs(self) -> f64 {
        self.place as f64 / FRAMES_PER_SEC
    }
}

/// A camera carried through a textured room, with the truth. The same tour and seed give the same bits, with any number of
/// threads.
///
/// ```
/// use visloc_core::Source;
/// use visloc_sim::CameraTour;
/// let mut tour = CameraTour::new("room", 1)?.with_size((160, 120))?;
/// let first = tour.next_item().expect("400 images").expect("no reading, no error");
/// assert_eq!((first.image.width(), tour.truth().poses().len()), (160, 400));
/// # Ok::<(), visloc_sim::TourError>(())
/// ```
#[derive(Debug)]
pub struct CameraTour {
    kind: TourKind,
    place: Place,
    camera: Camera,
    random: RngTree,
    tremor_rad: f64,
    stamps: Vec<Stamp>,
    is_covered: bool,
    num_kidnaps: u64,
    next: usize,
    ready: VecDeque<GrayFrame>,
    workers: Vec<(Renderer, Vec<Surface>)>,
}

impl CameraTour {
    /// A tour by its name, see [`TOURS`]; 640 x 480 px, 20 images a second, 65 degrees across, no distortion. The seed
    /// decides about textures, posters, the hand's tremor and the noise.
    ///
    /// # Errors
    /// If there is no tour of this name.
    pub fn new(name: &str, seed: u64) -> Result<Self, TourError> {
        let (_, kind, _) = TOURS.iter().find(|tour| tour.0 == name).ok_or_else(|| TourError::Name {
            found: name.to_owned(),
            known: TOURS.map(|tour| tour.0).join(", "),
        })?;
        let random = RngTree::new(seed).subtree("camera-tour", 0);
        let num_frames = (duration_secs(*kind) * FRAMES_PER_SEC) as usize;
        let tour = Self {
            kind: *kind,
            place: Place::new(*kind, &random),
            camera: Camera::default(),
            tremor_rad: random.stream("tremor", 0).random_range(0.0..std::f64::consts::TAU),
            random,
            stamps: (0..num_frames).map(|i| Stamp { at: i, place: i }).collect(),
            is_covered: false,
            num_kidnaps: 0,
            next: 0,
            ready: VecDeque::new(),
            workers: Vec::new(),
        };
        tour.with_size((640, 480))
    }

    /// The same view in images of another size, width and height in pixels.
    ///
    /// # Errors
    /// If a side is below 80 or above 4096 pixels.
    pub fn with_size(mut self, (width, height): (u32, u32)) -> Result<Self, TourError> {
        let refused = TourError::Size(width, height);
        if !(80..=4096).contains(&width) || !(80..=4096).contains(&height) {
            return Err(refused);
        }
        let focal = 0.78 * f64::from(width);
        let center = (0.5 * f64::from(width) - 0.5, 0.5 * f64::from(height) - 0.5);
        self.camera = Camera::pinhole((width, height), (focal, focal), center).map_err(|_| refused)?;
        self.workers = vec![(Renderer::new(&self.camera), Vec::new())];
        Ok(self)
    }

    /// Only these images: from `start` to before `end`, every `stride`-th.
    #[must_use]
    pub fn with_frames(mut self, start: usize, end: usize, stride: usize) -> Self {
        self.stamps = self.stamps.into_iter().take(end).skip(start).step_by(stride.max(1)).collect();
        self
    }

    /// Draws on `num_threads` threads of the current pool; 0 counts as 1. Changes the speed, never the images.
    #[must_use]
    pub fn with_threads(mut self, num_threads: usize) -> Self {
        self.workers.truncate(1);
        while self.workers.len() < num_threads.max(1) {
            let renderer = self.workers[0].0.sibling();
            self.workers.push((renderer, Vec::new()));
        }
        self
    }

    /// Images a second.
    pub fn frames_per_sec(&self) -> f64 {
        FRAMES_PER_SEC
    }

    /// Seconds from the start until which and from which the camera sees, if it is covered for a while.
    pub fn covered_secs(&self) -> Option<(f64, f64)> {
        (self.kind == TourKind::Kidnap).then_some(COVERED_SECS)
    }

    /// Where the camera is in every image.
    pub fn truth(&self) -> CameraTrajectory {
        let mut truth = CameraTrajectory::new();
        for stamp in &self.stamps {
            let world_from_camera = pose(self.kind, stamp.place_secs(), self.tremor_rad);
            // Times increase.
            let _ = truth.push(CameraPose { at: FIRST_STAMP + stamp.secs(), world_from_camera });
        }
        truth
    }

    /// Whether a hand covers the camera from the next picture on.
    pub fn cover(&mut self, is_covered: bool) {
        self.is_covered = is_covered;
        self.forget_drawn();
    }

    /// Somebody carries the camera back to a place where it has been, and it goes on from there. The seed decides where; the truth
    /// is another one from then on. Without a past nothing happens.
    pub fn kidnap(&mut self) {
        self.forget_drawn();
        let Some(now) = self.stamps.get(self.next).copied().filter(|stamp| stamp.place > 0) else { return };
        self.num_kidnaps += 1;
        let back = self.random.stream("kidnap", self.num_kidnaps).random_range(1..=now.place);
        for stamp in &mut self.stamps[self.next..] {
            stamp.place -= back.min(stamp.place);
        }
    }

    /// What has been drawn ahead is drawn anew.
    fn forget_drawn(&mut self) {
        self.next -= self.ready.len();
        self.ready.clear();
    }

    fn gain(&self, secs: f64) -> f32 {
        if self.is_covered {
            return COVERED_GAIN;
        }
        if self.covered_secs().is_some_and(|(from, to)| (from..to).contains(&secs)) {
            return COVERED_GAIN;
        }
        1.0 + 0.12 * (0.5 * secs + self.tremor_rad).sin() as f32
    }

    fn draw_batch(&mut self) {
        let end = (self.next + self.workers.len()).min(self.stamps.len());
        let frames = &self.stamps[self.next..end];
        let mut workers = std::mem::take(&mut self.workers);
        let tour = &*self;
        let images: Vec<GrayFrame> = workers
            .par_iter_mut()
            .zip(frames)
            .map(|((renderer, moving), stamp)| {
                let secs = stamp.secs();
                tour.place.moving(secs, moving);
                let at = |shift: f64| pose(tour.kind, stamp.place_secs() + shift, tour.tremor_rad);
                let shot = Shot {
                    sensor: Sensor { vignetting: 0.2, shot_noise: 0.0006, read_noise: 0.003 },
                    gain: tour.gain(secs),
                    light_color: [1.0; 3],
                    motion: CameraMotion::between(&at(-0.5 * SHUTTER_SECS), &at(0.5 * SHUTTER_SECS)),
                    noise_seed: tour.random.stream_seed("sensor-noise", stamp.at as u64),
                };
                let image = renderer.render(&tour.place.scene, moving, &at(0.0), &shot);
                GrayFrame::new(FIRST_STAMP + secs, GrayImage::from_rgb(&image))
            })
            .collect();
        self.workers = workers;
        self.ready.extend(images);
        self.next = end;
    }
}

impl ImageSource for CameraTour {
    fn camera(&self) -> &Camera {
        &self.camera
    }
}

impl Source<GrayFrame> for CameraTour {
    fn next_item(&mut self) -> Option<Result<GrayFrame, SourceError>> {
        if self.ready.is_empty() && self.next < self.stamps.len() {
            self.draw_batch();
        }
        self.ready.pop_front().map(Ok)
    }

    fn status(&self) -> SourceStatus<'_> {
        SourceStatus { num_items: Some(self.stamps.len()), ..SourceStatus::default() }
    }
}
