//! Pictures of a run.

use std::path::{Path, PathBuf};

use anyhow::Result;
use nalgebra::Vector3;
use visloc_core::{
    CameraTrajectory, GrayImage,
    eval::camera::{AbsoluteError, Alignment, absolute_error, associate},
    median,
};
use visloc_plot::{
    Color, ImageDots, ImagePicture, Panel, PlotError, Series, SpacePath, SpaceViews, TimeSeriesPicture,
    image_picture, is_of_series, remove_earlier, space_views, time_series,
};
use visloc_slam::{FrameOutcome, TrackingState, atlas::Meeting, track::Quality};

use super::{MapWay, POSE_TOLERANCE_SECS, SlamRecord, SlamRun};

/// A step of the way that takes longer, times the median step, is a gap.
const LONGEST_STEP: f64 = 3.0;

/// Draws the landmarks found in some frames over their images, while the run goes on.
pub struct FramePictures {
    folder: PathBuf,
    every: usize,
    fault: Option<PlotError>,
}

impl FramePictures {
    /// Into a folder, every so many frames.
    pub fn new(folder: &Path, every: usize) -> Self {
        remove_frames(folder);
        Self { folder: folder.to_path_buf(), every: every.max(1), fault: None }
    }

    /// Draws a frame if it is its turn. After a picture that cannot be written there are no more, and the others make room for the
    /// numbers, which cannot be made again so easily.
    pub fn look(&mut self, number: usize, image: &GrayImage, outcome: &FrameOutcome) {
        if !number.is_multiple_of(self.every) || self.fault.is_some() {
            return;
        }
        let dots = |wanted: bool, label: &str, color: Color| ImageDots {
            label: label.to_owned(),
            color,
            diameter_px: 5.0,
            points_px: outcome
                .features
                .iter()
                .filter(|(_, c)| *c == wanted)
                .map(|(px, _)| (px.x, px.y))
                .collect(),
        };
        let picture = image_picture(&ImagePicture {
            title: format!("frame {number}"),
            subtitle: state_words(outcome),
            image: image.to_rgb(),
            enlargement: 1,
            dots: vec![
                dots(true, "landmarks", Color::BLUISH_GREEN),
                dots(false, "candidates", Color::ORANGE),
            ],
            ..ImagePicture::default()
        });
        self.fault = picture.save(&self.folder, &format!("frame-{number:05}")).err();
        if self.fault.is_some() {
            remove_frames(&self.folder);
        }
    }

    /// Whether all could be written.
    pub fn finish(self) -> Result<()> {
        self.fault.map_or(Ok(()), |fault| Err(fault.into()))
    }
}

fn remove_frames(folder: &Path) {
    remove_earlier(folder, |name| is_of_series(name, "frame-"));
}

/// What became of a frame, for people.
fn state_words(outcome: &FrameOutcome) -> String {
    let (searched, found) = outcome.matches;
    let counts = format!("{found} of {searched} landmarks found");
    match outcome.state {
        TrackingState::Starting(wait) => format!("no map yet: {wait}"),
        TrackingState::Tracking(Quality::Good) => format!("tracked well, {counts}"),
        TrackingState::Tracking(Quality::Insufficient) => format!("tracked with few landmarks, {counts}"),
        TrackingState::Tracking(Quality::Bad) => format!("not tracked, {counts}"),
        TrackingState::Supposed => format!("maybe here, {counts}"),
        TrackingState::Carried => format!("carried by odometry, {counts}"),
        TrackingState::Lost => "lost in the map".to_owned(),
    }
}

/// Draws the way and the map of each map, the one with most poses first, over the truth if that is known, and the course of
/// errors, matches and times. Where the camera had no pose the way is interrupted; where a loop was closed and where a map was
/// joined to another is marked.
pub fn draw(
    folder: &Path,
    title: &str,
    run: &SlamRun,
    truth: Option<&CameraTrajectory>,
    error: Option<&AbsoluteError>,
) -> Result<()> {
    remove_earlier(folder, |name| name.starts_with("trajectory"));
    time_series(&courses(title, run, truth, error)).save(folder, "courses")?;
    for (index, way) in run.maps.iter().enumerate() {
        let (title, name) = match run.maps.len() {
            1 => (title.to_owned(), "trajectory".to_owned()),
            num => (
                format!("{title}, map {} of {num}", index + 1),
                match index {
                    0 => "trajectory".to_owned(),
                    _ => format!("trajectory-{}", index + 1),
                },
            ),
        };
        let views = match truth.and_then(|truth| Some((truth, error_in(way, truth)?))) {
            Some((truth, error)) => paths(title, run, way, truth, &error),
            None => own_paths(title, run, way),
        };
        let [above, side] = space_views(&views);
        above.save(folder, &name)?;
        side.save(folder, &format!("{name}-side"))?;
    }
    Ok(())
}

fn error_in(way: &MapWay, truth: &CameraTrajectory) -> Option<AbsoluteError> {
    absolute_error(&associate(truth, &way.trajectory, POSE_TOLERANCE_SECS), Alignment::Similarity)
}

/// The estimate and the map as they are, in map units, where nobody knows the truth.
fn own_paths(title: String, run: &SlamRun, way: &MapWay) -> SpaceViews {
    // The first image has x to the right, y down and z ahead.
    let place = |point: &Vector3<f64>| [point.x, point.z, -point.y];
    let points = landmarks(run, way, &place);
    let start = way.trajectory.poses().first().map(|pose| place(pose.world_from_camera.translation()));
    let mut paths = vec![
        SpacePath {
            colors: colors_by_height(&points),
            ..SpacePath::cloud(format!("{} landmarks", points.len()), Color::scale(0.5), points)
        },
        SpacePath::line("camera", Color::VERMILION, line(&way.trajectory, &place)),
        SpacePath::cloud("start", Color::BLACK, start.into_iter().collect()),
    ];
    paths.extend(marks(run, way, &place));
    SpaceViews {
        title,
        subtitle: "as the first image looks; the map is colored by height, low is dark".to_owned(),
        names: ["x", "ahead", "height"].map(str::to_owned),
        unit: "map units".to_owned(),
        shows_clouds: true,
        paths,
    }
}

/// The truth, the aligned estimate and the aligned map.
fn paths(
    title: String,
    run: &SlamRun,
    way: &MapWay,
    truth: &CameraTrajectory,
    error: &AbsoluteError,
) -> SpaceViews {
    let moved = |point: &Vector3<f64>| error.similarity.place(point).coords.data.0[0];
    let mut paths = vec![
        SpacePath::cloud("map", Color::GRAY, landmarks(run, way, &moved)),
        SpacePath::line("truth", Color::BLACK, line(truth, &|point| point.data.0[0])),
        SpacePath::line("estimate", Color::BLUE, line(&way.trajectory, &moved)),
    ];
    paths.extend(marks(run, way, &moved));
    SpaceViews {
        title,
        subtitle: format!("RMSE {:.4} m", error.statistics.rmse),
        shows_clouds: true,
        paths,
        ..SpaceViews::default()
    }
}

/// How a point of a map is shown.
type Place<'a> = &'a dyn Fn(&Vector3<f64>) -> [f64; 3];

/// The converged landmarks of a map.
fn landmarks(run: &SlamRun, way: &MapWay, place: Place<'_>) -> Vec<[f64; 3]> {
    let map = run.slam.map();
    map.all_landmarks()
        .filter(|(_, landmark)| landmark.is_converged())
        .filter(|(_, landmark)| map.keyframe(landmark.observations.keyframe_at(0)).map == way.map)
        .map(|(_, landmark)| place(&landmark.point_in_world.coords))
        .collect()
}

/// A way, interrupted where images without a pose lie between.
fn line(trajectory: &CameraTrajectory, place: Place<'_>) -> Vec<[f64; 3]> {
    let poses = trajectory.poses();
    let steps = || poses.windows(2).map(|pair| pair[1].at.secs_since(pair[0].at));
    let longest = median(steps()).map_or(f64::INFINITY, |usual| LONGEST_STEP * usual);
    let is_after_gap = std::iter::once(false).chain(steps().map(|step| step > longest));
    let points = poses.iter().map(|pose| place(pose.world_from_camera.translation()));
    points
        .zip(is_after_gap)
        .flat_map(|(point, gap)| gap.then_some([f64::NAN; 3]).into_iter().chain([point]))
        .collect()
}

/// Where loops were closed and maps were joined: where the camera was then.
fn marks(run: &SlamRun, way: &MapWay, place: Place<'_>) -> Vec<SpacePath> {
    let places = |is_meant: fn(&Meeting) -> bool| -> Vec<[f64; 3]> {
        let records =
            run.history.records.iter().filter(|record| record.meeting.as_ref().is_some_and(is_meant));
        let poses = records.filter_map(|record| way.trajectory.nearest(record.at, POSE_TOLERANCE_SECS));
        poses.map(|pose| place(pose.world_from_camera.translation())).collect()
    };
    let loops = places(|meeting| matches!(meeting, Meeting::Closed { .. } | Meeting::Followed { .. }));
    let joins = places(|meeting| matches!(meeting, Meeting::Joined { .. }));
    let shown = [("loop closed", Color::PURPLE, loops), ("maps joined", Color::ORANGE, joins)];
    let shown = shown.into_iter().filter(|(_, _, points)| !points.is_empty());
    shown.map(|(label, color, points)| SpacePath::rings(label, color, points)).collect()
}

/// From dark (low) to light (high).
fn colors_by_height(points: &[[f64; 3]]) -> Vec<Color> {
    let mut heights: Vec<f64> = points.iter().map(|point| point[2]).collect();
    heights.sort_by(f64::total_cmp);
    // By rank, so that a few far points do not take all the colors.
    let rank = |height: f64| heights.partition_point(|other| *other < height) as f64 / heights.len() as f64;
    points.iter().map(|point| Color::scale(0.95 * rank(point[2]))).collect()
}

fn courses(
    title: &str,
    run: &SlamRun,
    truth: Option<&CameraTrajectory>,
    error: Option<&AbsoluteError>,
) -> TimeSeriesPicture {
    let start = run.history.records.first().map(|record| record.at).unwrap_or_default();
    let series = |label: &str, color, value: &dyn Fn(&SlamRecord) -> f64| {
        let points = run.history.records.iter().map(|r| (r.at.secs_since(start), value(r))).collect();
        Series::new(label, color, points)
    };
    let mut panels = Vec::new();
    if let (Some(truth), Some(error)) = (truth, error) {
        let pairs = associate(truth, &run.trajectory, 0.01);
        let points =
            pairs.iter().zip(&error.each).map(|(p, e)| (p.estimate.at.secs_since(start), *e)).collect();
        panels.push(Panel {
            label: "position error [m]".to_owned(),
            series: vec![Series::new("error", Color::BLUE, points)],
            ..Panel::default()
        });
    }
    panels.push(Panel {
        label: "landmarks".to_owned(),
        series: vec![
            series("searched", Color::ORANGE, &|r| r.matches.0 as f64),
            series("found", Color::BLUISH_GREEN, &|r| r.matches.1 as f64),
        ],
        ..Panel::default()
    });
    panels.push(Panel {
        label: "time [ms]".to_owned(),
        series: vec![
            series("mapping", Color::VERMILION, &|r| r.mapping_secs * 1e3),
            series("tracking", Color::PURPLE, &|r| r.tracking_secs * 1e3),
        ],
        ..Panel::default()
    });
    TimeSeriesPicture { title: title.to_owned(), panels, ..TimeSeriesPicture::default() }
}
