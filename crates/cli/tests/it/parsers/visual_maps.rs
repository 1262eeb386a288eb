//! Maps of SLAM in files.

use std::sync::Arc;

use nalgebra::{Matrix2, Point2, Rotation3, Vector2, Vector3};
use visloc_core::{
    GrayImage, Timestamp,
    geom::{Camera, Rigid3},
};
use visloc_slam::{
    Readout,
    image::Pyramid,
    map::{LandmarkState, Map, NewKeyframe, Observation, SessionCamera},
    mapping::DepthFilter,
    recognize::View,
};
use visloc_vmap::{MapScale, ScaleSource, Session, VisualMap};

/// Two views of a checkered wall.
pub fn seeds() -> Vec<Vec<u8>> {
    let camera = Camera::pinhole((48, 36), (39.5, 39.5), (23.5, 17.5)).unwrap();
    let mut image = GrayImage::new(48, 36);
    for (i, value) in image.data_mut().iter_mut().enumerate() {
        *value = if (i % 48 / 6 + i / 48 / 6).is_multiple_of(2) { 200 } else { 40 };
    }
    let mut map = Map::new();
    let keyframe = |map: &mut Map, number: usize| {
        map.add_keyframe(NewKeyframe {
            frame: number,
            at: Timestamp::from_secs(number as f64),
            pyramid: Arc::new(Pyramid::new(image.clone(), 2)),
            camera_from_world: Rigid3::new(
                Rotation3::identity(),
                Vector3::new(-0.1 * number as f64, 0.0, 0.0),
            ),
            turned_from: None,
            odometry: None,
        })
    };
    let views = [keyframe(&mut map, 0), keyframe(&mut map, 1)];
    for i in 0..12 {
        let seen = |keyframe, shift: f64| {
            let px = Point2::new(18.0 + f64::from(i) - shift, 17.5);
            let (ray, covariance_px) = (camera.bearing(&px), Matrix2::identity() * 0.04);
            Observation { keyframe, px, ray, level: 0, covariance_px }
        };
        let filter = DepthFilter::new(1.0, 0.1);
        let landmark = map.add_landmark(seen(views[0], 0.0), filter, LandmarkState::Converged);
        map.add_observation(landmark, seen(views[1], 3.95));
    }
    for view in views {
        let described = View::of_keyframe(&map, view);
        map.describe(view, described);
    }
    let scales = vec![MapScale { source: ScaleSource::TwoPoints, relative_sigma: 0.01 }];
    let sessions = vec![Session { source: "wall".to_owned(), num_images: 2, ..Session::default() }];
    let map = VisualMap { map, scales, levels: vec![true], sessions };
    let readout = Readout(Vector2::new(0.0, 0.02));
    vec![
        map.to_bytes(&SessionCamera { readout, ..SessionCamera::as_calibrated(&camera) }),
        VisualMap::default().to_bytes(&SessionCamera::as_calibrated(&camera)),
    ]
}

pub fn read(bytes: &[u8]) {
    let Ok(opened) = VisualMap::from_bytes(bytes) else { return };
    let map = &opened.map.map;
    map.check().unwrap();
    let camera = Camera::default();
    for (_, keyframe) in map.all_keyframes() {
        let _ = keyframe.pyramid();
    }
    let again = opened.map.to_bytes(&SessionCamera::as_calibrated(&camera));
    // What was read can be written and read again.
    assert!(VisualMap::from_bytes(&again).is_ok());
}
