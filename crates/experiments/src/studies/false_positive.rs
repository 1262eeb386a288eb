//! What if something looks like a goal post? Source: 2010 figure 4.21 and section 4.4.4.

use serde_json::json;

use super::{
    StudyOutcome,
    facts::{MAP_2010, ViewFacts, pose},
};
use crate::{ExperimentError, Table, likelihood::View};

pub(super) fn conduct(seed: u64) -> Result<StudyOutcome, ExperimentError> {
    let goal = View::new(MAP_2010, pose(0.9, 0.0, 0.0));
    let with_post = View { false_posts_m: vec![[2.3, -0.2]], ..goal.clone() };
    let lines = View::new(MAP_2010, pose(-0.5, 0.4, 80.0));
    let lines_with_post = View { false_posts_m: vec![[-0.4, 1.5]], ..lines.clone() };
    let carpet = View { tilt_deg: 40.0, ..View::new(MAP_2010, pose(1.2, 0.9, 150.0)) };
    let carpet_with_post = View { false_posts_m: vec![[0.72, 1.18]], ..carpet.clone() };
    let views = [
        ("goal", "a goal", goal, "highest 1 to 2 m before the goal"),
        ("goal-and-post", "a goal and a false post", with_post, "changes altogether, low near the goal"),
        ("lines", "lines only", lines, "-"),
        ("lines-and-post", "lines and a false post", lines_with_post, "-"),
        ("carpet", "carpet only", carpet, "left out"),
        ("carpet-and-post", "carpet and a false post", carpet_with_post, "unpredictable, even 0 everywhere"),
    ];
    let title = "False positives: a yellow pillar that is no goal post";
    let mut table = Table::new("false-positive", title, &ViewFacts::HEADER);
    let (mut outcome, mut rows) = (StudyOutcome::default(), Vec::new());
    for (name, label, view, document) in views {
        let facts = ViewFacts::new(&format!("False positive: {label}"), &view, seed)?;
        rows.push(facts.json());
        if facts.eye.model().has_evidence() {
            table.push(facts.row(document));
            facts.add_to(&mut outcome, &format!("false-positive-{name}"));
        } else {
            let nothing = ["0 + 0", "-", "-", "-", "-", "-"].map(str::to_owned);
            let cells = [facts.label.clone()].into_iter().chain(nothing);
            table.push(cells.chain([format!("{document} | left out")]));
        }
    }
    outcome.report.heading = format!("False positives, seed {seed}");
    outcome.report.tables.push(table);
    outcome.report.notes.push(
        "A false post makes wrong places better than the true one, as the document says: a single image is not to be trusted, and \
         the filters cannot tell a pillar of the right color and size from a post. The likelihood never becomes 0 everywhere, \
         because the distance of each pixel is capped before the mean is taken."
            .to_owned(),
    );
    outcome.report.json = json!({ "study": "false-positive", "seed": seed, "views": rows });
    Ok(outcome)
}
