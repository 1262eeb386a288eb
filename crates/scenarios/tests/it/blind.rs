//! What nobody has seen for a minute is not relied upon: the covariance grows and the reliability falls, in every mode, until the
//! camera sees something again.

use std::f64::consts::TAU;

use visloc_base::{Frame, RgbImage, RngTree, SourceFrame};
use visloc_geom::PlanarPose;
use visloc_locate::{ALGORITHMS, FeatureChoice, LOCALIZED_RELIABILITY, Pipeline, PipelineConfig};
use visloc_world::Map;

use crate::pixels::tour;

/// Images of a wall: so many, each so long after the last one.
const NUM_IMAGES: u32 = 120;
const STEP_SECS: f64 = 0.5;
/// Time in which nothing may be published any more, seconds.
const STANDING_SECS: f64 = 20.0;
const WALKING_SECS: f64 = 16.0;
/// Radius and number of the circles that a walking robot walks in the minute.
const RADIUS_M: f64 = 0.8;
const CIRCLES: f64 = 3.0;

/// The robot's odometry, `start_from_robot`, after this share of the minute.
fn circle(share: f64) -> PlanarPose {
    let turn = CIRCLES * TAU * share;
    PlanarPose::new(RADIUS_M * turn.sin(), RADIUS_M * (1.0 - turn.cos()), turn)
}

/// A frame as the last one, with nothing in the image.
fn blind_frame(last: &Frame, image: u32, is_walking: bool) -> Frame {
    let (width, height) = (last.image.width(), last.image.height());
    let gray = vec![90; (width * height * 3) as usize];
    let share = f64::from(image) / f64::from(NUM_IMAGES);
    let moved = if is_walking { circle(share) } else { PlanarPose::default() };
    Frame {
        at: last.at + STEP_SECS * f64::from(image),
        image: RgbImage::from_raw(width, height, gray).unwrap(),
        odometry: last.odometry.map(|odometry| odometry.compose(&moved)),
        ..last.clone()
    }
}

/// What became of a robot that looked at a wall for a minute.
struct Outcome {
    name: String,
    /// When it was not localized any more, seconds; `None` if it never was.
    lost_secs: Option<f64>,
    /// Reliability at the end of the minute.
    reliability: f64,
    /// Whether it was localized, and right, at the end of the images after that.
    is_found: bool,
}

fn look_at_a_wall(
    algorithm: &str,
    features: FeatureChoice,
    is_walking: bool,
    frames: &[SourceFrame],
) -> Outcome {
    let name = format!("{algorithm} {features:?} {}", if is_walking { "walking" } else { "standing" });
    let map = Map::load("robocup-spl-2010").unwrap();
    let config = PipelineConfig { features, ..PipelineConfig::default() };
    let mut pipeline = Pipeline::new(&map, algorithm, None, &config, RngTree::new(1)).unwrap();
    let mut step = |frame: &Frame| {
        pipeline.analyze(frame).unwrap();
        pipeline.localize(frame).clone()
    };
    let (before, after) = frames.split_at(frames.len() / 2);
    let mut estimate = before.iter().map(|frame| step(&frame.frame)).last().unwrap();
    let was_localized = estimate.is_localized();
    let (mut lost_secs, mut traces) = (None, Vec::new());
    for image in 1..=NUM_IMAGES {
        let now = step(&blind_frame(&before[before.len() - 1].frame, image, is_walking));
        traces.push(now.covariance.trace());
        if was_localized {
            // Not each with the one before it: a grid has tiles.
            if let [.., before, _, _, _, _, _, _, _, last] = traces[..] {
                assert!(last > before, "{name} image {image}: {before} {last}");
            }
            assert!(now.reliability < estimate.reliability, "{name} image {image}");
            if !now.is_localized() {
                lost_secs = lost_secs.or(Some(STEP_SECS * f64::from(image)));
            }
        }
        estimate = now;
    }
    let reliability = estimate.reliability;
    let mut is_found = false;
    for frame in after {
        let later = frame.frame.at + STEP_SECS * f64::from(NUM_IMAGES);
        let estimate = step(&Frame { at: later, ..frame.frame.clone() });
        let error_m = estimate.world_from_robot.distance_m(&frame.truth.unwrap().world_from_robot);
        is_found = estimate.is_localized() && error_m < 0.5;
    }
    Outcome { name, lost_secs: was_localized.then_some(lost_secs).flatten(), reliability, is_found }
}

/// Eight seconds of a tour, a minute of a wall, eight seconds of the tour: standing, or in circles by odometry.
#[test]
fn a_minute_without_evidence_makes_every_algorithm_doubt() {
    let frames = tour(480, 1);
    let outcomes = |features| {
        let of =
            |algorithm: &str| [false, true].map(|walks| look_at_a_wall(algorithm, features, walks, &frames));
        ALGORITHMS.map(|algorithm| of(algorithm.name))
    };
    let outcomes = std::thread::scope(|scope| {
        let rich = scope.spawn(|| outcomes(FeatureChoice::Rich));
        let pixels = outcomes(FeatureChoice::Pixels);
        pixels.into_iter().chain(rich.join().unwrap()).collect::<Vec<_>>()
    });
    let (mut num_localized, mut num_found) = (0, 0);
    for [standing, walking] in &outcomes {
        for (outcome, limit_secs) in [(standing, STANDING_SECS), (walking, WALKING_SECS)] {
            let Some(secs) = outcome.lost_secs else { continue };
            assert!((1.0..=limit_secs).contains(&secs), "{}: {secs} s", outcome.name);
            assert!(outcome.reliability < 0.3 * LOCALIZED_RELIABILITY, "{}", outcome.name);
            num_localized += 1;
            num_found += usize::from(outcome.is_found);
        }
        assert!(walking.reliability <= standing.reliability, "{}", walking.name);
    }
    assert!(
        num_localized >= 32 && num_found + 2 >= num_localized,
        "{num_found} of {num_localized} are found again"
    );
}
