//! Which pixels do the filters drop, and rightly so? Precision and recall against the simulator's labels. Source of the
//! filters: 2010 section 4.2.

mod counts;
mod measure;
mod tables;

use serde_json::json;

use self::{
    measure::{LEAST_REPORTED, LEAST_VISIBLE_PX, measure},
    tables::{filter_table, object_table, scene_json},
};
use super::StudyOutcome;
use crate::ExperimentError;

pub(super) fn conduct(seed: u64) -> Result<StudyOutcome, ExperimentError> {
    let mut outcome = StudyOutcome::default();
    let mut scenes = Vec::new();
    let mut num_images = 0;
    for name in ["tour", "crowd"] {
        let scene = measure(name, seed)?;
        for kind in 0..2 {
            outcome.report.tables.push(filter_table(&scene, kind));
        }
        outcome.report.tables.push(object_table(&scene));
        num_images += scene.num_images;
        scenes.push(scene_json(&scene));
    }
    outcome.report.heading = format!("Filters of the image analysis, {num_images} images, seed {seed}");
    outcome.report.notes = vec![
        "A pixel is right if it lies within 2 px of the border between its object and what is behind it. Precision: share of the \
         kept pixels that are right. Recall: share of the right pixels before the filters that are kept."
            .to_owned(),
        "Drops, of these wrong: in the chain of all filters, where each judges what the ones before it have left.".to_owned(),
        format!(
            "Found: images with at least {LEAST_VISIBLE_PX} px of the object in which at least {LEAST_REPORTED} right pixels \
             are kept before the random discard. Invented: images without any px of it in which {LEAST_REPORTED} are kept."
        ),
    ];
    outcome.report.json = json!({ "study": "filters", "seed": seed, "scenes": scenes });
    Ok(outcome)
}
