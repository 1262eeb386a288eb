//! Why a run tracked nothing, or not enough, from what was counted in its images.
//!
//! Each image without a pose gets one [`Cause`]. [`RunCounters`] counts them while the run goes on, and tells at the end which
//! ones kept the camera from being tracked. Sentences are left to whoever shows them.

use visloc_core::{
    GrayImage, Timestamp,
    diagnosis::{BLACK, MAX_FINDINGS, NOTABLE_SHARE, WHITE},
};

use crate::{
    outcome::{FrameOutcome, TrackingState},
    start::{LostTracks, StartWait},
    track::Quality,
};

/// Why an image has no pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// The image cannot be used: its size, or its time.
    Unusable,
    /// The image is black.
    Black,
    /// The image is overexposed.
    White,
    /// The image has too few corners to follow.
    NoTexture,
    /// The camera stands still: without motion there is no depth.
    StandingStill,
    /// The camera turns and does not move: without parallax there is no depth.
    OnlyTurned,
    /// Corners are lost from image to image since there is too much time between the images.
    FewImages,
    /// Corners are lost from image to image though images come often: fast turns, motion blur, or jumps.
    TooFast,
    /// The corners do not move as those of a rigid scene before this camera.
    NoCommonMotion,
    /// The camera has not been found yet in the maps that the run began with.
    NotRecognized,
    /// The camera was tracked, was lost, and has not been found again; also images of maps that were given up then.
    Lost,
    /// Of a run: there were hardly any images.
    ShortRun,
}

impl Cause {
    /// All causes.
    pub const ALL: [Self; 12] = [
        Self::Unusable,
        Self::Black,
        Self::White,
        Self::NoTexture,
        Self::StandingStill,
        Self::OnlyTurned,
        Self::FewImages,
        Self::TooFast,
        Self::NoCommonMotion,
        Self::NotRecognized,
        Self::Lost,
        Self::ShortRun,
    ];

    /// Name for programs; stays as it is.
    #[must_use]
    pub fn code(self) -> &'static str {
        match self {
            Self::Unusable => "unusable-images",
            Self::Black => "black-images",
            Self::White => "overexposed-images",
            Self::NoTexture => "no-texture",
            Self::StandingStill => "standing-still",
            Self::OnlyTurned => "only-turned",
            Self::FewImages => "few-images",
            Self::TooFast => "too-fast",
            Self::NoCommonMotion => "no-common-motion",
            Self::NotRecognized => "not-recognized",
            Self::Lost => "lost",
            Self::ShortRun => "short-run",
        }
    }
}

/// With a smaller share of tracked images a run needs an explanation: once it has begun, tracking should go on.
const ENOUGH_TRACKED: f64 = 0.5;
/// A run of fewer images cannot tell.
const FEW_IMAGES: usize = 20;
/// A start with fewer corners has no texture to follow: most are noise and gone in the next image.
const FEW_CORNERS: usize = 100;
/// From one image to the next, seconds: with more, a camera in a hand has moved by more than corners can be followed.
const LONG_STEP_SECS: f64 = 0.15;

/// One cause and in which share of the images it applied, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    /// Why there is no pose.
    pub cause: Cause,
    /// In which share of the images.
    pub share: f64,
}

/// What sentences about a run may need.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RunFacts {
    /// Images of the run.
    pub num_images: usize,
    /// Mean time from one image to the next, seconds.
    pub step_secs: f64,
    /// Mean number of corners in the images with which starts were tried, and of those that had too few.
    pub num_corners: f64,
    /// When the camera was lost for good, seconds after the first image; `None` if it was not.
    pub lost_at_secs: Option<f64>,
}

/// Why a run tracked nothing, or not enough.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Diagnosis {
    /// The causes, the most frequent one first; none if enough was tracked.
    pub findings: Vec<Finding>,
    /// More about the run.
    pub facts: RunFacts,
}

/// Counts in how many images of a run what stood in the way of a pose.
#[derive(Debug, Clone, Default)]
pub struct RunCounters {
    num: usize,
    by_cause: [usize; Cause::ALL.len()],
    first_at: Option<Timestamp>,
    last_at: Option<Timestamp>,
    /// Sum and number.
    corners: (usize, usize),
    /// Images in a row until now in which a start waited for motion.
    num_waiting: usize,
    /// Whether the camera was in any map so far.
    was_found: bool,
    lost_at_secs: Option<f64>,
}

impl RunCounters {
    /// Counts an image that could not be used.
    pub fn count_unusable(&mut self) {
        self.num += 1;
        self.by_cause[Cause::Unusable as usize] += 1;
    }

    /// Counts an image and what became of it. `brightness` is its mean, see [`mean_brightness`].
    pub fn count(&mut self, at: Timestamp, brightness: f64, outcome: &FrameOutcome) {
        self.num += 1;
        let first = *self.first_at.get_or_insert(at);
        let step_secs = self.last_at.map_or(0.0, |last| at.secs_since(last));
        self.last_at = Some(at);
        self.was_found |= !matches!(outcome.state, TrackingState::Starting(_) | TrackingState::Lost);
        let cause = match outcome.state {
            TrackingState::Tracking(quality) if quality != Quality::Bad => {
                self.lost_at_secs = None;
                return;
            }
            TrackingState::Starting(wait) => {
                self.count_corners(wait);
                of_light(brightness).unwrap_or_else(|| of_wait(wait, step_secs))
            }
            TrackingState::Lost if !self.was_found => of_light(brightness).unwrap_or(Cause::NotRecognized),
            TrackingState::Tracking(_)
            | TrackingState::Supposed
            | TrackingState::Carried
            | TrackingState::Lost => {
                self.lost_at_secs.get_or_insert(at.secs_since(first));
                of_light(brightness).unwrap_or(Cause::Lost)
            }
        };
        if matches!(outcome.state, TrackingState::Starting(_)) {
            // The map was given up; there is nothing to be lost in.
            self.lost_at_secs = None;
        }
        self.by_cause[cause as usize] += 1;
        self.note_waiting(cause, outcome.state);
    }

    /// A start that lost its corners before they had moved enough had no camera that stood: all its images waited for the same.
    fn note_waiting(&mut self, cause: Cause, state: TrackingState) {
        if cause == Cause::StandingStill {
            self.num_waiting += 1;
            return;
        }
        let num_waiting = std::mem::take(&mut self.num_waiting);
        if let TrackingState::Starting(StartWait::TracksLost(LostTracks { num_images, .. })) = state {
            let num = num_waiting.min(num_images);
            self.by_cause[Cause::StandingStill as usize] -= num;
            self.by_cause[cause as usize] += num;
        }
    }

    /// Why too little has a pose; empty if enough has. `coverage` is the share of the images with a pose in the final
    /// trajectory: starts give poses to images before them.
    #[must_use]
    pub fn diagnosis(&self, coverage: f64) -> Diagnosis {
        let facts = self.facts();
        if self.num == 0 || coverage >= ENOUGH_TRACKED {
            return Diagnosis { findings: Vec::new(), facts };
        }
        let mut counts = self.by_cause;
        // What was tracked has no pose if its map was given up when the camera was lost.
        let num_without = ((1.0 - coverage) * self.num as f64).round() as usize;
        counts[Cause::Lost as usize] += num_without.saturating_sub(counts.iter().sum());
        if self.num < FEW_IMAGES {
            for cause in [Cause::StandingStill, Cause::OnlyTurned, Cause::NoCommonMotion] {
                counts[Cause::ShortRun as usize] += std::mem::take(&mut counts[cause as usize]);
            }
        }
        let share = |cause: Cause| counts[cause as usize] as f64 / self.num as f64;
        let mut findings: Vec<Finding> =
            Cause::ALL.into_iter().map(|cause| Finding { cause, share: share(cause) }).collect();
        findings.sort_by(|a, b| b.share.total_cmp(&a.share));
        let num_notable = findings.iter().filter(|finding| finding.share >= NOTABLE_SHARE).count();
        findings.truncate(num_notable.clamp(1, MAX_FINDINGS));
        Diagnosis { findings, facts }
    }

    fn count_corners(&mut self, wait: StartWait) {
        let num = match wait {
            StartWait::FewCorners(num) => num,
            StartWait::TracksLost(LostTracks { of, .. }) => of,
            _ => return,
        };
        self.corners.0 += num;
        self.corners.1 += 1;
    }

    fn facts(&self) -> RunFacts {
        let secs = self.first_at.zip(self.last_at).map_or(0.0, |(first, last)| last.secs_since(first));
        RunFacts {
            num_images: self.num,
            step_secs: secs / self.num.saturating_sub(1).max(1) as f64,
            num_corners: self.corners.0 as f64 / self.corners.1.max(1) as f64,
            lost_at_secs: self.lost_at_secs,
        }
    }
}

/// Mean brightness of an image, 0 to 255.
#[must_use]
pub fn mean_brightness(image: &GrayImage) -> f64 {
    // 256 bytes fit a sum of 16 bits, of which the compiler adds up many at a time.
    let of_part = |part: &[u8]| u64::from(part.iter().map(|value| u16::from(*value)).sum::<u16>());
    let sum: u64 = image.data().chunks(256).map(of_part).sum();
    sum as f64 / image.data().len().max(1) as f64
}

fn of_light(brightness: f64) -> Option<Cause> {
    if brightness < BLACK {
        return Some(Cause::Black);
    }
    (brightness > WHITE).then_some(Cause::White)
}

fn of_wait(wait: StartWait, step_secs: f64) -> Cause {
    match wait {
        StartWait::FewCorners(_) => Cause::NoTexture,
        StartWait::LittleMotion(_) => Cause::StandingStill,
        StartWait::LittleParallax(_) => Cause::OnlyTurned,
        StartWait::NoCommonMotion(_) | StartWait::Ambiguous => Cause::NoCommonMotion,
        StartWait::TracksLost(LostTracks { of, .. }) if of < FEW_CORNERS => Cause::NoTexture,
        StartWait::TracksLost(_) if step_secs > LONG_STEP_SECS => Cause::FewImages,
        StartWait::TracksLost(_) => Cause::TooFast,
    }
}
