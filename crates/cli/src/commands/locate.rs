//! `visloc locate`: where a single photo was taken.

use anyhow::{Context, Result};
use serde::Serialize;
use visloc_core::{RgbImage, RngTree, geom::Camera};
use visloc_io::{
    image_codec::read_image,
    sequence::{fit_calibration, read_calibration},
};
use visloc_locate::{Photo, PhotoAnswer, PhotoPose, diagnosis::RunCounters, locate_photo};
use visloc_plot::{is_of_series, remove_earlier};
use visloc_world::Map;

use crate::{
    args::LocateArgs,
    in_map,
    report::{FindingReport, GroundPose, draw_overlay, explain_photo, pose_in_words, save_json},
    run::Saving,
    say,
    settings::pipeline_config,
    slam::is_map_of_slam,
};

/// Most places that are printed and drawn.
const MAX_SHOWN: usize = 10;

/// What `--json` writes.
#[derive(Serialize)]
struct LocateReport {
    photo: String,
    map: String,
    seed: u64,
    /// The most probable one first.
    poses: Vec<PoseReport>,
    /// How probable it is that the photo was taken at none of them.
    elsewhere: f64,
    /// What is wrong with the photo; empty if nothing is, or if it tells a place.
    diagnosis: Vec<FindingReport>,
}

/// A place and how probable it is.
#[derive(Serialize)]
struct PoseReport {
    probability: f64,
    #[serde(flatten)]
    ground: GroundPose,
}

impl From<&PhotoPose> for PoseReport {
    fn from(pose: &PhotoPose) -> Self {
        Self { probability: pose.probability, ground: pose.into() }
    }
}

/// A place as probable as this, or its mirror image, leaves little to ask for.
const ABOUT_SURE: f64 = 0.4;

/// Runs the command.
pub fn execute(args: &LocateArgs) -> Result<()> {
    let image = read_image(&args.photo).with_context(|| args.photo.display().to_string())?;
    let camera = camera_of(args, &image)?;
    if is_map_of_slam(&args.map) {
        return in_map::locate(args, image, camera);
    }
    let config = pipeline_config(args.pipeline.as_deref(), &[])?;
    let map = Map::load(&args.map)?;
    let place = || {
        let names = [Some(&args.photo), args.pipeline.as_ref()].into_iter().flatten();
        names.map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
    };
    let pitch_down_rad = args.pitch.map(f64::to_radians);
    let photo = Photo { image, camera, pitch_down_rad, height_m: args.height };
    let answer = locate_photo(&map, &config, &photo, RngTree::new(args.seed.value())).with_context(place)?;
    let best = answer.poses.first().map_or(0.0, |pose| pose.probability);
    let cause = RunCounters::new(&map, &config).cause_in_photo(&photo.image).filter(|_| best < ABOUT_SURE);
    let diagnosis: Vec<FindingReport> = cause.map(explain_photo).into_iter().collect();
    print(&answer, &photo);
    diagnosis.iter().for_each(|finding| say::line!("{}\n  -> {}", finding.sentence, finding.advice));
    let mut saving = Saving::default();
    saving.save_if(args.json.json.as_deref(), |path| {
        let report = LocateReport {
            photo: args.photo.display().to_string(),
            map: map.name().to_owned(),
            seed: args.seed.value(),
            poses: answer.poses.iter().map(PoseReport::from).collect(),
            elsewhere: answer.elsewhere,
            diagnosis,
        };
        save_json(path, &report)
    });
    saving.save_if(args.out.as_deref(), |folder| {
        remove_earlier(folder, |name| is_of_series(name, "place-"));
        for (i, pose) in answer.poses.iter().take(MAX_SHOWN).enumerate() {
            let title = format!("{:.0} %: {}", 100.0 * pose.probability, pose_in_words(pose));
            draw_overlay(&photo, &map, pose, title)?.save(folder, &format!("place-{}", i + 1))?;
        }
        say::line!("pictures: {}", folder.display());
        Ok(())
    });
    saving.end()
}

/// The calibration for the size of the photo.
fn camera_of(args: &LocateArgs, image: &RgbImage) -> Result<Camera> {
    let calibration = read_calibration(&args.camera)?;
    let mut warnings = Vec::new();
    let camera = fit_calibration(&calibration, (image.width(), image.height()), &args.camera, &mut warnings)?;
    warnings.iter().for_each(|warning| say::note!("{warning}"));
    Ok(camera)
}

fn print(answer: &PhotoAnswer, photo: &Photo) {
    for pose in answer.poses.iter().take(MAX_SHOWN) {
        say::line!("{:4.0} %  {}", 100.0 * pose.probability, pose_in_words(pose));
    }
    if answer.poses.len() > MAX_SHOWN {
        say::line!("        and {} places less probable than these", answer.poses.len() - MAX_SHOWN);
    }
    say::line!(
        "{:4.0} %  at a place that is not among these, or it shows too little",
        100.0 * answer.elsewhere
    );
    let options = [("--pitch", photo.pitch_down_rad), ("--height", photo.height_m)];
    let (given, unknown): (Vec<_>, Vec<_>) = options.into_iter().partition(|(_, given)| given.is_some());
    let [given, unknown] =
        [given, unknown].map(|options| options.iter().map(|(option, _)| *option).collect::<Vec<_>>());
    if answer.elsewhere > 0.5 && !given.is_empty() {
        say::line!(
            "No place explains it with the camera's pose as given: without {} it may be found",
            given.join(" and ")
        );
    }
    if !unknown.is_empty() {
        say::line!(
            "It is told better if the camera's pose over the ground is known: {}",
            unknown.join(" and ")
        );
    }
}
