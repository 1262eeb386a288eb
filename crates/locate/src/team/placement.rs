//! Where the robot is by what others see.

use nalgebra::{Matrix2, Matrix3, Point2};
use visloc_core::{Timestamp, geom::PlanarPose};

use super::{
    belief::{Place, Spare},
    evidence::{Scene, in_world},
    fusion::covariance_intersection,
    mate::Mate,
    message::{Sighting, SightingKind},
    symmetry::Symmetry,
};

/// Sightings older than this say nothing of where the robot is now, seconds.
const MAX_AGE_SECS: f64 = 1.0;
/// Two positions agree within so many standard deviations.
const AGREES: f64 = 3.0;
/// A sighting that is less probably of this robot is of no use.
const MIN_PROBABILITY: f64 = 0.3;

/// Where others see the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    pub position: Point2<f64>,
    pub covariance: Matrix2<f64>,
    /// Heading with its standard deviation, radians, if the robot sees who sees it.
    pub heading: Option<(f64, f64)>,
    /// Probability that it is this robot that was seen.
    pub probability: f64,
    /// Number of the robot that sees it.
    pub by: u8,
}

impl Placement {
    /// The pose; looking along x if the heading is not known.
    pub fn pose(&self) -> PlanarPose {
        PlanarPose::new(self.position.x, self.position.y, self.heading.map_or(0.0, |(yaw_rad, _)| yaw_rad))
    }

    /// Covariance over (x, y, heading).
    pub fn pose_covariance(&self) -> Matrix3<f64> {
        let mut covariance = Matrix3::zeros();
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&self.covariance);
        covariance[(2, 2)] = self.heading_spread_rad().powi(2);
        covariance
    }

    /// Standard deviation of the heading, radians.
    pub fn heading_spread_rad(&self) -> f64 {
        self.heading.map_or(std::f64::consts::PI, |(_, sigma_rad)| sigma_rad)
    }

    /// Standard deviation of the position in its worst direction at most, meters.
    pub fn spread_m(&self) -> f64 {
        self.covariance.trace().max(0.0).sqrt()
    }
}

/// What is needed to look for oneself in others' sightings.
pub(super) struct Search<'a> {
    pub robots: &'a [&'a Mate],
    pub own: usize,
    /// Probabilities of the options of the robot at a place of the list.
    pub posterior: &'a dyn Fn(usize) -> Option<&'a [f64]>,
    pub symmetry: Symmetry,
    pub scene: &'a Scene,
    pub spare: &'a Spare,
    pub at: Timestamp,
    /// What the robot sees itself, in its frame now.
    pub seen: &'a [Sighting],
}

impl Search<'_> {
    /// The best place; of two mirrored ones the one on the side that is more probable for the robot that sees it.
    pub fn run(&self) -> Option<Placement> {
        let mut all: Vec<Placement> = Vec::new();
        for (index, robot) in self.robots.iter().enumerate().filter(|(index, _)| *index != self.own) {
            for sighting in robot.sightings.iter().filter(|s| is_robot(s.kind)) {
                all.extend(self.of_sighting(index, robot, sighting));
            }
        }
        let best = *all.iter().max_by(|a, b| a.probability.total_cmp(&b.probability))?;
        let mut joined = best;
        for other in all.iter().filter(|other| other.by != best.by) {
            let Some(other) = self.on_side_of(&joined, other) else { continue };
            let place = (joined.position, joined.covariance);
            if let Some(fused) = covariance_intersection(place, (other.position, other.covariance)) {
                (joined.position, joined.covariance) = fused;
            }
        }
        joined.heading = self.heading(&joined);
        Some(joined)
    }

    /// One that agrees, on the same side; `None` if it does not agree.
    fn on_side_of(&self, place: &Placement, other: &Placement) -> Option<Placement> {
        let mirrored =
            (self.symmetry == Symmetry::Point).then(|| Placement { position: -other.position, ..*other });
        std::iter::once(*other).chain(mirrored).find(|other| {
            let covariance = place.covariance + other.covariance;
            let off = place.position - other.position;
            covariance.try_inverse().is_some_and(|inverse| off.dot(&(inverse * off)) < AGREES * AGREES)
        })
    }

    fn of_sighting(&self, index: usize, robot: &Mate, sighting: &Sighting) -> Option<Placement> {
        let seen_at = robot.clock.to_own(sighting.at);
        let age_secs = self.at.secs_since(seen_at);
        if age_secs.abs() > MAX_AGE_SECS {
            return None;
        }
        let (option, share) = self.most_probable(index)?;
        let from = robot.place(option, robot.seen_from, self.symmetry, self.spare)?;
        let (position, covariance) = in_world(sighting, &from);
        let here = self.scene.anywhere();
        let others =
            self.robots.iter().enumerate().filter(|(other, _)| *other != index && *other != self.own);
        let of_others: f64 = others
            .filter_map(|(other, mate)| {
                let (option, share) = self.most_probable(other)?;
                let place = mate.place(option, mate.clock.to_other(seen_at), self.symmetry, self.spare)?;
                Some(share * self.scene.of_robot(sighting, &from, &place))
            })
            .sum();
        let num_false = self.scene.false_per_image;
        let unknown = self.scene.unexplained(sighting.kind, num_false, self.robots.len() as f64);
        let probability = share * here / (here + of_others + unknown);
        // The robot has moved since.
        let moved = (self.spare.robot_m_per_s * age_secs).powi(2);
        (probability >= MIN_PROBABILITY).then(|| Placement {
            position,
            covariance: covariance + Matrix2::identity() * moved,
            heading: None,
            probability,
            by: robot.number,
        })
    }

    /// The most probable option of a robot, and how probable it is up to the symmetry.
    fn most_probable(&self, index: usize) -> Option<(usize, f64)> {
        let shares = (self.posterior)(index)?;
        let (option, _) = shares.iter().enumerate().skip(1).max_by(|a, b| a.1.total_cmp(b.1))?;
        let share = match self.symmetry {
            Symmetry::None => shares[option],
            // Options of a track are 1 and 2, 3 and 4.
            Symmetry::Point => shares[option] + shares[if option % 2 == 1 { option + 1 } else { option - 1 }],
        };
        Some((option, share))
    }

    /// The heading from another robot that is seen where it stands.
    fn heading(&self, place: &Placement) -> Option<(f64, f64)> {
        let candidates = self.seen.iter().filter(|s| is_robot(s.kind)).flat_map(|sighting| {
            self.robots.iter().enumerate().filter_map(move |(index, robot)| {
                let (option, _) = self.most_probable(index).filter(|_| index != self.own)?;
                let at = robot.clock.to_other(sighting.at);
                let other = robot.place(option, at, self.symmetry, self.spare)?;
                self.heading_by(place, sighting, &other)
            })
        });
        candidates.min_by(|a, b| a.2.total_cmp(&b.2)).map(|(yaw_rad, sigma_rad, _)| (yaw_rad, sigma_rad))
    }

    /// Heading, its standard deviation, and how badly the distance fits, in standard deviations.
    fn heading_by(&self, place: &Placement, sighting: &Sighting, other: &Place) -> Option<(f64, f64, f64)> {
        let way = other.pose.position() - place.position;
        let (range_m, seen_m) = (way.norm(), sighting.in_robot.coords.norm());
        let sigma_m = (sighting.covariance.trace() + place.covariance.trace()).sqrt();
        let misfit = (range_m - seen_m).abs() / sigma_m;
        if misfit > AGREES || range_m <= sigma_m {
            return None;
        }
        let bearing_rad = sighting.in_robot.y.atan2(sighting.in_robot.x);
        Some((way.y.atan2(way.x) - bearing_rad, sigma_m / range_m, misfit))
    }
}

pub(super) fn is_robot(kind: SightingKind) -> bool {
    matches!(kind, SightingKind::Teammate | SightingKind::Robot)
}
