//! Maps in files.

use std::{fs, path::Path};

use anyhow::Result;
use visloc_slam::map::{MapId, SessionCamera};
use visloc_vmap::{Damage, OpenedMap, Session, VisualMap, VmapError, load, load_fixed, save};

use super::SlamRun;
use crate::{args::SlamArgs, say};

/// Whether a map is one of SLAM, by its name.
pub fn is_map_of_slam(name: &str) -> bool {
    name.ends_with(".vmap")
}

/// Reads a map, and tells what is damaged.
pub fn load_map(path: &Path) -> Result<VisualMap> {
    told(path, load(path))
}

/// The same for a map that only cameras are looked for in.
pub fn load_fixed_map(path: &Path) -> Result<VisualMap> {
    told(path, load_fixed(path))
}

fn told(path: &Path, opened: Result<OpenedMap, VmapError>) -> Result<VisualMap> {
    let opened = opened?;
    for damage in damages_in_words(&opened.damages) {
        say::note!("{}: {damage}", path.display());
    }
    Ok(opened.map)
}

/// What is damaged; sections that follow each other are told at once if they are so alike.
pub fn damages_in_words(damages: &[Damage]) -> Vec<String> {
    let alike = damages.chunk_by(|a, b| a.reason == b.reason && a.loss == b.loss);
    let in_words = |alike: &[Damage]| match alike {
        [first, .., last] => format!(
            "{} sections from {} to {} are damaged ({}): {}",
            alike.len(),
            first.section,
            last.section,
            first.reason,
            first.loss
        ),
        alone => alone.iter().map(ToString::to_string).collect(),
    };
    alike.map(in_words).collect()
}

/// Writes the map of a run, which may have begun with another one, and of whose maps one may have a unit that somebody has told.
pub fn save_map(
    path: &Path,
    args: &SlamArgs,
    run: &SlamRun,
    (loaded, told): (Option<VisualMap>, Option<(MapId, f64)>),
) -> Result<()> {
    let session = session((&args.source, args.seed.value()), run.history.records.num_seen());
    let mut map = loaded.unwrap_or_default().after(&run.slam, session);
    if let Some((id, meters_per_unit)) = told {
        map.tell_scale(id, meters_per_unit);
    }
    write(path, &map, &run.slam.session_camera())
}

/// A run over so many images of a source, with a seed.
pub(super) fn session((source, seed): (&str, u64), num_images: usize) -> Session {
    Session {
        source: source.to_owned(),
        program: concat!("visloc ", env!("CARGO_PKG_VERSION")).to_owned(),
        num_images: num_images as u64,
        seed,
    }
}

/// Writes a map, and says how large it is.
pub(super) fn write(path: &Path, map: &VisualMap, own: &SessionCamera) -> Result<()> {
    save(path, map, own)?;
    let (num, num_bytes) = (map.map.all_keyframes().count(), fs::metadata(path).map_or(0, |file| file.len()));
    let each = num_bytes / num.max(1) as u64;
    say::line!("map: {}, {} of {:.1} kB", path.display(), say::count(num, "keyframe"), each as f64 / 1e3);
    Ok(())
}
