//! How many pixels does it take? The document keeps 12 line pixels and 8 goal pixels at random and finds the loss of
//! precision practically nil. Source: 2010 section 4.3.2 and figure 4.16.

use rand::RngExt as _;
use rayon::prelude::*;
use serde_json::json;
use visloc_core::{Rng, RngTree, Source, geom::PlanarPose};
use visloc_locate::{PipelineConfig, vision::Percept};
use visloc_plot::{Color, Mark, Panel, Picture, Series, TimeSeriesPicture, ValueAxis, time_series};
use visloc_sim::{Scenario, Simulation};
use visloc_world::Map;

use super::StudyOutcome;
use crate::{
    ExperimentError, Table,
    likelihood::{Eye, HeadingChoice, LikelihoodMap, Peak, climb},
    quantile, sorted,
};

/// Images that are looked at: one a second, of walks with several seeds.
const NUM_SEEDS: u64 = 2;
/// Most images that are used, evenly spread over all that qualify.
const MAX_IMAGES: usize = 32;
/// An image is used if it has at least so many line and goal pixels: more than the most that are kept.
const LEAST_PIXELS: (usize, usize) = (40, 24);
/// Random choices for each image and number.
const NUM_DRAWS: u64 = 4;
/// Numbers of pixels that are kept: of lines with all goal pixels, and of goals with all line pixels.
const KEPT_LINES: [usize; 9] = [1, 2, 4, 6, 8, 12, 16, 24, 40];
const KEPT_GOALS: [usize; 7] = [1, 2, 4, 6, 8, 12, 24];
/// What the document keeps.
const PUBLISHED: (usize, usize) = (12, 8);
/// The highest peak is looked for from the best cells of a coarse map, meters.
const COARSE_STEP_M: f64 = 0.3;
const NUM_STARTS: usize = 4;
/// A peak within this distance of the truth is the right one, meters.
const RIGHT_M: f64 = 0.5;

/// An image with all its pixels.
struct Image {
    percept: Percept,
    truth: PlanarPose,
}

/// What a choice of pixels changes, compared with all pixels.
#[derive(Debug, Clone, Copy, Default)]
struct Change {
    /// Absolute difference of the likelihood at the true pose.
    likelihood: f64,
    /// How far the peak near the truth moves, meters and degrees.
    moved_m: f64,
    moved_deg: f64,
    /// Its distance from the truth, meters.
    error_m: f64,
}

/// Means over images and draws.
struct Row {
    num_lines: Option<usize>,
    num_goals: Option<usize>,
    mean: Change,
    p95_likelihood: f64,
    p95_moved_m: f64,
}

pub(super) fn conduct(seed: u64) -> Result<StudyOutcome, ExperimentError> {
    let (map, images) = images(seed)?;
    let config = PipelineConfig::with_color_table();
    let measure = |num_lines, num_goals| measure(&map, &config, &images, (num_lines, num_goals), seed);
    let lines: Vec<Row> = KEPT_LINES.iter().map(|n| measure(Some(*n), None)).collect::<Result<_, _>>()?;
    let goals: Vec<Row> = KEPT_GOALS.iter().map(|n| measure(None, Some(*n))).collect::<Result<_, _>>()?;
    let both = measure(Some(PUBLISHED.0), Some(PUBLISHED.1))?;
    let all = measure(None, None)?;
    let right_all = share_right(&map, &config, &images, None, seed)?;
    let right_few = share_right(&map, &config, &images, Some(PUBLISHED), seed)?;

    let mut outcome = StudyOutcome::default();
    let report = &mut outcome.report;
    report.heading =
        format!("Random discard: {} images with {NUM_DRAWS} choices each, seed {seed}", images.len());
    report.tables.push(table("lines", "Some line pixels, all goal pixels", &lines));
    report.tables.push(table("goals", "All line pixels, some goal pixels", &goals));
    let mut summary = Table::new(
        "random-discard",
        "12 line pixels and 8 goal pixels against all",
        &["", "document", "12 + 8", "all"],
    );
    let meters = |value: f64| format!("{value:.3} m");
    summary.push([
        "change of the likelihood at the truth, mean".to_owned(),
        "practically nil".to_owned(),
        format!("{:.4}", both.mean.likelihood),
        "0".to_owned(),
    ]);
    summary.push([
        "peak moves by, mean".to_owned(),
        "-".to_owned(),
        meters(both.mean.moved_m),
        "0".to_owned(),
    ]);
    let errors = [meters(both.mean.error_m), meters(all.mean.error_m)];
    summary.push(["peak near the truth: error, mean", "-", &errors[0], &errors[1]]);
    let shares = [right_few, right_all].map(|share| format!("{:.0} %", 100.0 * share));
    summary.push(["images whose highest peak is the right one", "-", &shares[0], &shares[1]]);
    report.tables.push(summary);
    report.notes = vec![
        "Published: \"la pérdida de precisión es prácticamente nula\". The peak near the truth is climbed to from the true pose; \
         the highest peak is that of the whole field."
            .to_owned(),
    ];
    report.json = json!({
        "study": "random-discard",
        "seed": seed,
        "images": images.len(),
        "lines": lines.iter().map(row_json).collect::<Vec<_>>(),
        "goals": goals.iter().map(row_json).collect::<Vec<_>>(),
        "published_choice": row_json(&both),
        "all_pixels": row_json(&all),
        "highest_peak_right": { "published_choice": right_few, "all_pixels": right_all },
    });
    report.pictures.push(("random-discard-likelihood".to_owned(), likelihood_picture(&lines, &goals)));
    report.pictures.push(("random-discard-peak".to_owned(), peak_picture(&lines, &goals)));
    Ok(outcome)
}

/// Images with many pixels of both kinds, and their map.
fn images(seed: u64) -> Result<(Map, Vec<Image>), ExperimentError> {
    let failed = |reason: String| ExperimentError::Setup { reason };
    let mut scenario = Scenario::load("tour").map_err(|error| failed(error.to_string()))?;
    scenario.frames_per_sec = 1.0;
    let mut config = PipelineConfig::with_color_table();
    config.analysis.filters.random_discard = false;
    let map = Map::load(&scenario.map).map_err(|error| failed(error.to_string()))?;
    let mut images = Vec::new();
    for part in 0..NUM_SEEDS {
        let seeds = RngTree::new(seed).subtree("random-discard", part);
        let simulation = Simulation::new(&scenario, seeds.stream_seed("simulation", 0));
        let mut simulation = simulation.map_err(|error| failed(error.to_string()))?;
        let mut eye = Eye::new(&map, &config, seeds)?;
        while let Some(next) = simulation.next_item() {
            let next = next.map_err(|error| failed(error.to_string()))?;
            let percept = eye.look(&next.frame)?;
            let num_goals = percept.pixels.iter().filter(|pixel| pixel.kind.is_goal()).count();
            let is_rich = num_goals >= LEAST_PIXELS.1 && percept.pixels.len() - num_goals >= LEAST_PIXELS.0;
            if let (true, Some(truth)) = (is_rich, next.truth) {
                images.push(Image { percept: percept.clone(), truth: truth.world_from_robot });
            }
        }
    }
    if images.is_empty() {
        return Err(failed("random discard: no image has enough pixels of both kinds".to_owned()));
    }
    let stride = images.len().div_ceil(MAX_IMAGES);
    let images = images.into_iter().step_by(stride).collect();
    Ok((map, images))
}

/// The percept with so many line pixels and goal pixels taken at random; `None` keeps all.
fn choose(percept: &Percept, (lines, goals): (Option<usize>, Option<usize>), rng: &mut Rng) -> Percept {
    let mut pixels = Vec::new();
    for (is_goal, max) in [(false, lines), (true, goals)] {
        let mut all: Vec<_> =
            percept.pixels.iter().filter(|p| p.kind.is_goal() == is_goal).copied().collect();
        let max = max.unwrap_or(all.len()).min(all.len());
        for i in 0..max {
            let other = rng.random_range(i..all.len());
            all.swap(i, other);
        }
        pixels.extend_from_slice(&all[..max]);
    }
    Percept { pixels, ..percept.clone() }
}

fn measure(
    map: &Map,
    config: &PipelineConfig,
    images: &[Image],
    kept: (Option<usize>, Option<usize>),
    seed: u64,
) -> Result<Row, ExperimentError> {
    let seeds = RngTree::new(seed).subtree("choices", 0);
    let of_image = |(index, image): (usize, &Image)| -> Result<Vec<Change>, ExperimentError> {
        let mut eye = Eye::new(map, config, seeds)?;
        eye.condition_on(&image.percept);
        let (reference, at_truth) = (climb(eye.model(), &image.truth), eye.model().likelihood(&image.truth));
        let change = |draw: u64, eye: &mut Eye| {
            let rng = &mut seeds.stream("choice", index as u64 * NUM_DRAWS + draw);
            eye.condition_on(&choose(&image.percept, kept, rng));
            let peak = climb(eye.model(), &image.truth);
            Change {
                likelihood: (eye.model().likelihood(&image.truth) - at_truth).abs(),
                moved_m: peak.pose.distance_m(&reference.pose),
                moved_deg: peak.pose.heading_difference_rad(&reference.pose).to_degrees(),
                error_m: peak.pose.distance_m(&image.truth),
            }
        };
        Ok((0..NUM_DRAWS).map(|draw| change(draw, &mut eye)).collect())
    };
    let changes: Result<Vec<Vec<Change>>, _> = images.par_iter().enumerate().map(of_image).collect();
    let changes: Vec<Change> = changes?.into_iter().flatten().collect();
    let mean = |value: fn(&Change) -> f64| {
        let count = changes.len().max(1) as f64;
        changes.iter().map(value).sum::<f64>() / count
    };
    Ok(Row {
        num_lines: kept.0,
        num_goals: kept.1,
        mean: Change {
            likelihood: mean(|c| c.likelihood),
            moved_m: mean(|c| c.moved_m),
            moved_deg: mean(|c| c.moved_deg),
            error_m: mean(|c| c.error_m),
        },
        p95_likelihood: p95(changes.iter().map(|c| c.likelihood)),
        p95_moved_m: p95(changes.iter().map(|c| c.moved_m)),
    })
}

fn p95(values: impl Iterator<Item = f64>) -> f64 {
    quantile(&sorted(values), 0.95).unwrap_or(f64::NAN)
}

/// Share of the images whose highest peak on the whole field is the right one.
fn share_right(
    map: &Map,
    config: &PipelineConfig,
    images: &[Image],
    kept: Option<(usize, usize)>,
    seed: u64,
) -> Result<f64, ExperimentError> {
    let seeds = RngTree::new(seed).subtree("choices", 0);
    let mut num_right = 0_u32;
    for (index, image) in images.iter().enumerate() {
        let mut eye = Eye::new(map, config, seeds)?;
        let kept = (kept.map(|kept| kept.0), kept.map(|kept| kept.1));
        let rng = &mut seeds.stream("choice", index as u64 * NUM_DRAWS);
        eye.condition_on(&choose(&image.percept, kept, rng));
        let coarse = LikelihoodMap::new(eye.model(), HeadingChoice::Best, COARSE_STEP_M);
        let starts = crate::likelihood::peaks(&coarse, 0.5).into_iter().take(NUM_STARTS);
        let climbed = starts.map(|start| climb(eye.model(), &start.pose));
        let best: Option<Peak> = climbed.reduce(|a, b| if b.likelihood > a.likelihood { b } else { a });
        num_right += u32::from(best.is_some_and(|peak| peak.pose.distance_m(&image.truth) < RIGHT_M));
    }
    let count = images.len().max(1) as f64;
    Ok(f64::from(num_right) / count)
}

fn table(name: &str, title: &str, rows: &[Row]) -> Table {
    let header = [
        "kept",
        "change of likelihood: mean",
        "95 %",
        "peak moves [m]: mean",
        "95 %",
        "turns [deg]",
        "peak's error [m]",
    ];
    let mut table = Table::new(&format!("random-discard-{name}"), title, &header);
    for row in rows {
        let kept = row.num_lines.or(row.num_goals).map_or_else(|| "all".to_owned(), |n| n.to_string());
        table.push([
            kept,
            format!("{:.4}", row.mean.likelihood),
            format!("{:.4}", row.p95_likelihood),
            format!("{:.3}", row.mean.moved_m),
            format!("{:.3}", row.p95_moved_m),
            format!("{:.2}", row.mean.moved_deg),
            format!("{:.3}", row.mean.error_m),
        ]);
    }
    table
}

fn row_json(row: &Row) -> serde_json::Value {
    json!({
        "line_pixels": row.num_lines,
        "goal_pixels": row.num_goals,
        "likelihood_change": { "mean": row.mean.likelihood, "p95": row.p95_likelihood },
        "peak_moved_m": { "mean": row.mean.moved_m, "p95": row.p95_moved_m },
        "peak_turned_deg": row.mean.moved_deg,
        "peak_error_m": row.mean.error_m,
    })
}

/// Two lines over the number of kept pixels.
fn picture(title: &str, label: &str, curves: [Vec<(f64, f64)>; 2]) -> Picture {
    let [lines, goals] = curves;
    let mark = |count: usize, label: &str| Mark { at_secs: count as f64, label: label.to_owned() };
    time_series(&TimeSeriesPicture {
        title: title.to_owned(),
        subtitle: "Some pixels of one kind at random, all of the other, against all of both; mean over images and choices"
            .to_owned(),
        x_label: "kept pixels".to_owned(),
        panels: vec![Panel {
            label: label.to_owned(),
            axis: ValueAxis::Auto,
            series: vec![
                Series::new("line pixels", Color::VERMILION, lines),
                Series::new("goal pixels", Color::BLUE, goals),
            ],
            ..Panel::default()
        }],
        marks: vec![mark(PUBLISHED.1, "8 of goals"), mark(PUBLISHED.0, "12 of lines")],
        panel_px: Some(300.0),
        ..TimeSeriesPicture::default()
    })
}

fn curve(rows: &[Row], value: impl Fn(&Row) -> f64) -> Vec<(f64, f64)> {
    let count = |row: &Row| row.num_lines.or(row.num_goals).map_or(f64::NAN, |n| n as f64);
    rows.iter().map(|row| (count(row), value(row))).collect()
}

fn likelihood_picture(lines: &[Row], goals: &[Row]) -> Picture {
    let value = |row: &Row| row.mean.likelihood;
    let title = "Random discard: change of the likelihood at the true pose";
    picture(title, "absolute change of the likelihood", [curve(lines, value), curve(goals, value)])
}

fn peak_picture(lines: &[Row], goals: &[Row]) -> Picture {
    let value = |row: &Row| row.mean.moved_m;
    let title = "Random discard: how far the likelihood's peak moves";
    picture(title, "displacement of the peak [m]", [curve(lines, value), curve(goals, value)])
}
