//! Where the camera of a tour is.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Rotation3, Vector3};
use visloc_core::geom::{CameraFrame, Rigid3, World};

use super::TourKind;

/// Seconds before which the covered camera of the kidnap is carried away, and after which it sees again.
pub(super) const COVERED_SECS: (f64, f64) = (13.0, 15.0);

/// Length of a tour, seconds.
pub(super) fn duration_secs(kind: TourKind) -> f64 {
    match kind {
        TourKind::Room => 20.0,
        TourKind::Hall => 30.0,
        TourKind::Walking => 15.0,
        TourKind::Kidnap => 24.0,
    }
}

/// The pose at a time since the start, for the phase of the hand's tremor, radians.
pub(super) fn pose(kind: TourKind, secs: f64, tremor_rad: f64) -> Rigid3<World, CameraFrame> {
    let (eye, target) = match kind {
        TourKind::Room => orbit(secs / 20.0 * 1.08),
        TourKind::Hall => hall(secs / 30.0),
        TourKind::Walking => aside(secs),
        // Before the kidnap 0.68 of a round, after it on from a quarter.
        TourKind::Kidnap if secs < COVERED_SECS.1 => orbit(secs.min(COVERED_SECS.0) * 0.052),
        TourKind::Kidnap => orbit(0.25 + (secs - COVERED_SECS.1) * 0.052),
    };
    let shake = |period: f64, phase: f64| (TAU * secs / period + phase + tremor_rad).sin();
    let tremor = Vector3::new(shake(2.3, 0.0), shake(3.1, 1.0), shake(1.9, 2.0)) * 0.008;
    let turn =
        Rotation3::from_scaled_axis(Vector3::new(shake(2.7, 0.5), shake(3.7, 1.5), shake(5.3, 2.5)) * 0.012);
    let upright = looking(&(eye + tremor), &target);
    Rigid3::new(Rotation3::from_matrix_unchecked(upright * turn.into_inner()), eye + tremor)
}

/// On an ellipse, looking across the room; a round is 1.
fn orbit(rounds: f64) -> (Vector3<f64>, Vector3<f64>) {
    let (sin, cos) = (TAU * rounds).sin_cos();
    let eye = Vector3::new(2.1 * cos, 1.5 * sin, 1.35 + 0.2 * (2.0 * TAU * rounds).sin());
    let target = Vector3::new(-0.5 * cos + 0.3 * sin, -0.4 * sin, 0.85);
    (eye, target)
}

/// Around the hall, looking ahead and outwards; a round is 1.
fn hall(rounds: f64) -> (Vector3<f64>, Vector3<f64>) {
    let (sin, cos) = (TAU * rounds).sin_cos();
    let eye = Vector3::new(3.4 * cos, 1.8 * sin, 1.6 + 0.5 * (TAU * rounds).sin());
    let ahead = Vector3::new(-3.4 * sin, 1.8 * cos, 0.0).normalize();
    let inwards = Vector3::new(-cos, -sin, 0.0);
    (eye, eye + ahead * 0.6 + inwards + Vector3::new(0.0, 0.0, -0.12))
}

/// A sideways step of 0.5 m in 3 s without a turn, then still.
fn aside(secs: f64) -> (Vector3<f64>, Vector3<f64>) {
    let share = (secs / 3.0).min(1.0);
    let smooth = share * share * (3.0 - 2.0 * share);
    let eye = Vector3::new(-2.6, 0.5 - 0.5 * smooth, 1.4);
    (eye, eye + Vector3::new(3.6, 0.0, -0.4))
}

/// Rotation of a camera (x right, y down, z forward) that looks from one point to another and holds the horizon level.
fn looking(eye: &Vector3<f64>, target: &Vector3<f64>) -> Matrix3<f64> {
    let forward = (target - eye).normalize();
    let right = forward.cross(&Vector3::z()).normalize();
    Matrix3::from_columns(&[right, forward.cross(&right), forward])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_moves_smoothly_and_holds_its_rotation() {
        for (_, kind, _) in super::super::TOURS {
            let mut last = pose(kind, 0.0, 0.3);
            for step in 1..(duration_secs(kind) * 25.0) as u32 {
                let secs = f64::from(step) / 25.0;
                let next = pose(kind, secs, 0.3);
                let motion = last.inverse() * next;
                let is_carried = kind == TourKind::Kidnap && (secs - COVERED_SECS.1).abs() < 0.05;
                assert!(is_carried || motion.translation().norm() < 0.06, "{kind:?} at {secs}");
                assert!(is_carried || motion.rotation_angle_rad() < 0.06, "{kind:?} at {secs}");
                let error = next.rotation().transpose() * next.rotation() - Matrix3::identity();
                assert!(error.norm() < 1e-9 && next.rotation().determinant() > 0.0);
                last = next;
            }
        }
    }
}
