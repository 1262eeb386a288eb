//! How many borders of doors and of the floor do both detectors of straight edges find, and is it still so when the light
//! changes? Precision and recall against the simulator's labels. Source of the detectors: 2017 section 5.3.1.

mod borders;

use serde_json::json;
use visloc_core::{RngTree, Source};
use visloc_locate::vision::office::{OfficeAnalysisConfig, OfficeAnalyzer, OfficeColors, SegmentDetector};
use visloc_sim::{LightFade, Scenario, Simulation};
use visloc_world::Map;

use self::borders::{Borders, Counts, KINDS};
use super::StudyOutcome;
use crate::{ExperimentError, Table, percent};

/// Images a second: neighbors resemble each other.
const FRAMES_PER_SEC: f64 = 3.0;
/// Seeds of each scene.
const NUM_SEEDS: u64 = 3;
const DETECTORS: [(SegmentDetector, &str); 2] =
    [(SegmentDetector::Gradient, "gradient"), (SegmentDetector::Contour, "contour, as in the documents")];

/// Something that is done to the light.
type Change = fn(&mut Scenario);

/// Warm light of bulbs, and that of the blue sky.
const BULB: [f32; 3] = [1.25, 0.95, 0.55];
const SKY: [f32; 3] = [0.8, 0.98, 1.3];

const LIGHTS: [(&str, Change); 8] = [
    ("as it is", |_| {}),
    ("0.35 of the light", |scenario| scenario.camera.exposure_stops = 0.35_f64.log2()),
    ("0.6 of the light", |scenario| scenario.camera.exposure_stops = 0.6_f64.log2()),
    ("1.6 of the light", |scenario| scenario.camera.exposure_stops = 1.6_f64.log2()),
    ("bulbs", |scenario| scenario.light.color = BULB),
    ("blue sky", |scenario| scenario.light.color = SKY),
    ("lamps differ by 1 : 20", |scenario| {
        scenario.light.unevenness = 0.9;
        scenario.light.ambient = 0.15;
    }),
    ("sky to bulbs at a third, and back in 20 s", |scenario| {
        scenario.light.color = SKY;
        scenario.light.fade = Some(LightFade { share: 0.33, color: BULB, period_secs: 20.0 });
    }),
];

pub(super) fn conduct(seed: u64) -> Result<StudyOutcome, ExperimentError> {
    let mut outcome = StudyOutcome::default();
    let header = ["border", "detector", "lines", "of these right", "border px", "of these found"];
    let mut scenes = Vec::new();
    for name in ["office-walk", "office-large"] {
        let counts = measure(name, seed, |_| {}, &DETECTORS.map(|(detector, _)| with(detector)))?;
        let title = format!("Borders in scene {name:?}, {NUM_SEEDS} seeds");
        let mut table = Table::new(&format!("segments-{name}"), &title, &header);
        for (kind, (_, border)) in KINDS.iter().enumerate() {
            for ((_, detector), counts) in DETECTORS.iter().zip(&counts) {
                table.push(row(border, detector, &counts[kind]));
            }
        }
        for ((_, detector), counts) in DETECTORS.iter().zip(&counts) {
            table.push(row("all", detector, &sum(counts)));
        }
        outcome.report.tables.push(table);
        scenes.push(
            json!({ "scene": name, "detectors": DETECTORS.iter().zip(&counts).map(|((_, detector), counts)|
            json!({ "detector": detector, "kinds": kinds_json(counts) })).collect::<Vec<_>>() }),
        );
    }
    let header =
        ["light", "of the lines right", "of the border px found", "light taken for white: right", "found"];
    let mut table = Table::new("segments-light", "Light, gradient detector, scene \"office-walk\"", &header);
    let mut lights = Vec::new();
    for (name, change) in LIGHTS {
        let follows = with(SegmentDetector::Gradient);
        let white = OfficeAnalysisConfig { light_follow: 0.0, ..follows };
        let counts = measure("office-walk", seed, change, &[follows, white])?;
        let [follows, white] = [0, 1].map(|i| counts.get(i).map(sum).unwrap_or_default());
        table.push([
            name.to_owned(),
            percent(follows.precision()),
            percent(follows.recall()),
            percent(white.precision()),
            percent(white.recall()),
        ]);
        lights.push(json!({ "light": name, "precision": follows.precision(), "recall": follows.recall(),
            "white_precision": white.precision(), "white_recall": white.recall() }));
    }
    outcome.report.tables.push(table);
    outcome.report.heading = format!("Straight edges in a building, seed {seed}");
    outcome.report.notes = vec![
        "Right: 70 % of a line lie within 2 px of a border of its kind between the simulator's labels. Border px: pixels of \
         such borders from the horizon down, of the floor within 12 m; found if a line of its kind runs within 2 px."
            .to_owned(),
    ];
    outcome.report.json = json!({ "study": "segments", "seed": seed, "scenes": scenes, "lights": lights });
    Ok(outcome)
}

fn with(detector: SegmentDetector) -> OfficeAnalysisConfig {
    OfficeAnalysisConfig { detector, ..OfficeAnalysisConfig::default() }
}

/// Counts of each configuration on the same images.
fn measure(
    name: &str,
    seed: u64,
    change: Change,
    configs: &[OfficeAnalysisConfig],
) -> Result<Vec<[Counts; KINDS.len()]>, ExperimentError> {
    let failed = |error: &dyn std::fmt::Display| ExperimentError::Setup { reason: error.to_string() };
    let mut scenario = Scenario::load(name).map_err(|error| failed(&error))?;
    scenario.frames_per_sec = FRAMES_PER_SEC;
    change(&mut scenario);
    let mut counts = vec![[Counts::default(); KINDS.len()]; configs.len()];
    for part in 0..NUM_SEEDS {
        let seeds = RngTree::new(seed).subtree("segments", part);
        let simulation = Simulation::new(&scenario, seeds.stream_seed("simulation", 0));
        let mut simulation = simulation.map_err(|error| failed(&error))?;
        let Map::Office(office) = simulation.map() else {
            return Err(failed(&"the scenario has no building"));
        };
        let colors = OfficeColors {
            wall: office.plan().wall_color.rgb,
            floor: office.plan().floor_color.rgb,
            doors: office.door_colors().iter().map(|color| color.rgb).collect(),
        };
        let analyzers = configs.iter().map(|config| OfficeAnalyzer::new(*config, &colors));
        let mut analyzers: Vec<_> = analyzers.collect::<Result<_, _>>().map_err(|error| failed(&error))?;
        let mut rng = seeds.stream("analysis", 0);
        let mut index = 0;
        while let Some(next) = simulation.next_item() {
            let next = next.map_err(|error| failed(&error))?;
            let labels =
                simulation.labels(index).filter(|_| next.truth.is_some_and(|truth| truth.height_m == 0.0));
            index += 1;
            let Some(labels) = labels else { continue };
            let borders = Borders::new(&labels, &next.frame.camera, &next.frame.robot_from_camera);
            for (analyzer, counts) in analyzers.iter_mut().zip(&mut counts) {
                analyzer.analyze(&next.frame, &mut rng).map_err(|error| failed(&error))?;
                borders.score(analyzer.lines(), counts);
            }
        }
    }
    Ok(counts)
}

fn sum(counts: &[Counts; KINDS.len()]) -> Counts {
    let mut all = Counts::default();
    counts.iter().for_each(|counts| all.add(counts));
    all
}

fn row(border: &str, detector: &str, counts: &Counts) -> [String; 6] {
    [
        border.to_owned(),
        detector.to_owned(),
        counts.lines.to_string(),
        percent(counts.precision()),
        counts.border_px.to_string(),
        percent(counts.recall()),
    ]
}

fn kinds_json(counts: &[Counts; KINDS.len()]) -> serde_json::Value {
    let kind = |((_, name), counts): (&(_, &str), &Counts)| {
        json!({ "border": name, "lines": counts.lines, "precision": counts.precision(),
            "border_px": counts.border_px, "recall": counts.recall() })
    };
    KINDS.iter().zip(counts).map(kind).collect()
}
