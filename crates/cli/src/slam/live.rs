//! SLAM on live ROS 2 topics: camera pose, map points and state, and orders from there.

use std::path::PathBuf;

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
    map::{Landmark, Map, MapId},
};
use visloc_vmap::{ScaleSource, VisualMap, save};

use super::{NamedMaps, SlamRecord, SlamWatcher, drive::Restart, load_map, map_file, write_ply};
use crate::{
    args::SlamArgs,
    run::{obeyed, publish_settings},
};

/// Frame of the map; its unit is the median depth at the start, unless somebody has said how long it is.
const MAP_FRAME: &str = "map";
/// Time between point clouds, seconds.
const POINTS_EVERY_SECS: f64 = 1.0;

/// Publishes what SLAM knows after every image.
struct SlamLive {
    publisher: ResultPublisher,
    orders: Orders,
    points_sent_at: Option<Timestamp>,
}

/// What others ask for, and what that needs.
struct Orders {
    args: SlamSaved,
    /// What the run began with.
    began_with: Option<VisualMap>,
    /// How long the unit of a map is, meters, if somebody has said it.
    told: Option<(MapId, f64)>,
    restart: Option<Restart>,
    num_images: usize,
}

/// Where maps are saved and loaded.
struct SlamSaved {
    points: Option<PathBuf>,
    saves: NamedMaps,
    loads: NamedMaps,
    source: String,
    seed: u64,
}

/// Joins the network. What the run begins with is extended by it when it is saved.
pub fn open_slam_live(
    domain_id: u16,
    args: &SlamArgs,
    began_with: Option<&VisualMap>,
) -> Result<Box<dyn SlamWatcher>> {
    let args = SlamSaved {
        points: args.points.as_deref().map(PathBuf::from),
        saves: NamedMaps::beside("--save", args.save.as_deref()),
        loads: NamedMaps::beside("--load", args.load.as_deref().or(args.save.as_deref())),
        source: args.source.to_string(),
        seed: args.seed.value(),
    };
    let began_with = began_with.cloned();
    Ok(Box::new(SlamLive {
        publisher: ResultPublisher::open(&publish_settings(domain_id, false))?,
        orders: Orders { args, began_with, told: None, restart: None, num_images: 0 },
        points_sent_at: None,
    }))
}

impl SlamLive {
    fn send_points(&mut self, at: Timestamp, slam: &Slam) {
        let is_due = self.points_sent_at.is_none_or(|sent| at.secs_since(sent).abs() >= POINTS_EVERY_SECS);
        if !is_due {
            return;
        }
        self.points_sent_at = Some(at);
        let unit = self.orders.unit_of(slam.map());
        self.publisher.publish_points(landmark_cloud(at, MAP_FRAME, slam.map(), unit));
    }
}

impl Orders {
    /// How long the unit of the map that is active is: 1 unless somebody has said it.
    fn unit_of(&self, map: &Map) -> f64 {
        self.told.filter(|(id, _)| *id == map.active()).map_or(1.0, |(_, meters)| meters)
    }

    fn obey(&mut self, order: Order, slam: &Slam) -> Result<String, String> {
        match order {
            Order::Reset => {
                self.begin_again(Restart::Anew);
                Ok("reset: the map is forgotten".into())
            }
            Order::SaveMap(name) => self.save(&name, slam),
            Order::LoadMap(name) => self.load(&name),
            Order::SetScale(meters_per_unit) => self.set_scale(meters_per_unit, slam),
            Order::InitialPose(..) => Err("initialpose: SLAM has no map to place a pose on".into()),
        }
    }

    fn begin_again(&mut self, restart: Restart) {
        self.restart = Some(restart);
        self.told = None;
    }

    fn save(&self, name: &str, slam: &Slam) -> Result<String, String> {
        let path = match (self.args.saves.path(name), &self.args.points) {
            (Err(_), Some(points)) if name.is_empty() => {
                let written = write_ply(points, slam.map(), slam.camera(), "map units");
                return written
                    .map(|()| format!("map saved: {}", points.display()))
                    .map_err(|error| format!("save_map: {error:#}"));
            }
            (Err(_), None) if name.is_empty() => {
                return Err("save_map: expected a file for the map, found none; start with --save FILE or --points FILE".into());
            }
            (path, _) => path.map_err(|reason| format!("save_map: {reason}"))?,
        };
        let map = self.map_so_far(slam);
        if map.map.all_keyframes().next().is_none() {
            return Err("save_map: there is no map yet".into());
        }
        save(&path, &map, &slam.session_camera()).map_err(|error| format!("save_map: {error}"))?;
        Ok(format!("map saved: {}", path.display()))
    }

    /// The map as it would be saved now.
    fn map_so_far(&self, slam: &Slam) -> VisualMap {
        let session = map_file::session((&self.args.source, self.args.seed), self.num_images);
        let mut map = self.began_with.clone().unwrap_or_default().after(slam, session);
        if let Some((id, meters)) = self.told {
            map.tell_scale(id, meters);
        }
        map
    }

    fn load(&mut self, name: &str) -> Result<String, String> {
        let path = self.args.loads.path(name).map_err(|reason| format!("load_map: {reason}"))?;
        let map = load_map(&path).map_err(|error| format!("load_map: {error:#}"))?;
        self.begin_again(Restart::In(Box::new(map.map.clone())));
        self.began_with = Some(map);
        Ok(format!("map loaded: {}; the camera is looked for in it", path.display()))
    }

    fn set_scale(&mut self, meters_per_unit: f64, slam: &Slam) -> Result<String, String> {
        let active = slam.map().active();
        self.told = None;
        let source = self.map_so_far(slam).scale_of_part(active).source;
        if source != ScaleSource::Unknown {
            return Err(format!("set_scale: the map is in meters already ({})", source.name()));
        }
        self.told = Some((active, meters_per_unit));
        Ok(format!("set_scale: a map unit is {meters_per_unit} m"))
    }
}

/// The landmarks of the map that is active as a cloud in a frame, each coordinate times the length of the map's unit.
pub fn landmark_cloud(at: Timestamp, frame: &str, map: &Map, unit: f64) -> PointCloud2 {
    let converged = map.landmarks().filter(|(_, landmark)| landmark.is_converged());
    let point = |(_, l): (_, &Landmark)| {
        [l.point_in_world.x, l.point_in_world.y, l.point_in_world.z].map(|value| (value * unit) as f32)
    };
    point_cloud(at, frame, &converged.map(point).collect::<Vec<_>>())
}

impl SlamWatcher for SlamLive {
    fn after_frame(&mut self, at: Timestamp, outcome: &FrameOutcome, slam: &Slam) {
        self.orders.num_images += 1;
        let record = SlamRecord::new(0, at, outcome);
        if let Some(camera_from_world) = outcome.camera_from_world.filter(|_| record.is_tracked()) {
            let mut pose = Pose::rigid(&camera_from_world.inverse());
            let unit = self.orders.unit_of(slam.map());
            for value in [&mut pose.position.x, &mut pose.position.y, &mut pose.position.z] {
                *value *= unit;
            }
            self.publisher.publish_camera(PoseStamped { header: Header::new(at, MAP_FRAME), pose });
        }
        let state = record.state_name();
        let values = [("searched", outcome.matches.0.to_string()), ("found", outcome.matches.1.to_string())];
        let status = diagnostics_message(at, "SLAM", (record.is_tracked(), state), &values);
        self.publisher.publish_diagnostics(status);
        self.send_points(at, slam);
        self.publisher.obey(|order| obeyed(self.orders.obey(order, slam)));
    }

    fn takes_restart(&mut self) -> Option<Restart> {
        self.orders.restart.take()
    }

    fn finish(self: Box<Self>) -> (Option<VisualMap>, Option<(MapId, f64)>) {
        (self.orders.began_with, self.orders.told)
    }
}
