//! Live ROS 2 topics of a camera in a map of SLAM, and orders from there.

use std::path::Path;

use anyhow::{Context, Result};
use visloc_io::{
    bag::{
        ResultFrames, ResultMessages,
        messages::{Header, Pose, PoseStamped},
    },
    ros2::{Order, ResultPublisher, occupancy_grid},
};
use visloc_slam::SlamConfig;
use visloc_vmap::VisualMap;

use super::{floor::floor_of, results::result_sample};
use crate::{
    host::now,
    run::{TF_AHEAD_SECS, obeyed, publish_settings},
    slam::{MapView, MapWatcher, MapWish, NamedMaps, landmark_cloud, load_fixed_map},
};

/// Publishes what is known after every image.
struct MapLive {
    publisher: ResultPublisher,
    results: ResultMessages,
    frames: ResultFrames,
    has_sent_points: bool,
    maps: NamedMaps,
    publishes_map: bool,
}

/// Joins the network. Maps that other programs name lie beside that of `--map`.
pub fn open_map_live(
    domain_id: u16,
    frames: ResultFrames,
    (name, map): (&str, Option<&VisualMap>),
) -> Result<Box<dyn MapWatcher>> {
    let path = Path::new(name);
    let mut publisher = ResultPublisher::open(&publish_settings(domain_id, true))?;
    if let Some(map) = map {
        let floor = floor_of(path, map).context("--publish-map")?;
        publisher.publish_map(occupancy_grid(now(), &frames.map, &floor))?;
    }
    Ok(Box::new(MapLive {
        publisher,
        maps: NamedMaps::beside("--map", Some(path)),
        publishes_map: map.is_some(),
        results: ResultMessages::new(frames.clone(), TF_AHEAD_SECS),
        frames,
        has_sent_points: false,
    }))
}

impl MapWatcher for MapLive {
    fn look(&mut self, view: &MapView<'_>) {
        let &MapView { localizer, frame, num_dropped, .. } = view;
        let (at, estimate) = (frame.gray.at, localizer.estimate());
        let sample = result_sample(frame, estimate, &localizer.hypotheses(), num_dropped);
        for message in self.results.step(&sample) {
            self.publisher.publish(message);
        }
        if let Some(estimate) = estimate.filter(|estimate| estimate.is_localized()) {
            let pose = Pose::rigid(&estimate.world_from_camera);
            self.publisher.publish_camera(PoseStamped { header: Header::new(at, &self.frames.map), pose });
        }
        if !std::mem::replace(&mut self.has_sent_points, true) {
            self.publisher.publish_points(landmark_cloud(at, &self.frames.map, localizer.slam().map(), 1.0));
        }
    }

    fn take_wish(&mut self, _: &mut SlamConfig, _: &mut u64) -> Option<MapWish> {
        let mut wish = None;
        let (results, maps) = (&mut self.results, &self.maps);
        self.publisher.obey(|order| {
            obeyed(match order {
                Order::Reset => {
                    results.reset();
                    wish = Some(MapWish::Anew);
                    Ok("reset: the pose is forgotten".into())
                }
                Order::LoadMap(name) => {
                    let loaded = maps.path(&name).and_then(|path| {
                        let map = load_fixed_map(&path).map_err(|error| format!("{error:#}"))?;
                        Ok((path, map))
                    });
                    loaded.map_err(|reason| format!("load_map: {reason}")).map(|(path, map)| {
                        results.reset();
                        wish = Some(MapWish::In(Box::new(map)));
                        format!("map loaded: {}; the camera is looked for in it", path.display())
                    })
                }
                Order::SaveMap(_) => {
                    Err("save_map: the map stays as it is; visloc slam --load extends it".into())
                }
                Order::SetScale(_) => {
                    Err("set_scale: the map stays as it is; visloc map align gives it meters".into())
                }
                Order::InitialPose(..) => {
                    Err("initialpose: a camera in a map of SLAM is found by what it sees alone".into())
                }
            })
        });
        if let Some(MapWish::In(map)) = &wish {
            self.has_sent_points = false;
            self.publish_floor(map);
        }
        wish
    }

    fn num_unsent(&self) -> usize {
        self.publisher.num_failed()
    }
}

impl MapLive {
    /// The floor of another map, if that of the first was published.
    fn publish_floor(&mut self, map: &VisualMap) {
        if !self.publishes_map {
            return;
        }
        let floor = floor_of(Path::new("load_map"), map);
        let published = floor.and_then(|floor| {
            Ok(self.publisher.publish_map(occupancy_grid(now(), &self.frames.map, &floor))?)
        });
        // The camera can be found all the same.
        let _ = obeyed(
            published.map(|()| "/map is that of the map now".to_owned()).map_err(|e| format!("{e:#}")),
        );
    }
}
