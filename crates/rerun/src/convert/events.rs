//! What happened.

use visloc_studio::recording::{AnnotationKind, Row, annotate};

use super::Moment;
use crate::{Entry, Shape, entry::Mood};

/// Kidnaps, losses, finds and jumps of a whole run, each with its moment.
pub(super) fn entries(moments: &[Moment], rows: &[Row]) -> Vec<(Moment, Entry)> {
    let all = annotate(rows).into_iter().filter_map(|annotation| {
        let mood = match annotation.kind {
            AnnotationKind::Found => Mood::Good,
            AnnotationKind::Lost | AnnotationKind::Jump => Mood::Bad,
            AnnotationKind::Kidnap => Mood::Neutral,
        };
        let moment = *moments.get(annotation.frame)?;
        Some((moment, Entry::now("events", Shape::Event { text: annotation.text, mood })))
    });
    all.collect()
}
