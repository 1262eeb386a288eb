//! `visloc map merge | trim`.

use std::path::Path;

use anyhow::{Result, bail};
use visloc_slam::SlamConfig;
use visloc_vmap::{VisualMap, save};

use super::visual_map::{largest, nobody};
use crate::{claims::Identity, say, slam::load_map};

/// Makes one map of two.
pub fn merge(path: &Path, other_path: &Path, out: &Path, seed: u64) -> Result<()> {
    let (map, other) = (load_map(path)?, load_map(other_path)?);
    if Identity::of(path).is(&Identity::of(other_path)) {
        bail!("{}: expected two maps, found the same file twice", other_path.display());
    }
    largest(&map, path)?;
    largest(&other, other_path)?;
    let merged = map.merged_with(other, &SlamConfig::default(), seed);
    let (merged, how) = match merged {
        Ok(Some(merged)) => merged,
        Ok(None) => bail!("{}: expected a map with keyframes", path.display()),
        Err(apart) => {
            let reason = apart.reason.map(|reason| reason.to_string()).unwrap_or_default();
            let [path, other_path] = [path, other_path].map(Path::display);
            if apart.is_shown_too_little {
                bail!(
                    "{} keyframes of {other_path} may show places of {path}, but each misses most of what should be seen there: at the best one {reason}. \
                     Rooms with the same furniture look so",
                    apart.num_agreeing
                );
            }
            let reason = if reason.is_empty() { reason } else { format!("; the last one: {reason}") };
            bail!(
                "expected at least 3 keyframes that show a common place of {path} and {other_path} and agree on it, found {}: {} of {} look alike{reason}",
                apart.num_agreeing,
                apart.num_alike,
                apart.num_keyframes
            );
        }
    };
    say::line!(
        "{} keyframes show the same places: {} landmarks are the same, lengths of the one were multiplied by {:.4}",
        how.num_keyframes,
        how.num_same,
        how.scale
    );
    write(out, &merged)
}

/// Makes a map smaller.
pub fn trim(path: &Path, keyframes: usize, out: &Path) -> Result<()> {
    let mut map = load_map(path)?;
    let id = largest(&map, path)?;
    let thinned = map.trim(id, keyframes);
    let share = (thinned.least_redundancy * 100.0).round();
    let rest = if thinned.num_keyframes == 0 {
        String::new()
    } else if share > 0.0 {
        format!("; three others see at least {share:.0} % of what each of them saw")
    } else {
        "; no three others see what some of them saw, so that the camera will be found at fewer places"
            .to_owned()
    };
    say::line!(
        "{} keyframes went, and {} landmarks that nobody else saw twice{rest}",
        thinned.num_keyframes,
        thinned.num_landmarks
    );
    write(out, &map)
}

fn write(out: &Path, map: &VisualMap) -> Result<()> {
    save(out, map, &nobody())?;
    let (keyframes, landmarks) = (map.map.all_keyframes().count(), map.map.all_landmarks().count());
    let (keyframes, landmarks) = (say::count(keyframes, "keyframe"), say::count(landmarks, "landmark"));
    say::line!("map: {}, {keyframes}, {landmarks}", out.display());
    Ok(())
}
