//! What nobody has seen for a minute is not relied upon: the covariance grows and the reliability falls, in every mode, until the
//! camera sees something again.

use std::f64::consts::TAU;

use visloc_core::{Frame, RgbImage, SourceFrame, geom::PlanarPose};
use visloc_locate::{
    ALGORITHMS, Estimate, FeatureChoice, LOCALIZED_RELIABILITY, Pipeline, PipelineConfig, ReliabilityConfig,
};
use visloc_world::Map;

use crate::pixels::tour;

/// Images of a wall: so many, each so long after the last one.
const NUM_IMAGES: u32 = 40;
const STEP_SECS: f64 = 1.5;
const MINUTE_SECS: f64 = 60.0;
/// Radius and number of the circles that a walking robot walks in the minute.
const RADIUS_M: f64 = 0.8;
const CIRCLES: f64 = 3.0;
/// Images of the tour before the first minute, and between the two.
const NUM_BEFORE: usize = 240;
const NUM_BETWEEN: usize = 120;

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
        camera_index: 0,
        odometry: last.odometry.map(|odometry| odometry.compose(&moved)),
        ..last.clone()
    }
}

fn position_variance(estimate: &Estimate) -> f64 {
    estimate.covariance[(0, 0)] + estimate.covariance[(1, 1)]
}

/// What is said of the place grows with every image, also for the heading alone. While the robot walks the position may seem to get better
/// now and then, when it comes back to where it went blind: an error of the heading is of no consequence there.
fn expect_more_doubt(name: &str, is_walking: bool, estimates: &[Estimate]) {
    for (image, pair) in estimates.windows(2).enumerate() {
        let (before, now) = (&pair[0], &pair[1]);
        let context = format!("{name}, image {image}: {before:?}, then {now:?}");
        assert!(now.reliability < before.reliability, "{context}");
        assert!(now.covariance[(2, 2)] > before.covariance[(2, 2)], "{context}");
        let least = if is_walking { position_variance(&estimates[0]) } else { position_variance(before) };
        assert!(position_variance(now) > least, "{context}");
    }
    let half = &estimates[estimates.len() / 2];
    let end = &estimates[estimates.len() - 1];
    assert!(position_variance(end) > position_variance(half), "{name}: {half:?}, then {end:?}");
}

/// An algorithm that looks at a wall for a minute, sees the tour again, and looks at a wall once more.
struct Watcher {
    pipeline: Pipeline,
    name: String,
}

impl Watcher {
    fn step(&mut self, frame: &Frame) -> Estimate {
        self.pipeline.step(frame).unwrap().clone()
    }

    /// A minute of a wall. `None` if the robot was not localized before, else the estimate at the end.
    fn look_at_a_wall(&mut self, before: Estimate, last: &Frame, is_walking: bool) -> Option<Estimate> {
        let name = format!("{} {}", self.name, if is_walking { "walking" } else { "standing" });
        let mut estimates = vec![before];
        for image in 1..=NUM_IMAGES {
            estimates.push(self.step(&blind_frame(last, image, is_walking)));
        }
        if !estimates[0].is_localized() {
            return None;
        }
        expect_more_doubt(&name, is_walking, &estimates);
        // A robot that was sure is not localized any more after half of the time in which the reliability fades.
        let limit_secs = 0.52 * ReliabilityConfig::default().blind_secs;
        let secs = STEP_SECS * estimates.iter().take_while(|estimate| estimate.is_localized()).count() as f64;
        assert!(secs <= limit_secs + STEP_SECS, "{name}: localized for {secs} s");
        estimates.pop()
    }

    /// Whether the robot was localized before a minute of circles, and whether it was found again after it.
    fn watch(&mut self, frames: &[SourceFrame]) -> Option<bool> {
        let (before, after) = frames.split_at(NUM_BEFORE);
        let estimate = before.iter().map(|frame| self.step(&frame.frame)).last().unwrap();
        let walked = self.look_at_a_wall(estimate, &before[NUM_BEFORE - 1].frame, true);
        let later = |frame: &SourceFrame| Frame { at: frame.frame.at + MINUTE_SECS, ..frame.frame.clone() };
        let estimate = after.iter().map(|frame| self.step(&later(frame))).last().unwrap();
        let last = &after[after.len() - 1];
        let error_m = estimate.world_from_robot.distance_m(&last.truth.unwrap().world_from_robot);
        let is_found = estimate.is_localized() && error_m < 0.5;
        let stood = self.look_at_a_wall(estimate, &later(last), false);
        if let (Some(walked), Some(stood)) = (&walked, &stood) {
            let lost = 0.3 * LOCALIZED_RELIABILITY;
            assert!(
                walked.reliability < lost && stood.reliability < lost,
                "{}: {walked:?} {stood:?}",
                self.name
            );
        }
        walked.map(|_| is_found)
    }
}

#[test]
fn a_minute_without_evidence_makes_every_algorithm_doubt() {
    let frames = tour(NUM_BEFORE + NUM_BETWEEN, 1);
    let map = Map::load("robocup-spl-2010").unwrap();
    let watch = |features| {
        ALGORITHMS.map(|algorithm| {
            let config = PipelineConfig { features, ..PipelineConfig::default() };
            let pipeline =
                Pipeline::builder(&map).named(algorithm.name, None).config(config).build().unwrap();
            Watcher { pipeline, name: format!("{} {features:?}", algorithm.name) }.watch(frames)
        })
    };
    let found = std::thread::scope(|scope| {
        let rich = scope.spawn(|| watch(FeatureChoice::Rich));
        let pixels = watch(FeatureChoice::Pixels);
        pixels.into_iter().chain(rich.join().unwrap()).collect::<Vec<_>>()
    });
    let num_localized = found.iter().flatten().count();
    let num_found = found.iter().flatten().filter(|is_found| **is_found).count();
    assert!(
        num_localized + 2 >= found.len() && num_found + 1 >= num_localized,
        "{num_localized} of {} were localized, {num_found} were found again",
        found.len()
    );
}
