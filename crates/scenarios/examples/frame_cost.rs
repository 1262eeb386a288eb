//! What a frame costs, image by image, on a machine that has other things to do: the same frames are followed several
//! times, which gives the same bits, and of each frame the shortest time counts.
//!
//! `cargo run --release -p visloc-scenarios --example frame_cost -- SCENARIO[:SEED[:FRAMES]]... RECORDING.mcap=MAP...`; the
//! algorithm is `evolutionary` with its defaults. Given as `MAP`: the name of a map or its file.

// The other examples and tests never look at a clock.
#![allow(clippy::disallowed_methods)]

use std::time::Instant;

use visloc_core::{Clock, SourceFrame};
use visloc_io::bag::{BagReader, BagTopics};
use visloc_locate::Pipeline;
use visloc_scenarios::collect;
use visloc_sim::{Scenario, Simulation};
use visloc_world::Map;

/// How often the frames are followed.
const TIMES: usize = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "{:<24} {:>7} {:>22} {:>30} {:>30}",
        "", "frames", "analysis: mean, 99 %", "localizer: mean, median, 99 %", "both: mean, 99 %, ratio"
    );
    for run in std::env::args().skip(1) {
        let (map, frames) = load(&run)?;
        let mut shortest = vec![[f64::INFINITY; 2]; frames.len()];
        for _ in 0..TIMES {
            follow(&map, &frames, &mut shortest)?;
        }
        let sorted = |part: &dyn Fn(&[f64; 2]) -> f64| {
            let mut values: Vec<f64> = shortest.iter().map(part).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let (analysis, localizer, both) = (sorted(&|t| t[0]), sorted(&|t| t[1]), sorted(&|t| t[0] + t[1]));
        println!(
            "{:<24} {:>7} {:>10.3} {:>8.3} ms {:>9.3} {:>8.3} {:>8.3} ms {:>8.3} {:>8.3} ms {:>8.2}",
            run.rsplit('/').next().unwrap_or(&run),
            frames.len(),
            mean(&analysis),
            quantile(&analysis, 0.99),
            mean(&localizer),
            quantile(&localizer, 0.5),
            quantile(&localizer, 0.99),
            mean(&both),
            quantile(&both, 0.99),
            quantile(&both, 0.99) / mean(&both),
        );
    }
    Ok(())
}

/// The map and all frames of a scenario or a recording.
fn load(run: &str) -> Result<(Map, Vec<SourceFrame>), Box<dyn std::error::Error>> {
    if let Some((recording, map)) = run.split_once('=') {
        let mut bag = BagReader::open(recording, BagTopics::default())?;
        return Ok((Map::load(map)?, collect(&mut bag)?));
    }
    let mut parts = run.split(':');
    let scenario = Scenario::load(parts.next().unwrap_or("office"))?;
    let seed = parts.next().map_or(Ok(1), str::parse)?;
    let num_frames = parts.next().map_or(Ok(1500), str::parse)?;
    let simulation = Simulation::new(&scenario, seed)?;
    let map = simulation.map().clone();
    let frames = collect(&mut simulation.with_num_frames(num_frames))?;
    Ok((map, frames))
}

/// Follows the frames once, and keeps the shortest time of analysis and localizer for each, milliseconds.
fn follow(
    map: &Map,
    frames: &[SourceFrame],
    shortest: &mut [[f64; 2]],
) -> Result<(), Box<dyn std::error::Error>> {
    let start = Instant::now();
    let clock = Clock::new(move || start.elapsed().as_secs_f64());
    let mut pipeline = Pipeline::builder(map).clock(clock).build()?;
    for (source, shortest) in frames.iter().zip(shortest) {
        pipeline.step(&source.frame)?;
        let times = pipeline.times();
        for (shortest, part) in shortest.iter_mut().zip([times.analysis_ms, times.localizer_ms]) {
            *shortest = shortest.min(part);
        }
    }
    Ok(())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// A quantile of sorted values; 0 of none.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let i = (share * sorted.len() as f64) as usize;
    sorted.get(i.min(sorted.len().saturating_sub(1))).copied().unwrap_or(0.0)
}
