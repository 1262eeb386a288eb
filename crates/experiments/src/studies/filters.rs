//! Which pixels do the filters drop, and rightly so? Precision and recall against the simulator's labels. Source of the
//! filters: 2010 section 4.2.

use serde_json::json;
use visloc_base::{FrameSource, RngTree, SourceFrame};
use visloc_locate::PipelineConfig;
use visloc_sim::{LabelImage, Scenario, Simulation};
use visloc_vision::{DropReason, FeatureKind, Percept, field::FilterSwitches};

use super::{
    StudyOutcome,
    truth::{is_object, is_true},
};
use crate::{ExperimentError, Table, likelihood::Eye};

/// Images a second: neighbors resemble each other.
const FRAMES_PER_SEC: f64 = 3.0;
/// Seeds of each scene.
const NUM_SEEDS: u64 = 3;
/// An object with fewer pixels than this is not missed.
const LEAST_VISIBLE_PX: usize = 100;
/// So many pixels are needed to report an object.
const LEAST_REPORTED: usize = 2;

/// A filter: its name, its switch, the reason that it gives, and the kinds of pixels that it judges.
struct Filter {
    name: &'static str,
    switch: fn(&mut FilterSwitches) -> &mut bool,
    reason: DropReason,
    for_lines: bool,
    for_goals: bool,
}

const fn filter(
    name: &'static str,
    switch: fn(&mut FilterSwitches) -> &mut bool,
    reason: DropReason,
    (for_lines, for_goals): (bool, bool),
) -> Filter {
    Filter { name, switch, reason, for_lines, for_goals }
}

const FILTERS: [Filter; 9] = [
    filter("beside carpet", |s| &mut s.beside_carpet, DropReason::NotBesideCarpet, (true, false)),
    filter("post or bar", |s| &mut s.post_or_bar, DropReason::NotPostOrBar, (false, true)),
    filter("isolated", |s| &mut s.isolated, DropReason::Isolated, (true, true)),
    filter("too thin", |s| &mut s.too_thin, DropReason::TooThin, (true, false)),
    filter("horizon", |s| &mut s.horizon, DropReason::BeyondHorizon, (true, false)),
    filter("own body", |s| &mut s.own_body, DropReason::OwnBody, (true, true)),
    filter("end of field", |s| &mut s.field_end, DropReason::BeyondFieldEnd, (true, false)),
    filter("goal blobs", |s| &mut s.goal_blobs, DropReason::NotInGoalBlob, (false, true)),
    filter("obstacles", |s| &mut s.obstacles, DropReason::InObstacle, (true, false)),
];

/// Kept pixels of one kind under one setting of the switches.
#[derive(Debug, Clone, Copy, Default)]
struct Kept {
    right: u64,
    wrong: u64,
}

impl Kept {
    fn count(&mut self, is_right: bool) {
        if is_right { self.right += 1 } else { self.wrong += 1 }
    }

    #[allow(clippy::cast_precision_loss)]
    fn precision(self) -> Option<f64> {
        let all = self.right + self.wrong;
        (all > 0).then(|| self.right as f64 / all as f64)
    }

    /// Share of the right pixels before the filters that are still there.
    #[allow(clippy::cast_precision_loss)]
    fn recall(self, before: Self) -> Option<f64> {
        (before.right > 0).then(|| self.right as f64 / before.right as f64)
    }
}

/// Lines, then goals.
type ByKind<T> = [T; 2];

/// One setting of the switches, and what it keeps.
struct Setting {
    eye: Eye,
    kept: ByKind<Kept>,
}

/// Whether an object is in the image and whether it is reported.
#[derive(Debug, Clone, Copy, Default)]
struct Found {
    visible: u64,
    found: u64,
    absent: u64,
    invented: u64,
}

struct SceneResult {
    name: &'static str,
    num_images: usize,
    none: ByKind<Kept>,
    alone: Vec<ByKind<Kept>>,
    without: Vec<ByKind<Kept>>,
    dropped: Vec<ByKind<Kept>>,
    chain: ByKind<Kept>,
    few: ByKind<Kept>,
    objects: [Found; 3],
}

const KINDS: [(FeatureKind, &str); 3] = [
    (FeatureKind::FieldLine, "lines"),
    (FeatureKind::YellowGoal, "yellow goal"),
    (FeatureKind::BlueGoal, "blue goal"),
];

pub(super) fn conduct(seed: u64) -> Result<StudyOutcome, ExperimentError> {
    let mut outcome = StudyOutcome::default();
    let mut scenes = Vec::new();
    let mut num_images = 0;
    for name in ["tour", "crowd"] {
        let scene = scene(name, seed)?;
        for kind in 0..2 {
            outcome.report.tables.push(filter_table(&scene, kind));
        }
        outcome.report.tables.push(object_table(&scene));
        num_images += scene.num_images;
        scenes.push(scene_json(&scene));
    }
    outcome.report.heading = format!("Filters of the image analysis, {num_images} images, seed {seed}");
    outcome.report.notes = vec![
        "A pixel is right if it lies within 2 px of the border between its object and what is behind it. Precision: share of the \
         kept pixels that are right. Recall: share of the right pixels before the filters that are kept."
            .to_owned(),
        "Drops, of these wrong: in the chain of all filters, where each judges what the ones before it have left.".to_owned(),
        format!(
            "Found: images with at least {LEAST_VISIBLE_PX} px of the object in which at least {LEAST_REPORTED} right pixels \
             are kept before the random discard. Invented: images without any px of it in which {LEAST_REPORTED} are kept."
        ),
    ];
    outcome.report.json = json!({ "study": "filters", "seed": seed, "scenes": scenes });
    Ok(outcome)
}

fn scene(name: &'static str, seed: u64) -> Result<SceneResult, ExperimentError> {
    let failed = |reason: String| ExperimentError::Setup { reason };
    let mut scenario = Scenario::load(name).map_err(|error| failed(error.to_string()))?;
    scenario.frames_per_sec = FRAMES_PER_SEC;
    let mut result = SceneResult {
        name,
        num_images: 0,
        none: Default::default(),
        alone: vec![Default::default(); FILTERS.len()],
        without: vec![Default::default(); FILTERS.len()],
        dropped: vec![Default::default(); FILTERS.len()],
        chain: Default::default(),
        few: Default::default(),
        objects: Default::default(),
    };
    for part in 0..NUM_SEEDS {
        let seeds = RngTree::new(seed).subtree("filters", part);
        let simulation = Simulation::new(&scenario, seeds.stream_seed("simulation", 0));
        let mut simulation = simulation.map_err(|error| failed(error.to_string()))?;
        let mut settings = Settings::new(&simulation, seeds)?;
        let mut index = 0;
        while let Some(next) = simulation.next_frame() {
            let next = next.map_err(|error| failed(error.to_string()))?;
            if let Some(labels) = simulation.labels(index) {
                settings.look(&next, &labels, &mut result)?;
            }
            index += 1;
        }
        result.num_images += index;
        settings.add_to(&mut result);
    }
    Ok(result)
}

/// All settings of the switches, side by side on the same images.
struct Settings {
    none: Setting,
    alone: Vec<Setting>,
    without: Vec<Setting>,
    chain: Setting,
    few: Setting,
}

impl Settings {
    fn new(simulation: &Simulation, seeds: RngTree) -> Result<Self, ExperimentError> {
        let setting = |change: &dyn Fn(&mut FilterSwitches)| {
            let mut config = PipelineConfig::default();
            change(&mut config.analysis.filters);
            let eye = Eye::new(simulation.map(), &config, seeds)?;
            Ok::<Setting, ExperimentError>(Setting { eye, kept: Default::default() })
        };
        let all = |is_on: bool| {
            move |switches: &mut FilterSwitches| {
                for filter in &FILTERS {
                    *(filter.switch)(switches) = is_on;
                }
                switches.random_discard = false;
            }
        };
        let except = |filter: &'static Filter, is_on: bool| {
            move |switches: &mut FilterSwitches| {
                all(!is_on)(switches);
                *(filter.switch)(switches) = is_on;
            }
        };
        Ok(Self {
            none: setting(&all(false))?,
            alone: FILTERS.iter().map(|filter| setting(&except(filter, true))).collect::<Result<_, _>>()?,
            without: FILTERS
                .iter()
                .map(|filter| setting(&except(filter, false)))
                .collect::<Result<_, _>>()?,
            chain: setting(&all(true))?,
            few: setting(&|_| ())?,
        })
    }

    fn look(
        &mut self,
        next: &SourceFrame,
        labels: &LabelImage,
        result: &mut SceneResult,
    ) -> Result<(), ExperimentError> {
        let singles = [&mut self.none, &mut self.chain, &mut self.few];
        for setting in singles.into_iter().chain(&mut self.alone).chain(&mut self.without) {
            let percept = setting.eye.look(&next.frame)?;
            for pixel in &percept.pixels {
                setting.kept[usize::from(pixel.kind.is_goal())].count(is_true(labels, pixel.kind, &pixel.px));
            }
        }
        let percept = self.chain.eye.percept();
        for pixel in &percept.dropped {
            let Some(filter) = FILTERS.iter().position(|filter| filter.reason == pixel.reason) else {
                continue;
            };
            let counts = &mut result.dropped[filter][usize::from(pixel.kind.is_goal())];
            counts.count(is_true(labels, pixel.kind, &pixel.px));
        }
        for ((kind, _), found) in KINDS.iter().zip(&mut result.objects) {
            count_object(*kind, percept, labels, found);
        }
        Ok(())
    }

    fn add_to(&self, result: &mut SceneResult) {
        let pairs =
            [(&self.none, &mut result.none), (&self.chain, &mut result.chain), (&self.few, &mut result.few)];
        let alone = self.alone.iter().zip(&mut result.alone);
        for (setting, sum) in
            pairs.into_iter().chain(alone).chain(self.without.iter().zip(&mut result.without))
        {
            for (sum, kept) in sum.iter_mut().zip(setting.kept) {
                sum.right += kept.right;
                sum.wrong += kept.wrong;
            }
        }
    }
}

fn count_object(kind: FeatureKind, percept: &Percept, labels: &LabelImage, found: &mut Found) {
    let visible_px = labels.labels().iter().filter(|label| is_object(kind, **label)).count();
    let reported = || percept.pixels.iter().filter(|pixel| pixel.kind == kind);
    if visible_px >= LEAST_VISIBLE_PX {
        let right = reported().filter(|pixel| is_true(labels, kind, &pixel.px)).count();
        found.visible += 1;
        found.found += u64::from(right >= LEAST_REPORTED);
    } else if visible_px == 0 {
        found.absent += 1;
        found.invented += u64::from(reported().count() >= LEAST_REPORTED);
    }
}

fn filter_table(scene: &SceneResult, kind: usize) -> Table {
    let objects = ["line", "goal"][kind];
    let title = format!("Filters for {objects} pixels, scene {:?}, {} images", scene.name, scene.num_images);
    let header = [
        "filter",
        "drops",
        "of these wrong",
        "alone: precision",
        "recall",
        "without it: precision",
        "recall",
    ];
    let mut table = Table::new(&format!("filters-{}-{objects}s", scene.name), &title, &header);
    let none = scene.none[kind];
    let whole = |name: &str, kept: Kept| {
        let all = kept.right + kept.wrong;
        [
            format!("{name}: {all} pixels"),
            String::new(),
            String::new(),
            percent(kept.precision()),
            percent(kept.recall(none)),
            String::new(),
            String::new(),
        ]
    };
    table.push(whole("no filter", none));
    for (i, filter) in FILTERS.iter().enumerate() {
        if !(if kind == 0 { filter.for_lines } else { filter.for_goals }) {
            continue;
        }
        let (dropped, alone, without) =
            (scene.dropped[i][kind], scene.alone[i][kind], scene.without[i][kind]);
        table.push([
            filter.name.to_owned(),
            (dropped.right + dropped.wrong).to_string(),
            percent(dropped.precision().map(|right| 1.0 - right)),
            percent(alone.precision()),
            percent(alone.recall(none)),
            percent(without.precision()),
            percent(without.recall(none)),
        ]);
    }
    table.push(whole("all filters", scene.chain[kind]));
    table.push(whole("and random discard", scene.few[kind]));
    table
}

fn object_table(scene: &SceneResult) -> Table {
    let title = format!("Objects, scene {:?}, {} images", scene.name, scene.num_images);
    let header = ["object", "images with it", "found", "images without it", "invented"];
    let mut table = Table::new(&format!("filters-{}-objects", scene.name), &title, &header);
    for ((_, name), found) in KINDS.iter().zip(&scene.objects) {
        table.push([
            (*name).to_owned(),
            found.visible.to_string(),
            percent(ratio(found.found, found.visible)),
            found.absent.to_string(),
            percent(ratio(found.invented, found.absent)),
        ]);
    }
    table
}

#[allow(clippy::cast_precision_loss)]
fn ratio(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| "-".to_owned(), |share| format!("{:.1} %", 100.0 * share))
}

fn scene_json(scene: &SceneResult) -> serde_json::Value {
    let kept = |kept: Kept, kind: usize| {
        json!({
            "pixels": kept.right + kept.wrong,
            "precision": kept.precision(),
            "recall": kept.recall(scene.none[kind]),
        })
    };
    let kind = |kind: usize| {
        let filters = FILTERS
            .iter()
            .enumerate()
            .filter(|(_, filter)| if kind == 0 { filter.for_lines } else { filter.for_goals });
        json!({
            "no_filter": kept(scene.none[kind], kind),
            "all_filters": kept(scene.chain[kind], kind),
            "with_random_discard": kept(scene.few[kind], kind),
            "filters": filters.map(|(i, filter)| json!({
                "filter": filter.name,
                "drops": scene.dropped[i][kind].right + scene.dropped[i][kind].wrong,
                "drops_wrong_share": scene.dropped[i][kind].precision().map(|right| 1.0 - right),
                "alone": kept(scene.alone[i][kind], kind),
                "without": kept(scene.without[i][kind], kind),
            })).collect::<Vec<_>>(),
        })
    };
    let object = |((_, name), found): (&(FeatureKind, &str), &Found)| {
        json!({
            "object": name,
            "images_with_it": found.visible,
            "found": ratio(found.found, found.visible),
            "images_without_it": found.absent,
            "invented": ratio(found.invented, found.absent),
        })
    };
    json!({
        "scene": scene.name,
        "images": scene.num_images,
        "lines": kind(0),
        "goals": kind(1),
        "objects": KINDS.iter().zip(&scene.objects).map(object).collect::<Vec<_>>(),
    })
}
