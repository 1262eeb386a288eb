//! Maps of the rendered clip of a desk: written, read, damaged, and gone on in.

#![allow(clippy::unwrap_used)]

use std::{fs, path::PathBuf, sync::LazyLock};

use nalgebra::Vector2;
use visloc_core::{
    CameraPose, CameraTrajectory, GrayImage, ImageSource, RngTree, Source, Timestamp,
    eval::camera::{Alignment, absolute_error, associate},
    geom::{Camera, Distortion},
};
use visloc_io::sequence::{SequenceRange, open_tum, read_camera_trajectory};
use visloc_slam::{
    Exposure, Readout, Schedule, Slam, SlamConfig, TrackingState,
    lie::log,
    map::{Map, SessionCamera},
    recognize::View,
};
use visloc_vmap::{
    FORMAT_VERSION, MapScale, ScaleSource, Session, VisualMap, VmapError, load, load_fixed, save,
};

/// Images of the clip from which the map is made; the others are new to it.
const NUM_TAUGHT: usize = 45;

fn clip() -> (Camera, Vec<GrayImage>) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip");
    let mut source = open_tum(&folder, SequenceRange::default()).unwrap();
    let camera = *source.camera();
    let images = std::iter::from_fn(|| source.next_item().map(|frame| frame.unwrap().image)).collect();
    (camera, images)
}

fn time(number: usize) -> Timestamp {
    Timestamp::from_secs(number as f64 / 30.0)
}

fn config() -> SlamConfig {
    let mut config = SlamConfig::default();
    // The clip is short: keyframes have to be near to each other.
    config.mapping.max_shift_ratio = 0.02;
    config
}

/// What the first part of the clip teaches, as a file.
fn taught() -> &'static [u8] {
    static FILE: LazyLock<Vec<u8>> = LazyLock::new(|| {
        let (camera, images) = clip();
        let mut slam = Slam::new(&camera, &config(), 1).unwrap();
        for (number, image) in images.into_iter().enumerate().take(NUM_TAUGHT) {
            slam.add_frame(time(number), image).unwrap();
        }
        assert!(slam.map().keyframes().count() >= 5);
        let map = VisualMap {
            map: slam.map().clone(),
            scales: vec![MapScale { source: ScaleSource::TwoPoints, relative_sigma: 0.01 }],
            levels: Vec::new(),
            sessions: vec![Session { source: "desk-clip".to_owned(), num_images: 45, ..Session::default() }],
        };
        map.to_bytes(&slam.session_camera())
    });
    &FILE
}

fn opened(file: &[u8]) -> VisualMap {
    let opened = VisualMap::from_bytes(file).unwrap();
    assert_eq!(opened.damages, []);
    opened.map.map.check().unwrap();
    opened.map
}

fn camera_of(map: &Map) -> visloc_slam::map::SessionCamera {
    *map.all_keyframes().next().unwrap().1.foreign.as_deref().unwrap()
}

/// Follows images in a map; answers how many have a pose.
fn follow(slam: &mut Slam, images: &[GrayImage]) -> usize {
    let is_tracked = |(number, image): (usize, &GrayImage)| {
        slam.add_frame(time(number), image.clone()).unwrap().camera_from_world.is_some()
    };
    images.iter().enumerate().map(is_tracked).filter(|is_tracked| *is_tracked).count()
}

#[test]
fn a_map_that_was_read_is_written_as_the_same_file() {
    let map = opened(taught());
    assert!(map.to_bytes(&camera_of(&map.map)) == taught());
    assert_eq!((map.scales.len(), map.sessions.len()), (1, 1));
    let num_bytes = taught().len() / map.map.keyframes().count();
    assert!(num_bytes < 40_000, "{num_bytes} bytes a keyframe");
}

#[test]
fn the_camera_is_found_in_a_map_that_was_read_and_the_map_stays_as_it_is() {
    let (camera, images) = clip();
    let map = opened(taught());
    let file = || {
        let mut slam = Slam::in_fixed_map(map.map.clone(), &camera, &config(), 7).unwrap();
        let first = slam.add_frame(time(0), images[50].clone()).unwrap();
        assert_eq!(first.state, TrackingState::Tracking(visloc_slam::track::Quality::Good));
        assert!(first.is_relocalized);
        for (number, image) in (1..).zip(&images[51..]) {
            let outcome = slam.add_frame(time(number), image.clone()).unwrap();
            assert!(outcome.camera_from_world.is_some(), "image {}", 50 + number);
        }
        let map = VisualMap { map: slam.map().clone(), ..map.clone() };
        (map.to_bytes(&slam.session_camera()), format!("{:?}", slam.trajectory()))
    };
    let (bytes, way) = file();
    assert!(bytes == taught());
    assert_eq!(way, file().1, "the same bits again");
}

#[test]
fn a_camera_is_found_in_a_map_that_keeps_each_look_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.vmap");
    fs::write(&path, taught()).unwrap();
    let (all, fixed) = (load(&path).unwrap().map.map, load_fixed(&path).unwrap().map.map);
    let num_places = |map: &Map| {
        let views = map.all_keyframes().filter_map(|(_, keyframe)| keyframe.view.as_deref());
        views.map(View::len).sum::<usize>()
    };
    assert!(4 * num_places(&fixed) < 3 * num_places(&all), "{} of {}", num_places(&fixed), num_places(&all));
    assert_eq!(fixed.all_landmarks().count(), all.all_landmarks().count());
    let (camera, images) = clip();
    let mut slam = Slam::in_fixed_map(fixed, &camera, &config(), 7).unwrap();
    let first = slam.add_frame(time(0), images[50].clone()).unwrap();
    assert!(first.is_relocalized);
}

#[test]
fn mapping_goes_on_in_a_map_that_was_read() {
    let (camera, images) = clip();
    let map = opened(taught()).map;
    let num_before = map.keyframes().count();
    let mut ways = Vec::new();
    for schedule in [Schedule::Sequential, Schedule::Sequential, Schedule::Threaded] {
        let mut slam = Slam::resume(map.clone(), &camera, &config(), 7, schedule).unwrap();
        let num = follow(&mut slam, &images[40..]);
        slam.finish();
        assert!(num + 3 >= images.len() - 40, "{num} of {}", images.len() - 40);
        assert_eq!(slam.map().maps().len(), 1, "it goes on in the map that there was");
        if schedule == Schedule::Sequential {
            assert!(slam.map().keyframes().count() > num_before);
            ways.push(format!("{:?}", slam.trajectory()));
        }
        slam.map().check().unwrap();
    }
    assert_eq!(ways[0], ways[1], "the same bits again");
}

#[test]
fn a_map_that_was_read_outlives_a_camera_that_is_lost_at_once() {
    let (camera, images) = clip();
    let map = opened(taught()).map;
    let num_before = map.keyframes().count();
    let mut slam = Slam::resume(map, &camera, &config(), 7, Schedule::Sequential).unwrap();
    let dark = GrayImage::new(images[0].width(), images[0].height());
    let way: Vec<GrayImage> = images[30..33].iter().cloned().chain((0..60).map(|_| dark.clone())).collect();
    assert!(follow(&mut slam, &way) > 0);
    assert!(slam.map().all_keyframes().count() >= num_before);
}

#[test]
fn another_camera_finds_itself_in_the_map() {
    let (camera, images) = clip();
    let map = opened(taught()).map;
    // A wider lens with a distortion, in which the middle of the new image shows what the camera of the map would see.
    let (width, height) = camera.size_px();
    let (fx, fy) = camera.focal_px();
    let lens = Distortion::RadialTangential([-0.15, 0.02, 0.0, 0.0, 0.0]);
    let other = Camera::checked((width, height), (0.85 * fx, 0.85 * fy), camera.center_px(), lens).unwrap();
    let through_other = |image: &GrayImage| {
        let mut seen = GrayImage::new(image.width(), image.height());
        for y in 0..image.height() {
            for x in 0..image.width() {
                let ray = other.bearing(&nalgebra::Point2::new(x as f64, y as f64));
                let Ok(px) = camera.project(&ray.into()) else { continue };
                if camera.contains(&px) {
                    let (left, top) = (px.x.floor(), px.y.floor());
                    let at = |dx: usize, dy: usize| {
                        let (x, y) = (left as usize + dx, top as usize + dy);
                        f64::from(image.row(y.min(image.height() - 1))[x.min(image.width() - 1)])
                    };
                    let (u, v) = (px.x - left, px.y - top);
                    let mixed = (1.0 - v) * ((1.0 - u) * at(0, 0) + u * at(1, 0))
                        + v * ((1.0 - u) * at(0, 1) + u * at(1, 1));
                    seen.data_mut()[y * image.width() + x] = mixed.round() as u8;
                }
            }
        }
        seen
    };
    let mut fixed = Slam::in_fixed_map(map.clone(), &camera, &config(), 7).unwrap();
    let mut slam = Slam::in_fixed_map(map, &other, &config(), 7).unwrap();
    let mut num = 0;
    for (number, image) in images[20..40].iter().enumerate() {
        let own = fixed.add_frame(time(number), image.clone()).unwrap();
        let outcome = slam.add_frame(time(number), through_other(image)).unwrap();
        let (Some(own), Some(seen)) = (own.camera_from_world, outcome.camera_from_world) else { continue };
        num += 1;
        let apart = own * seen.inverse();
        assert!(apart.rotation_angle_rad() < 0.01, "image {number}: {} rad", apart.rotation_angle_rad());
        // Share of the distance to the desk, which is about 1.
        assert!(apart.translation().norm() < 0.02, "image {number}: {}", apart.translation().norm());
    }
    assert!(num >= 18, "{num} of 20");
}

#[test]
fn a_flipped_byte_is_told_by_section_and_survived_where_it_can_be() {
    let file = taught();
    let tree = RngTree::new(5);
    let (mut num_refused, mut num_survived) = (0, 0);
    for number in 0..600 {
        let mut damaged = file.to_vec();
        let at = (tree.stream_seed("place", number) % file.len() as u64) as usize;
        damaged[at] ^= 1 << (number % 8);
        match VisualMap::from_bytes(&damaged) {
            Ok(opened) => {
                opened.map.map.check().unwrap();
                assert!(opened.map.map.keyframes().count() >= 5, "byte {at}");
                // The copy of the head is looked at only if the head is damaged.
                assert!(!opened.damages.is_empty() || at + 12_000 > file.len(), "byte {at}");
                num_survived += 1;
            }
            Err(VmapError::Section { section, .. }) => {
                assert!(["cameras", "keyframes"].contains(&section.as_str()), "{section}, byte {at}");
                num_refused += 1;
            }
            Err(error) => panic!("byte {at}: {error}"),
        }
    }
    assert!(num_survived > 20 * num_refused, "{num_survived} survived, {num_refused} refused");
}

#[test]
fn a_camera_is_found_in_what_damage_has_left() {
    let (camera, images) = clip();
    let mut damaged = taught().to_vec();
    // Images are most of a file.
    for part in 1..40 {
        let at = damaged.len() * part / 40;
        damaged[at] ^= 0x10;
    }
    let head = taught().len() - 10_000;
    damaged[head..].copy_from_slice(&taught()[head..]);
    let Ok(opened) = VisualMap::from_bytes(&damaged) else { return };
    assert!(!opened.damages.is_empty());
    let mut slam = Slam::in_fixed_map(opened.map.map, &camera, &config(), 7).unwrap();
    let _ = follow(&mut slam, &images[..20]);
}

#[test]
fn cut_files_are_used_as_far_as_they_go_and_foreign_and_newer_ones_are_refused() {
    for length in [0, 7, 8, 20] {
        assert!(VisualMap::from_bytes(&taught()[..length]).is_err(), "{length} bytes");
    }
    for length in [taught().len() / 2, taught().len() - 1] {
        let opened = VisualMap::from_bytes(&taught()[..length]).unwrap();
        opened.map.map.check().unwrap();
        assert_eq!(opened.damages.is_empty(), length + 1 == taught().len(), "{length} bytes");
    }
    assert!(matches!(VisualMap::from_bytes(b"ply\nformat ascii 1.0\n"), Err(VmapError::Foreign)));
    let mut newer = taught().to_vec();
    newer[8] = FORMAT_VERSION as u8 + 1;
    // Whoever writes a newer version makes a check sum of it, too.
    let count = u32::from_le_bytes(newer[12..16].try_into().unwrap()) as usize;
    let end = 16 + 40 * count;
    let sum = crc32fast::hash(&newer[..end]);
    newer[end..end + 4].copy_from_slice(&sum.to_le_bytes());
    assert!(matches!(VisualMap::from_bytes(&newer), Err(VmapError::TooNew { .. })));
}

#[test]
fn a_file_gets_its_name_when_it_is_complete_and_the_one_before_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.vmap");
    let map = opened(taught());
    let camera = camera_of(&map.map);
    save(&path, &map, &camera).unwrap();
    let first = fs::read(&path).unwrap();
    let sessions = vec![Session::default()];
    save(&path, &VisualMap { sessions, ..load(&path).unwrap().map }, &camera).unwrap();
    assert!(fs::read(folder.path().join("room.vmap~")).unwrap() == first);
    assert!(load(&path).unwrap().map.sessions == [Session::default()]);
    let names = fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(names, 2, "nothing else is left behind");
    fs::write(&path, "ply").unwrap();
    let missing = folder.path().join("none.vmap");
    for path in [&path, &missing] {
        let error = load(path).unwrap_err();
        assert!(error.to_string().starts_with(&format!("{}: ", path.display())), "{error}");
    }
}

/// The clip as a camera would have taken it that exposes its rows one after the other, and where it was.
fn bent_clip(readout: Readout) -> (Vec<GrayImage>, CameraTrajectory) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip");
    let truth = read_camera_trajectory(&folder.join("groundtruth.txt")).unwrap();
    let (camera, images) = clip();
    let (mut bent, mut way) = (Vec::new(), CameraTrajectory::new());
    for (i, image) in images.iter().enumerate() {
        let pose = |i: usize| truth.poses()[i].world_from_camera;
        let (before, after) = (i.saturating_sub(1), (i + 1).min(images.len() - 1));
        let secs = time(after).secs_since(time(before));
        let mut motion = log(&(pose(after).inverse() * pose(before))) / secs;
        // The desk is about so many meters away.
        motion.fixed_rows_mut::<3>(0).unscale_mut(1.5);
        bent.push(Exposure { motion, readout: Readout(-readout.0) }.at_once(image, &camera));
        way.push(CameraPose { at: time(i), world_from_camera: pose(i) }).unwrap();
    }
    (bent, way)
}

#[test]
fn a_map_knows_how_long_its_camera_exposes_and_images_are_put_right_by_that() {
    let (camera, _) = clip();
    let readout = Readout(Vector2::new(0.0, 0.03));
    let error = |taken: Readout, known: Readout| {
        let (images, truth) = bent_clip(taken);
        let mut slam = Slam::in_fixed_map(map_by(known), &camera, &config(), 1).unwrap();
        assert_eq!(slam.readout(), known);
        for (number, image) in images.into_iter().enumerate() {
            slam.add_frame(time(number), image).unwrap();
        }
        let mut found = CameraTrajectory::new();
        for pose in slam.trajectory() {
            found.push(CameraPose { at: pose.at, world_from_camera: pose.world_from_camera }).unwrap();
        }
        let pairs = associate(&truth, &found, 0.01);
        assert!(pairs.len() > 50, "{}", pairs.len());
        absolute_error(&pairs, Alignment::Similarity).unwrap().statistics.rmse
    };
    let at_once = Readout::default();
    let errors = [(at_once, at_once), (readout, at_once), (readout, readout)].map(|(a, b)| error(a, b));
    let [least, without, with] = errors;
    assert!(with - least < 0.5 * (without - least), "{errors:?}");
}

/// The taught map of a camera that takes so long to expose an image.
fn map_by(readout: Readout) -> Map {
    let (camera, images) = clip();
    let mut slam = Slam::new(&camera, &config(), 1).unwrap();
    for (number, image) in images.into_iter().enumerate().take(NUM_TAUGHT) {
        slam.add_frame(time(number), image).unwrap();
    }
    let map = VisualMap { map: slam.map().clone(), ..VisualMap::default() };
    opened(&map.to_bytes(&SessionCamera { readout, ..slam.session_camera() })).map
}
