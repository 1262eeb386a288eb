//! Does the likelihood grow gradually towards the true pose? Source: 2010 figures 4.17 and 4.18.

use serde_json::json;

use super::{
    StudyOutcome,
    facts::{MAP_2010, ViewFacts, pose},
};
use crate::{
    ExperimentError, Table,
    likelihood::{HeadingChoice, LikelihoodMap, View, heading_profile, profile_csv},
};

/// Rings around the true place, meters.
const RINGS_M: [(f64, f64); 5] = [(0.0, 0.25), (0.25, 0.5), (0.5, 1.0), (1.0, 2.0), (2.0, 4.0)];

pub(super) fn conduct(seed: u64) -> Result<StudyOutcome, ExperimentError> {
    let view = View::new(MAP_2010, pose(0.6, 1.3, -30.0));
    let facts = ViewFacts::new("Discrimination: a goal and lines, from the left side", &view, seed)?;
    let truth = facts.truth;
    let fixed = LikelihoodMap::new(facts.eye.model(), HeadingChoice::Fixed(truth.yaw_rad), facts.map.step_m);
    let profile = heading_profile(facts.eye.model(), truth.x_m, truth.y_m);
    let best = profile.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a }).unwrap_or_default();
    let fixed_error_m = fixed.maximum().0.distance_m(&truth);
    let rings: Vec<Option<f64>> =
        RINGS_M.iter().map(|(from_m, to_m)| facts.map.mean_around(&truth, *from_m, *to_m)).collect();
    let is_falling = rings.windows(2).all(|pair| pair[0] > pair[1]);

    let mut table = Table::new(
        "discrimination",
        "Discrimination: one image from x 0.6 m, y 1.3 m, -30 deg",
        &["question", "document", "here"],
    );
    table.push(["maximum, true heading: distance from the truth", "at the truth", &meters(fixed_error_m)]);
    table.push([
        "maximum, best heading: distance from the truth",
        "at the truth",
        &meters(facts.maximum_error_m()),
    ]);
    let heading = format!("{:.1} deg", best.0.to_degrees());
    table.push(["best heading at the true place", "about -30 deg, the true one", &heading]);
    for ((from_m, to_m), mean) in RINGS_M.iter().zip(&rings) {
        let question = format!("mean likelihood from {from_m} to {to_m} m away");
        let mean = mean.map_or_else(|| "-".to_owned(), |mean| format!("{mean:.3}"));
        table.push([question, "grows gradually".to_owned(), mean]);
    }
    table.push(["local maxima", "there are some", &facts.num_peaks().to_string()]);

    let mut outcome = StudyOutcome::default();
    let report = &mut outcome.report;
    report.heading = format!("Discrimination of one image, seed {seed}");
    report.tables.push(table);
    report.notes.push(format!(
        "The likelihood {} from ring to ring around the true place.",
        if is_falling { "falls" } else { "does not fall" }
    ));
    report.json = json!({
        "study": "discrimination",
        "seed": seed,
        "view": facts.json(),
        "maximum_error_true_heading_m": fixed_error_m,
        "best_heading_deg": best.0.to_degrees(),
        "rings": RINGS_M.iter().zip(&rings).map(|((from_m, to_m), mean)| json!({
            "from_m": from_m, "to_m": to_m, "mean_likelihood": mean,
        })).collect::<Vec<_>>(),
        "local_maxima": facts.num_peaks(),
    });
    let pictures = facts.pictures();
    let heading = pictures.profile((truth.x_m, truth.y_m), &profile);
    report.pictures.push(("discrimination-heading".to_owned(), heading));
    let mut with_truth = facts.pictures();
    with_truth.subtitle = "heading fixed to the true one".to_owned();
    report.pictures.push(("discrimination-true-heading-map".to_owned(), with_truth.heat(&fixed)));
    report.pictures.push(("discrimination-true-heading-surface".to_owned(), with_truth.surface(&fixed)));
    outcome.files.push(("discrimination-heading.csv".to_owned(), profile_csv(&profile)));
    facts.add_to(&mut outcome, "discrimination");
    Ok(outcome)
}

fn meters(value: f64) -> String {
    format!("{value:.2} m")
}
