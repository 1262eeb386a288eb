//! Counting over a run.

use visloc_core::{
    Frame, RgbImage, Timestamp,
    diagnosis::{BLACK, MAX_FINDINGS, NOTABLE_SHARE, WHITE},
    geom::PlanarPose,
};
use visloc_world::Map;

use super::{Cause, view};
use crate::{
    Estimate, LOCALIZED_RELIABILITY, LiftDetector, PipelineConfig,
    odometer::{Odometer, Odometry},
    vision::{ImageLook, Percept, color::HueRange},
};

/// Time that every run has for its first localization, seconds: most need one to three.
const START_SECS: f64 = 5.0;
/// A run that goes on for less than this afterwards is judged from its first image on, seconds.
const MIN_JUDGED_SECS: f64 = 2.0;
/// With a smaller share of localized images a run needs an explanation.
const ENOUGH_LOCALIZED: f64 = 0.2;
/// Images with less mean chroma have no colors, 0 to 255: JPEG leaves one or two levels to gray images.
const GRAY: f64 = 4.0;
/// Less carpet than this is none; more than this is a field, 0 to 1.
const SOME_CARPET: f64 = 0.03;
const MUCH_CARPET: f64 = 0.25;
/// With fewer border pixels there is nothing to compare with the map.
const FEW_BORDERS: usize = 6;
/// A place that explains less of an image does not explain it.
const EXPLAINED: f64 = 0.5;
/// Without a more probable hypothesis than this several places fit.
const WINNER: f64 = 0.7;
/// Poses this near are the same, meters and radians.
const SAME: (f64, f64) = (0.5, 0.35);
/// A camera that moved and turned less than this saw the same all the time, meters and radians.
const SAME_VIEW: (f64, f64) = (0.15, 0.2);

/// Counts in how many images of a run what stood in the way of a place.
#[derive(Debug, Clone)]
pub struct RunCounters {
    world: World,
    carpet: HueRange,
    lift: LiftDetector,
    first_at: Option<Timestamp>,
    last_at: Option<Timestamp>,
    early: Tally,
    late: Tally,
    /// Images before the first one that was localized.
    num_before_found: usize,
    num_without_odometry: usize,
    odometer: Odometer,
    /// Images to which the odometry jumped.
    num_jumps: usize,
    first_view: Option<PlanarPose>,
    /// Farthest from the first view, meters and radians.
    view_extent: (f64, f64),
    sums: CameraSums,
}

/// What is to be known of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
enum World {
    Field { is_point_symmetric: bool },
    Office { has_doors: bool, has_colored_doors: bool },
    Other,
}

#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    num: usize,
    num_localized: usize,
    by_cause: [usize; Cause::ALL.len()],
    /// Highest reliability, and when, seconds after the first image of the run.
    best: (f64, f64),
}

impl Tally {
    fn plus(&self, other: &Self) -> Self {
        let mut sum = *self;
        sum.num += other.num;
        sum.num_localized += other.num_localized;
        sum.by_cause.iter_mut().zip(other.by_cause).for_each(|(count, more)| *count += more);
        if other.best.0 > sum.best.0 {
            sum.best = other.best;
        }
        sum
    }

    fn share(&self, count: usize) -> f64 {
        count as f64 / self.num.max(1) as f64
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct CameraSums {
    num: usize,
    view_deg: f64,
    tilt_deg: f64,
    height_m: f64,
}

/// One cause and in which share of the judged images it applied, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    /// What stood in the way.
    pub cause: Cause,
    /// In which share of the images.
    pub share: f64,
}

/// What sentences about a run may need.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RunFacts {
    /// From the first to the last image, seconds.
    pub duration_secs: f64,
    /// When the judged images begin, seconds after the first image: behind the start of a run that goes on, else 0.
    pub judged_from_secs: f64,
    /// Highest reliability in the judged images, 0 to 1, and when, seconds after the first image of the run.
    pub best_reliability: (f64, f64),
    /// Mean horizontal angle of view by the calibration, degrees.
    pub view_deg: f64,
    /// Mean tilt of the camera, positive down, degrees.
    pub tilt_deg: f64,
    /// Mean height of the camera above the ground, meters.
    pub height_m: f64,
}

/// Why a run localized nothing, or almost nothing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Diagnosis {
    /// The causes, the most frequent one first; none if enough was localized.
    pub findings: Vec<Finding>,
    /// Share of the judged images that were localized, 0 to 1.
    pub localized_share: f64,
    /// More about the run.
    pub facts: RunFacts,
}

impl RunCounters {
    /// Of a run that has not begun.
    pub fn new(map: &Map, config: &PipelineConfig) -> Self {
        let world = match map {
            Map::Field(field) => World::Field { is_point_symmetric: field.is_point_symmetric() },
            Map::Office(office) => World::Office {
                has_doors: !office.doors().is_empty(),
                has_colored_doors: office.door_colors().iter().any(|color| !color.is_gray()),
            },
            _ => World::Other,
        };
        Self {
            world,
            carpet: config.analysis.colors.carpet(),
            lift: LiftDetector::new(config.lift),
            first_at: None,
            last_at: None,
            early: Tally::default(),
            late: Tally::default(),
            num_before_found: 0,
            num_without_odometry: 0,
            odometer: Odometer::new(config.refinement.max_motion_m),
            num_jumps: 0,
            first_view: None,
            view_extent: (0.0, 0.0),
            sums: CameraSums::default(),
        }
    }

    /// Counts an image that could not be analyzed.
    pub fn count_unusable(&mut self, at: Timestamp) {
        self.tally(at, Some(Cause::Unusable), 0.0);
    }

    /// Counts an image, what was seen in it, and what was made of it.
    pub fn count(&mut self, frame: &Frame, percept: &Percept, estimate: &Estimate) {
        let is_lifted = self.lift.update(frame.at, frame.ground_contact.as_ref());
        let is_localized = estimate.reliability > LOCALIZED_RELIABILITY;
        let cause = match is_localized {
            true => None,
            false if is_lifted => Some(Cause::Lifted),
            false => Some(self.cause(frame, percept, estimate)),
        };
        self.tally(frame.at, cause, estimate.reliability);
        self.look_around(frame);
    }

    /// Why nothing, or almost nothing, was localized so far; empty if enough was.
    pub fn diagnosis(&self) -> Diagnosis {
        let duration_secs = self.duration_secs();
        let is_long = duration_secs >= START_SECS + MIN_JUDGED_SECS;
        let tally = if is_long { self.late } else { self.early.plus(&self.late) };
        let localized_share = tally.share(tally.num_localized);
        let facts = RunFacts {
            judged_from_secs: if is_long { START_SECS } else { 0.0 },
            best_reliability: tally.best,
            ..self.facts()
        };
        if tally.num == 0 || (localized_share >= ENOUGH_LOCALIZED && self.is_kept()) {
            return Diagnosis { findings: Vec::new(), localized_share, facts };
        }
        let mut counts = tally.by_cause;
        let run_cause = if duration_secs < START_SECS {
            Some(Cause::ShortRun)
        } else if self.saw_the_same() {
            Some(Cause::SameView)
        } else {
            None
        };
        if let Some(run_cause) = run_cause {
            for cause in Cause::ALL.into_iter().filter(|cause| cause.may_pass()) {
                counts[run_cause as usize] += std::mem::take(&mut counts[cause as usize]);
            }
        }
        let finding = |cause: Cause| Finding { cause, share: tally.share(counts[cause as usize]) };
        let mut findings: Vec<Finding> = Cause::ALL.into_iter().map(finding).collect();
        findings.sort_by(|a, b| b.share.total_cmp(&a.share));
        let num_notable = findings.iter().filter(|finding| finding.share >= NOTABLE_SHARE).count();
        findings.truncate(num_notable.clamp(1, MAX_FINDINGS));
        let without_odometry = self.num_without_odometry as f64 / self.sums.num.max(1) as f64;
        let may_help = findings[0].cause.may_pass() && findings[0].cause != Cause::NoDoors;
        if without_odometry > 0.5 && may_help {
            findings.push(Finding { cause: Cause::NoOdometry, share: without_odometry });
        }
        Diagnosis { findings, localized_share, facts }
    }

    /// Whether a robot that was found stayed so in most images: who was found at moments only may have been taken for another place.
    fn is_kept(&self) -> bool {
        let tally = self.early.plus(&self.late);
        tally.num_localized as f64 >= 0.5 * (tally.num - self.num_before_found) as f64
    }

    /// Share of the images with odometry to which it jumped farther than a robot moves, if so many did that its numbers cannot be right.
    pub fn odometry_jumps(&self) -> Option<f64> {
        let num = self.sums.num - self.num_without_odometry;
        let share = self.num_jumps as f64 / num.max(1) as f64;
        (share >= NOTABLE_SHARE).then_some(share)
    }

    fn duration_secs(&self) -> f64 {
        self.first_at.zip(self.last_at).map_or(0.0, |(first, last)| last.secs_since(first))
    }

    fn facts(&self) -> RunFacts {
        let mean = |sum: f64| sum / self.sums.num.max(1) as f64;
        RunFacts {
            duration_secs: self.duration_secs(),
            view_deg: mean(self.sums.view_deg),
            tilt_deg: mean(self.sums.tilt_deg),
            height_m: mean(self.sums.height_m),
            ..RunFacts::default()
        }
    }

    fn tally(&mut self, at: Timestamp, cause: Option<Cause>, reliability: f64) {
        let first = *self.first_at.get_or_insert(at);
        self.last_at = Some(at);
        let secs = at.secs_since(first);
        let was_found = self.early.num_localized + self.late.num_localized > 0;
        self.num_before_found += usize::from(!was_found && cause.is_some());
        let tally = if secs < START_SECS { &mut self.early } else { &mut self.late };
        tally.num += 1;
        if reliability > tally.best.0 {
            tally.best = (reliability, secs);
        }
        match cause {
            Some(cause) => tally.by_cause[cause as usize] += 1,
            None => tally.num_localized += 1,
        }
    }

    fn look_around(&mut self, frame: &Frame) {
        self.sums.num += 1;
        self.sums.view_deg += view::view_deg(frame);
        self.sums.tilt_deg += view::tilt_deg(frame);
        self.sums.height_m += frame.robot_from_camera.translation().z;
        let step = self.odometer.update(frame.at, frame.odometry);
        let Some(robot) = frame.odometry else {
            self.num_without_odometry += 1;
            return;
        };
        self.num_jumps += usize::from(matches!(step, Odometry::Missing { .. }));
        let now = PlanarPose::new(robot.x_m, robot.y_m, robot.yaw_rad + view::pan_rad(frame));
        let first = self.first_view.get_or_insert(now);
        self.view_extent.0 = self.view_extent.0.max(first.distance_m(&now));
        self.view_extent.1 = self.view_extent.1.max(first.heading_difference_rad(&now));
    }

    fn saw_the_same(&self) -> bool {
        let is_known = self.num_without_odometry == 0;
        is_known && self.view_extent.0 < SAME_VIEW.0 && self.view_extent.1 < SAME_VIEW.1
    }

    /// What is wrong with a photo by its light and colors, wherever its camera was.
    pub fn cause_in_photo(&self, image: &RgbImage) -> Option<Cause> {
        let look = ImageLook::new(image, &self.carpet);
        of_light(&look).or_else(|| self.of_colors(&look))
    }

    /// The first cause that applies on the way from the camera to the pose.
    fn cause(&self, frame: &Frame, percept: &Percept, estimate: &Estimate) -> Cause {
        let look = ImageLook::new(&frame.image, &self.carpet);
        of_light(&look)
            .or_else(|| view::cause(frame))
            .or_else(|| self.of_world(&look, percept))
            .unwrap_or_else(|| self.of_estimate(estimate))
    }

    fn of_world(&self, look: &ImageLook, percept: &Percept) -> Option<Cause> {
        if percept.is_informative && matches!(self.world, World::Office { has_doors: true, .. }) {
            return None;
        }
        let is_empty = percept.borders.len() < FEW_BORDERS && !percept.is_informative;
        self.of_colors(look).or(match self.world {
            World::Field { .. } => is_empty.then_some(Cause::FewBorders),
            World::Office { .. } => Some(Cause::NoDoors),
            World::Other => None,
        })
    }

    fn of_colors(&self, look: &ImageLook) -> Option<Cause> {
        let is_gray = look.chroma < GRAY;
        match self.world {
            World::Field { .. } if is_gray => Some(Cause::Gray),
            World::Field { .. } if look.carpet_share < SOME_CARPET => Some(Cause::NoCarpet),
            World::Office { has_doors: false, .. } => Some(Cause::MapWithoutDoors),
            World::Office { .. } if look.carpet_share > MUCH_CARPET => Some(Cause::FieldImage),
            World::Office { has_colored_doors: true, .. } if is_gray => Some(Cause::Gray),
            _ => None,
        }
    }

    fn of_estimate(&self, estimate: &Estimate) -> Cause {
        let is_explained = estimate.likelihood >= EXPLAINED && !estimate.hypotheses.is_empty();
        if estimate.reliability_up_to_symmetry > LOCALIZED_RELIABILITY
            || (is_explained && self.is_mirrored(estimate))
        {
            return Cause::PointSymmetric;
        }
        if !is_explained {
            return Cause::Unexplained;
        }
        let is_undecided = estimate.hypotheses.len() > 1 && estimate.hypotheses[0].probability < WINNER;
        if is_undecided { Cause::LookAlikes } else { Cause::Unconfirmed }
    }

    /// Whether the two best places are each other's mirror image on a field that looks alike from both.
    fn is_mirrored(&self, estimate: &Estimate) -> bool {
        let [first, second, ..] = estimate.hypotheses.as_slice() else { return false };
        let pose = first.world_from_robot;
        let mirrored = PlanarPose::new(-pose.x_m, -pose.y_m, pose.yaw_rad + std::f64::consts::PI);
        let other = &second.world_from_robot;
        self.world == World::Field { is_point_symmetric: true }
            && mirrored.distance_m(other) < SAME.0
            && mirrored.heading_difference_rad(other) < SAME.1
    }
}

fn of_light(look: &ImageLook) -> Option<Cause> {
    if look.brightness < BLACK {
        return Some(Cause::Black);
    }
    (look.brightness > WHITE).then_some(Cause::White)
}
