//! How a map comes to be: points that converge, what bundle adjustment changes, the start with several corner thresholds.

use nalgebra::Point3;
use visloc_plot::{
    Color, Picture, ScatterPicture, ScatterSeries, SpacePath, SpaceViews, scatter, space_views,
};
use visloc_slam::{
    Slam, SlamConfig,
    map::{KeyframeId, Map},
    mapping::adjust_all,
    track::focal_px,
};

use super::sequence::open;
use crate::{ExperimentError, quantile, sorted};

/// Frames after a keyframe whose candidates are drawn. Source: 2017 figure 6.9.
const AFTER_FRAMES: [usize; 4] = [1, 5, 10, 15];
/// The keyframe that is watched, the first one after the start.
const WATCHED_KEYFRAME: usize = 2;
/// Images from which the map is made that is adjusted.
const ADJUSTED_FRAMES: usize = 200;
/// FAST thresholds of the start, gray levels. Source: 2017 figure 7.8, which does not say which ones.
const FAST_THRESHOLDS: [u8; 4] = [5, 10, 20, 40];
/// What is drawn of the depth, of the median depth.
const MAX_DEPTHS: f64 = 3.0;

/// All pictures of a sequence; only those for which it is long enough.
pub(super) fn all(
    sequence: &str,
    file: &str,
    max_frames: usize,
) -> Result<Vec<(String, Picture)>, ExperimentError> {
    let refused = |reason: String| ExperimentError::Setup { reason: format!("{sequence}: {reason}") };
    let mut pictures = Vec::new();
    convergence(sequence, max_frames, &mut |after, picture| {
        pictures.push((format!("{file}-convergence-{after:02}"), picture));
    })
    .map_err(refused)?;
    pictures.extend(adjustment(sequence, file, max_frames).map_err(refused)?);
    let start = start(sequence, max_frames).map_err(refused)?;
    pictures.extend(start.map(|picture| (format!("{file}-start"), picture)));
    Ok(pictures)
}

/// Runs until `watch` is content or the images end.
fn run(
    sequence: &str,
    max_frames: usize,
    config: &SlamConfig,
    watch: &mut dyn FnMut(&Slam) -> bool,
) -> Result<Slam, String> {
    let mut images = open(sequence, max_frames)?.images;
    let mut slam = Slam::new(images.camera(), config, 1).map_err(|error| error.to_string())?;
    while let Some(frame) = images.next_item() {
        let frame = frame.map_err(|error| error.to_string())?;
        // A refused image is left out.
        if slam.add_frame(frame.at, frame.image).is_ok() && watch(&slam) {
            break;
        }
    }
    Ok(slam)
}

/// The candidates of a keyframe some images later, seen from above.
fn convergence(
    sequence: &str,
    max_frames: usize,
    found: &mut dyn FnMut(usize, Picture),
) -> Result<(), String> {
    let (mut watched, mut num_after) = (None, 0);
    run(sequence, max_frames, &SlamConfig::default(), &mut |slam| {
        let newest = slam.map().keyframes().map(|(id, _)| id).find(|id| id.index() >= WATCHED_KEYFRAME);
        watched = watched.or(newest);
        let Some(keyframe) = watched else { return false };
        num_after += 1;
        if AFTER_FRAMES.contains(&num_after) {
            found(num_after, candidates(slam.map(), keyframe, num_after));
        }
        num_after >= AFTER_FRAMES[3]
    })
    .map(drop)
}

/// Seen from the keyframe: x to the right, depth upwards. A candidate is a line along its ray over two standard deviations.
fn candidates(map: &Map, keyframe: KeyframeId, num_after: usize) -> Picture {
    let of_keyframe = || {
        map.landmarks().filter(|(_, landmark)| landmark.is_alive() && landmark.host().keyframe == keyframe)
    };
    let camera_from_world = map.keyframe(keyframe).camera_from_world();
    let known: Vec<Point3<f64>> = of_keyframe()
        .filter(|(_, landmark)| landmark.is_converged())
        .map(|(_, landmark)| camera_from_world.transform(&landmark.point_in_world))
        .collect();
    let depths = map.landmarks().filter(|(_, landmark)| landmark.is_converged());
    let depths =
        sorted(depths.map(|(_, l)| camera_from_world.transform(&l.point_in_world).z).filter(|z| *z > 0.0));
    let farthest = MAX_DEPTHS * quantile(&depths, 0.5).unwrap_or(1.0);
    let mut lines = Vec::new();
    for (_, landmark) in of_keyframe() {
        let Some(filter) = &landmark.filter else { continue };
        let (far, near) = filter.interval();
        let ray = landmark.host().ray;
        let ends = [near, far].map(|inverse_depth| (1.0 / inverse_depth).min(farthest));
        lines.extend(ends.map(|depth| (ray.x * depth, depth)));
        lines.push((f64::NAN, f64::NAN));
    }
    let num_candidates = lines.len() / 3;
    scatter(&ScatterPicture {
        title: format!("Points of a keyframe after {num_after} images"),
        subtitle: format!("{num_candidates} uncertain, {} converged; seen from above", known.len()),
        axes: ["right [map units]", "depth [map units]"].map(str::to_owned),
        x_m: (-0.8 * farthest, 0.8 * farthest),
        y_m: (0.0, farthest),
        series: vec![
            ScatterSeries {
                label: "uncertain depth, two standard deviations".to_owned(),
                color: Color::VERMILION,
                is_line: true,
                points: lines,
                ..ScatterSeries::default()
            },
            ScatterSeries {
                label: "converged".to_owned(),
                color: Color::BLUE,
                points: known.iter().map(|point| (point.x, point.z)).collect(),
                ..ScatterSeries::default()
            },
        ],
    })
}

/// A map made without bundle adjustment, before and after one of all of it. Source: 2017 figure 6.10.
fn adjustment(sequence: &str, file: &str, max_frames: usize) -> Result<Vec<(String, Picture)>, String> {
    let config = SlamConfig::preset("config2").map_err(|error| error.to_string())?;
    let slam = run(sequence, max_frames.min(ADJUSTED_FRAMES), &config, &mut |_| false)?;
    if slam.map().keyframes().count() < 3 {
        return Ok(Vec::new());
    }
    let mut adjusted = slam.map().clone();
    let report = adjust_all(&mut adjusted, &config.mapping, focal_px(slam.camera()));
    let parts = |label: &str, color: Color, map: &Map| {
        let way = map.keyframes().map(|(_, keyframe)| *keyframe.center_in_world());
        let points = map.landmarks().filter(|(_, landmark)| landmark.is_converged());
        let cloud = points.map(|(_, landmark)| landmark.point_in_world);
        let place = |point: Point3<f64>| [point.x, point.y, point.z];
        [
            SpacePath::cloud(format!("points {label}"), color, cloud.map(place).collect()),
            SpacePath::line(format!("keyframes {label}"), color, way.map(place).collect()),
        ]
    };
    let before = parts("before", Color::VERMILION, slam.map());
    let views = space_views(&SpaceViews {
        title: "Map before and after bundle adjustment".to_owned(),
        subtitle: format!("{} keyframes, {} points", report.num_free, report.num_points),
        unit: "map units".to_owned(),
        shows_clouds: true,
        paths: before.into_iter().chain(parts("after", Color::BLUE, &adjusted)).collect(),
        ..SpaceViews::default()
    });
    let names = ["adjustment", "adjustment-side"].map(|name| format!("{file}-{name}"));
    Ok(names.into_iter().zip(views).collect())
}

/// The first map with several thresholds of the corner detector, from above, depths relative to their median.
fn start(sequence: &str, max_frames: usize) -> Result<Option<Picture>, String> {
    let mut series = Vec::new();
    for (i, threshold) in FAST_THRESHOLDS.into_iter().enumerate() {
        let mut config = SlamConfig::default();
        config.features.fast_threshold = threshold;
        config.features.low_fast_threshold = threshold;
        let slam = run(sequence, max_frames, &config, &mut |slam| slam.map().num_keyframe_ids() >= 2)?;
        let map = slam.map();
        let Some((_, first)) = map.keyframes().next() else { continue };
        let known = map.landmarks().filter(|(_, landmark)| landmark.is_converged());
        let points: Vec<Point3<f64>> = known
            .map(|(_, landmark)| first.camera_from_world().transform(&landmark.point_in_world))
            .collect();
        let Some(median) = quantile(&sorted(points.iter().map(|point| point.z)), 0.5) else { continue };
        series.push(ScatterSeries {
            label: format!("threshold {threshold}: {} points, {} images", points.len(), slam.frames().len()),
            color: Color::series(i),
            points: points.iter().map(|point| (point.x / median, point.z / median)).collect(),
            ..ScatterSeries::default()
        });
    }
    Ok((!series.is_empty()).then(|| {
        scatter(&ScatterPicture {
            title: "The first map with several FAST thresholds".to_owned(),
            subtitle: "Seen from above the first camera, which looks up from (0, 0)".to_owned(),
            axes: ["right [median depth]", "depth [median depth]"].map(str::to_owned),
            x_m: (-1.5, 1.5),
            y_m: (0.0, MAX_DEPTHS),
            series,
        })
    }))
}
