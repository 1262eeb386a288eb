//! Where else could the image have been taken? Source: 2010 figure 4.19 and section 4.4.2.

use serde_json::json;

use super::{
    StudyOutcome,
    facts::{MAP_2010, ViewFacts, pose},
};
use crate::{ExperimentError, Table, likelihood::View, robocup::mirrored};

/// A field on which every place has a mirror image.
const MAP_2024: &str = "robocup-spl-2024";

pub(super) fn conduct(seed: u64) -> Result<StudyOutcome, ExperimentError> {
    let views = [
        ("both-posts", "both posts of a goal", MAP_2010, pose(0.6, 1.3, -30.0), "-"),
        (
            "one-post",
            "one post",
            MAP_2010,
            pose(1.8, -0.2, 40.0),
            "high in several zones, most near the goal",
        ),
        ("lines", "lines only", MAP_2010, pose(-0.5, 0.4, 80.0), "may be high nearly everywhere"),
        ("white-goals", "white goals", MAP_2024, pose(-2.5, 0.8, 165.0), "-"),
    ];
    let title = "Symmetry: places that explain an image almost as well as the true one";
    let mut header = ViewFacts::HEADER.to_vec();
    header.insert(3, "at the mirror image");
    let mut table = Table::new("symmetry", title, &header);
    let (mut outcome, mut rows) = (StudyOutcome::default(), Vec::new());
    for (name, label, map, truth, document) in views {
        let facts = ViewFacts::new(&format!("Symmetry: {label}"), &View::new(map, truth), seed)?;
        let at_mirror = facts.eye.model().likelihood(&mirrored(&truth));
        let mut row = facts.row(document).to_vec();
        row.insert(3, format!("{at_mirror:.3}"));
        table.push(row);
        rows.push(json!({ "facts": facts.json(), "likelihood_at_mirror_image": at_mirror }));
        facts.add_to(&mut outcome, &format!("symmetry-{name}"));
    }
    outcome.report.heading = format!("Symmetry, seed {seed}");
    outcome.report.tables.push(table);
    outcome.report.notes.push(
        "Peaks and area: places that reach 95 % of the maximum with their best heading; peaks at least 0.4 m apart.".to_owned(),
    );
    outcome.report.json = json!({ "study": "symmetry", "seed": seed, "views": rows });
    Ok(outcome)
}
