//! Precision and recall of the composite features over recordings with truth, or simulated runs.
//!
//! `cargo run --release -p visloc-scenarios --example feature_detectors -- MAP RUN...` where a run is a bag or
//! `sim:SCENARIO:SEED:FRAMES`.

use visloc_core::{RngTree, Source, SourceFrame};
use visloc_io::bag::{BagReader, BagTopics};
use visloc_locate::{PipelineConfig, analysis_for, vision::field::FieldAnalyzer};
use visloc_scenarios::DetectionScores;
use visloc_sim::{Scenario, Simulation};
use visloc_world::{Map, field::Field};

/// Every so many frames one is counted: neighbors show the same.
const STEP: usize = 3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let Map::Field(field) = Map::load(&args.next().ok_or("expected a map")?)? else {
        return Err("expected a RoboCup field".into());
    };
    let mut total = DetectionScores::default();
    for run in args {
        score(&field, open(&run)?.as_mut(), &mut total)?;
    }
    println!(
        "{:<14} {:>9} {:>9} {:>9} {:>9} {:>12}",
        "", "precision", "recall", "found", "visible", "median"
    );
    for (name, s) in &total.0 {
        let error = s.median_error_m().map_or("-".to_owned(), |m| format!("{m:.3} m"));
        let (precision, recall) = (s.precision(), s.recall());
        println!(
            "{name:<14} {precision:>9.3} {recall:>9.3} {:>9} {:>9} {error:>12}",
            s.num_found, s.num_visible
        );
    }
    Ok(())
}

fn open(run: &str) -> Result<Box<dyn Source<SourceFrame>>, Box<dyn std::error::Error>> {
    let Some(scenario) = run.strip_prefix("sim:") else {
        return Ok(Box::new(BagReader::open(run, BagTopics::default())?));
    };
    let mut parts = scenario.split(':');
    let name = parts.next().unwrap_or("tour");
    let seed = parts.next().map_or(Ok(1), str::parse)?;
    let frames = parts.next().map_or(Ok(900), str::parse)?;
    Ok(Box::new(Simulation::new(&Scenario::load(name)?, seed)?.with_num_frames(frames)))
}

fn score(
    field: &Field,
    source: &mut dyn Source<SourceFrame>,
    total: &mut DetectionScores,
) -> Result<(), Box<dyn std::error::Error>> {
    let mut analyzer = FieldAnalyzer::new(analysis_for(field, &PipelineConfig::default()))?;
    let mut rng = RngTree::new(1).stream("analysis", 0);
    let mut index = 0;
    while let Some(frame) = source.next_item() {
        let frame = frame?;
        index += 1;
        let Some(truth) = frame.truth.filter(|truth| truth.height_m < 0.02 && index % STEP == 0) else {
            continue;
        };
        let percept = analyzer.analyze(&frame.frame, &mut rng)?;
        total.add(percept, field, &truth.world_from_robot);
    }
    Ok(())
}
