//! Live ROS 2 topics of a camera in a map of SLAM, and orders from there.

use anyhow::Result;
use visloc_io::{
    bag::{
        ResultFrames, ResultMessages,
        messages::{Header, Pose, PoseStamped},
    },
    ros2::{Order, ResultPublisher},
};
use visloc_slam::map::Map;
use visloc_vmap::CameraEstimate;

use super::{frames::MapFrame, results::result_sample};
use crate::{
    host::host,
    run::{TF_AHEAD_SECS, node_settings},
    slam::landmark_cloud,
};

/// Publishes what is known after every image.
pub struct MapLive {
    publisher: ResultPublisher,
    results: ResultMessages,
    frames: ResultFrames,
    has_sent_points: bool,
}

impl MapLive {
    /// Joins the network.
    ///
    /// # Errors
    /// If there is none.
    pub fn open(domain_id: u16, frames: ResultFrames) -> Result<Self> {
        Ok(Self {
            publisher: ResultPublisher::open(&node_settings(domain_id))?,
            results: ResultMessages::new(frames.clone(), TF_AHEAD_SECS),
            frames,
            has_sent_points: false,
        })
    }

    /// Publishes what is known after a frame.
    pub fn look(
        &mut self,
        map: &Map,
        frame: &MapFrame,
        estimate: Option<&CameraEstimate>,
        num_dropped: usize,
    ) {
        let at = frame.gray.at;
        for message in self.results.step(&result_sample(frame, estimate, num_dropped)) {
            self.publisher.publish(message);
        }
        if let Some(estimate) = estimate.filter(|estimate| estimate.is_localized()) {
            let pose = Pose::rigid(&estimate.world_from_camera);
            self.publisher.publish_camera(PoseStamped { header: Header::new(at, &self.frames.map), pose });
        }
        if !std::mem::replace(&mut self.has_sent_points, true) {
            self.publisher.publish_points(landmark_cloud(at, &self.frames.map, map));
        }
    }

    /// Whether the camera is to be looked for anew.
    pub fn takes_reset(&mut self) -> bool {
        let mut is_reset = false;
        for order in self.publisher.orders() {
            match order {
                Order::Reset => {
                    host().notice("reset: the pose is forgotten");
                    self.results.reset();
                    is_reset = true;
                }
                Order::SaveMap => {
                    host().notice("save_map: the map stays as it is; visloc slam --load extends it")
                }
                Order::InitialPose(..) => {
                    host().notice("initialpose: a camera in a map of SLAM is found by what it sees alone");
                }
            }
        }
        is_reset
    }

    /// Messages that could not be sent.
    pub fn num_unsent(&self) -> usize {
        self.publisher.num_failed()
    }
}
