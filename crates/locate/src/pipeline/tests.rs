use serde_json::{Value, json};
use visloc_core::{
    Frame, RgbImage, Rng, Timestamp,
    geom::{Camera, Mount},
    settings::{Parameter, Settings, overlay, parameters},
};
use visloc_world::Map;

use super::*;
use crate::{Estimate, Individual, Localizer, ObservationModel, StepInput};

/// Another value than that of a parameter.
fn other(parameter: &Parameter) -> Value {
    let moved = |value: f64| match parameter.range {
        Some((least, most)) if value + 0.01 * (most - least) > most => value - 0.01 * (most - least),
        Some((least, most)) => value + 0.01 * (most - least),
        None => value * 1.01 + 0.001,
    };
    match &parameter.value {
        Value::Bool(is_on) => json!(!is_on),
        Value::Number(number) if number.is_u64() => json!(number.as_u64().unwrap() + 1),
        Value::Number(number) => json!(moved(number.as_f64().unwrap())),
        Value::String(name) => json!(parameter.choices.iter().find(|c| c.name != *name).unwrap().name),
        Value::Array(all) => {
            let first = all[0].as_f64().unwrap();
            json!([json!(first * 0.99)].iter().chain(&all[1..]).collect::<Vec<_>>())
        }
        _ => json!(7),
    }
}

/// Every key of some parameters that counts beside the others, set to something else, with the parameters that it leads to.
fn each_changed<T: Settings>(defaults: &T) -> Vec<(String, T)> {
    let all = parameters(defaults).unwrap();
    assert!(all.len() > 5);
    let change = |parameter: &Parameter| {
        let text = format!("{} = {}", parameter.path, other(parameter));
        match overlay(defaults, &text) {
            Err(error) if error.reason.contains("it would change nothing") => {
                assert!(parameter.only_if.is_some(), "{error}");
                None
            }
            changed => {
                Some((parameter.path.clone(), changed.unwrap_or_else(|error| panic!("{text}: {error}"))))
            }
        }
    };
    all.iter().filter_map(change).collect()
}

/// What the parts of a pipeline are given on a map.
fn effective(map: &Map, config: &PipelineConfig) -> String {
    let Map::Field(field) = map else { panic!() };
    let analysis = analysis_for(field, config);
    format!(
        "{analysis:?} {:?} {:?} {:?} {:?} {:?}",
        config.observation, config.lift, config.features, config.refinement, config.office
    )
}

/// No key is accepted and ignored: on every kind of field each one changes what the parts are given.
#[test]
fn every_key_of_the_pipeline_has_an_effect() {
    for name in ["robocup-spl-2010", "robocup-spl-2024"] {
        let map = Map::load(name).unwrap();
        let before = effective(&map, &PipelineConfig::default());
        for (path, config) in each_changed(&PipelineConfig::default()) {
            assert_ne!(effective(&map, &config), before, "{name}: {path} is ignored");
        }
    }
}

#[test]
fn what_the_map_says_is_refused_with_the_reason() {
    let refused = |text: &str| overlay(&PipelineConfig::default(), text).unwrap_err().reason;
    let keys = ["line_width_m", "goal_height_m", "composite.circle_radius_m", "composite.mark_size_m"];
    for key in keys.into_iter().chain(["composite.post_diameter_m", "composite.has_white_goals"]) {
        let reason = refused(&format!("analysis.{key} = 1.0"));
        assert!(reason.contains("cannot be set: the map says"), "{reason}");
    }
    assert_eq!(
        refused("[analysis]\nline_width_m = 0.1"),
        "`analysis.line_width_m` cannot be set: the map says how wide lines are"
    );
}

/// A number of line pixels that the user gives holds on every field, also 0.
#[test]
fn the_user_says_what_is_informative() {
    for name in ["robocup-spl-2010", "robocup-spl-2024"] {
        let Map::Field(field) = Map::load(name).unwrap() else { panic!() };
        for lines in [0, 4] {
            let text = format!("analysis.min_informative_lines = {lines}");
            let config = overlay(&PipelineConfig::default(), &text).unwrap();
            assert_eq!(analysis_for(&field, &config).min_informative_lines, Some(lines), "{name}");
        }
    }
}

/// Each parameter of each algorithm reaches it, or is refused by a limit that it has with another one.
#[test]
fn every_key_of_every_algorithm_changes_it() {
    let map = Map::load("robocup-spl-2010").unwrap();
    for algorithm in crate::ALGORITHMS {
        let all = algorithm_parameters(&map, algorithm.name, FeatureChoice::Rich, None).unwrap();
        for parameter in &all {
            let text = format!("{} = {}", parameter.path, other(parameter));
            match algorithm_parameters(&map, algorithm.name, FeatureChoice::Rich, Some(&text)) {
                Ok(changed) => assert_ne!(changed, all, "{}: {text}", algorithm.name),
                Err(error) => {
                    assert!(parameter.only_if.is_some(), "{}: {text}: {error}", algorithm.name);
                    assert!(error.to_string().contains("it would change nothing"), "{error}");
                }
            }
        }
    }
}

/// Knows what it is told at the start, and counts images.
struct Dreamer {
    model: Box<dyn ObservationModel>,
    estimate: Estimate,
    num_weighed: usize,
}

impl Localizer for Dreamer {
    fn reset(&mut self) {
        self.estimate = Estimate::unknown();
    }

    fn step(&mut self, input: &StepInput<'_>, _: &mut Rng) -> &Estimate {
        self.model.condition_on(input.percept);
        self.estimate.likelihood = self.model.likelihood(&self.estimate.world_from_robot);
        self.num_weighed += 1;
        &self.estimate
    }

    fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    fn individuals(&self, _: &mut Vec<Individual>) {}

    fn num_weighed(&self) -> usize {
        self.num_weighed
    }
}

#[test]
fn an_algorithm_of_ones_own_follows_the_robot() {
    let map = Map::load("robocup-spl-2010").unwrap();
    let config = PipelineConfig { features: FeatureChoice::Pixels, ..PipelineConfig::default() };
    let dreamer = |model| Dreamer { model, estimate: Estimate::unknown(), num_weighed: 0 };
    let mut pipeline = Pipeline::builder(&map).localizer(dreamer).config(config).build().unwrap();
    let camera = Camera::pinhole((64, 48), (70.0, 70.0), (31.5, 23.5)).unwrap();
    for i in 1..=3 {
        let at = Timestamp::from_secs(f64::from(i));
        let frame = Frame::new(at, RgbImage::new(64, 48), camera, Mount::default().robot_from_camera());
        let estimate = pipeline.step(&frame).unwrap();
        assert!((0.0..=1.0).contains(&estimate.likelihood));
        assert_eq!(pipeline.localizer().num_weighed(), i as usize);
    }
}
