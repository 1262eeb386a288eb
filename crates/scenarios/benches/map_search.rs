//! What an image costs in a map of SLAM: the search from nothing, where the image shows the map and where it does not.
//!
//! `cargo bench -p visloc-scenarios --bench map_search`

#![allow(missing_docs, clippy::unwrap_used)] // the macros make public functions; a benchmark may stop

use std::path::PathBuf;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use visloc_core::{GrayFrame, GrayImage, ImageSource, Source, Timestamp, geom::Camera};
use visloc_io::sequence::{SequenceRange, open_tum};
use visloc_slam::{Slam, SlamConfig, map::Map};
use visloc_vmap::{MapLocalizer, VisualMap};

/// The camera, all images of the rendered desk, and a map of every second one as it comes from a file.
fn desk() -> (Camera, Vec<GrayImage>, Map) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/desk-clip");
    let mut source = open_tum(&folder, SequenceRange::default()).unwrap();
    let camera = *source.camera();
    let mut config = SlamConfig::default();
    // The clip is short: keyframes have to be near to each other.
    config.mapping.max_shift_ratio = 0.02;
    let mut slam = Slam::new(&camera, &config, 1).unwrap();
    let mut images = Vec::new();
    while let Some(frame) = source.next_item().map(Result::unwrap) {
        if images.len() % 2 == 0 {
            slam.add_frame(frame.at, frame.image.clone()).unwrap();
        }
        images.push(frame.image);
    }
    let map = VisualMap { map: slam.map().clone(), ..VisualMap::default() };
    let map = VisualMap::from_bytes(&map.to_bytes(&slam.session_camera())).unwrap().map;
    (camera, images, map.map)
}

/// The same texture in other places: columns of 40 px in another order.
fn shuffled(image: &GrayImage) -> GrayImage {
    let mut shuffled = image.clone();
    let width = image.width();
    for (target, row) in shuffled.data_mut().chunks_exact_mut(width).zip(image.data().chunks_exact(width)) {
        for (i, column) in target.chunks_mut(40).enumerate() {
            let start = (40 * (7 * i + 3)) % (width - 40);
            let num = column.len();
            column.copy_from_slice(&row[start..start + num]);
        }
    }
    shuffled
}

fn search(c: &mut Criterion) {
    let (camera, images, map) = desk();
    let elsewhere: Vec<GrayImage> = images.iter().map(shuffled).collect();
    for (name, images) in [("there", &images), ("elsewhere", &elsewhere)] {
        let mut next = images.iter().cycle();
        c.bench_function(&format!("search from nothing, {name}"), |b| {
            b.iter_batched(
                || {
                    let config = SlamConfig::default();
                    let localizer = MapLocalizer::new(&map, None, &camera, &config, 1).unwrap();
                    (localizer, next.next().unwrap().clone())
                },
                |(mut localizer, image)| localizer.step(GrayFrame::new(Timestamp::default(), image)).unwrap(),
                BatchSize::LargeInput,
            );
        });
    }
}

criterion_group!(benches, search);
criterion_main!(benches);
