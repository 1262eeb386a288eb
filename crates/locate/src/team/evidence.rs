//! How well a sighting fits where robots say that they are.

use nalgebra::{Matrix2, Matrix2x3, Point2, Vector2};
use visloc_core::Timestamp;

use super::{
    TeamConfig,
    belief::{Place, Spare},
    joint::{Case, Factor},
    mate::{Mate, Seen},
    message::{Sighting, SightingKind},
    outbox,
    symmetry::Symmetry,
};

/// A ball or person that was seen so long ago says nothing of where it is, seconds.
const SINGLE_SECS: f64 = 1.5;

/// Probability that the ball that another robot tells of is the ball, and not something that looks like it; of a person the same.
const SAME_SINGLE: f64 = 0.8;

/// What decides densities besides places.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scene {
    /// Size of the map, square meters.
    pub area_m2: f64,
    pub detection: f64,
    pub false_per_image: f64,
    /// False sightings in all images that resemble each other: what is new counts for all of them.
    pub num_false: f64,
    pub honesty: f64,
    pub correlation_secs: f64,
}

impl Scene {
    pub fn new(area_m2: f64, config: &TeamConfig) -> Self {
        Self {
            area_m2,
            detection: config.detection,
            false_per_image: config.false_per_image,
            num_false: config.false_per_image * config.messages_per_sec * config.correlation_secs,
            honesty: config.honesty,
            correlation_secs: config.correlation_secs,
        }
    }

    /// Density of sightings that fit nobody who is known, for each square meter: false ones, and those of unknown robots.
    pub fn unexplained(&self, kind: SightingKind, num_false: f64, num_unknown: f64) -> f64 {
        let unknown = if kind == SightingKind::Robot { self.detection * num_unknown } else { 0.0 };
        (num_false + unknown) / self.area_m2
    }

    /// Density of a robot that may be anywhere.
    pub fn anywhere(&self) -> f64 {
        self.detection / self.area_m2
    }

    /// Density of a sighting of a robot that stands at a place, seen from a place.
    pub fn of_robot(&self, sighting: &Sighting, observer: &Place, seen: &Place) -> f64 {
        let relative = seen.pose.relative_to(&observer.pose);
        let in_robot = Point2::new(relative.x_m, relative.y_m);
        let covariance = sighting.covariance
            + of_observer(observer, &in_robot)
            + turned(&position(seen), -observer.pose.yaw_rad);
        self.detection * gaussian(&(sighting.in_robot - in_robot), &covariance)
    }

    /// Densities of a sighting of the ball (or the person whom all know) beside another one's, seen from another place: of one ball, and of
    /// two that have nothing to do with each other. `moved_m` is how far it may have moved between them, and `doubt` the probability that
    /// the other one made it up.
    pub fn of_single(
        &self,
        (sighting, observer): (&Sighting, &Place),
        (other, witness): (&Sighting, &Place),
        moved_m: f64,
        doubt: f64,
    ) -> f64 {
        let there = in_world(other, witness);
        let in_robot = observer.pose.inverse().transform(&there.0);
        let moved = Matrix2::identity() * moved_m * moved_m;
        let covariance = sighting.covariance
            + of_observer(observer, &in_robot)
            + turned(&(there.1 + moved), -observer.pose.yaw_rad);
        let same = gaussian(&(sighting.in_robot - in_robot), &covariance);
        let is_same = SAME_SINGLE * (1.0 - doubt);
        self.detection * (is_same * same + (1.0 - is_same) / self.area_m2)
    }
}

/// What explains the sightings of one robot.
pub(super) struct SightingModel<'a> {
    /// In the order of the joint.
    pub robots: &'a [&'a Mate],
    /// Who sees.
    pub observer: usize,
    pub symmetry: Symmetry,
    pub scene: &'a Scene,
    pub spare: Spare,
    pub ball_m_per_s: f64,
}

impl SightingModel<'_> {
    /// Densities of a sighting; `false` if it says nothing.
    pub fn densities(&self, sighting: &Sighting, factor: &mut Factor) -> bool {
        factor.tables.resize_with(self.robots.len(), Vec::new);
        factor.tables.iter_mut().for_each(Vec::clear);
        match sighting.kind {
            SightingKind::Teammate | SightingKind::Robot => {
                self.of_robot(sighting, factor);
                true
            }
            SightingKind::Ball | SightingKind::Person => self.of_single(sighting, factor),
            SightingKind::Opponent => false,
        }
    }

    /// Probability that a robot makes up what it sees.
    fn doubt(&self, robot: &Mate) -> f64 {
        robot.doubt.probability(self.scene.honesty)
    }

    /// Of nobody who is known, or made up.
    fn set_base(&self, sighting: &Sighting, num_unknown: f64, factor: &mut Factor) {
        let seer = self.robots[self.observer];
        let Scene { num_false, correlation_secs, .. } = *self.scene;
        let (same, old) = self.seen_before(sighting);
        let (counted, secs) =
            old.map_or((0.0, 0.0), |old| (old.counted, sighting.at.secs_since(old.sighting.at)));
        factor.again = same / (self.scene.unexplained(sighting.kind, num_false, num_unknown) + same);
        let num_false = num_false * (1.0 - factor.again);
        let unexplained = |kind: SightingKind, unknown: f64| self.scene.unexplained(kind, num_false, unknown);
        factor.base = unexplained(sighting.kind, num_unknown);
        // Who makes up what it sees sees as much as if there were as many robots again.
        factor.invented = unexplained(SightingKind::Robot, self.robots.len() as f64);
        factor.doubt = self.doubt(seer);
        // What is seen once says nothing yet, since it may be false, and the second time all that it will say for a while. From then on it stays
        // where it was, whatever it is.
        factor.cases = [
            Case { share: 1.0 - counted, weight: factor.again, same: 0.0 },
            Case { share: counted, weight: factor.again * secs / correlation_secs, same },
        ];
    }

    /// What was seen a moment ago and fits best, with the density of a sighting if it is the same.
    fn seen_before(&self, sighting: &Sighting) -> (f64, Option<&Seen>) {
        let seer = self.robots[self.observer];
        let (step, _) = seer.belief.motion.between(seer.weighed_from, seer.seen_from);
        let is_recent = |old: &&Seen| {
            let secs = sighting.at.secs_since(old.sighting.at);
            old.sighting.kind == sighting.kind && secs > 0.0 && secs <= self.scene.correlation_secs
        };
        let density = |old: &Seen| {
            let moved_m = self.spare.robot_m_per_s * sighting.at.secs_since(old.sighting.at);
            let old = outbox::turned(&old.sighting, &step.inverse());
            let covariance = sighting.covariance + old.covariance + Matrix2::identity() * moved_m * moved_m;
            self.scene.detection * gaussian(&(sighting.in_robot - old.in_robot), &covariance)
        };
        let recent = seer.weighed.iter().filter(is_recent).map(|old| (density(old), Some(old)));
        recent.fold((0.0, None), |best, next| if next.0 > best.0 { next } else { best })
    }

    /// Of a robot, by all that it may be.
    fn of_robot(&self, sighting: &Sighting, factor: &mut Factor) {
        let seen_at = self.robots[self.observer].clock.to_own(sighting.at);
        self.set_base(sighting, self.robots.len() as f64, factor);
        for (index, (table, robot)) in factor.tables.iter_mut().zip(self.robots).enumerate() {
            if index != self.observer {
                let at = robot.clock.to_other(seen_at);
                self.fill(robot, at, table, |from, place| self.scene.of_robot(sighting, from, place));
            }
        }
    }

    /// Of the ball or the person whom all know, beside those of others; `false` if nobody else has seen it of late.
    fn of_single(&self, sighting: &Sighting, factor: &mut Factor) -> bool {
        let seen_at = self.robots[self.observer].clock.to_own(sighting.at);
        let recent = |index: usize| {
            let robot = self.robots[index];
            let (single, frame_at) = *robot.single(sighting.kind).filter(|_| index != self.observer)?;
            let secs = robot.clock.to_own(single.at).secs_since(seen_at).abs();
            (secs <= SINGLE_SECS).then_some((single, frame_at, self.ball_m_per_s * secs))
        };
        self.set_base(sighting, 0.0, factor);
        let has_any = (0..self.robots.len()).any(|index| recent(index).is_some());
        for (index, (table, robot)) in factor.tables.iter_mut().zip(self.robots).enumerate() {
            let Some((single, frame_at, moved_m)) = recent(index) else { continue };
            let doubt = self.doubt(robot);
            self.fill(robot, frame_at, table, |from, witness| {
                self.scene.of_single((sighting, from), (&single, witness), moved_m, doubt)
            });
        }
        has_any
    }

    /// A density for each option of who sees and each one of another robot, which is told where it is at a time of its own clock.
    fn fill(
        &self,
        robot: &Mate,
        at: Timestamp,
        table: &mut Vec<f64>,
        density: impl Fn(&Place, &Place) -> f64,
    ) {
        let seer = self.robots[self.observer];
        for from in 0..seer.belief.num_options(self.symmetry) {
            let from = seer.place(from, seer.seen_from, self.symmetry, &self.spare);
            for option in 0..robot.belief.num_options(self.symmetry) {
                let place = robot.place(option, at, self.symmetry, &self.spare);
                table.push(match (&from, &place) {
                    (Some(from), Some(place)) => density(from, place),
                    // Of a robot that is elsewhere, or seen from elsewhere, nothing is known.
                    _ => self.scene.anywhere(),
                });
            }
        }
    }
}

/// A sighting on the map, with its covariance, from a place.
pub(super) fn in_world(sighting: &Sighting, from: &Place) -> (Point2<f64>, Matrix2<f64>) {
    let seen = turned(&(sighting.covariance + of_observer(from, &sighting.in_robot)), from.pose.yaw_rad);
    (from.pose.transform(&sighting.in_robot), seen)
}

/// Covariance of a point in a robot's frame by that of the robot's own place.
fn of_observer(place: &Place, in_robot: &Point2<f64>) -> Matrix2<f64> {
    let (sin, cos) = place.pose.yaw_rad.sin_cos();
    // A robot that stands elsewhere or turns sees the same point elsewhere.
    let change = Matrix2x3::new(-cos, -sin, in_robot.y, sin, -cos, -in_robot.x);
    change * place.covariance * change.transpose()
}

fn position(place: &Place) -> Matrix2<f64> {
    place.covariance.fixed_view::<2, 2>(0, 0).into_owned()
}

fn turned(covariance: &Matrix2<f64>, by_rad: f64) -> Matrix2<f64> {
    let (sin, cos) = by_rad.sin_cos();
    let turn = Matrix2::new(cos, -sin, sin, cos);
    turn * covariance * turn.transpose()
}

fn gaussian(difference: &Vector2<f64>, covariance: &Matrix2<f64>) -> f64 {
    let determinant = covariance.determinant();
    let Some(inverse) = covariance.try_inverse().filter(|_| determinant > 0.0) else { return 0.0 };
    let exponent = -0.5 * difference.dot(&(inverse * difference));
    exponent.exp() / (std::f64::consts::TAU * determinant.sqrt())
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;
    use visloc_core::geom::PlanarPose;

    use super::*;

    const SCENE: Scene = Scene {
        area_m2: 50.0,
        detection: 0.8,
        false_per_image: 0.05,
        num_false: 0.25,
        honesty: 0.9,
        correlation_secs: 1.0,
    };

    fn place(x_m: f64, y_m: f64, yaw_rad: f64) -> Place {
        Place { pose: PlanarPose::new(x_m, y_m, yaw_rad), covariance: Matrix3::identity() * 1e-4 }
    }

    fn seen(kind: SightingKind, from: &Place, at: (f64, f64)) -> Sighting {
        let point = from.pose.inverse().transform(&Point2::new(at.0, at.1));
        let (range_m, bearing_rad) = (point.coords.norm(), point.y.atan2(point.x));
        Sighting::polar(Timestamp::default(), kind, (bearing_rad, 0.03), (range_m, 0.1 * range_m))
    }

    #[test]
    fn a_robot_is_seen_where_it_stands() {
        let (observer, other) = (place(1.0, 0.5, 0.4), place(3.0, 1.5, -2.0));
        let sighting = seen(SightingKind::Teammate, &observer, (3.0, 1.5));
        let here = SCENE.of_robot(&sighting, &observer, &other);
        let mirrored = SCENE.of_robot(&sighting, &observer, &place(-3.0, -1.5, 1.1));
        assert!(here > 50.0 * SCENE.anywhere() && mirrored < 1e-6 * here, "{here} {mirrored}");
        // Both mirrored look the same.
        let pi = std::f64::consts::PI;
        let both = SCENE.of_robot(&sighting, &place(-1.0, -0.5, 0.4 + pi), &place(-3.0, -1.5, -2.0 + pi));
        assert!((both - here).abs() < 1e-9 * here, "{both} {here}");
    }

    #[test]
    fn two_see_one_ball() {
        let (a, b) = (place(-2.0, 0.5, 0.3), place(1.5, 1.0, 3.0));
        let ball = (0.5, -0.4);
        let (of_a, of_b) = (seen(SightingKind::Ball, &a, ball), seen(SightingKind::Ball, &b, ball));
        let same = SCENE.of_single((&of_a, &a), (&of_b, &b), 0.05, 0.0);
        let mirrored =
            SCENE.of_single((&of_a, &a), (&of_b, &place(-1.5, -1.0, 3.0 - std::f64::consts::PI)), 0.05, 0.0);
        assert!(same > 10.0 * mirrored, "{same} {mirrored}");
        assert!(mirrored > 0.0, "there may be two");
        let (at, covariance) = in_world(&of_a, &a);
        assert!((at - Point2::new(0.5, -0.4)).norm() < 1e-9 && covariance.determinant() > 0.0);
    }

    /// What is seen once says nothing, where something was seen a moment ago all that it will say for a while, and elsewhere it is new.
    #[test]
    fn what_is_seen_twice_counts_once() {
        let at = Timestamp::from_secs;
        let seen = |secs: f64, bearing_rad: f64| {
            Sighting::polar(at(secs), SightingKind::Teammate, (bearing_rad, 0.05), (2.0, 0.2))
        };
        let mut mate = Mate::new(1, 1);
        (mate.weighed_from, mate.seen_from) = (at(1.0), at(1.2));
        let factor = |mate: &Mate, secs: f64, bearing_rad: f64| {
            let robots = [mate];
            let model = SightingModel {
                robots: &robots,
                observer: 0,
                symmetry: Symmetry::Point,
                scene: &SCENE,
                spare: Spare { robot_m_per_s: 0.3, clock_secs: 0.1 },
                ball_m_per_s: 0.5,
            };
            let mut factor = Factor::default();
            assert!(model.densities(&seen(secs, bearing_rad), &mut factor));
            factor
        };
        let weight = |mate: &Mate, secs: f64, bearing_rad: f64| {
            factor(mate, secs, bearing_rad).cases.iter().map(|case| case.share * case.weight).sum::<f64>()
        };
        assert_eq!(weight(&mate, 1.2, 0.3), 0.0);
        mate.weighed.push(Seen { sighting: seen(1.0, 0.3), again: 0.0, counted: 0.0 });
        assert!(weight(&mate, 1.2, 0.32) > 0.9 && weight(&mate, 1.2, -0.5) < 0.01);
        assert!(weight(&mate, 2.2, 0.32) < 0.01, "that was long ago");
        let base = factor(&mate, 1.2, 0.32).base;
        assert!(
            base < SCENE.unexplained(SightingKind::Teammate, SCENE.num_false, 0.0),
            "false ones do not last"
        );
        (mate.weighed[0].again, mate.weighed[0].counted) = (1.0, 1.0);
        let again = factor(&mate, 1.2, 0.32);
        assert!((weight(&mate, 1.2, 0.32) - 0.2).abs() < 0.05 && again.cases[1].same > 100.0 * base);
    }
}
