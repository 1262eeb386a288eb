//! Odometry with gaps, jumps and numbers that are none.

use visloc_core::{Source as _, SourceFrame, geom::PlanarPose};
use visloc_io::bag::{BagReader, BagTopics, BagWriter};
use visloc_locate::FeatureChoice;
use visloc_scenarios::{Replay, run};
use visloc_world::Map;

use crate::pixels::tour;

/// Images at which the odometry is missing for a second.
const GAP: std::ops::Range<usize> = 250..280;
/// Image at which it begins again elsewhere, and one at which it is not a number.
const RESET: usize = 300;
const NAN: usize = 320;

fn disturbed(frames: &[SourceFrame]) -> Vec<SourceFrame> {
    let mut frames = frames.to_vec();
    let away = PlanarPose::new(4.0, -3.0, 2.0);
    for (i, frame) in frames.iter_mut().enumerate() {
        let odometry = &mut frame.frame.odometry;
        match i {
            NAN => *odometry = Some(PlanarPose { x_m: f64::NAN, ..PlanarPose::default() }),
            i if GAP.contains(&i) => *odometry = None,
            i if i >= RESET => *odometry = odometry.map(|pose| away.compose(&pose)),
            _ => {}
        }
    }
    frames
}

/// Largest distance from the truth from the gap on, meters.
fn largest_error_m(frames: &[SourceFrame], algorithm: &str, features: FeatureChoice) -> f64 {
    let map = Map::load("robocup-spl-2010").unwrap();
    let run = run(&mut Replay::new(frames), &map, algorithm, features, 1).unwrap();
    let truths = frames.iter().map(|frame| frame.truth.unwrap().world_from_robot);
    let errors = run
        .estimates
        .iter()
        .zip(truths)
        .map(|(estimate, truth)| estimate.world_from_robot.distance_m(&truth));
    errors.skip(GAP.start).fold(0.0, f64::max)
}

/// Twelve seconds of a tour with a gap, a reset and a NaN of the odometry: no kind of algorithm is thrown off.
#[test]
fn disturbed_odometry_throws_nobody_off() {
    let frames = tour(420, 2);
    let disturbed = disturbed(frames);
    for algorithm in ["evolutionary", "mce", "markov"] {
        for (features, more_m) in [(FeatureChoice::Rich, 0.05), (FeatureChoice::Pixels, 0.5)] {
            let plain_m = largest_error_m(frames, algorithm, features);
            let found_m = largest_error_m(&disturbed, algorithm, features);
            assert!(
                found_m < plain_m + more_m,
                "{algorithm} {features:?}: {plain_m} m, disturbed {found_m} m"
            );
        }
    }
}

/// Through a recording: in the gap the frames have no odometry, instead of one that says that the robot has stopped.
#[test]
fn a_gap_in_a_recording_is_a_gap() {
    const MISSING: std::ops::Range<usize> = 10..40;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gap.mcap");
    let mut writer = BagWriter::create(&path, BagTopics::default()).unwrap();
    let mut frames = tour(50, 2).to_vec();
    frames[MISSING].iter_mut().for_each(|frame| frame.frame.odometry = None);
    frames.iter().for_each(|frame| writer.write(frame).unwrap());
    writer.finish().unwrap();
    let mut reader = BagReader::open(&path, BagTopics::default()).unwrap();
    let read: Vec<SourceFrame> = std::iter::from_fn(|| reader.next_item()).collect::<Result<_, _>>().unwrap();
    assert_eq!(read.len(), frames.len());
    for (i, frame) in read.iter().enumerate() {
        // The first one is near enough to the last sample.
        let is_in_gap = (MISSING.start + 1..MISSING.end).contains(&i);
        assert_eq!(frame.frame.odometry.is_none(), is_in_gap, "image {i}");
    }
}
