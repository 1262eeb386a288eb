//! Where a single photo was taken.

use visloc_core::{RgbImage, RngTree, SourceFrame};
use visloc_locate::{
    Photo, PhotoPose, PipelineConfig,
    diagnosis::{Cause, RunCounters},
    locate_photo,
};
use visloc_scenarios::collect;
use visloc_sim::{Scenario, Simulation};
use visloc_world::Map;

/// A frame as a photo, the pitch half a degree wrong and the height 2 %.
fn photo(frame: &SourceFrame) -> Photo {
    let frame = &frame.frame;
    let ahead = frame.robot_from_camera.rotate(&nalgebra::Vector3::z());
    Photo {
        image: frame.image.clone(),
        camera: frame.camera,
        pitch_down_rad: Some((-ahead.z).asin() + 0.5_f64.to_radians()),
        height_m: Some(1.02 * frame.robot_from_camera.translation().z),
    }
}

/// Every second of a tour over a field with white goals, twenty images: the right place is among those that explain the image, and a place
/// that has nearly all of the probability is the right one. Most images leave several places.
#[test]
fn single_images_tell_the_place() {
    let map = Map::load("robocup-spl-2024").unwrap();
    let simulation = Simulation::new(&Scenario::load("tour-2024").unwrap(), 4).unwrap();
    let frames = collect(&mut simulation.with_threads(2).with_num_frames(600).with_step(30)).unwrap();
    let (mut sure, mut surely_right, mut told) = (0, 0, 0);
    for frame in &frames {
        let answer = locate_photo(&map, &PipelineConfig::default(), &photo(frame), RngTree::new(1)).unwrap();
        let total = answer.elsewhere + answer.poses.iter().map(|pose| pose.probability).sum::<f64>();
        // Places of less than a fifth of a percent are left out.
        assert!((0.5..1.0 + 1e-9).contains(&total), "{total}");
        let truth = frame.truth.unwrap().world_from_robot.to_rigid3() * frame.frame.robot_from_camera;
        let (at, ahead) = (truth.translation(), truth.rotate(&nalgebra::Vector3::z()));
        let is_right = |pose: &&PhotoPose| {
            let found = &pose.world_from_camera;
            (found.translation() - at).norm() < 0.3
                && found.rotate(&nalgebra::Vector3::z()).dot(&ahead) > 0.98
        };
        told += usize::from(answer.poses.iter().any(|pose| is_right(&pose)));
        // Of two mirrored places each has half.
        if answer.poses.first().is_some_and(|pose| pose.probability > 0.45) {
            sure += 1;
            surely_right += usize::from(answer.poses.iter().take(2).any(|pose| is_right(&pose)));
        }
    }
    assert!(told >= 18 && surely_right == sure, "{told} told, {surely_right} of {sure} right");
}

/// An image that shows nothing was taken anywhere.
#[test]
fn a_blank_image_tells_nothing() {
    let map = Map::load("robocup-spl-2024").unwrap();
    let simulation = Simulation::new(&Scenario::load("tour-2024").unwrap(), 4).unwrap();
    let frames = collect(&mut simulation.with_num_frames(1)).unwrap();
    let blank = Photo { image: RgbImage::new(320, 240), ..photo(&frames[0]) };
    let answer = locate_photo(&map, &PipelineConfig::default(), &blank, RngTree::new(1)).unwrap();
    assert!(answer.poses.is_empty() && answer.elsewhere > 0.99, "{answer:?}");
    let counters = RunCounters::new(&map, &PipelineConfig::default());
    assert_eq!(counters.cause_in_photo(&blank.image), Some(Cause::Black));
    assert_eq!(counters.cause_in_photo(&frames[0].frame.image), None);
}
