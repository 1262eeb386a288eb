//! Opens what the user names.

use anyhow::{Context, Result, anyhow};
use visloc_base::FrameSource;
use visloc_data::bag::{BagReader, BagTopics};
use visloc_sim::{Scenario, Simulation};
use visloc_world::Map;

/// Which frames.
pub struct SourceSettings<'a> {
    /// Bag, or `sim:` and a scenario.
    pub name: &'a str,
    /// Map; may be absent for a simulation, which has one.
    pub map: Option<&'a str>,
    /// Topics of a bag.
    pub topics: BagTopics,
    /// Seed of a simulation.
    pub seed: u64,
    /// Threads of a simulation.
    pub num_threads: usize,
    /// Most frames of a simulation.
    pub max_frames: Option<u32>,
}

/// Frames and the map that they belong to.
pub struct OpenSource {
    /// The frames.
    pub frames: Box<dyn FrameSource>,
    /// The map.
    pub map: Map,
}

/// Opens a bag or starts a simulation, and loads the map.
///
/// # Errors
/// If the bag, the scenario or the map cannot be used.
pub fn open_source(settings: SourceSettings<'_>) -> Result<OpenSource> {
    let given_map = settings.map.map(Map::load).transpose()?;
    if let Some(scenario) = settings.name.strip_prefix("sim:") {
        let simulation = simulation(scenario, settings.seed, settings.num_threads, settings.max_frames)?;
        let map = given_map.unwrap_or_else(|| simulation.map().clone());
        return Ok(OpenSource { frames: Box::new(simulation), map });
    }
    let map = given_map
        .ok_or_else(|| anyhow!("a bag needs a map: --map robocup-spl-2010, or your own TOML file"))?;
    let bag = BagReader::open(settings.name, settings.topics)?;
    Ok(OpenSource { frames: Box::new(bag), map })
}

/// Starts the simulation of a scenario.
///
/// # Errors
/// If the scenario cannot be used.
pub fn simulation(
    scenario: &str,
    seed: u64,
    num_threads: usize,
    max_frames: Option<u32>,
) -> Result<Simulation> {
    let scenario = Scenario::load(scenario)?;
    let simulation = Simulation::new(&scenario, seed)?.with_threads(num_threads);
    let Some(max_frames) = max_frames else { return Ok(simulation) };
    let max_frames = usize::try_from(max_frames).context("too many frames")?;
    Ok(simulation.with_num_frames(max_frames))
}
