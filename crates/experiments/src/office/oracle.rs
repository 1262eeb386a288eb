//! When has a robot that was put down seen what tells its place from all others?
//!
//! From the truth: at the first image that shows enough, all places of the building that explain it as well as the true one
//! are rivals. They are moved along with the robot, and each is gone once it explained an image worse than the true place
//! a few times. When none is left, nothing but the true place explains what was seen since. A rival may shift by what an
//! odometry that is off by a tenth would allow: the robot has no better one. No algorithm can know its place sooner,
//! except by luck or by what it does not see.

use visloc_core::{Rng, Timestamp, geom::PlanarPose};
use visloc_locate::{
    ConfigError, ObservationModel,
    observation::office::{OfficeModelConfig, OfficeObservationModel},
    vision::Percept,
};
use visloc_world::office::Office;

/// One image in so many is looked at: neighbors show the same.
const STEP: usize = 3;
/// Poses from which rivals are picked.
const NUM_POSES: usize = 40_000;
/// Pixels of doors and of the floor that the image needs in which rivals are looked for.
const MIN_PIXELS: (usize, usize) = (6, 4);
/// A pose with a likelihood lower than the true one's by this is not worth a climb ...
const MAX_ROUGH_DEFICIT: f64 = 0.25;
/// ... and does not explain an image if the best pose around it is still lower by this.
const MAX_DEFICIT: f64 = 0.06;
/// A rival is gone after so many images that it does not explain.
const MAX_STRIKES: u8 = 3;
/// Two poses nearer than this are one place.
const SAME_M: f64 = 0.3;
const SAME_RAD: f64 = 0.2;
/// Error of the odometry, as a share of the way and of the turns, beside what the first image leaves open.
const DRIFT: f64 = 0.1;
const FIRST_SLACK: (f64, f64) = (0.1, 0.05);
/// Steps of a climb: meters, radians.
const CLIMB: [(f64, f64); 3] = [(0.08, 0.03), (0.03, 0.012), (0.01, 0.004)];

/// Watches a run with the truth.
#[derive(Debug)]
pub(super) struct Oracle {
    model: OfficeObservationModel,
    rng: Rng,
    index: usize,
    was_carried: bool,
    since: Option<Since>,
    /// For each time that the robot was put down, seconds until its place was told from all others.
    told_secs: Vec<Option<f64>>,
}

/// What happened since the robot was put down.
#[derive(Debug)]
struct Since {
    down_at: Timestamp,
    start: PlanarPose,
    last: PlanarPose,
    way_m: f64,
    turn_rad: f64,
    rivals: Option<Vec<Rival>>,
}

/// A place that explains what was seen: where the robot would have been put down.
#[derive(Debug, Clone, Copy)]
struct Rival {
    /// As the first image had it, and as later ones do.
    first: PlanarPose,
    start: PlanarPose,
    num_strikes: u8,
}

impl Oracle {
    pub fn new(office: &Office, rng: Rng) -> Result<Self, ConfigError> {
        Ok(Self {
            model: OfficeObservationModel::new(office, &OfficeModelConfig::default())?,
            rng,
            index: 0,
            was_carried: false,
            since: None,
            told_secs: Vec::new(),
        })
    }

    /// Seconds from each putting down until the place was told from all others; `None` if it never was.
    pub fn into_told_secs(mut self) -> Vec<Option<f64>> {
        self.close(None);
        self.told_secs
    }

    fn close(&mut self, told_secs: Option<f64>) {
        if self.since.take().is_some() {
            self.told_secs.push(told_secs);
        }
    }

    /// Takes in an image with the true pose.
    pub fn note(&mut self, percept: &Percept, truth: &PlanarPose, is_carried: bool) {
        self.index += 1;
        if is_carried {
            self.close(None);
            self.was_carried = true;
            return;
        }
        if std::mem::take(&mut self.was_carried) {
            self.since = Some(Since::new(percept.at, *truth));
        }
        let Some(since) = &mut self.since else { return };
        since.move_to(truth);
        let num_doors = percept.pixels.iter().filter(|pixel| pixel.kind.is_door_edge()).count();
        if !self.index.is_multiple_of(STEP) || percept.pixels.len() < MIN_PIXELS.0 + MIN_PIXELS.1 {
            return;
        }
        self.model.condition_on(percept);
        if since.rivals.is_none() {
            let num_floor = percept.pixels.len() - num_doors;
            if num_doors >= MIN_PIXELS.0 && num_floor >= MIN_PIXELS.1 {
                since.rivals = Some(rivals(&self.model, truth, &since.start, &mut self.rng));
            }
            return;
        }
        since.judge(&self.model, truth);
        if since.rivals.as_ref().is_some_and(Vec::is_empty) {
            let told_secs = percept.at.secs_since(since.down_at);
            self.close(Some(told_secs));
        }
    }
}

impl Since {
    fn new(down_at: Timestamp, start: PlanarPose) -> Self {
        Self { down_at, start, last: start, way_m: 0.0, turn_rad: 0.0, rivals: None }
    }

    fn move_to(&mut self, truth: &PlanarPose) {
        self.way_m += truth.distance_m(&self.last);
        self.turn_rad += truth.heading_difference_rad(&self.last);
        self.last = *truth;
    }

    /// Which rivals explain this image?
    fn judge(&mut self, model: &OfficeObservationModel, truth: &PlanarPose) {
        let motion = truth.relative_to(&self.start);
        let (_, best) = climbed(model, truth, (truth, FIRST_SLACK), 1);
        let slack = (FIRST_SLACK.0 + DRIFT * self.way_m, FIRST_SLACK.1 + DRIFT * self.turn_rad);
        for rival in self.rivals.iter_mut().flatten() {
            let center = rival.first.compose(&motion);
            let (pose, likelihood) = climbed(model, &rival.start.compose(&motion), (&center, slack), 1);
            rival.start = pose.compose(&motion.inverse());
            rival.num_strikes += u8::from(likelihood < best - MAX_DEFICIT);
            if is_same(&pose, truth) {
                rival.num_strikes = MAX_STRIKES;
            }
        }
        if let Some(rivals) = &mut self.rivals {
            rivals.retain(|rival| rival.num_strikes < MAX_STRIKES);
        }
    }
}

/// Places that explain an image as well as the true one.
fn rivals(
    model: &OfficeObservationModel,
    truth: &PlanarPose,
    start: &PlanarPose,
    rng: &mut Rng,
) -> Vec<Rival> {
    let back = truth.relative_to(start).inverse();
    let (_, best) = climbed(model, truth, (truth, FIRST_SLACK), 0);
    let mut places: Vec<PlanarPose> = Vec::new();
    for _ in 0..NUM_POSES {
        let pose = model.propose(rng);
        if model.likelihood(&pose) < best - MAX_ROUGH_DEFICIT {
            continue;
        }
        let (pose, likelihood) = climbed(model, &pose, (&pose, (SAME_M, SAME_RAD)), 0);
        let is_known = is_same(&pose, truth) || places.iter().any(|place| is_same(place, &pose));
        if likelihood >= best - MAX_DEFICIT && !is_known {
            places.push(pose);
        }
    }
    let rival = |pose: PlanarPose| {
        let start = pose.compose(&back);
        Rival { first: start, start, num_strikes: 0 }
    };
    places.into_iter().map(rival).collect()
}

fn is_same(a: &PlanarPose, b: &PlanarPose) -> bool {
    a.distance_m(b) < SAME_M && a.heading_difference_rad(b) < SAME_RAD
}

/// The best pose that small steps reach within some distance of a center, and its likelihood.
fn climbed(
    model: &OfficeObservationModel,
    from: &PlanarPose,
    (center, (slack_m, slack_rad)): (&PlanarPose, (f64, f64)),
    first_step: usize,
) -> (PlanarPose, f64) {
    let (mut best, mut likelihood) = (*from, model.likelihood(from));
    for (step_m, step_rad) in &CLIMB[first_step..] {
        for _ in 0..3 {
            let mut is_better = false;
            let steps = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)];
            for (x, y, yaw) in steps.into_iter().flat_map(|(x, y, yaw)| [(x, y, yaw), (-x, -y, -yaw)]) {
                let pose = best.compose(&PlanarPose::new(x * step_m, y * step_m, yaw * step_rad));
                let is_allowed =
                    pose.distance_m(center) <= slack_m && pose.heading_difference_rad(center) <= slack_rad;
                let value = if is_allowed { model.likelihood(&pose) } else { 0.0 };
                if value > likelihood {
                    (best, likelihood, is_better) = (pose, value, true);
                }
            }
            if !is_better {
                break;
            }
        }
    }
    (best, likelihood)
}
