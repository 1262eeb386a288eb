//! Angles in radians.

use std::f64::consts::{PI, TAU};

/// Wraps an angle to (-pi, pi].
///
/// ```
/// use std::f64::consts::PI;
/// assert!((visloc_core::geom::angle::wrap(3.0 * PI) - PI).abs() < 1e-12);
/// assert!((visloc_core::geom::angle::wrap(-0.5) + 0.5).abs() < 1e-12);
/// ```
#[inline]
pub fn wrap(angle_rad: f64) -> f64 {
    if angle_rad > -PI && angle_rad <= PI {
        return angle_rad;
    }
    let wrapped = angle_rad.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// The signed turn in (-pi, pi] that takes `from_rad` to `to_rad`.
#[inline]
pub fn difference(to_rad: f64, from_rad: f64) -> f64 {
    wrap(to_rad - from_rad)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn wrap_keeps_pi_and_moves_minus_pi() {
        assert_eq!(wrap(PI), PI);
        assert_eq!(wrap(-PI), PI);
        assert!((wrap(PI + 0.1) - (-PI + 0.1)).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn wrapped_angle_is_in_range_and_equivalent(angle_rad in -1e3..1e3f64) {
            let wrapped = wrap(angle_rad);
            prop_assert!(wrapped > -PI && wrapped <= PI);
            prop_assert!((wrapped.sin() - angle_rad.sin()).abs() < 1e-9);
            prop_assert!((wrapped.cos() - angle_rad.cos()).abs() < 1e-9);
        }

        #[test]
        fn difference_undoes_a_turn(from_rad in -3.0..3.0f64, turn_rad in -3.1..3.1f64) {
            prop_assert!((difference(from_rad + turn_rad, from_rad) - turn_rad).abs() < 1e-9);
        }
    }
}
