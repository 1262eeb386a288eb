//! What one frame in a building costs: image analysis with both detectors, one candidate pose, one iteration with 10 races
//! of 30, in an ordinary corridor and in a building about ten times as large.
//!
//! `cargo bench -p visloc-scenarios --bench office`

#![allow(missing_docs, clippy::unwrap_used)] // the macros make public functions; a benchmark may stop

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use visloc_core::{Frame, RngTree, Source};
use visloc_locate::{
    ObservationModel, Pipeline,
    observation::office::{OfficeModelConfig, OfficeObservationModel},
    vision::office::{OfficeAnalysisConfig, OfficeAnalyzer, OfficeColors, SegmentDetector},
};
use visloc_sim::{Scenario, Simulation};
use visloc_world::Map;

fn frames(scenario: &str) -> (Map, Vec<Frame>) {
    let mut simulation = Simulation::new(&Scenario::load(scenario).unwrap(), 1).unwrap().with_num_frames(300);
    let map = simulation.map().clone();
    let frames = std::iter::from_fn(|| simulation.next_item()).map(|frame| frame.unwrap().frame).collect();
    (map, frames)
}

fn colors(map: &Map) -> OfficeColors {
    let Map::Office(office) = map else { panic!("a building") };
    OfficeColors {
        wall: office.plan().wall_color.rgb,
        floor: office.plan().floor_color.rgb,
        doors: office.door_colors().iter().map(|color| color.rgb).collect(),
    }
}

fn analysis(c: &mut Criterion) {
    let (map, frames) = frames("office");
    for detector in [SegmentDetector::Gradient, SegmentDetector::Contour] {
        let config = OfficeAnalysisConfig { detector, ..OfficeAnalysisConfig::default() };
        let mut analyzer = OfficeAnalyzer::new(config, &colors(&map)).unwrap();
        let mut rng = RngTree::new(1).stream("analysis", 0);
        let mut next = frames.iter().cycle();
        c.bench_function(&format!("analysis of a 320 x 240 image, {detector:?}"), |b| {
            b.iter(|| analyzer.analyze(next.next().unwrap(), &mut rng).unwrap().quality);
        });
    }
}

fn candidate_pose(c: &mut Criterion) {
    for scenario in ["office", "office-large"] {
        let (map, frames) = frames(scenario);
        let Map::Office(office) = &map else { return };
        let mut analyzer = OfficeAnalyzer::new(OfficeAnalysisConfig::default(), &colors(&map)).unwrap();
        let mut rng = RngTree::new(1).stream("analysis", 0);
        let mut model = OfficeObservationModel::new(office, &OfficeModelConfig::default()).unwrap();
        model.condition_on(analyzer.analyze(&frames[0], &mut rng).unwrap());
        let poses: Vec<_> = (0..4096).map(|_| model.propose(&mut rng)).collect();
        let mut next = poses.iter().cycle();
        c.bench_function(&format!("candidate pose, {scenario}"), |b| {
            b.iter(|| model.likelihood(next.next().unwrap()));
        });
    }
}

const TEN_RACES: &str = "max_races = 10\nnum_exploiters = 30\nmax_exploiters = 300\n";

/// Whole runs; what the analysis alone takes is measured above.
fn iterations(c: &mut Criterion) {
    let mut group = c.benchmark_group("300 frames, 10 races of 30");
    for scenario in ["office", "office-large"] {
        let (map, frames) = frames(scenario);
        group.bench_function(scenario, |b| {
            let pipeline = || Pipeline::builder(&map).named("evolutionary", Some(TEN_RACES)).build().unwrap();
            let run =
                |mut pipeline: Pipeline| frames.iter().filter(|frame| pipeline.step(frame).is_ok()).count();
            b.iter_batched(pipeline, run, BatchSize::LargeInput);
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = analysis, candidate_pose, iterations
}
criterion_main!(benches);
