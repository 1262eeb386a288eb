//! What is known about the start.

use std::str::FromStr;

use visloc_core::geom::PlanarPose;
use visloc_locate::Half;

use super::number::numbers;

/// Spread of a pose that is given without one, meters and radians.
const POSE_SPREAD_M: f64 = 0.2;
const POSE_SPREAD_RAD: f64 = 0.2;

/// One `--start`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StartArg {
    /// A half of the field.
    Half(Half),
    /// On a side line of one half or of both, facing the field.
    SideLines(Half),
    /// Near a pose.
    Pose {
        /// The pose.
        world_from_robot: PlanarPose,
        /// Standard deviations, meters and radians.
        spread: (f64, f64),
    },
}

impl FromStr for StartArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        match kind {
            "half" if !rest.is_empty() => Ok(Self::Half(half(rest)?)),
            "side-lines" => Ok(Self::SideLines(if rest.is_empty() { Half::Both } else { half(rest)? })),
            "pose" => pose(rest),
            _ => Err("expected half:negative, half:positive, side-lines, side-lines:negative, \
                      side-lines:positive or pose:X,Y,HEADING"
                .to_owned()),
        }
    }
}

fn half(text: &str) -> Result<Half, String> {
    match text {
        "negative" => Ok(Half::Negative),
        "positive" => Ok(Half::Positive),
        _ => Err(format!("expected the half with negative or positive x, found \"{text}\"")),
    }
}

/// `X,Y,HEADING[,SPREAD]`: meters and degrees.
fn pose(text: &str) -> Result<StartArg, String> {
    let [x_m, y_m, heading_deg, spread_m] = match (numbers(text), numbers(text)) {
        (Ok([x, y, heading]), _) => [x, y, heading, POSE_SPREAD_M],
        (_, Ok(all)) if (0.001..=1000.0).contains(&all[3]) => all,
        _ => {
            return Err(
                "expected pose:X,Y,HEADING in meters and degrees, or with a spread in meters".to_owned()
            );
        }
    };
    Ok(StartArg::Pose {
        world_from_robot: PlanarPose::new(x_m, y_m, heading_deg.to_radians()),
        spread: (spread_m, POSE_SPREAD_RAD),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_are_read() {
        assert_eq!("half:negative".parse(), Ok(StartArg::Half(Half::Negative)));
        assert_eq!("side-lines".parse(), Ok(StartArg::SideLines(Half::Both)));
        let Ok(StartArg::Pose { world_from_robot, spread }) = "pose:1.5, -2,90,0.3".parse() else {
            panic!("a pose")
        };
        assert!((world_from_robot.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!((spread.0 - 0.3).abs() < 1e-12);
    }

    #[test]
    fn what_is_wrong_is_told() {
        for (text, expected) in [
            ("here", "half:negative"),
            ("half:left", "negative or positive"),
            ("pose:1,2", "X,Y,HEADING"),
            ("pose:1,2,nan", "X,Y,HEADING"),
            ("pose:1,2,3,0", "X,Y,HEADING"),
        ] {
            let error = text.parse::<StartArg>().unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
