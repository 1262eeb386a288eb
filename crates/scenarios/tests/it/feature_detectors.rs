//! Precision and recall of the composite features on simulated tours. The bounds leave a margin to what
//! `cargo run --release -p visloc-scenarios --example feature_detectors -- MAP RUN...` finds on many more images.

use visloc_core::{RngTree, Source};
use visloc_locate::{PipelineConfig, analysis_for, vision::field::FieldAnalyzer};
use visloc_scenarios::DetectionScores;
use visloc_sim::{Scenario, Simulation};
use visloc_world::Map;

/// Every fifth frame of the first 20 seconds of three seeds.
fn scores(scenario: &str) -> DetectionScores {
    let mut total = DetectionScores::default();
    for seed in 1..=3 {
        let simulation = Simulation::new(&Scenario::load(scenario).unwrap(), seed).unwrap();
        let Map::Field(field) = simulation.map().clone() else { panic!("a field") };
        let mut analyzer = FieldAnalyzer::new(analysis_for(&field, &PipelineConfig::default())).unwrap();
        let mut rng = RngTree::new(seed).stream("analysis", 0);
        let mut simulation = simulation.with_threads(2).with_num_frames(600).with_step(5);
        while let Some(frame) = simulation.next_item() {
            let frame = frame.unwrap();
            let percept = analyzer.analyze(&frame.frame, &mut rng).unwrap();
            total.add(percept, &field, &frame.truth.unwrap().world_from_robot);
        }
    }
    for (name, s) in &total.0 {
        println!(
            "{scenario} {name}: {:.3} {:.3} ({} {})",
            s.precision(),
            s.recall(),
            s.num_found,
            s.num_visible
        );
    }
    total
}

/// Name, least precision, least recall. A detector with fewer than five detections is not judged.
fn expect(scenario: &str, bounds: &[(&str, f64, f64)]) {
    let scores = scores(scenario);
    for (name, precision, recall) in bounds {
        let score = &scores.0[name];
        assert!(score.num_found >= 5, "{scenario}, {name}: {} found", score.num_found);
        assert!(score.precision() >= *precision, "{scenario}, {name}: precision {}", score.precision());
        assert!(score.recall() >= *recall, "{scenario}, {name}: recall {}", score.recall());
    }
}

#[test]
fn detectors_are_right_on_a_tour() {
    let bounds = [
        ("line", 0.9, 0.7),
        ("junction L", 0.9, 0.3),
        ("junction T", 0.9, 0.3),
        ("penalty mark", 0.85, 0.8),
        ("post", 0.85, 0.5),
    ];
    expect("tour", &bounds);
}

#[test]
fn detectors_are_right_among_robots() {
    let bounds = [("line", 0.8, 0.6), ("junction L", 0.75, 0.15), ("junction T", 0.8, 0.3)];
    expect("crowd", &bounds);
}

#[test]
fn white_posts_are_found_in_front_of_white_walls() {
    let bounds =
        [("line", 0.85, 0.7), ("junction L", 0.9, 0.3), ("junction T", 0.9, 0.3), ("post", 0.9, 0.45)];
    expect("tour-2024", &bounds);
}

/// A detector that nobody has to build: teams can rely on what it says, and it finds more than half of what could be seen.
#[test]
fn robots_and_balls_are_detected_where_they_are() {
    let mut scores = DetectionScores::default();
    for seed in [31, 32, 33] {
        scores.add_game(&Scenario::load("tour-2024").unwrap(), seed, 40).unwrap();
    }
    for name in ["robot", "ball"] {
        let s = &scores.0[name];
        println!("{name}: {:.3} {:.3} ({} {})", s.precision(), s.recall(), s.num_found, s.num_visible);
        assert!(s.num_found >= 20 && s.precision() >= 0.9 && s.recall() >= 0.5, "{name}: {s:?}");
        assert!(s.median_error_m().unwrap() < 0.15, "{name}: {:?}", s.median_error_m());
    }
}
