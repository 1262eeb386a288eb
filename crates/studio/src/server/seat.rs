//! One drives at a time.

use std::net::SocketAddr;

use super::wheel::Wheel;
use crate::Command;

/// Who has driven keeps the seat for so long, seconds.
const SEAT_SECS: f64 = 2.0;

/// Somebody at a page, or a program that speaks for pages elsewhere.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Visitor {
    /// Different for each connection.
    pub id: u64,
    /// Where they connect from.
    pub address: SocketAddr,
}

impl Visitor {
    /// What others are told.
    pub fn name(&self) -> String {
        self.address.to_string()
    }
}

/// The seat of the one who drives.
#[derive(Debug, Default)]
pub(super) struct Seat {
    taken: Option<Taken>,
}

#[derive(Debug)]
struct Taken {
    by: Visitor,
    until_secs: f64,
    /// Whether their last command was to move.
    is_moving: bool,
}

impl Seat {
    /// Whether a visitor may drive; then the seat is theirs.
    ///
    /// # Errors
    /// Who drives.
    pub fn take(&mut self, visitor: &Visitor, command: &Command, now_secs: f64) -> Result<(), String> {
        if !Wheel::is_for(command) {
            return Ok(());
        }
        if let Some(taken) = self.taken.as_ref().filter(|it| it.by != *visitor && now_secs < it.until_secs) {
            let name = taken.by.name();
            return Err(format!("{name} drives; the robot is free {SEAT_SECS:.0} s after they have let go"));
        }
        let was_moving = self.taken.as_ref().is_some_and(|taken| taken.by == *visitor && taken.is_moving);
        let is_moving = match *command {
            Command::Drive { forward, left, turn, .. } => [forward, left, turn] != [0.0; 3],
            _ => was_moving,
        };
        self.taken = Some(Taken { by: visitor.clone(), until_secs: now_secs + SEAT_SECS, is_moving });
        Ok(())
    }

    /// A visitor leaves; whether the robot moves as that one wanted it to.
    pub fn leave(&mut self, visitor: &Visitor) -> bool {
        self.taken.take_if(|taken| taken.by == *visitor).is_some_and(|taken| taken.is_moving)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_drives_at_a_time_and_the_other_is_told_who() {
        let visitor = |id, port| Visitor { id, address: format!("192.168.0.7:{port}").parse().unwrap() };
        let (one, two) = (visitor(1, 100), visitor(2, 200));
        let drive = Command::Drive { forward: 1.0, left: 0.0, turn: 0.0, seen_secs: None };
        let head = Command::Head { yaw_deg: None, pitch_deg: None };
        let stop = Command::Drive { forward: 0.0, left: 0.0, turn: 0.0, seen_secs: None };
        let mut seat = Seat::default();
        seat.take(&two, &Command::Forget {}, 0.0).unwrap();
        seat.take(&one, &drive, 0.0).unwrap();
        let refused = seat.take(&two, &drive, 1.9).unwrap_err();
        assert!(refused.starts_with("192.168.0.7:100 drives"), "{refused}");
        seat.take(&one, &drive, 1.9).unwrap();
        assert!(seat.take(&two, &drive, 2.1).is_err());
        seat.take(&one, &head, 2.2).unwrap();
        assert!(!seat.leave(&two) && seat.leave(&one) && !seat.leave(&one));
        seat.take(&two, &drive, 2.2).unwrap();
        seat.take(&two, &stop, 2.3).unwrap();
        assert!(!seat.leave(&two), "it stands already");
        seat.take(&one, &drive, 2.4).unwrap();
        seat.take(&two, &drive, 4.5).unwrap();
    }
}
