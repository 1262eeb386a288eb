//! How often the true pose is among the poses that the features of a single image suggest.
//!
//! `cargo run --release -p visloc-scenarios --example suggested_poses -- MAP BAG...`: of each fifth image 400 poses, half of
//! them suggested by features, are weighed by the twenty pixels; counted is a pose within 0.3 m and 0.2 rad of the truth
//! among the eight most likely, on a symmetric field also the mirrored one.

use rand::RngExt;
use visloc_core::{Rng, RngTree, Source, geom::PlanarPose};
use visloc_io::bag::{BagReader, BagTopics};
use visloc_locate::{
    ObservationModel, PipelineConfig, analysis_for,
    observation::{
        features::FeatureModel,
        field::{FieldFeatureModel, FieldModelConfig, FieldObservationModel},
    },
    vision::{Percept, field::FieldAnalyzer},
};
use visloc_world::{Map, field::Field};

const NUM_POSES: usize = 400;
const NUM_BEST: usize = 8;
const STEP: usize = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let Map::Field(field) = Map::load(&args.next().ok_or("expected a map")?)? else {
        return Err("expected a RoboCup field".into());
    };
    for bag in args {
        let (lines, composite, all) = count(&field, &bag)?;
        let percent = |n: usize| 100.0 * n as f64 / all.max(1) as f64;
        println!("{bag}: {all} images, lines {:.1} %, composite {:.1} %", percent(lines), percent(composite));
    }
    Ok(())
}

/// Images with the truth among the best without composite features, with them, and all images.
fn count(field: &Field, bag: &str) -> Result<(usize, usize, usize), Box<dyn std::error::Error>> {
    let mut reader = BagReader::open(bag, BagTopics::default())?;
    let mut analyzer = FieldAnalyzer::new(analysis_for(field, &PipelineConfig::default()))?;
    let mut features = FieldFeatureModel::new(field);
    let mut pixels = FieldObservationModel::new(field, &FieldModelConfig::default())?;
    let mut rng = RngTree::new(1).stream("suggest", 0);
    let (mut lines, mut composite, mut all, mut index) = (0, 0, 0, 0);
    while let Some(frame) = reader.next_item() {
        let frame = frame?;
        index += 1;
        let Some(truth) = frame.truth.filter(|t| t.height_m < 0.02 && index % STEP == 0) else { continue };
        let mut percept = analyzer.analyze(&frame.frame, &mut rng)?.clone();
        pixels.condition_on(&percept);
        let pose = &truth.world_from_robot;
        composite += usize::from(is_among_best(&mut features, &pixels, &percept, pose, &mut rng));
        percept.features.clear();
        lines += usize::from(is_among_best(&mut features, &pixels, &percept, pose, &mut rng));
        all += 1;
    }
    Ok((lines, composite, all))
}

fn is_among_best(
    features: &mut FieldFeatureModel,
    pixels: &FieldObservationModel,
    percept: &Percept,
    truth: &PlanarPose,
    rng: &mut Rng,
) -> bool {
    features.condition_on(percept);
    if !pixels.has_evidence() {
        return false;
    }
    let mut poses: Vec<(PlanarPose, f64)> = Vec::new();
    for _ in 0..NUM_POSES {
        let suggested = if rng.random_bool(0.5) { features.suggest(rng) } else { None };
        let pose = suggested.unwrap_or_else(|| pixels.propose(rng));
        if pixels.region().contains(&pose) {
            poses.push((pose, pixels.likelihood(&pose)));
        }
    }
    poses.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut best: Vec<PlanarPose> = Vec::new();
    for (pose, _) in poses {
        // One of each place.
        if best.len() < NUM_BEST && best.iter().all(|other| !is_near(other, &pose, 0.15, 0.1)) {
            best.push(pose);
        }
    }
    best.iter().any(|pose| {
        let mirrored = features.mirrored(pose);
        is_near(pose, truth, 0.3, 0.2) || mirrored.is_some_and(|pose| is_near(&pose, truth, 0.3, 0.2))
    })
}

fn is_near(a: &PlanarPose, b: &PlanarPose, distance_m: f64, turn_rad: f64) -> bool {
    a.distance_m(b) < distance_m && a.heading_difference_rad(b) < turn_rad
}
