//! The true motion of the whole run.

use nalgebra::Point2;
use rand::RngExt as _;
use visloc_core::{
    Rng, RngTree, gaussian,
    geom::{PlanarPose, angle},
};

use super::{
    floor::Floor,
    path::{Curve, ease},
};
use crate::scenario::{Carry, Motion, ScenarioError, Wander};

/// Resolution of the plan.
pub(super) const STEPS_PER_SEC: f64 = 100.0;
/// A kidnapped robot comes down at least this far away where there is room, meters.
const FAR_M: f64 = 1.6;

/// What the robot is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Activity {
    /// Feet on the ground, still.
    Standing,
    /// Feet on the ground, moving.
    Walking,
    /// In somebody's hands, and the feet tell.
    Lifted,
    /// In somebody's hands, but the robot does not notice and walks on the spot.
    LiftedUnnoticed,
}

impl Activity {
    pub(crate) fn is_carried(self) -> bool {
        matches!(self, Self::Lifted | Self::LiftedUnnoticed)
    }
}

/// The robot at one moment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment {
    pub(crate) position: Point2<f64>,
    /// Heading, radians, continuous over full turns.
    pub(crate) yaw_rad: f64,
    /// Height of the footprint, meters.
    pub(crate) height_m: f64,
    /// How far the carried body leans forward, radians.
    pub(crate) lean_rad: f64,
    /// 0 standing to 1 walking, with soft edges.
    pub(crate) swing: f64,
    pub(crate) activity: Activity,
}

impl Moment {
    pub(crate) fn pose(&self) -> PlanarPose {
        PlanarPose::new(self.position.x, self.position.y, self.yaw_rad)
    }
}

/// The true motion, sampled.
#[derive(Debug)]
pub(crate) struct MotionPlan {
    moments: Vec<Moment>,
}

impl MotionPlan {
    /// Plans all motions of a scenario. Each has a random stream of its own, so that a change to one leaves the
    /// earlier ones as they are.
    pub(crate) fn new(
        name: &str,
        start: PlanarPose,
        motions: &[Motion],
        floor: &Floor,
        random: &RngTree,
    ) -> Result<Self, ScenarioError> {
        let first = Moment {
            position: start.position(),
            yaw_rad: start.yaw_rad,
            height_m: 0.0,
            lean_rad: 0.0,
            swing: 0.0,
            activity: Activity::Standing,
        };
        let mut planner = Planner { name, floor, moments: vec![first] };
        for (i, motion) in motions.iter().enumerate() {
            let rng = &mut random.stream("motion", i as u64);
            match motion {
                Motion::Stand(stand) => planner.stand(stand.secs),
                Motion::Turn(turn) => {
                    planner.turn(turn.angle_deg.to_radians(), turn.speed_deg_per_s.to_radians())
                }
                Motion::Walk(walk) => {
                    let through: Vec<_> = walk.through_m.iter().map(|p| Point2::new(p[0], p[1])).collect();
                    let curve = Curve::new(&planner.last().pose(), &through);
                    planner.walk(&curve, walk.speed_m_per_s, walk.heading_swing_deg.to_radians());
                }
                Motion::Wander(wander) => planner.wander(wander, rng)?,
                Motion::Carry(carry) => planner.carry(carry, rng)?,
            }
        }
        let mut moments = planner.moments;
        soften_swing(&mut moments);
        Ok(Self { moments })
    }

    /// The robot at a time since the start; after the last motion it stands.
    pub(crate) fn at(&self, secs: f64) -> Moment {
        let step = (secs * STEPS_PER_SEC).max(0.0);
        let index = step as usize;
        let last = self.moments.len() - 1;
        if index >= last {
            let swing = 0.0;
            return Moment { activity: Activity::Standing, swing, height_m: 0.0, ..self.moments[last] };
        }
        let (a, b) = (&self.moments[index], &self.moments[index + 1]);
        let share = step - index as f64;
        let mix = |from: f64, to: f64| from + (to - from) * share;
        Moment {
            position: a.position + (b.position - a.position) * share,
            yaw_rad: mix(a.yaw_rad, b.yaw_rad),
            height_m: mix(a.height_m, b.height_m),
            lean_rad: mix(a.lean_rad, b.lean_rad),
            swing: mix(a.swing, b.swing),
            activity: b.activity,
        }
    }
}

struct Planner<'a> {
    name: &'a str,
    floor: &'a Floor,
    moments: Vec<Moment>,
}

impl Planner<'_> {
    fn last(&self) -> Moment {
        self.moments[self.moments.len() - 1]
    }

    fn no_space(&self, what: &'static str, tries: usize) -> ScenarioError {
        ScenarioError::NoSpace { name: self.name.to_owned(), what, tries }
    }

    fn stand(&mut self, secs: f64) {
        let moment = Moment { activity: Activity::Standing, ..self.last() };
        let steps = (secs * STEPS_PER_SEC).round() as usize;
        self.moments.extend(std::iter::repeat_n(moment, steps));
    }

    fn turn(&mut self, angle_rad: f64, speed_rad_per_s: f64) {
        let start = Moment { activity: Activity::Walking, ..self.last() };
        let steps = (angle_rad.abs() / speed_rad_per_s * STEPS_PER_SEC).ceil() as usize;
        for step in 1..=steps {
            let yaw_rad = start.yaw_rad + angle_rad * ease(step as f64 / steps as f64);
            self.moments.push(Moment { yaw_rad, ..start });
        }
    }

    fn walk(&mut self, curve: &Curve, speed_m_per_s: f64, swing_rad: f64) {
        let start = Moment { activity: Activity::Walking, ..self.last() };
        for (position, yaw_rad) in curve.walk(start.yaw_rad, speed_m_per_s, swing_rad) {
            self.moments.push(Moment { position, yaw_rad, ..start });
        }
    }

    /// Draws ways through random points until one is free all along.
    fn wander(&mut self, wander: &Wander, rng: &mut Rng) -> Result<(), ScenarioError> {
        const TRIES: usize = 400;
        const MARGIN_M: f64 = 0.05;
        let length_m = wander.speed_m_per_s * (wander.secs - 1.0);
        let start = self.last();
        for _ in 0..TRIES {
            let Some(through) = self.random_way(start.position, length_m, rng) else { continue };
            let mut curve = Curve::new(&start.pose(), &through);
            if curve.length_m() < length_m {
                continue;
            }
            curve.truncate(length_m);
            // The start itself may be closer to something than a way should come.
            if curve.points().iter().skip(12).all(|point| self.floor.is_free(point, MARGIN_M)) {
                self.walk(&curve, wander.speed_m_per_s, wander.heading_swing_deg.to_radians());
                return Ok(());
            }
        }
        Err(self.no_space("way to wander", TRIES))
    }

    /// Random points that visit every part of the floor before coming back to one; a little longer than asked for.
    fn random_way(&self, start: Point2<f64>, length_m: f64, rng: &mut Rng) -> Option<Vec<Point2<f64>>> {
        const CELLS: (usize, usize) = (4, 3);
        let (half_x, half_y) = self.floor.half_m();
        let cell = |point: &Point2<f64>| {
            let share = |value: f64, half: f64, cells: usize| {
                (((value / half + 1.0) / 2.0 * cells as f64) as usize).min(cells - 1)
            };
            share(point.y, half_y, CELLS.1) * CELLS.0 + share(point.x, half_x, CELLS.0)
        };
        let mut visits = [0.0_f64; CELLS.0 * CELLS.1];
        visits[cell(&start)] += 1.0;
        let (mut through, mut here, mut way_m) = (Vec::new(), start, 0.0);
        while way_m < length_m * 1.05 + 0.5 {
            let candidates = (0..40).map(|_| self.floor.random_point_from(&here, rng)).filter(|point| {
                (0.7..3.0).contains(&(point - here).norm()) && self.floor.is_way_free(&here, point, 0.18)
            });
            let cost = |point: &Point2<f64>| 2.0 * visits[cell(point)] + 0.5 * (point - here).norm();
            let next = candidates.min_by(|a, b| cost(a).total_cmp(&cost(b)))?;
            way_m += (next - here).norm();
            visits[cell(&next)] += 1.0;
            through.push(next);
            here = next;
        }
        Some(through)
    }

    fn carry(&mut self, carry: &Carry, rng: &mut Rng) -> Result<(), ScenarioError> {
        let start = self.last();
        let target = match &carry.to {
            Some(to) => to.pose(),
            None => self.random_target(start.position, rng)?,
        };
        let activity = if carry.has_foot_signal { Activity::Lifted } else { Activity::LiftedUnnoticed };
        let lean_rad = gaussian(rng, 0.2);
        let way = target.position() - start.position;
        let turn_rad = angle::difference(target.yaw_rad, start.yaw_rad);
        let steps = (carry.secs * STEPS_PER_SEC).ceil() as usize;
        for step in 1..=steps {
            let s = step as f64 / steps as f64;
            // Up in the first quarter, down in the last; sideways in between.
            let moved = ease((s - 0.12) / 0.76);
            let raised = ease(s / 0.25) * ease((1.0 - s) / 0.25);
            self.moments.push(Moment {
                position: start.position + way * moved,
                yaw_rad: start.yaw_rad + turn_rad * moved,
                height_m: carry.lift_m * raised,
                lean_rad: lean_rad * raised,
                swing: 0.0,
                activity,
            });
        }
        Ok(())
    }

    fn random_target(&self, here: Point2<f64>, rng: &mut Rng) -> Result<PlanarPose, ScenarioError> {
        const TRIES: usize = 60;
        const MARGIN_M: f64 = 0.2;
        let mut farthest: Option<Point2<f64>> = None;
        for _ in 0..TRIES {
            let Some(point) = self.floor.random_free_point(MARGIN_M, rng) else { continue };
            let distance = |p: &Point2<f64>| (p - here).norm();
            if farthest.is_none_or(|best| distance(&point) > distance(&best)) {
                farthest = Some(point);
            }
            if distance(&point) >= FAR_M {
                farthest = Some(point);
                break;
            }
        }
        let point = farthest.ok_or_else(|| self.no_space("place to put the robot down", TRIES))?;
        let yaw_rad = rng.random_range(-std::f64::consts::PI..std::f64::consts::PI);
        Ok(PlanarPose::new(point.x, point.y, yaw_rad))
    }
}

/// Steps start and end softly: the mean of walking over the time around.
fn soften_swing(moments: &mut [Moment]) {
    const REACH: usize = 30;
    let mut sums = vec![0_usize];
    for moment in moments.iter() {
        let is_walking = moment.activity == Activity::Walking;
        sums.push(sums[sums.len() - 1] + usize::from(is_walking));
    }
    let len = moments.len();
    for (i, moment) in moments.iter_mut().enumerate() {
        let (from, to) = (i.saturating_sub(REACH), (i + REACH + 1).min(len));
        moment.swing = (sums[to] - sums[from]) as f64 / (to - from) as f64;
    }
}
