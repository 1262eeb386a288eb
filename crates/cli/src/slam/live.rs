//! SLAM on live ROS 2 topics: camera pose, map points and state, and orders from there.

use std::path::{Path, PathBuf};

use anyhow::Result;
use visloc_core::Timestamp;
use visloc_io::{
    bag::{
        diagnostics_message,
        messages::{Header, PointCloud2, Pose, PoseStamped},
    },
    ros2::{Order, ResultPublisher, point_cloud},
};
use visloc_slam::{
    FrameOutcome, Slam,
    map::{Landmark, Map},
};

use super::{SlamRecord, SlamWatcher, write_ply};
use crate::{host::host, run::node_settings};

/// Frame of the map; its unit is the median depth at the start.
const MAP_FRAME: &str = "map";
/// Time between point clouds, seconds.
const POINTS_EVERY_SECS: f64 = 1.0;

/// Publishes what SLAM knows after every image.
pub struct SlamLive {
    publisher: ResultPublisher,
    map_file: Option<PathBuf>,
    points_sent_at: Option<Timestamp>,
    is_reset: bool,
}

impl SlamLive {
    /// Joins the network. `/visloc/save_map` writes to the file, if there is one.
    ///
    /// # Errors
    /// If there is no network.
    pub fn open(domain_id: u16, map_file: Option<&Path>) -> Result<Self> {
        let publisher = ResultPublisher::open(&node_settings(domain_id))?;
        Ok(Self {
            publisher,
            map_file: map_file.map(Path::to_path_buf),
            points_sent_at: None,
            is_reset: false,
        })
    }

    fn obey(&mut self, slam: &Slam) {
        for order in self.publisher.orders() {
            match order {
                Order::Reset => self.is_reset = true,
                Order::SaveMap => match &self.map_file {
                    Some(path) => {
                        let result = write_ply(path, slam.map(), slam.camera(), "map units");
                        let saved = || format!("map saved: {}", path.display());
                        host().notice(&result.map_or_else(|error| format!("{error:#}"), |()| saved()));
                    }
                    None => host().notice(
                        "save_map: expected a file for the map, found none; start with --points FILE",
                    ),
                },
                Order::InitialPose(..) => host().notice("initialpose: SLAM has no map to place a pose on"),
            }
        }
    }

    fn send_points(&mut self, at: Timestamp, slam: &Slam) {
        let is_due = self.points_sent_at.is_none_or(|sent| at.secs_since(sent).abs() >= POINTS_EVERY_SECS);
        if !is_due {
            return;
        }
        self.points_sent_at = Some(at);
        self.publisher.publish_points(landmark_cloud(at, MAP_FRAME, slam.map()));
    }
}

/// The landmarks of the map that is active as a cloud in a frame.
#[allow(clippy::cast_possible_truncation)]
pub fn landmark_cloud(at: Timestamp, frame: &str, map: &Map) -> PointCloud2 {
    let converged = map.landmarks().filter(|(_, landmark)| landmark.is_converged());
    let point = |(_, l): (_, &Landmark)| {
        [l.point_in_world.x, l.point_in_world.y, l.point_in_world.z].map(|value| value as f32)
    };
    point_cloud(at, frame, &converged.map(point).collect::<Vec<_>>())
}

impl SlamWatcher for SlamLive {
    fn after_frame(&mut self, at: Timestamp, outcome: &FrameOutcome, slam: &Slam) {
        let record = SlamRecord::new(0, at, outcome);
        if let Some(camera_from_world) = outcome.camera_from_world.filter(|_| record.is_tracked()) {
            let pose = Pose::rigid(&camera_from_world.inverse());
            self.publisher.publish_camera(PoseStamped { header: Header::new(at, MAP_FRAME), pose });
        }
        let state = record.state_name();
        let values = [("searched", outcome.matches.0.to_string()), ("found", outcome.matches.1.to_string())];
        let status = diagnostics_message(at, "SLAM", (record.is_tracked(), &state), &values);
        self.publisher.publish_diagnostics(status);
        self.send_points(at, slam);
        self.obey(slam);
    }

    fn takes_reset(&mut self) -> bool {
        std::mem::take(&mut self.is_reset)
    }
}
