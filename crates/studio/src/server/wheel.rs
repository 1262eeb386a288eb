//! A robot that others drive over the link: who drives, how fast it may go, and when it stops.
//!
//! Motion is a dead man's switch: a command holds for [`HOLD_SECS`], so whoever drives repeats it as long as a key is held. Each one says
//! which moment its driver was looking at. If that is too long ago, on a slow link or after one that hung, the robot does not move: nobody
//! drives by what is out of date. Both times are by this program's clock, so clocks of others do not matter.

use std::sync::{Mutex, MutexGuard, PoisonError};

use serde_json::{Value, json};
use visloc_core::{Clock, geom::nao::HeadAngles};

use crate::Command;

/// A command to move holds for so long, seconds. With a loop that looks every 0.05 s, the robot stops within half a second.
const HOLD_SECS: f64 = 0.4;
/// What a driver looks at may be so old, seconds.
const MOST_LAG_SECS: f64 = 1.0;
/// Shares of the speed ahead: a legged robot is slower sideways.
const SIDEWAYS: f64 = 0.5;
/// Farthest that the head is turned to a side and down or up, degrees.
const MOST_HEAD_DEG: [f64; 2] = [120.0, 60.0];

/// How fast a robot may be driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveLimits {
    /// Ahead and back, meters per second; to the sides half of it.
    pub speed_m_per_s: f64,
    /// Turn, radians per second.
    pub turn_rad_per_s: f64,
}

/// What the robot is to do now.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveOrder {
    /// Ahead and to the left, meters per second, and counter-clockwise, radians per second. All 0: it stands.
    pub speeds: [f64; 3],
    /// Where the head looks; by itself if absent.
    pub head: Option<HeadAngles>,
    /// Whether somebody drives: otherwise the robot may be moved by others.
    pub is_driven: bool,
}

/// What those who drive have asked for.
#[derive(Debug)]
pub struct Wheel {
    limits: DriveLimits,
    clock: Clock,
    asked: Mutex<Asked>,
}

#[derive(Debug, Default)]
struct Asked {
    speeds: [f64; 3],
    /// Until when they hold.
    until_secs: f64,
    head: Option<HeadAngles>,
    driver: Option<String>,
    /// How old was what the driver looked at with the last command.
    lag_secs: Option<f64>,
}

impl Wheel {
    /// A robot that stands.
    pub fn new(limits: DriveLimits, clock: Clock) -> Self {
        Self { limits, clock, asked: Mutex::new(Asked::default()) }
    }

    fn asked(&self) -> MutexGuard<'_, Asked> {
        self.asked.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a command is one for a wheel.
    pub(crate) fn is_for(command: &Command) -> bool {
        matches!(command, Command::Drive { .. } | Command::Head { .. })
    }

    /// Does what the one at the wheel asks for.
    ///
    /// # Errors
    /// Why not, as a sentence for that person. The robot stands then.
    pub(crate) fn take(&self, driver: &str, command: &Command) -> Result<(), String> {
        match *command {
            Command::Drive { forward, left, turn, seen_secs } => {
                self.drive(driver, [forward, left, turn], seen_secs)
            }
            Command::Head { yaw_deg, pitch_deg } => {
                self.asked().head = head(yaw_deg, pitch_deg)?;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn drive(&self, driver: &str, shares: [f64; 3], seen_secs: Option<f64>) -> Result<(), String> {
        let now_secs = self.clock.secs();
        let mut asked = self.asked();
        let lag_secs = seen_secs.map(|seen_secs| now_secs - seen_secs);
        (asked.speeds, asked.lag_secs) = ([0.0; 3], lag_secs);
        asked.driver = Some(driver.to_owned());
        if shares == [0.0; 3] {
            return Ok(());
        }
        match lag_secs {
            Some(secs) if (0.0..=MOST_LAG_SECS).contains(&secs) => {}
            Some(secs) => {
                return Err(format!(
                    "the robot stands: what you see is {secs:.1} s old; it is driven only by what is at most \
                     {MOST_LAG_SECS:.0} s old"
                ));
            }
            None => return Err("the robot stands: expected seen_secs, the time of what you see".to_owned()),
        }
        let DriveLimits { speed_m_per_s, turn_rad_per_s } = self.limits;
        let most = [speed_m_per_s, SIDEWAYS * speed_m_per_s, turn_rad_per_s];
        asked.speeds = std::array::from_fn(|i| shares[i].clamp(-1.0, 1.0) * most[i]);
        asked.until_secs = now_secs + HOLD_SECS;
        Ok(())
    }

    /// The driver has left, or the link to them is lost: the robot stands.
    pub(crate) fn let_go(&self) {
        let mut asked = self.asked();
        (asked.speeds, asked.driver) = ([0.0; 3], None);
    }

    /// What the robot is to do now.
    pub fn order(&self) -> DriveOrder {
        let asked = self.asked();
        let is_driven = asked.speeds != [0.0; 3] && self.clock.secs() < asked.until_secs;
        let speeds = if is_driven { asked.speeds } else { [0.0; 3] };
        DriveOrder { speeds, head: asked.head, is_driven }
    }

    /// What those who watch should know: `drive` of the state message.
    pub fn fields(&self) -> Value {
        let DriveOrder { is_driven, head, .. } = self.order();
        let asked = self.asked();
        json!({
            "secs": self.clock.secs(),
            "driver": asked.driver.as_ref().filter(|_| is_driven),
            "is_driven": is_driven,
            "lag_secs": asked.lag_secs,
            "speed_m_per_s": self.limits.speed_m_per_s,
            "turn_deg_per_s": self.limits.turn_rad_per_s.to_degrees(),
            "head_deg": head.map(|head| [head.yaw_rad.to_degrees(), head.pitch_rad.to_degrees()]),
        })
    }
}

fn head(yaw_deg: Option<f64>, pitch_deg: Option<f64>) -> Result<Option<HeadAngles>, String> {
    if yaw_deg.is_none() && pitch_deg.is_none() {
        return Ok(None);
    }
    let angles = [yaw_deg.unwrap_or(0.0), pitch_deg.unwrap_or(0.0)];
    for ((name, most), found) in ["to the left", "down"].iter().zip(MOST_HEAD_DEG).zip(angles) {
        if !(-most..=most).contains(&found) {
            return Err(format!("head {name}: expected -{most} to {most} degrees, found {found}"));
        }
    }
    let [yaw_rad, pitch_rad] = angles.map(f64::to_radians);
    Ok(Some(HeadAngles { yaw_rad, pitch_rad }))
}

#[cfg(test)]
mod tests {
    use std::sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    };

    use super::*;

    fn wheel() -> (Wheel, Arc<AtomicU64>) {
        let ms = Arc::new(AtomicU64::new(10_000));
        let now = Arc::clone(&ms);
        let clock = Clock::new(move || now.load(Ordering::Relaxed) as f64 / 1e3);
        let limits = DriveLimits { speed_m_per_s: 0.3, turn_rad_per_s: 1.0 };
        (Wheel::new(limits, clock), ms)
    }

    fn drive(shares: [f64; 3], seen_secs: f64) -> Command {
        let [forward, left, turn] = shares;
        Command::Drive { forward, left, turn, seen_secs: Some(seen_secs) }
    }

    #[test]
    fn the_robot_moves_no_faster_than_it_may_and_stops_when_nothing_comes() {
        let (wheel, ms) = wheel();
        assert_eq!(wheel.order(), DriveOrder::default());
        wheel.take("desk", &drive([7.0, -1.0, 0.5], 9.9)).unwrap();
        assert_eq!(wheel.order().speeds, [0.3, -0.15, 0.5]);
        ms.fetch_add(390, Ordering::Relaxed);
        assert!(wheel.order().is_driven);
        ms.fetch_add(20, Ordering::Relaxed);
        assert_eq!(wheel.order(), DriveOrder::default(), "the key is held no more, or the link is lost");
        wheel.take("desk", &drive([1.0, 0.0, 0.0], 10.4)).unwrap();
        wheel.let_go();
        assert!(!wheel.order().is_driven);
    }

    #[test]
    fn who_sees_what_is_long_past_does_not_drive() {
        let (wheel, ms) = wheel();
        wheel.take("desk", &drive([1.0, 0.0, 0.0], 9.5)).unwrap();
        assert!((wheel.fields()["lag_secs"].as_f64().unwrap() - 0.5).abs() < 1e-9);
        ms.fetch_add(100, Ordering::Relaxed);
        for seen_secs in [9.0, 11.0] {
            let refused = wheel.take("desk", &drive([1.0, 0.0, 0.0], seen_secs)).unwrap_err();
            assert!(refused.contains("s old") && !wheel.order().is_driven, "{refused}");
        }
        let blind = Command::Drive { forward: 1.0, left: 0.0, turn: 0.0, seen_secs: None };
        assert!(wheel.take("desk", &blind).unwrap_err().contains("seen_secs"));
        wheel.take("desk", &drive([0.0; 3], 0.0)).unwrap();
    }

    #[test]
    fn the_head_stays_where_it_is_turned_to() {
        let (wheel, ms) = wheel();
        let look = |yaw_deg, pitch_deg| wheel.take("desk", &Command::Head { yaw_deg, pitch_deg });
        look(Some(90.0), None).unwrap();
        ms.fetch_add(60_000, Ordering::Relaxed);
        let order = wheel.order();
        assert!(!order.is_driven && (order.head.unwrap().yaw_rad.to_degrees() - 90.0).abs() < 1e-9);
        assert!(look(Some(0.0), Some(90.0)).unwrap_err().contains("down"));
        look(None, None).unwrap();
        assert_eq!(wheel.order().head, None);
    }
}
