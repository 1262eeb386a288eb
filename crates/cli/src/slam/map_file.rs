//! Maps in files.

use std::{fs, path::Path};

use anyhow::{Context, Result};
use visloc_slam::{Slam, map::MapId};
use visloc_vmap::{MapScale, ScaleSource, Session, VisualMap, load, save};

use super::SlamRun;
use crate::{args::SlamArgs, say};

/// Reads a map, and tells what is damaged.
///
/// # Errors
/// If it is no map that can be used.
pub fn load_map(path: &Path) -> Result<VisualMap> {
    let opened = load(path).with_context(|| path.display().to_string())?;
    for damage in &opened.damages {
        say::note!("{}: {damage}", path.display());
    }
    Ok(opened.map)
}

/// Writes the map of a run, which may have begun with another one.
///
/// # Errors
/// If it cannot be written.
pub fn save_map(path: &Path, args: &SlamArgs, run: &SlamRun, loaded: Option<VisualMap>) -> Result<()> {
    let loaded = loaded.unwrap_or_default();
    let scales = scales_after(&loaded, &run.slam);
    let mut sessions = loaded.sessions;
    sessions.push(Session {
        source: args.source.to_string(),
        program: concat!("visloc ", env!("CARGO_PKG_VERSION")).to_owned(),
        num_images: run.history.records.num_seen() as u64,
        seed: args.seed.value(),
    });
    let map = VisualMap { map: run.slam.map().clone(), scales, sessions };
    save(path, &map, &run.slam.session_camera()).with_context(|| path.display().to_string())?;
    let (num, num_bytes) = (map.map.all_keyframes().count(), fs::metadata(path).map_or(0, |file| file.len()));
    let each = num_bytes / num.max(1) as u64;
    say::line!("map: {}, {num} keyframes of {:.1} kB", path.display(), each as f64 / 1e3);
    Ok(())
}

/// Change of the scale of a keyframe, in logarithms, up to which it was only adjusted: more, and its map was moved into the frame of another.
const ADJUSTED: f64 = 0.1;

/// The scales of the maps after a run: a map that was loaded keeps its own, also when others were joined to it; any other has what
/// the odometry says.
fn scales_after(loaded: &VisualMap, slam: &Slam) -> Vec<MapScale> {
    let map = slam.map();
    let mut maps: Vec<MapId> = Vec::new();
    let mut scales: Vec<MapScale> = Vec::new();
    for (id, keyframe) in map.all_keyframes() {
        let number = maps.iter().position(|map| *map == keyframe.map).unwrap_or_else(|| {
            maps.push(keyframe.map);
            scales.push(scale_by_odometry(slam, keyframe.map));
            maps.len() - 1
        });
        let is_loaded = id.index() < loaded.map.num_keyframe_ids();
        if is_loaded && map.scale_of(id).ln().abs() < ADJUSTED {
            let known = loaded.scale(loaded.map.keyframe(id).map);
            if known.source != ScaleSource::Unknown {
                scales[number] = known;
            }
        }
    }
    scales
}

fn scale_by_odometry(slam: &Slam, map: MapId) -> MapScale {
    slam.metric_scale(map).map_or_else(MapScale::default, |scale| MapScale {
        source: ScaleSource::Odometry,
        relative_sigma: scale.deviation,
    })
}
