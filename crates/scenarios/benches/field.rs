//! What one frame on a RoboCup field costs: image analysis, one candidate pose, one iteration of each localizer.
//!
//! `cargo bench -p visloc-scenarios`

#![allow(missing_docs, clippy::unwrap_used)] // the macros make public functions; a benchmark may stop

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use visloc_core::{Frame, RngTree, Source, geom::PlanarPose};
use visloc_locate::{
    ALGORITHMS, FeatureChoice, ObservationModel, Pipeline, PipelineConfig,
    observation::field::{DrawnFieldModel, FieldModelConfig, FieldObservationModel},
    vision::field::{FieldAnalysisConfig, FieldAnalyzer},
};
use visloc_sim::{Scenario, Simulation};
use visloc_world::Map;

/// Six seconds of the tour: goals come into view and leave it.
fn frames() -> (Map, Vec<Frame>) {
    let mut simulation = Simulation::new(&Scenario::load("tour").unwrap(), 1).unwrap().with_num_frames(180);
    let map = simulation.map().clone();
    let frames = std::iter::from_fn(|| simulation.next_item()).map(|frame| frame.unwrap().frame).collect();
    (map, frames)
}

fn analysis(c: &mut Criterion) {
    let (_, frames) = frames();
    for (name, is_on) in [("", false), (", with composite features", true)] {
        let mut config = FieldAnalysisConfig::default();
        config.composite.is_on = is_on;
        let mut analyzer = FieldAnalyzer::new(config).unwrap();
        let mut rng = RngTree::new(1).stream("analysis", 0);
        let mut next = frames.iter().cycle();
        c.bench_function(&format!("analysis of a 320 x 240 image{name}"), |b| {
            b.iter(|| analyzer.analyze(next.next().unwrap(), &mut rng).unwrap().quality);
        });
    }
}

fn candidate_pose(c: &mut Criterion) {
    let (map, frames) = frames();
    let Map::Field(field) = &map else { return };
    let mut analyzer = FieldAnalyzer::new(FieldAnalysisConfig::default()).unwrap();
    let mut rng = RngTree::new(1).stream("analysis", 0);
    let full = frames.iter().find_map(|frame| {
        let percept = analyzer.analyze(frame, &mut rng).unwrap();
        (percept.pixels.len() == 20).then(|| percept.clone())
    });
    let percept = full.unwrap();
    let mut fast = FieldObservationModel::new(field, &FieldModelConfig::default()).unwrap();
    fast.condition_on(&percept);
    let region = fast.region();
    let poses: Vec<PlanarPose> = (0..4096).map(|_| region.sample(&mut rng)).collect();
    let mut next = poses.iter().cycle();
    c.bench_function("candidate pose, 20 pixels, tables", |b| {
        b.iter(|| fast.likelihood(next.next().unwrap()));
    });
    let drawn = DrawnFieldModel::new(field, &FieldModelConfig::default()).unwrap();
    c.bench_function("candidate pose, 20 pixels, drawn reference", |b| {
        b.iter(|| drawn.likelihood(&percept, next.next().unwrap()));
    });
}

fn iterations(c: &mut Criterion) {
    let (map, frames) = frames();
    let pixels = ALGORITHMS.map(|algorithm| (algorithm.name, FeatureChoice::Pixels));
    let rich = [("evolutionary", FeatureChoice::Rich), ("mce", FeatureChoice::Rich)];
    for (algorithm, features) in pixels.into_iter().chain(rich) {
        let pipeline = || {
            let config = PipelineConfig { features, ..PipelineConfig::default() };
            Pipeline::builder(&map).named(algorithm, None).config(config).build().unwrap()
        };
        let name = format!("180 iterations of {algorithm} on {features:?}, with analysis");
        c.bench_function(&name, |b| {
            let run = |mut pipeline: Pipeline| {
                for frame in &frames {
                    pipeline.step(frame).unwrap();
                }
            };
            b.iter_batched(pipeline, run, BatchSize::LargeInput);
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(30);
    targets = analysis, candidate_pose, iterations
}
criterion_main!(benches);
