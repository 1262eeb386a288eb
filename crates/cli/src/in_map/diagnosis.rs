//! Why a camera was hardly found in a map of SLAM, from what was counted in its images: each image without a place gets one cause.

use visloc_slam::{
    SlamConfig,
    image::Pyramid,
    recognize::{Refusal, View},
};
use visloc_vmap::{LOCALIZED_RELIABILITY, MapLocalizer, VisualMap};

use super::photo::finest_focal_px;
use crate::report::{FindingReport, NOT_RECOGNIZED};
use crate::slam::MapFrame;

/// With a smaller share of localized images a run needs an explanation: once it is found, a camera should be followed.
const ENOUGH_LOCALIZED: f64 = 0.5;
/// Causes of a smaller share of the images are not told, unless there is no greater one.
const NOTABLE_SHARE: f64 = 0.2;

/// Images whose pixels are larger than those of the map by more than this show too little of what places are recognized by: an octave.
const MOST_COARSER: f64 = 2.0;

/// Why an image has no place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cause {
    SmallMap,
    FewPixels,
    FewCorners,
    NotRecognized,
    FewFound,
    Unsure,
}

impl Cause {
    const ALL: [Self; 6] = [
        Self::SmallMap,
        Self::FewPixels,
        Self::FewCorners,
        Self::NotRecognized,
        Self::FewFound,
        Self::Unsure,
    ];
}

/// Counts in how many images of a run what stood in the way of a place.
#[derive(Debug, Clone)]
pub struct MapCounters {
    num_landmarks: usize,
    finest_px: Option<f64>,
    /// How many times as large as those of the map the pixels of an image were at most.
    coarsest: f64,
    num: usize,
    num_localized: usize,
    by_cause: [usize; Cause::ALL.len()],
    best_reliability: f64,
}

impl MapCounters {
    /// Of a run in a map that has not begun.
    pub fn new(map: &VisualMap) -> Self {
        let num_landmarks = map.map.all_landmarks().count();
        Self {
            num_landmarks,
            finest_px: finest_focal_px(map),
            coarsest: 1.0,
            num: 0,
            num_localized: 0,
            by_cause: [0; Cause::ALL.len()],
            best_reliability: 0.0,
        }
    }

    /// Counts an image and what became of it.
    pub fn count(&mut self, frame: &MapFrame, localizer: &MapLocalizer, config: &SlamConfig) {
        self.num += 1;
        if localizer.estimate().is_some_and(|estimate| estimate.is_localized()) {
            self.num_localized += 1;
            return;
        }
        let reliability = localizer.estimate().map_or(0.0, |estimate| estimate.reliability);
        self.best_reliability = self.best_reliability.max(reliability);
        let refusal = localizer.outcome().and_then(|outcome| outcome.refusal);
        let fewest = config.relocation.min_matches;
        let coarser = self.finest_px.map_or(1.0, |finest_px| finest_px / frame.camera.focal_px().0);
        self.coarsest = self.coarsest.max(coarser);
        let cause = match refusal {
            _ if self.num_landmarks < fewest => Cause::SmallMap,
            _ if reliability > 0.0 => Cause::Unsure,
            _ if coarser > MOST_COARSER => Cause::FewPixels,
            // A few corners look alike by chance wherever there are many.
            None | Some(Refusal::FewAlike { .. } | Refusal::NoCommonPose { .. }) => {
                if num_corners(frame, config) < fewest { Cause::FewCorners } else { Cause::NotRecognized }
            }
            Some(_) => Cause::FewFound,
        };
        self.by_cause[cause as usize] += 1;
    }

    /// Why so little was localized, the most frequent cause first; empty if enough was.
    pub fn explain(&self) -> Vec<FindingReport> {
        let share = |num: usize| num as f64 / self.num.max(1) as f64;
        if self.num == 0 || share(self.num_localized) >= ENOUGH_LOCALIZED {
            return Vec::new();
        }
        let mut causes = Cause::ALL.map(|cause| (cause, share(self.by_cause[cause as usize])));
        causes.sort_by(|a, b| b.1.total_cmp(&a.1));
        let num_notable = causes.iter().filter(|(_, share)| *share >= NOTABLE_SHARE).count().max(1);
        causes.into_iter().take(num_notable).map(|(cause, share)| self.report(cause, share)).collect()
    }

    fn report(&self, cause: Cause, share: f64) -> FindingReport {
        let (code, sentence, advice) = match cause {
            Cause::SmallMap => (
                "small-map",
                format!("the map has only {} landmarks, too few to recognize a place by", self.num_landmarks),
                "teach more of the place: visloc slam SOURCE --load MAP --save MAP",
            ),
            Cause::FewPixels => (
                "few-pixels",
                format!(
                    "the image has too few pixels: they are {:.1} times as large as those of the map, whose corners are not to be seen in it",
                    self.coarsest
                ),
                "give images as large as the camera takes them, not previews; or teach the place with a camera like this one",
            ),
            Cause::FewCorners => (
                "few-corners",
                "the image has hardly any corner: it is dark, overexposed or blurred, or shows nothing but a plain surface".to_owned(),
                "things with patterns have to be in view; more light, a slower camera",
            ),
            Cause::NotRecognized => ("not-recognized", NOT_RECOGNIZED.0.to_owned(), NOT_RECOGNIZED.1),
            Cause::FewFound => (
                "few-found",
                "a place looks alike, but too little of what should be seen from there is found".to_owned(),
                "look at the calibration (visloc check-camera, --camera FILE); what was moved since has to be taught anew",
            ),
            Cause::Unsure => (
                "unsure",
                format!(
                    "a place fits, but so little of it is seen that it may be another: the reliability was {:.2} at most, \
                     {LOCALIZED_RELIABILITY} is needed",
                    self.best_reliability
                ),
                "more different views help: let the camera move and look around",
            ),
        };
        FindingReport { code, from_s: 0.0, share, sentence, advice }
    }
}

/// Corners of an image that a place could be recognized by.
fn num_corners(frame: &MapFrame, config: &SlamConfig) -> usize {
    let pyramid = Pyramid::new(frame.gray.image.clone(), config.features.pyramid_levels);
    View::of_image(&pyramid, &frame.camera, &config.features).len()
}
