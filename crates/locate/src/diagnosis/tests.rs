//! One run for each cause.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Point2, Rotation3, Vector2, Vector3};
use visloc_core::{
    Frame, GroundContact, RgbImage, Timestamp,
    geom::{Camera, PlanarPose, Rigid3, nao},
};
use visloc_world::Map;

use super::{Cause, Diagnosis, RunCounters};
use crate::{
    Estimate, Hypothesis, PipelineConfig,
    vision::{BorderPixel, FeatureKind, Percept},
};

const CARPET: [u8; 3] = [60, 118, 68];
const WALL: [u8; 3] = [200, 196, 180];

/// What a run sees and makes of it, all the time.
struct Run {
    map: &'static str,
    color: [u8; 3],
    focal_px: f64,
    height_m: f64,
    tilt_deg: f64,
    contact: Option<GroundContact>,
    has_odometry: bool,
    moves: bool,
    secs: f64,
    num_borders: usize,
    is_informative: bool,
    reliability: f64,
    up_to_symmetry: f64,
    likelihood: f64,
    probabilities: Vec<f64>,
}

impl Default for Run {
    /// A run with nothing to complain about except that nothing is confirmed.
    fn default() -> Self {
        Self {
            map: "robocup-spl-2010",
            color: CARPET,
            focal_px: 373.3,
            height_m: 0.5,
            tilt_deg: 13.0,
            contact: None,
            has_odometry: true,
            moves: true,
            secs: 12.0,
            num_borders: 40,
            is_informative: true,
            reliability: 0.3,
            up_to_symmetry: 0.3,
            likelihood: 0.9,
            probabilities: vec![1.0],
        }
    }
}

impl Run {
    fn frame(&self, secs: f64) -> Frame {
        let mut image = RgbImage::new(320, 240);
        for y in 0..240 {
            for x in 0..320 {
                image.set(x, y, self.color);
            }
        }
        let tilt = Rotation3::from_axis_angle(&Vector3::y_axis(), self.tilt_deg.to_radians());
        let x_m = if self.moves { 0.2 * secs } else { 0.0 };
        Frame {
            at: Timestamp::from_secs(secs),
            image,
            camera_index: 0,
            camera: Camera::pinhole((320, 240), (self.focal_px, self.focal_px), (159.5, 119.5)).unwrap(),
            robot_from_camera: Rigid3::new(
                tilt * nao::body_from_optical(),
                Vector3::new(0.0, 0.0, self.height_m),
            ),
            odometry: self.has_odometry.then(|| PlanarPose::new(x_m, 0.0, 0.0)),
            ground_contact: self.contact,
        }
    }

    fn percept(&self) -> Percept {
        let border = BorderPixel {
            ideal_px: Point2::new(9.0, 9.0),
            inward: Vector2::x(),
            kind: FeatureKind::FieldLine,
        };
        Percept {
            borders: vec![border; self.num_borders],
            is_informative: self.is_informative,
            ..Percept::default()
        }
    }

    fn estimate(&self) -> Estimate {
        let hypothesis = |(i, probability): (usize, &f64)| Hypothesis {
            world_from_robot: PlanarPose::new(0.7 * i as f64, 1.0, 0.1 * i as f64),
            covariance: Matrix3::identity(),
            probability: *probability,
        };
        Estimate {
            reliability: self.reliability,
            reliability_up_to_symmetry: self.up_to_symmetry,
            likelihood: self.likelihood,
            hypotheses: self.probabilities.iter().enumerate().map(hypothesis).collect(),
            ..Estimate::unknown()
        }
    }

    fn diagnosis(&self) -> Diagnosis {
        let map = match self.map {
            "no doors" => {
                let text = visloc_world::BUILT_IN_MAPS.iter().find(|(name, _)| *name == "office").unwrap().1;
                Map::parse("no doors", text.split("[[doors]]").next().unwrap()).unwrap()
            }
            name => Map::load(name).unwrap(),
        };
        let mut counters = RunCounters::new(&map, &PipelineConfig::default());
        for i in 0..(self.secs * 5.0) as usize {
            counters.count(&self.frame(0.2 * i as f64), &self.percept(), &self.estimate());
        }
        counters.diagnosis()
    }
}

/// A run with this cause.
fn example(cause: Cause) -> Run {
    let base = Run::default();
    let office = Run { map: "office", color: WALL, ..Run::default() };
    match cause {
        Cause::Unusable | Cause::Unconfirmed => base,
        Cause::Lifted => Run { contact: Some(GroundContact::Pressure([0.0; 8])), ..base },
        Cause::Black => Run { color: [3, 2, 4], ..base },
        Cause::White => Run { color: [255, 254, 255], ..base },
        Cause::Calibration => Run { focal_px: 4000.0, ..base },
        Cause::CameraOnGround => Run { height_m: 0.0, ..base },
        Cause::CameraUp => Run { tilt_deg: -60.0, ..base },
        Cause::CameraDown => Run { tilt_deg: 80.0, ..base },
        Cause::MapWithoutDoors => Run { map: "no doors", ..office },
        Cause::FieldImage => Run { color: CARPET, is_informative: false, ..office },
        Cause::Gray => Run { color: [90; 3], ..base },
        Cause::NoCarpet => Run { color: WALL, ..base },
        Cause::FewBorders => Run { num_borders: 2, is_informative: false, ..base },
        Cause::NoDoors => Run { is_informative: false, ..office },
        Cause::PointSymmetric => {
            Run { map: "robocup-spl-2024", up_to_symmetry: 0.9, reliability: 0.0, ..base }
        }
        Cause::LookAlikes => Run { probabilities: vec![0.4, 0.35, 0.25], ..office },
        Cause::Unexplained => Run { likelihood: 0.2, ..base },
        Cause::ShortRun => Run { secs: 3.0, ..base },
        Cause::SameView => Run { moves: false, ..base },
        Cause::NoOdometry => Run { has_odometry: false, ..base },
    }
}

#[test]
fn each_cause_is_told_and_no_other() {
    for cause in Cause::ALL {
        let diagnosis = match cause {
            Cause::Unusable => {
                let mut counters =
                    RunCounters::new(&Map::load("office").unwrap(), &PipelineConfig::default());
                (0..60).for_each(|i| counters.count_unusable(Timestamp::from_secs(0.2 * f64::from(i))));
                counters.diagnosis()
            }
            cause => example(cause).diagnosis(),
        };
        let found: Vec<Cause> = diagnosis.findings.iter().map(|finding| finding.cause).collect();
        let wanted = match cause {
            Cause::NoOdometry => vec![Cause::Unconfirmed, Cause::NoOdometry],
            cause => vec![cause],
        };
        assert_eq!(found, wanted);
        assert!(diagnosis.findings.iter().all(|finding| finding.share == 1.0), "{diagnosis:?}");
    }
}

#[test]
fn a_run_that_is_localized_needs_no_explanation() {
    let mut run = Run { reliability: 0.9, up_to_symmetry: 0.9, ..Run::default() };
    assert!(run.diagnosis().findings.is_empty());
    let map = Map::load("robocup-spl-2010").unwrap();
    let mut diagnosis_of = |is_localized: fn(u32) -> bool| {
        let mut counters = RunCounters::new(&map, &PipelineConfig::default());
        for i in 0..100 {
            run.reliability = if is_localized(i) { 0.9 } else { 0.1 };
            counters.count(&run.frame(0.2 * f64::from(i)), &run.percept(), &run.estimate());
        }
        counters.diagnosis()
    };
    assert!(!diagnosis_of(|i| i > 30 && i % 4 == 0).findings.is_empty(), "found at moments only");
    assert!(diagnosis_of(|i| i > 30 && i % 4 > 0).findings.is_empty());
    let diagnosis = diagnosis_of(|i| i > 75);
    assert!(
        diagnosis.findings.is_empty() && diagnosis.localized_share > 0.2,
        "late, and kept: {diagnosis:?}"
    );
    assert!((diagnosis.facts.tilt_deg - 13.0).abs() < 1e-6 && (diagnosis.facts.view_deg - 46.4).abs() < 0.1);
    assert!(RunCounters::new(&map, &PipelineConfig::default()).diagnosis().findings.is_empty());
}

#[test]
fn who_was_localized_at_the_start_alone_hears_of_the_rest() {
    let mut run = Run::default();
    let mut counters = RunCounters::new(&Map::load("robocup-spl-2010").unwrap(), &PipelineConfig::default());
    for i in 0..60 {
        run.reliability = if i < 25 { 1.0 } else { 0.4 };
        counters.count(&run.frame(0.2 * f64::from(i)), &run.percept(), &run.estimate());
    }
    let facts = counters.diagnosis().facts;
    assert_eq!((facts.judged_from_secs, facts.best_reliability), (5.0, (0.4, 5.0)));
}

#[test]
fn mirrored_places_are_no_look_alikes() {
    let map = Map::load("robocup-spl-2024").unwrap();
    let run = Run::default();
    let mut counters = RunCounters::new(&map, &PipelineConfig::default());
    let mut estimate = run.estimate();
    let other = Hypothesis {
        world_from_robot: PlanarPose::new(0.0, -1.0, PI),
        probability: 0.5,
        ..estimate.hypotheses[0]
    };
    estimate.hypotheses = vec![Hypothesis { probability: 0.5, ..estimate.hypotheses[0] }, other];
    for i in 0..60 {
        counters.count(&run.frame(0.2 * f64::from(i)), &run.percept(), &estimate);
    }
    assert_eq!(counters.diagnosis().findings[0].cause, Cause::PointSymmetric);
}

#[test]
fn codes_are_words_and_different() {
    let codes: std::collections::BTreeSet<&str> = Cause::ALL.iter().map(|cause| cause.code()).collect();
    assert_eq!(codes.len(), Cause::ALL.len());
    assert!(codes.iter().all(|code| code.chars().all(|c| c.is_ascii_lowercase() || c == '-')));
    assert!(Cause::ALL.iter().enumerate().all(|(i, cause)| *cause as usize == i), "the list is in order");
}
