//! Pictures of a run.

use std::path::{Path, PathBuf};

use anyhow::Result;
use visloc_core::{
    CameraTrajectory, GrayImage,
    eval::camera::{AbsoluteError, associate},
};
use visloc_plot::{
    Color, ImageDots, ImagePicture, Panel, PlotError, Series, SpacePath, SpaceViews, TimeSeriesPicture,
    image_picture, is_of_series, remove_earlier, space_views, time_series,
};
use visloc_slam::{FrameOutcome, TrackingState, track::Quality};

use super::{SlamRecord, SlamRun};

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
        TrackingState::Carried => format!("carried by odometry, {counts}"),
        TrackingState::Lost => "lost in the map".to_owned(),
    }
}

/// Draws the trajectory with the map, over the truth if that is known, and the course of errors, matches and times.
pub fn draw(
    folder: &Path,
    title: &str,
    run: &SlamRun,
    truth: Option<&CameraTrajectory>,
    error: Option<&AbsoluteError>,
) -> Result<()> {
    remove_earlier(folder, |name| name == "trajectory" || name == "trajectory-side");
    time_series(&courses(title, run, truth, error)).save(folder, "courses")?;
    let views = match (truth, error) {
        (Some(truth), Some(error)) => paths(title, run, truth, error),
        _ if run.trajectory.poses().is_empty() => return Ok(()),
        _ => own_paths(title, run),
    };
    let [above, side] = space_views(&views);
    above.save(folder, "trajectory")?;
    side.save(folder, "trajectory-side")?;
    Ok(())
}

/// The estimate and the map as they are, in map units, where nobody knows the truth.
fn own_paths(title: &str, run: &SlamRun) -> SpaceViews {
    // The first image has x to the right, y down and z ahead.
    let place = |point: &nalgebra::Vector3<f64>| [point.x, point.z, -point.y];
    let landmarks = run.map.landmarks().filter(|(_, landmark)| landmark.is_converged());
    let points: Vec<_> = landmarks.map(|(_, landmark)| place(&landmark.point_in_world.coords)).collect();
    let poses = run.trajectory.poses();
    let way: Vec<_> = poses.iter().map(|pose| place(pose.world_from_camera.translation())).collect();
    let start = way.first().copied();
    SpaceViews {
        title: title.to_owned(),
        subtitle: "as the first image looks; the map is colored by height, low is dark".to_owned(),
        names: ["x", "ahead", "height"].map(str::to_owned),
        unit: "map units".to_owned(),
        shows_clouds: true,
        paths: vec![
            SpacePath {
                colors: colors_by_height(&points),
                ..SpacePath::cloud(format!("{} landmarks", points.len()), Color::scale(0.5), points)
            },
            SpacePath::line("camera", Color::VERMILION, way),
            SpacePath::cloud("start", Color::BLACK, start.into_iter().collect()),
        ],
    }
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

/// The truth, the aligned estimate and the aligned map.
fn paths(title: &str, run: &SlamRun, truth: &CameraTrajectory, error: &AbsoluteError) -> SpaceViews {
    let place = |point: &nalgebra::Vector3<f64>| [point.x, point.y, point.z];
    let moved = |point: &nalgebra::Vector3<f64>| place(&error.similarity.place(point).coords);
    let landmarks = run.map.landmarks().filter(|(_, landmark)| landmark.is_converged());
    let landmarks = landmarks.map(|(_, landmark)| moved(&landmark.point_in_world.coords));
    let estimate = run.trajectory.poses().iter().map(|pose| moved(pose.world_from_camera.translation()));
    let truth = truth.poses().iter().map(|pose| place(pose.world_from_camera.translation()));
    SpaceViews {
        title: title.to_owned(),
        subtitle: format!("RMSE {:.4} m", error.statistics.rmse),
        shows_clouds: true,
        paths: vec![
            SpacePath::cloud("map", Color::GRAY, landmarks.collect()),
            SpacePath::line("truth", Color::BLACK, truth.collect()),
            SpacePath::line("estimate", Color::BLUE, estimate.collect()),
        ],
        ..SpaceViews::default()
    }
}
