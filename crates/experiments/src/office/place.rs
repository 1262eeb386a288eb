//! Where a run takes place: a scenario of the simulator, or a recording with its map.

use std::path::Path;

use visloc_core::{Source, SourceFrame};
use visloc_io::bag::{BagReader, BagTopics};
use visloc_sim::{Scenario, Simulation};
use visloc_world::{Map, office::Office};

use crate::ExperimentError;

/// The map beside a recording.
const MAP_FILE: &str = "map.yaml";

fn refused(name: &str, reason: &dyn std::fmt::Display) -> ExperimentError {
    ExperimentError::Setup { reason: format!("{name}: {reason}") }
}

/// Whether a name is that of a recording.
fn is_recording(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mcap"))
}

/// The building.
pub(super) fn building(name: &str) -> Result<Office, ExperimentError> {
    let map = if is_recording(name) {
        let file = Path::new(name).with_file_name(MAP_FILE);
        for needed in [Path::new(name), &file] {
            if !needed.is_file() {
                return Err(refused(
                    name,
                    &format!("expected a recording with {MAP_FILE} beside it, found no {}", needed.display()),
                ));
            }
        }
        Map::load(&file.display().to_string()).map_err(|error| refused(name, &error))?
    } else {
        let scenario = Scenario::load(name).map_err(|error| refused(name, &error))?;
        Map::load(&scenario.map).map_err(|error| refused(name, &error))?
    };
    match map {
        Map::Office(office) => Ok(office),
        other => Err(refused(name, &format!("expected a building, found the map {}", other.name()))),
    }
}

/// All frames, at most `max_frames` of a scenario. The seed decides what is random in a scenario.
pub(super) fn frames(
    name: &str,
    seed: u64,
    max_frames: usize,
) -> Result<Box<dyn Source<SourceFrame>>, ExperimentError> {
    if is_recording(name) {
        let reader = BagReader::open(name, BagTopics::default());
        return Ok(Box::new(reader.map_err(|error| refused(name, &error))?));
    }
    let scenario = Scenario::load(name).map_err(|error| refused(name, &error))?;
    let simulation = Simulation::new(&scenario, seed).map_err(|error| refused(name, &error))?;
    Ok(Box::new(simulation.with_num_frames(max_frames)))
}

/// What a table calls it: a recording goes by its file's name.
pub(super) fn short_name(name: &str) -> String {
    let stem = Path::new(name).file_stem().filter(|_| is_recording(name));
    stem.map_or_else(|| name.to_owned(), |stem| stem.to_string_lossy().into_owned())
}
