//! Scenarios, parameters, and what stands on the command line.

use visloc_core::settings::overlay;
use visloc_io::{
    bag::BagTopics,
    read_ros_parameters,
    sequence::Bound,
    sources::{KINDS, SourceAddress},
};
use visloc_locate::{
    Algorithm, FeatureChoice, PipelineConfig, algorithm_parameters, robot_calibration::RobotCorrection,
};
use visloc_sim::{BUILT_IN_SCENARIOS, Scenario};
use visloc_slam::SlamConfig;
use visloc_world::Map;

use super::{choice, chosen};

pub fn scenario_seeds() -> Vec<Vec<u8>> {
    BUILT_IN_SCENARIOS.iter().map(|(_, text)| text.as_bytes().to_vec()).collect()
}

pub fn scenario(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let _ = Scenario::parse("input.toml", text).map(|scenario| scenario.num_frames());
}

type Read = fn(&str);

thread_local! {
    static FIELD: Map = Map::load("robocup-spl-2010").unwrap();
}

fn algorithm(name: &str, text: &str) {
    FIELD.with(|map| {
        let _ = algorithm_parameters(map, name, FeatureChoice::default(), Some(text));
    });
}

/// Tables of parameters that users write.
const TABLES: [Read; 7] = [
    |text| drop(overlay(&PipelineConfig::default(), text)),
    |text| drop(SlamConfig::from_toml(text)),
    |text| drop(overlay(&BagTopics::default(), text)),
    |text| {
        if let Ok(robot) = toml::from_str::<RobotCorrection>(text) {
            let _ = robot.check();
        }
    },
    |text| algorithm("evolutionary", text),
    |text| algorithm("mc", text),
    |text| algorithm("markov", text),
];

pub fn parameter_seeds() -> Vec<Vec<u8>> {
    let defaults_of = |name| Algorithm::named(name).unwrap().to_toml();
    vec![
        chosen(0, toml::to_string(&PipelineConfig::default()).unwrap()),
        chosen(1, toml::to_string(&SlamConfig::default()).unwrap()),
        chosen(2, toml::to_string(&BagTopics::default()).unwrap()),
        chosen(3, toml::to_string(&RobotCorrection::default()).unwrap()),
        chosen(4, defaults_of("evolutionary").unwrap()),
        chosen(5, defaults_of("mc").unwrap()),
        chosen(6, defaults_of("markov").unwrap()),
        chosen(5, "num_particles = 500\n[motion]\nnoise_m_per_m = 0.5\n"),
    ]
}

pub fn parameters(bytes: &[u8]) {
    let Some((form, rest)) = choice(bytes, TABLES.len()) else { return };
    if let Ok(text) = std::str::from_utf8(rest) {
        TABLES[form](text);
    }
}

pub fn ros_parameter_seeds() -> Vec<Vec<u8>> {
    let example = include_bytes!("../../../../../interop/ros2/visloc.params.yaml");
    vec![example.to_vec(), b"visloc: { ros__parameters: { seed: 1, config: { a.b: [1, 2] } } }".to_vec()]
}

pub fn ros_parameters(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let _ = read_ros_parameters(text, "visloc");
}

pub fn address_seeds() -> Vec<Vec<u8>> {
    let examples = KINDS.iter().map(|kind| kind.example.as_bytes().to_vec());
    examples.chain([b"120".to_vec(), b"4.5s".to_vec(), b"vidoe:clip.mp4".to_vec()]).collect()
}

pub fn address(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(address) = SourceAddress::parse(text) {
        let _ = (address.has_robot(), address.rest());
    }
    let _ = text.parse::<Bound>();
}
