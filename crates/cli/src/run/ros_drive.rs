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

use super::node_settings;

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
    ///
    /// # Errors
    /// If there is no network, or a name is none.
    pub fn start(
        domain_id: u16,
        topics: &DriveTopics,
        wanted: impl Fn() -> Wanted + Send + 'static,
    ) -> Result<Self> {
        let mut node = node_settings(domain_id);
        node.name.push_str("_drive");
        let publisher = DrivePublisher::open(&node, topics)?;
        let is_over = Arc::new(AtomicBool::new(false));
        let over = Arc::clone(&is_over);
        let work = move || {
            let mut course = Course::default();
            while !over.load(Ordering::Relaxed) {
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
    fn tell(&mut self, publisher: &DrivePublisher, (speeds, head): Wanted) {
        if let Some(speeds) = speeds {
            publisher.drive(speeds);
            self.num_stops_due = NUM_STOPS;
        } else if self.num_stops_due > 0 {
            publisher.drive([0.0; 3]);
            self.num_stops_due -= 1;
        }
        if let Some(angles) = head.filter(|_| head != self.head) {
            publisher.look(angles);
        }
        self.head = head;
    }
}
