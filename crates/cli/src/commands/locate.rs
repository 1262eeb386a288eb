//! `visloc locate`: where a single photo was taken.

use anyhow::{Context, Result};
use serde::Serialize;
use visloc_core::RngTree;
use visloc_io::{
    image_codec::read_image,
    sequence::{fit_calibration, read_calibration},
};
use visloc_locate::{
    Photo, PhotoAnswer, PhotoPose,
    diagnosis::{Diagnosis, Finding, RunCounters},
    locate_photo,
};
use visloc_plot::{is_of_series, remove_earlier};
use visloc_world::Map;

use crate::{
    args::LocateArgs,
    report::{FindingReport, draw_overlay, explain_localization, save_json},
    run::Saving,
    say,
    settings::pipeline_config,
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

/// Place of the camera over the ground, the direction in which it looked, and how it was held: meters, degrees.
#[derive(Serialize)]
struct PoseReport {
    x_m: f64,
    y_m: f64,
    yaw_deg: f64,
    probability: f64,
    height_m: f64,
    /// Down is positive.
    pitch_deg: f64,
    /// Clockwise is positive.
    roll_deg: f64,
}

impl From<&PhotoPose> for PoseReport {
    fn from(pose: &PhotoPose) -> Self {
        Self {
            x_m: pose.world_from_view.x_m,
            y_m: pose.world_from_view.y_m,
            yaw_deg: pose.world_from_view.yaw_rad.to_degrees(),
            probability: pose.probability,
            height_m: pose.height_m,
            pitch_deg: pose.pitch_down_rad.to_degrees(),
            roll_deg: pose.roll_clockwise_rad.to_degrees(),
        }
    }
}

/// A place as probable as this, or its mirror image, leaves little to ask for.
const ABOUT_SURE: f64 = 0.4;

/// Runs the command.
pub fn execute(args: &LocateArgs) -> Result<()> {
    let config = pipeline_config(args.pipeline.as_deref(), &[])?;
    let map = Map::load(&args.map)?;
    let calibration = read_calibration(&args.camera)?;
    let place = || {
        let names = [Some(&args.photo), args.pipeline.as_ref()].into_iter().flatten();
        names.map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ")
    };
    let image = read_image(&args.photo).with_context(|| args.photo.display().to_string())?;
    let mut warnings = Vec::new();
    let camera = fit_calibration(&calibration, (image.width(), image.height()), &args.camera, &mut warnings)?;
    warnings.iter().for_each(|warning| say::note!("{warning}"));
    let pitch_down_rad = args.pitch.map(f64::to_radians);
    let photo = Photo { image, camera, pitch_down_rad, height_m: args.height };
    let answer = locate_photo(&map, &config, &photo, RngTree::new(args.seed.value())).with_context(place)?;
    let best = answer.poses.first().map_or(0.0, |pose| pose.probability);
    let cause = RunCounters::new(&map, &config).cause_in_photo(&photo.image).filter(|_| best < ABOUT_SURE);
    let findings = cause.map(|cause| Finding { cause, share: 1.0 }).into_iter().collect();
    let diagnosis = explain_localization(&Diagnosis { findings, ..Diagnosis::default() });
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
            let title = format!("{:.0} %: {}", 100.0 * pose.probability, in_words(pose));
            draw_overlay(&photo, &map, pose, title)?.save(folder, &format!("place-{}", i + 1))?;
        }
        say::line!("pictures: {}", folder.display());
        Ok(())
    });
    saving.end()
}

fn in_words(pose: &PhotoPose) -> String {
    let view = &pose.world_from_view;
    format!(
        "x {:.2} m, y {:.2} m, looking to {:.0} deg; {:.2} m high, {:.1} deg {}, rolled by {:.1} deg",
        view.x_m,
        view.y_m,
        view.yaw_rad.to_degrees(),
        pose.height_m,
        pose.pitch_down_rad.to_degrees().abs(),
        if pose.pitch_down_rad < 0.0 { "up" } else { "down" },
        pose.roll_clockwise_rad.to_degrees()
    )
}

fn print(answer: &PhotoAnswer, photo: &Photo) {
    for pose in answer.poses.iter().take(MAX_SHOWN) {
        say::line!("{:4.0} %  {}", 100.0 * pose.probability, in_words(pose));
    }
    if answer.poses.len() > MAX_SHOWN {
        say::line!("        and {} places less probable than these", answer.poses.len() - MAX_SHOWN);
    }
    say::line!(
        "{:4.0} %  at a place that is not among these, or it shows too little",
        100.0 * answer.elsewhere
    );
    let unknown: Vec<&str> = [("--pitch", photo.pitch_down_rad), ("--height", photo.height_m)]
        .into_iter()
        .filter_map(|(option, given)| given.is_none().then_some(option))
        .collect();
    if !unknown.is_empty() {
        say::line!(
            "It is told better if the camera's pose over the ground is known: {}",
            unknown.join(" and ")
        );
    }
}
