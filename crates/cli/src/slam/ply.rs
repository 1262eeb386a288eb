//! Landmarks and keyframes as a file that 3-D viewers open.

use std::path::Path;

use anyhow::{Context, Result};
use nalgebra::{Point2, Point3};
use visloc_core::{files, geom::Camera, median};
use visloc_slam::map::{Keyframe, Landmark, Map};

/// Color of the keyframes: no landmark is red, since landmarks are gray.
const KEYFRAME_COLOR: [u8; 3] = [220, 40, 40];
/// Depth of a keyframe's pyramid, share of the median distance between a keyframe and the landmarks that it sees.
const PYRAMID_SHARE: f64 = 0.06;

/// Writes converged landmarks as points, in the gray of the image that they were made from, with the number of keyframes that
/// see each; after them each keyframe as a pyramid: five points (the camera's center and the corners of its image) and
/// eight edges, in a color of their own.
pub fn write_ply(path: &Path, map: &Map, camera: &Camera, unit: &str) -> Result<()> {
    files::write(path, ply_text(map, camera, unit).as_bytes()).with_context(|| path.display().to_string())
}

fn ply_text(map: &Map, camera: &Camera, unit: &str) -> String {
    let landmarks: Vec<&Landmark> =
        map.landmarks().map(|(_, landmark)| landmark).filter(|landmark| landmark.is_converged()).collect();
    let keyframes: Vec<&Keyframe> = map.keyframes().map(|(_, keyframe)| keyframe).collect();
    let (num_landmarks, num_keyframes) = (landmarks.len(), keyframes.len());
    let mut text = format!(
        "ply\nformat ascii 1.0\ncomment unit of length: {unit}\n\
         comment {num_landmarks} landmarks, then 5 vertices for each of {num_keyframes} keyframes: center and corners\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int observations\n\
         element edge {}\nproperty int vertex1\nproperty int vertex2\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
        num_landmarks + 5 * num_keyframes,
        8 * num_keyframes
    );
    let mut vertex = |p: &Point3<f64>, [r, g, b]: [u8; 3], observations: usize| {
        text += &format!("{:.6} {:.6} {:.6} {r} {g} {b} {observations}\n", p.x, p.y, p.z);
    };
    for landmark in &landmarks {
        let gray = gray_of(map, landmark);
        vertex(&landmark.point_in_world, [gray; 3], landmark.observations.len());
    }
    let depth = PYRAMID_SHARE * usual_depth(map, &landmarks);
    for keyframe in &keyframes {
        let world_from_camera = keyframe.camera_from_world().inverse();
        vertex(keyframe.center_in_world(), KEYFRAME_COLOR, 0);
        let camera = keyframe.camera(camera);
        for corner in corners(camera) {
            let ray = camera.bearing(&corner);
            vertex(&world_from_camera.transform(&(ray * depth).into()), KEYFRAME_COLOR, 0);
        }
    }
    let [r, g, b] = KEYFRAME_COLOR;
    for i in 0..num_keyframes {
        let center = num_landmarks + 5 * i;
        for corner in 1..5 {
            let next = corner % 4 + 1;
            text += &format!("{center} {} {r} {g} {b}\n", center + corner);
            text += &format!("{} {} {r} {g} {b}\n", center + corner, center + next);
        }
    }
    text
}

fn corners(camera: &Camera) -> [Point2<f64>; 4] {
    let (width, height) = camera.size_px();
    let (right, bottom) = (f64::from(width) - 1.0, f64::from(height) - 1.0);
    [(0.0, 0.0), (right, 0.0), (right, bottom), (0.0, bottom)].map(|(x, y)| Point2::new(x, y))
}

/// Gray of the image at the place where a landmark was made; middle gray if that image is gone.
fn gray_of(map: &Map, landmark: &Landmark) -> u8 {
    let seen = landmark.observations.iter().find_map(|observation| {
        let pyramid = map.keyframe(observation.keyframe).pyramid()?;
        let image = pyramid.level(0);
        let [column, row] = [observation.px.x, observation.px.y].map(|value| value.round().max(0.0) as usize);
        let is_inside = column < image.width() && row < image.height();
        is_inside.then(|| image.data()[row * image.width() + column])
    });
    seen.unwrap_or(128)
}

/// Median distance of landmarks from the keyframes that they were made from; 1 without landmarks.
fn usual_depth(map: &Map, landmarks: &[&Landmark]) -> f64 {
    let depth = |landmark: &&Landmark| {
        let host = map.keyframe(landmark.observations.keyframes().next()?);
        Some((landmark.point_in_world - host.center_in_world()).norm())
    };
    median(landmarks.iter().filter_map(depth)).unwrap_or(1.0)
}
