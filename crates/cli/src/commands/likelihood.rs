//! `visloc likelihood`: how well every pose explains one image.

use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;
use visloc_core::{RngTree, Source, SourceFrame, geom::PlanarPose};
use visloc_experiments::likelihood::{
    Eye, HeadingChoice, LikelihoodMap, LikelihoodPictures, PEAK_DISTANCE_M, SimulatedView, View,
    heading_profile, map_csv, peaks, profile_csv,
};
use visloc_io::sources::{SourceOption, SourceOptions};
use visloc_locate::PipelineConfig;
use visloc_world::Map;

use crate::{
    args::{HeadingText, LikelihoodArgs},
    host::end_at_signals,
    report::save_json,
    run::{Progress, Saving, open_source, refuse_source_options, source_options, write_text},
    say,
    settings::{pipeline_config, refuse_far_from, topic_options},
};

/// Most cells of a map.
const MAX_CELLS: f64 = 4e6;
/// Peaks that reach this share of the maximum are listed.
const PEAK_SHARE: f64 = 0.95;
/// Most peaks that are listed.
const MAX_PEAKS: usize = 8;

/// Runs the command.
pub fn execute(args: &LikelihoodArgs) -> Result<()> {
    let mut config = match &args.pipeline {
        // Simulated views are those of the documents.
        None if args.view.is_some() => PipelineConfig::with_color_table(),
        path => pipeline_config(path.as_deref(), &[])?,
    };
    if args.all_pixels {
        config.analysis.filters.random_discard = false;
    }
    let place =
        || args.pipeline.as_ref().map_or("cannot start".to_owned(), |path| path.display().to_string());
    let rng = RngTree::new(args.seed.value()).subtree("pipeline", 0);
    let (mut eye, frame) = match &args.view {
        Some(pose) => {
            refuse_source_options(
                &options(args)?,
                "expected a SOURCE, found --view, which has no such thing",
            )?;
            let [x_m, y_m, yaw_deg] = *pose;
            let map = args.map.as_deref().unwrap_or("robocup-spl-2010");
            let pose = PlanarPose::new(x_m, y_m, yaw_deg.to_radians());
            let view = View { pan_deg: args.pan, tilt_deg: args.tilt, ..View::new(map, pose) };
            let image = SimulatedView::take(&view, args.seed.value())?;
            check_place(args, &image.map)?;
            (Eye::new(&image.map, &config, rng).with_context(place)?, image.source)
        }
        None => {
            let mut source = open(args)?;
            check_place(args, &source.1)?;
            let mut eye = Eye::new(&source.1, &config, rng).with_context(place)?;
            // The analysis follows the light from frame to frame.
            let progress = Progress::new(None);
            let frame = frame_at(source.0.as_mut(), args.at, |next| {
                progress.advance();
                eye.look(&next.frame).map(|_| ())
            });
            progress.clear();
            (eye, frame?)
        }
    };
    end_at_signals();
    if args.view.is_some() {
        eye.look(&frame.frame)?;
    }
    let truth = frame.truth.map(|truth| truth.world_from_robot);
    show(args, &eye, &frame, truth)
}

fn open(args: &LikelihoodArgs) -> Result<(Box<dyn Source<SourceFrame>>, Map)> {
    let bag = args.bag.as_deref().context("expected a bag or --view")?;
    let source = open_source(bag, args.map.as_deref(), &options(args)?)?;
    source.warnings.iter().for_each(|warning| say::note!("{warning}"));
    Ok((source.frames, source.map))
}

fn options(args: &LikelihoodArgs) -> Result<SourceOptions> {
    Ok(SourceOptions {
        seed: args.seed.given,
        // It draws the pixels that are weighed, too.
        honored_elsewhere: vec![SourceOption::Seed],
        ..source_options(&args.options, topic_options(&args.topics)?)?
    })
}

/// The first frame that is so many seconds after the start; every frame until there is shown to `watch`.
fn frame_at<E>(
    source: &mut dyn Source<SourceFrame>,
    secs: f64,
    mut watch: impl FnMut(&SourceFrame) -> Result<(), E>,
) -> Result<SourceFrame>
where
    anyhow::Error: From<E>,
{
    let mut start = None;
    let mut last_secs = 0.0;
    while let Some(next) = source.next_item() {
        let next = next?;
        last_secs = next.frame.at.secs_since(*start.get_or_insert(next.frame.at));
        let is_there = last_secs >= secs - 1e-6;
        let seen = watch(&next);
        if is_there {
            seen?;
            return Ok(next);
        }
    }
    match start {
        None => bail!("no frame that can be used"),
        Some(_) => bail!("--at {secs}: the last frame is at {last_secs:.1} s"),
    }
}

/// Refuses a place that is far from the map.
fn check_place(args: &LikelihoodArgs, map: &Map) -> Result<()> {
    let place = args.place.map(|[x_m, y_m]| (x_m, y_m));
    place.map_or(Ok(()), |(x_m, y_m)| refuse_far_from(map, (x_m, y_m), &format!("--place {x_m},{y_m}")))
}

/// Refuses a map of so many cells that it would take hours.
fn check_cells(eye: &Eye, step_m: f64) -> Result<()> {
    let region = eye.model().region();
    let cells = (region.max_x_m - region.min_x_m) / step_m * ((region.max_y_m - region.min_y_m) / step_m);
    if cells > MAX_CELLS {
        bail!(
            "--step {step_m}: expected at most {MAX_CELLS} cells on this map, found {cells:.0}; take larger ones"
        );
    }
    Ok(())
}

/// What `--json` writes.
#[derive(Debug, Serialize)]
struct LikelihoodReport {
    map: String,
    seed: u64,
    step_m: f64,
    line_pixels: usize,
    goal_pixels: usize,
    quality: f64,
    truth: Option<PoseReport>,
    maximum: PoseReport,
    maximum_error_m: Option<f64>,
    best_heading_at_place_deg: f64,
    area_near_maximum_m2: f64,
    peaks: Vec<PoseReport>,
}

/// A pose with its likelihood: meters, degrees.
#[derive(Debug, Clone, Copy, Serialize)]
struct PoseReport {
    x_m: f64,
    y_m: f64,
    heading_deg: f64,
    likelihood: f64,
}

impl PoseReport {
    fn new(pose: &PlanarPose, likelihood: f64) -> Self {
        Self { x_m: pose.x_m, y_m: pose.y_m, heading_deg: pose.yaw_rad.to_degrees(), likelihood }
    }

    fn line(&self) -> String {
        format!(
            "x {:6.2} m, y {:6.2} m, heading {:6.1} deg, likelihood {:.3}",
            self.x_m, self.y_m, self.heading_deg, self.likelihood
        )
    }
}

fn show(args: &LikelihoodArgs, eye: &Eye, frame: &SourceFrame, truth: Option<PlanarPose>) -> Result<()> {
    if !eye.model().has_evidence() {
        bail!("the image shows no pixel of a line or goal: every pose explains it equally well");
    }
    let heading = match args.heading {
        HeadingText::Best => HeadingChoice::Best,
        HeadingText::Degrees(degrees) => HeadingChoice::Fixed(degrees.to_radians()),
        HeadingText::Truth => {
            let truth = truth.ok_or_else(|| anyhow!("--heading truth: the recording has no truth"))?;
            HeadingChoice::Fixed(truth.yaw_rad)
        }
    };
    check_cells(eye, args.step)?;
    let progress =
        Progress::message("weighing every place and heading; larger steps (--step) take less time");
    let map = LikelihoodMap::new(eye.model(), heading, args.step);
    progress.clear();
    let (maximum, likelihood) = map.maximum();
    let place = args.place.map(|[x_m, y_m]| (x_m, y_m));
    let (x_m, y_m) = place.unwrap_or_else(|| truth.map_or((maximum.x_m, maximum.y_m), |t| (t.x_m, t.y_m)));
    let profile = heading_profile(eye.model(), x_m, y_m);
    let best = profile.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a }).unwrap_or_default();
    let pixels = &eye.percept().pixels;
    let report = LikelihoodReport {
        map: eye.field().dimensions().name.clone(),
        seed: args.seed.value(),
        step_m: args.step,
        line_pixels: pixels.iter().filter(|pixel| !pixel.kind.is_goal()).count(),
        goal_pixels: pixels.iter().filter(|pixel| pixel.kind.is_goal()).count(),
        quality: eye.percept().quality,
        truth: truth.map(|pose| PoseReport::new(&pose, eye.model().likelihood(&pose))),
        maximum: PoseReport::new(&maximum, likelihood),
        maximum_error_m: truth.map(|pose| pose.distance_m(&maximum)),
        best_heading_at_place_deg: best.0.to_degrees(),
        area_near_maximum_m2: map.area_above_m2(PEAK_SHARE * likelihood),
        peaks: peaks(&map, PEAK_DISTANCE_M)
            .iter()
            .filter(|peak| peak.likelihood >= PEAK_SHARE * likelihood)
            .take(MAX_PEAKS)
            .map(|peak| PoseReport::new(&peak.pose, peak.likelihood))
            .collect(),
    };
    print(&report, (x_m, y_m));
    let mut saving = Saving::default();
    saving.save_if(args.json.json.as_deref(), |path| save_json(path, &report));
    saving.save(save(args, eye, frame, &map, ((x_m, y_m), &profile)));
    saving.end()
}

fn print(report: &LikelihoodReport, place: (f64, f64)) {
    say::line!(
        "{} line pixels and {} goal pixels, quality {:.2}",
        report.line_pixels,
        report.goal_pixels,
        report.quality
    );
    if let Some(truth) = &report.truth {
        say::line!("truth    {}", truth.line());
    }
    say::line!("maximum  {}", report.maximum.line());
    if let Some(error_m) = report.maximum_error_m {
        say::line!("The maximum is {error_m:.2} m from the truth.");
    }
    say::line!(
        "At x {:.2} m, y {:.2} m the best heading is {:.1} deg.",
        place.0,
        place.1,
        report.best_heading_at_place_deg
    );
    say::line!(
        "{:.2} m2 reach {:.0} % of the maximum, with {}:",
        report.area_near_maximum_m2,
        100.0 * PEAK_SHARE,
        say::count(report.peaks.len(), "peak")
    );
    for peak in &report.peaks {
        say::line!("         {}", peak.line());
    }
}

/// A place and the likelihood of its headings.
type Profile<'a> = ((f64, f64), &'a [(f64, f64)]);

fn save(
    args: &LikelihoodArgs,
    eye: &Eye,
    frame: &SourceFrame,
    map: &LikelihoodMap,
    (place, profile): Profile<'_>,
) -> Result<()> {
    let truth = frame.truth.map(|truth| truth.world_from_robot);
    let source = match (&args.bag, &args.view) {
        (Some(bag), _) => format!("{bag}, {} s", args.at),
        (None, Some(view)) => {
            let [x_m, y_m, yaw_deg] = *view;
            format!("view from {x_m} m, {y_m} m, {yaw_deg} deg")
        }
        (None, None) => String::new(),
    };
    let heading = match args.heading {
        HeadingText::Best => "best heading at each place".to_owned(),
        HeadingText::Truth => "heading fixed to the true one".to_owned(),
        HeadingText::Degrees(degrees) => format!("heading fixed to {degrees} deg"),
    };
    let pictures = LikelihoodPictures {
        title: format!("Likelihood of one image: {source}"),
        subtitle: format!("{} pixels; {heading}", eye.percept().pixels.len()),
        field: eye.field(),
        truth,
    };
    write_text(&args.out.join("likelihood-map.csv"), &map_csv(map))?;
    write_text(&args.out.join("likelihood-heading.csv"), &profile_csv(profile))?;
    pictures.heat(map).save(&args.out, "likelihood-map")?;
    pictures.surface(map).save(&args.out, "likelihood-surface")?;
    pictures.profile(place, profile).save(&args.out, "likelihood-heading")?;
    pictures.image(&frame.frame, eye.percept()).save(&args.out, "image")?;
    say::line!("\npictures and tables: {}", args.out.display());
    Ok(())
}
