//! Where two lines meet: which of the four arms of the crossing are there tells the kind.

use nalgebra::{Point2, Vector2};
use visloc_core::geom::angle;

use super::{
    segments::Segment,
    view::{GroundView, Seen},
};
use crate::vision::{Junction, JunctionKind};

/// All lines of a field meet at right angles; the camera's direction may be off: largest difference, as a cosine.
const MAX_COSINE: f64 = 0.42;
/// How far a line may end before the crossing, meters, and pixels if that is more.
const MAX_GAP_M: f64 = 0.3;
const MAX_GAP_PX: f64 = 10.0;
/// Crossings farther away than this are not judged, meters.
const MAX_DISTANCE_M: f64 = 5.0;
/// Pixels between the border of the other line and the first sample of an arm.
const MIN_CLEARANCE_PX: f64 = 2.0;
/// Length of an arm that is looked at, meters, and in pixels at least.
const ARM_M: f64 = 0.12;
const ARM_PX: f64 = 3.0;
/// The longest arm that every line has, from the crossing, meters.
const MAX_ARM_M: f64 = 0.55;
/// Samples of an arm, and how many of them must agree.
const NUM_SAMPLES: u32 = 5;
const MIN_AGREEING: u32 = 4;

/// What is known about an arm of a crossing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Arm {
    Line,
    Carpet,
    Unknown,
}

/// All junctions between the lines.
pub(super) fn find(segments: &[Segment], view: &GroundView, line_width_m: f64, out: &mut Vec<Junction>) {
    for (i, a) in segments.iter().enumerate() {
        for b in &segments[i + 1..] {
            let Some(junction) = junction(a, b, view, line_width_m) else { continue };
            let is_new = |other: &Junction| (other.at_in_robot - junction.at_in_robot).norm() > 0.2;
            if out.iter().all(is_new) {
                out.push(junction);
            }
        }
    }
}

fn junction(a: &Segment, b: &Segment, view: &GroundView, line_width_m: f64) -> Option<Junction> {
    let along = [a, b].map(|s| (s.ends_in_robot[1] - s.ends_in_robot[0]).normalize());
    if along[0].dot(&along[1]).abs() > MAX_COSINE {
        return None;
    }
    let at_px = a.line.crossing(&b.line)?;
    let at = view.ground(&at_px)?;
    if at.coords.norm() > MAX_DISTANCE_M || !reaches(a, &at_px, &at, view) || !reaches(b, &at_px, &at, view) {
        return None;
    }
    let white = a.white;
    // Where the two images cross at a sharp angle an arm has to be looked at farther away.
    let sharpness = a.line.along.perp(&b.line.along).abs().max(0.05);
    let clearance_px = MIN_CLEARANCE_PX / sharpness;
    let arms = along.map(|along| {
        [1.0, -1.0].map(|sign| arm(&at, along * sign, view, (line_width_m, clearance_px), white))
    });
    let (kind, direction) = classify(&arms, &along)?;
    let direction_rad = angle::wrap(direction.y.atan2(direction.x));
    Some(Junction { kind, at_in_robot: at, at_px, direction_rad })
}

/// Whether a line comes near enough to a crossing.
fn reaches(segment: &Segment, at_px: &Point2<f64>, at: &Point2<f64>, view: &GroundView) -> bool {
    let position = segment.line.position(at_px);
    let gap_px = (segment.from - position).max(position - segment.to);
    if gap_px <= MAX_GAP_PX * view.scale {
        return true;
    }
    let nearest = if position < segment.from { segment.from } else { segment.to };
    let end = view.ground(&segment.line.at(nearest));
    end.is_some_and(|end| (end - at).norm() < MAX_GAP_M)
}

/// Looks along one arm of a crossing.
fn arm(
    at: &Point2<f64>,
    along: Vector2<f64>,
    view: &GroundView,
    (line_width_m, clearance_px): (f64, f64),
    white: u32,
) -> Arm {
    let px_m = view.meters_per_px(at, &along) * view.scale;
    let first = line_width_m / 2.0 + clearance_px * px_m;
    let last = first + ARM_M.max(ARM_PX * px_m);
    let (Some(from_px), Some(to_px)) = (view.px(&(at + along * first)), view.px(&(at + along * last))) else {
        return Arm::Unknown;
    };
    if last > MAX_ARM_M {
        return Arm::Unknown;
    }
    let across = (to_px - from_px).normalize();
    let across = Vector2::new(-across.y, across.x);
    let (mut num_white, mut num_carpet) = (0, 0);
    for i in 0..NUM_SAMPLES {
        let t = first + (last - first) * f64::from(i) / f64::from(NUM_SAMPLES - 1);
        match view.at_ground(&(at + along * t), &across, white) {
            Seen::White => num_white += 1,
            Seen::Carpet => num_carpet += 1,
            Seen::Other => {}
            Seen::Nothing => return Arm::Unknown,
        }
    }
    match (num_white >= MIN_AGREEING, num_carpet >= MIN_AGREEING) {
        (true, _) => Arm::Line,
        (_, true) => Arm::Carpet,
        _ => Arm::Unknown,
    }
}

/// The kind of a junction and its direction, from its arms along and against both lines.
fn classify(arms: &[[Arm; 2]; 2], along: &[Vector2<f64>; 2]) -> Option<(JunctionKind, Vector2<f64>)> {
    let side = |k: usize| match arms[k] {
        [Arm::Line, Arm::Line] => Some(0.0),
        [Arm::Line, Arm::Carpet] => Some(1.0),
        [Arm::Carpet, Arm::Line] => Some(-1.0),
        _ => None,
    };
    let (a, b) = (side(0)?, side(1)?);
    match (a == 0.0, b == 0.0) {
        (true, true) => Some((JunctionKind::X, along[0])),
        (true, false) => Some((JunctionKind::T, along[1] * b)),
        (false, true) => Some((JunctionKind::T, along[0] * a)),
        (false, false) => Some((JunctionKind::L, along[0] * a + along[1] * b)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arms_tell_the_kind() {
        let along = [Vector2::x(), Vector2::y()];
        let (l, c, u) = (Arm::Line, Arm::Carpet, Arm::Unknown);
        let kind = |arms| classify(&arms, &along);
        assert_eq!(kind([[l, l], [l, l]]), Some((JunctionKind::X, Vector2::x())));
        assert_eq!(kind([[l, l], [c, l]]), Some((JunctionKind::T, -Vector2::y())));
        assert_eq!(kind([[l, c], [l, c]]), Some((JunctionKind::L, Vector2::new(1.0, 1.0))));
        for unclear in [[[l, u], [l, c]], [[c, c], [l, l]], [[u, u], [u, u]]] {
            assert_eq!(kind(unclear), None);
        }
    }
}
