//! Runs all settings of the switches on the same images.

use visloc_core::{RngTree, Source, SourceFrame};
use visloc_locate::{
    PipelineConfig,
    vision::{FeatureKind, Percept, field::FilterSwitches},
};
use visloc_sim::{LabelImage, Scenario, Simulation};

use super::{
    super::truth::{is_object, is_true},
    counts::{ByKind, FILTERS, Filter, Found, KINDS, Kept, SceneResult},
};
use crate::{ExperimentError, likelihood::Eye};

/// Images a second: neighbors resemble each other.
const FRAMES_PER_SEC: f64 = 3.0;
/// Seeds of each scene.
const NUM_SEEDS: u64 = 3;
/// An object with fewer pixels than this is not missed.
pub(super) const LEAST_VISIBLE_PX: usize = 100;
/// So many pixels are needed to report an object.
pub(super) const LEAST_REPORTED: usize = 2;

/// One setting of the switches, and what it keeps.
struct Setting {
    eye: Eye,
    kept: ByKind<Kept>,
}

/// Counts a scene.
pub(super) fn measure(name: &'static str, seed: u64) -> Result<SceneResult, ExperimentError> {
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
        while let Some(next) = simulation.next_item() {
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
            let mut config = PipelineConfig::with_color_table();
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
