//! Tracking and mapping in sequence and on two threads: one code path, and nothing that can break it.

#![allow(clippy::unwrap_used)]

use std::{path::PathBuf, sync::Arc};

use visloc_core::{
    CameraPose, CameraTrajectory, ImageSource, Source,
    eval::camera::{Alignment, absolute_error, associate},
};
use visloc_io::{
    image_codec::{decode_gray, encode_gray_png},
    sequence::{SequenceRange, open_tum, read_camera_trajectory},
};
use visloc_slam::{
    Schedule, Slam, SlamConfig,
    map::{Keyframe, KeyframePicture, Map, Packing, PictureShelf},
    mapping::Mapper,
};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip")
}

/// When the mapper is waited for.
#[derive(Clone, Copy, PartialEq)]
enum Wait {
    EveryFrame,
    AtTheEnd,
    Never,
}

fn run(preset: &str, schedule: Schedule, wait: Wait) -> Slam {
    run_packing(preset, schedule, wait, None)
}

fn run_packing(preset: &str, schedule: Schedule, wait: Wait, packing: Option<Packing>) -> Slam {
    let mut source = open_tum(&folder(), SequenceRange::default()).unwrap();
    let config = SlamConfig::preset(preset).unwrap();
    let mut slam = Slam::with_schedule(source.camera(), &config, 1, schedule).unwrap();
    packing.into_iter().for_each(|packing| slam.set_packing(packing));
    let mut num_mapped = 0;
    while let Some(frame) = source.next_item() {
        let frame = frame.unwrap();
        num_mapped += slam.add_frame(frame.at, frame.image).unwrap().mapped.len();
        if wait == Wait::EveryFrame {
            num_mapped += slam.finish().len();
        }
    }
    if wait != Wait::Never {
        num_mapped += slam.finish().len();
        assert!(num_mapped > 0);
    }
    slam.map().check().unwrap();
    slam
}

fn trajectory(slam: &Slam) -> CameraTrajectory {
    let mut trajectory = CameraTrajectory::new();
    for pose in slam.trajectory() {
        trajectory.push(CameraPose { at: pose.at, world_from_camera: pose.world_from_camera }).unwrap();
    }
    trajectory
}

fn bits(slam: &Slam) -> Vec<u64> {
    let translation = |pose: &CameraPose| *pose.world_from_camera.translation();
    trajectory(slam)
        .poses()
        .iter()
        .flat_map(|pose| translation(pose).iter().map(|v| v.to_bits()).collect::<Vec<_>>())
        .collect()
}

#[test]
fn a_thread_that_is_waited_for_gives_the_bits_of_the_sequence() {
    for preset in ["sdvl", "config5"] {
        let in_sequence = bits(&run(preset, Schedule::Sequential, Wait::AtTheEnd));
        assert!(!in_sequence.is_empty());
        assert_eq!(in_sequence, bits(&run(preset, Schedule::Sequential, Wait::EveryFrame)));
        assert_eq!(in_sequence, bits(&run(preset, Schedule::Threaded, Wait::EveryFrame)));
    }
}

#[test]
fn images_that_are_packed_without_loss_change_no_bit() {
    let packing = || Packing {
        pack: |image| encode_gray_png(image).ok(),
        unpack: |bytes| decode_gray(bytes).ok(),
        num_at_hand: 2,
        shelf: Arc::new(PictureShelf::new(2)),
    };
    let completed = |schedule, packing| {
        let mut slam = run_packing("sdvl", schedule, Wait::EveryFrame, packing);
        slam.complete();
        let is_resting = |keyframe: &Keyframe| matches!(keyframe.picture, Some(KeyframePicture::Resting(_)));
        let num_resting = slam.map().all_keyframes().filter(|(_, keyframe)| is_resting(keyframe)).count();
        (bits(&slam), num_resting)
    };
    let (unpacked, num_resting) = completed(Schedule::Sequential, None);
    assert_eq!(num_resting, 0);
    for schedule in [Schedule::Sequential, Schedule::Threaded] {
        let (packed, num_resting) = completed(schedule, Some(packing()));
        assert!(num_resting > 0, "some are packed");
        assert_eq!(packed, unpacked);
    }
}

#[test]
fn keyframes_of_a_complete_map_are_linked_to_all_that_they_show() {
    let slam = run("sdvl", Schedule::Sequential, Wait::AtTheEnd);
    let error = |map: &Map| {
        let mut centers = CameraTrajectory::new();
        for (_, keyframe) in map.keyframes() {
            let world_from_camera = keyframe.camera_from_world().inverse();
            centers.push(CameraPose { at: keyframe.at, world_from_camera }).unwrap();
        }
        let truth = read_camera_trajectory(&folder().join("groundtruth.txt")).unwrap();
        let pairs = associate(&truth, &centers, 0.01);
        absolute_error(&pairs, Alignment::Similarity).unwrap().statistics.rmse
    };
    let num_linked = |map: &Map| map.landmarks().map(|(_, l)| l.observations.len()).sum::<usize>();
    let mut map = slam.map().clone();
    Mapper::new(slam.camera(), &SlamConfig::default()).complete(&mut map);
    map.check().unwrap();
    assert!(num_linked(&map) > num_linked(slam.map()), "{} of {}", num_linked(&map), num_linked(slam.map()));
    assert!(error(&map) < error(slam.map()) + 0.002, "{} m, before {} m", error(&map), error(slam.map()));
}

#[test]
fn a_run_is_completed_on_a_thread_as_in_sequence() {
    let completed = |schedule| {
        let mut slam = run("sdvl", schedule, Wait::EveryFrame);
        slam.complete();
        slam.map().check().unwrap();
        bits(&slam)
    };
    assert_eq!(completed(Schedule::Sequential), completed(Schedule::Threaded));
}

/// Frames come as fast as tracking takes them, much faster than a camera: the hardest case for the queues.
fn threaded_runs(num: usize) {
    let truth = read_camera_trajectory(&folder().join("groundtruth.txt")).unwrap();
    let mut num_good = 0;
    for i in 0..num {
        let slam = run("sdvl", Schedule::Threaded, if i % 4 == 3 { Wait::Never } else { Wait::AtTheEnd });
        let pairs = associate(&truth, &trajectory(&slam), 0.01);
        let error = absolute_error(&pairs, Alignment::Similarity);
        num_good += usize::from(pairs.len() >= 50 && error.is_some_and(|error| error.statistics.rmse < 0.02));
    }
    assert!(num_good * 3 >= num * 2, "{num_good} of {num} runs");
}

#[test]
fn a_few_threaded_runs_end_well() {
    threaded_runs(6);
}

#[test]
#[ignore = "a hundred runs take a minute"]
fn a_hundred_threaded_runs_end_well() {
    threaded_runs(100);
}
