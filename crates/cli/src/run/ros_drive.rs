//! Moves a robot over ROS 2 as those who watch ask for it.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread::{self, JoinHandle},
    time::Duration,
};

use anyhow::{Context, Result};
use visloc_core::geom::nao::HeadAngles;
use visloc_io::ros2::{DrivePublisher, DriveTopics};

use super::live::node_settings;

/// How often the robot is told its speeds.
const EVERY: Duration = Duration::from_millis(50);
/// So often it is told to stand when nobody drives any more; then others may move it.
const NUM_STOPS: u32 = 10;

/// What the robot is to do now: speeds while somebody drives, and where its head looks.
pub type Wanted = (Option<[f64; 3]>, Option<HeadAngles>);

/// Tells the robot its speeds on a thread of its own, so that it stops also while no image comes. It stands when this is dropped.
pub struct RosDriver {
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl RosDriver {
    /// Joins the network. Nothing is said before somebody drives.
    pub fn start(
        domain_id: u16,
        topics: &DriveTopics,
        wanted: impl Fn() -> Wanted + Send + 'static,
    ) -> Result<Self> {
        let mut node = node_settings(domain_id);
        node.name.push_str("_drive");
        let mut publisher = DrivePublisher::open(&node, topics)?;
        let is_over = Arc::new(AtomicBool::new(false));
        let over = Arc::clone(&is_over);
        let work = move || {
            let mut course = Course::default();
            while !over.load(Ordering::Relaxed) {
                publisher.keep_joined();
                course.tell(&publisher, wanted());
                thread::sleep(EVERY);
            }
            course.tell(&publisher, (None, None));
        };
        let thread = thread::Builder::new().name("drive".to_owned()).spawn(work);
        Ok(Self { is_over, thread: Some(thread.context("cannot start to drive")?) })
    }
}

impl Drop for RosDriver {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What the robot was told so far.
#[derive(Default)]
struct Course {
    head: Option<HeadAngles>,
    num_stops_due: u32,
}

impl Course {
    /// What the robot is told now; nothing while nobody drives.
    fn next(&mut self, (speeds, head): Wanted) -> Wanted {
        let look = head.filter(|_| head != self.head);
        self.head = head;
        if speeds.is_some() {
            self.num_stops_due = NUM_STOPS;
            return (speeds, look);
        }
        let is_told = self.num_stops_due > 0;
        self.num_stops_due = self.num_stops_due.saturating_sub(1);
        (is_told.then_some([0.0; 3]), look)
    }

    fn tell(&mut self, publisher: &DrivePublisher, wanted: Wanted) {
        let (speeds, look) = self.next(wanted);
        if let Some(speeds) = speeds {
            publisher.drive(speeds);
        }
        if let Some(angles) = look {
            publisher.look(angles);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_is_not_driven_is_told_to_stand_and_then_left_alone() {
        let mut course = Course::default();
        assert_eq!(course.next((None, None)), (None, None), "others may move it");
        let ahead = Some([0.2, 0.0, 0.0]);
        let left = Some(HeadAngles { yaw_rad: 0.5, pitch_rad: 0.0 });
        assert_eq!(course.next((ahead, left)), (ahead, left));
        assert_eq!(course.next((ahead, left)), (ahead, None), "the head is told once");
        let told: Vec<_> = (0..20).map(|_| course.next((None, left)).0).collect();
        assert!(told[..10].iter().all(|speeds| *speeds == Some([0.0; 3])), "half a second: {told:?}");
        assert!(told[10..].iter().all(Option::is_none));
    }
}
