//! `visloc locate` in a map that SLAM has made.

use std::path::Path;

use anyhow::{Context, Result, bail};
use nalgebra::Point2;
use serde::Serialize;
use visloc_core::{GrayFrame, GrayImage, RgbImage, Timestamp, geom::Camera};
use visloc_io::image_codec::resize_gray;
use visloc_locate::PhotoPose;
use visloc_plot::{Color, ImageDots, ImagePicture, image_picture, is_of_series, remove_earlier};
use visloc_slam::SlamConfig;
use visloc_vmap::{Hypothesis, MapLocalizer, VisualMap};

use super::{diagnosis::MapCounters, report::unit};
use crate::{
    args::LocateArgs,
    report::{FindingReport, GroundPose, pose_in_words, save_json},
    run::Saving,
    say,
    slam::{MapFrame, load_fixed_map},
};

/// What `--json` writes.
#[derive(Serialize)]
struct LocateInMapReport {
    photo: String,
    map: String,
    seed: u64,
    /// What a unit of length is.
    unit: &'static str,
    /// The most probable one first.
    poses: Vec<PoseInMap>,
    /// How probable it is that the photo was taken at none of them.
    elsewhere: f64,
    /// Why it was not found; empty if it was.
    diagnosis: Vec<FindingReport>,
}

/// Pose of the camera in the frame of the map.
#[derive(Serialize)]
struct PoseInMap {
    probability: f64,
    x: f64,
    y: f64,
    z: f64,
    qx: f64,
    qy: f64,
    qz: f64,
    qw: f64,
    /// Which of the file's maps.
    map: usize,
    /// The same over the ground, of a map in meters with z up.
    #[serde(flatten)]
    ground: Option<GroundPose>,
}

/// The picture of a photo that was not recognized.
const UNKNOWN_PLACE: &str = "not-recognized";

/// A photo whose pixels are finer than those of the map by more than this is reduced.
const MOST_FINER: f64 = 1.2;

/// Says where in a map of SLAM a photo was taken by a camera.
pub fn locate(args: &LocateArgs, image: RgbImage, calibrated: Camera) -> Result<()> {
    refuse_others(args)?;
    let map = load_fixed_map(Path::new(&*args.map))?;
    let config = SlamConfig::default();
    // What a photo shows finer than the map has no counterpart there.
    let finer = finest_focal_px(&map).map_or(1.0, |focal_px| calibrated.focal_px().0 / focal_px);
    let camera = if finer > MOST_FINER { calibrated.scaled(1.0 / finer) } else { calibrated };
    let mut localizer = MapLocalizer::in_map(&map, &camera, &config, args.seed.value())?;
    let gray = resize_gray(GrayImage::from_rgb(&image), camera.size_px());
    let gray = GrayFrame::new(Timestamp::from_nanos(0), gray);
    localizer.step(gray.clone()).with_context(|| args.photo.display().to_string())?;
    let places = localizer.hypotheses();
    let mut counters = MapCounters::new(&map);
    counters.count(&MapFrame { gray, camera, robot: None }, &localizer, &config);
    let diagnosis = counters.explain();
    let elsewhere = (1.0 - places.iter().map(|place| place.probability).sum::<f64>()).max(0.0);
    print(&map, &places, elsewhere, &diagnosis);
    let mut saving = Saving::default();
    saving.save_if(args.json.json.as_deref(), |path| {
        let report = LocateInMapReport {
            photo: args.photo.display().to_string(),
            map: args.map.to_string(),
            seed: args.seed.value(),
            unit: unit(&map),
            poses: places.iter().map(|place| pose_in_map(&map, place)).collect(),
            elsewhere,
            diagnosis,
        };
        save_json(path, &report)
    });
    saving.save_if(args.out.as_deref(), |folder| {
        draw(folder, &localizer, image, &camera, &calibrated)?;
        say::line!("picture: {}", folder.display());
        Ok(())
    });
    saving.end()
}

/// Focal length of the camera of the map that sees most in a degree, pixels.
pub fn finest_focal_px(map: &VisualMap) -> Option<f64> {
    let cameras = map.map.all_keyframes().filter_map(|(_, keyframe)| keyframe.foreign.as_deref());
    cameras.map(|session| session.camera.focal_px().0).max_by(f64::total_cmp)
}

/// The pose over the ground, if the map has one.
fn over_ground(map: &VisualMap, place: &Hypothesis) -> Option<PhotoPose> {
    let has_ground = unit(map) == "m" && map.is_level(place.map);
    has_ground.then(|| PhotoPose::new(place.world_from_camera, place.probability))
}

fn pose_in_map(map: &VisualMap, place: &Hypothesis) -> PoseInMap {
    let at = place.world_from_camera.translation();
    let [qx, qy, qz, qw] = place.world_from_camera.quaternion_xyzw();
    PoseInMap {
        probability: place.probability,
        x: at.x,
        y: at.y,
        z: at.z,
        qx,
        qy,
        qz,
        qw,
        map: place.map.index(),
        ground: over_ground(map, place).as_ref().map(GroundPose::from),
    }
}

fn print(map: &VisualMap, places: &[Hypothesis], elsewhere: f64, diagnosis: &[FindingReport]) {
    for place in places {
        let words =
            over_ground(map, place).map_or_else(|| in_frame_of_map(map, place), |pose| pose_in_words(&pose));
        say::line!("{:4.0} %  {words}", 100.0 * place.probability);
    }
    say::line!("{:4.0} %  at a place that is not among these, or not in the map", 100.0 * elsewhere);
    diagnosis.iter().for_each(|finding| say::line!("{}\n  -> {}", finding.sentence, finding.advice));
}

fn in_frame_of_map(map: &VisualMap, place: &Hypothesis) -> String {
    let at = place.world_from_camera.translation();
    let [qx, qy, qz, qw] = place.world_from_camera.quaternion_xyzw();
    format!(
        "x {:.3}, y {:.3}, z {:.3} {}, orientation (x, y, z, w) {qx:.4}, {qy:.4}, {qz:.4}, {qw:.4}",
        at.x,
        at.y,
        at.z,
        unit(map)
    )
}

/// Draws which landmarks of the map were found in the photo, and which ones should be there and were not.
fn draw(
    folder: &Path,
    localizer: &MapLocalizer,
    image: RgbImage,
    camera: &Camera,
    calibrated: &Camera,
) -> Result<()> {
    let outcome = localizer.outcome();
    let pose = outcome.and_then(|outcome| outcome.camera_from_world);
    let found = outcome.map(|outcome| outcome.fixed.as_slice()).unwrap_or_default();
    let tried = outcome.map(|outcome| outcome.fixed_tried.as_slice()).unwrap_or_default();
    let missed = tried.iter().filter(|id| found.iter().all(|feature| feature.landmark != **id));
    let places = missed.filter_map(|id| {
        let point = localizer.slam().map().landmark(*id).point_in_world;
        camera.project(&pose?.transform(&point)).ok().filter(|px| camera.contains(px))
    });
    // In the photo as it was taken.
    let ratio = calibrated.focal_px().0 / camera.focal_px().0;
    let in_photo = |px: Point2<f64>| ((px.x + 0.5) * ratio - 0.5, (px.y + 0.5) * ratio - 0.5);
    let dots = |label: &str, color, points_px| ImageDots {
        label: label.to_owned(),
        color,
        diameter_px: 3.0 * ratio,
        points_px,
    };
    let picture = ImagePicture {
        title: localizer.hypotheses().first().map_or("the place was not recognized".to_owned(), |place| {
            format!("{:.0} %: {} landmarks of the map", 100.0 * place.probability, found.len())
        }),
        image,
        enlargement: if ratio > 1.0 { 1 } else { 2 },
        dots: vec![
            dots("should be seen, not found", Color::VERMILION, places.map(in_photo).collect()),
            dots("found", Color::BLUISH_GREEN, found.iter().map(|f| in_photo(f.px)).collect()),
        ],
        ..ImagePicture::default()
    };
    remove_earlier(folder, |name| name == UNKNOWN_PLACE || is_of_series(name, "place-"));
    let name = if localizer.hypotheses().is_empty() { UNKNOWN_PLACE } else { "place-1" };
    image_picture(&picture).save(folder, name)?;
    Ok(())
}

/// Options that make no difference in a map of SLAM.
fn refuse_others(args: &LocateArgs) -> Result<()> {
    let others = [
        ("--pitch", args.pitch.is_some()),
        ("--height", args.height.is_some()),
        ("--pipeline", args.pipeline.is_some()),
    ];
    match others.into_iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => bail!("{option}: it makes no difference in a map of SLAM (.vmap)"),
        None => Ok(()),
    }
}
