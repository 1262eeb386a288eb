//! What pages ask for.

use serde::{Deserialize, Serialize};
use visloc_locate::team::Liar;

/// A command from a page, as JSON: `{"type": "kidnap", "x_m": 1.0, "y_m": 0.5, "yaw_rad": 0.0}`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Command {
    /// A new page is there and wants to see everything.
    Hello {},
    /// Go on.
    Play {},
    /// Stop.
    Pause {},
    /// One step, and stop.
    Step {},
    /// How much faster than in reality; 0 is as fast as possible.
    Speed {
        /// The factor.
        factor: f64,
    },
    /// Everything from the beginning.
    Reset {
        /// Seed of everything random.
        seed: u64,
    },
    /// Shows something else.
    Open {
        /// Id of one of the scenes that the scene message lists.
        scene: String,
    },
    /// Walks until the next command.
    Drive {
        /// Ahead, share of the robot's speed, -1 to 1.
        forward: f64,
        /// To the left, -1 to 1.
        left: f64,
        /// Counter-clockwise, -1 to 1.
        turn: f64,
        /// A robot elsewhere holds it for 0.4 s, and only if this moment of its, `secs` of `drive` in the state that is shown, is not
        /// long past.
        #[serde(default)]
        seen_secs: Option<f64>,
    },
    /// Walks to a place.
    WalkTo {
        /// Meters.
        x_m: f64,
        /// Meters.
        y_m: f64,
    },
    /// Whether the robot walks around by itself.
    Autopilot {
        /// Whether.
        is_on: bool,
    },
    /// Where the head looks; by itself from side to side without angles.
    Head {
        /// To the left, degrees.
        #[serde(default)]
        yaw_deg: Option<f64>,
        /// Down, degrees.
        #[serde(default)]
        pitch_deg: Option<f64>,
    },
    /// Somebody holds the robot over a place, until [`Command::PutDown`].
    Carry {
        /// Meters.
        x_m: f64,
        /// Meters.
        y_m: f64,
        /// Heading, radians.
        yaw_rad: f64,
    },
    /// Lifts the robot where it is.
    Lift {},
    /// Puts the robot down.
    PutDown {},
    /// Carries the robot to another place, to a random one without coordinates.
    Kidnap {
        /// Number of the robot in its team, from 1.
        #[serde(default)]
        robot: Option<u8>,
        /// Meters.
        #[serde(default)]
        x_m: Option<f64>,
        /// Meters.
        #[serde(default)]
        y_m: Option<f64>,
        /// Heading, radians.
        #[serde(default)]
        yaw_rad: Option<f64>,
    },
    /// Whether the robot's feet notice that it is carried.
    Felt {
        /// Whether.
        is_on: bool,
    },
    /// A hand over the camera.
    Cover {
        /// Whether.
        is_on: bool,
    },
    /// Light in the world.
    Light {
        /// Brightness of the image, powers of two.
        exposure_stops: f64,
        /// How much the lamps differ, 0 to 1.
        unevenness: f64,
    },
    /// Errors of the odometry as multiple of the scenario's.
    Odometry {
        /// The factor.
        factor: f64,
    },
    /// Whether the others hear a robot of a team, and it them.
    Link {
        /// Its number, from 1.
        robot: u8,
        /// Whether.
        is_on: bool,
    },
    /// Makes a robot of a team a liar, or an honest one again.
    Lie {
        /// Its number, from 1.
        robot: u8,
        /// How it lies; nothing if it is honest.
        #[serde(default)]
        how: Option<Liar>,
    },
    /// Shows the image of another robot of a team.
    Look {
        /// Its number, from 1.
        robot: u8,
    },
    /// How many other robots walk around; of a team, how many there are in all.
    Robots {
        /// How many.
        count: u32,
    },
    /// Which algorithms run side by side.
    Algorithms {
        /// Their names.
        names: Vec<String>,
    },
    /// Changes a parameter.
    Parameter {
        /// Number of the algorithm, from 0; none for what all of them share.
        #[serde(default)]
        algorithm: Option<usize>,
        /// Key with its tables.
        path: String,
        /// The value.
        value: serde_json::Value,
    },
    /// All parameters as they were.
    Defaults {
        /// Number of the algorithm, from 0; none for what all of them share.
        #[serde(default)]
        algorithm: Option<usize>,
    },
    /// All algorithms forget where the robot is.
    Forget {},
    /// Draws how well every place explains the image.
    Likelihood {
        /// Whether.
        is_on: bool,
    },
    /// Records what is shown, into a file whose name the program chooses; or ends the recording.
    Record {
        /// Whether.
        is_on: bool,
    },
    /// Writes on the robot's side what a run has found so far.
    Save {},
    /// Computes a recording again with the parameters as they are set, and shows both.
    Recompute {
        /// Seed of everything random.
        seed: u64,
    },
    /// Shows what was recorded only.
    Recorded {},
    /// Opens a file that a page has handed over; only the server says so.
    #[serde(skip)]
    OpenFile {
        /// Where it is.
        path: std::path::PathBuf,
        /// Whether it is a map to play on.
        is_place: bool,
    },
    /// Goes to a moment of a recording.
    Seek {
        /// Number of the frame, from 0.
        frame: usize,
    },
}

impl Command {
    /// The word that it is sent with.
    pub fn name(&self) -> String {
        let message = serde_json::to_value(self).unwrap_or_default();
        message["type"].as_str().unwrap_or("unknown").to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_read_and_mistakes_refused() {
        let read = |text: &str| serde_json::from_str::<Command>(text);
        let expected = Command::WalkTo { x_m: 1.0, y_m: -2.0 };
        assert_eq!(read(r#"{"type":"walk_to","x_m":1,"y_m":-2}"#).unwrap(), expected);
        assert_eq!(read(r#"{"type":"play"}"#).unwrap(), Command::Play {});
        for wrong in [
            "",
            "[]",
            r#"{"type":"fly"}"#,
            r#"{"type":"walk_to","x_m":1}"#,
            r#"{"type":"play","now":true}"#,
            r#"{"type":"walk_to","x_m":"here","y_m":0}"#,
            r#"{"type":"seek","frame":-1}"#,
            r#"{"type":"lie","robot":1,"how":"always"}"#,
            r#"{"type":"link","robot":300,"is_on":true}"#,
            r#"{"type":"open_file","path":"/etc/passwd"}"#,
        ] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
