//! What if other robots hide a part? Source: 2010 figure 4.20.

use serde_json::json;

use super::{
    StudyOutcome,
    facts::{MAP_2010, ViewFacts, pose},
};
use crate::{ExperimentError, Table, likelihood::View};

pub(super) fn conduct(seed: u64) -> Result<StudyOutcome, ExperimentError> {
    let free = View::new(MAP_2010, pose(0.9, 0.0, 0.0));
    let hidden = View { robots: vec![pose(2.0, 0.42, 200.0), pose(2.4, -0.1, 170.0)], ..free.clone() };
    let views = [
        ("free", "nothing in the way", free, "highest 1 to 2 m before the goal"),
        ("hidden", "two robots in the way", hidden, "the same zones, but larger; symmetric ones rise"),
    ];
    let title = "Occlusion: two robots before the goal; what is not seen is not punished";
    let mut table = Table::new("occlusion", title, &ViewFacts::HEADER);
    let (mut outcome, mut rows) = (StudyOutcome::default(), Vec::new());
    for (name, label, view, document) in views {
        let facts = ViewFacts::new(&format!("Occlusion: {label}"), &view, seed)?;
        table.push(facts.row(document));
        rows.push(facts.json());
        facts.add_to(&mut outcome, &format!("occlusion-{name}"));
    }
    outcome.report.heading = format!("Occlusion, seed {seed}");
    outcome.report.tables.push(table);
    outcome.report.json = json!({ "study": "occlusion", "seed": seed, "views": rows });
    Ok(outcome)
}
