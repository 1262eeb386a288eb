//! What was left out of a run.

use serde::Serialize;
use visloc_core::{SkippedInput, Timestamp};

use crate::say;

/// Origins that are told one by one: of a folder each damaged image is one.
const MAX_SHOWN: usize = 5;

/// Inputs that could not be used, grouped by where they came from.
#[derive(Debug, Clone, Serialize, Default)]
pub struct SkippedReport {
    /// All together.
    pub count: usize,
    /// By origin, in order of their first appearance.
    pub groups: Vec<SkippedGroup>,
}

/// Inputs of one origin.
#[derive(Debug, Clone, Serialize)]
pub struct SkippedGroup {
    /// For instance the topic.
    pub origin: String,
    /// How many.
    pub count: usize,
    /// Stamp of the first, seconds.
    pub first_at_s: Option<f64>,
    /// What was wrong with the first.
    pub first_reason: String,
}

impl SkippedReport {
    /// Counts inputs.
    pub fn new<'a>(inputs: impl IntoIterator<Item = &'a SkippedInput>) -> Self {
        let mut report = Self::default();
        for input in inputs {
            report.count += 1;
            match report.groups.iter_mut().find(|group| group.origin == input.origin) {
                Some(group) => group.count += 1,
                None => report.groups.push(SkippedGroup {
                    origin: input.origin.clone(),
                    count: 1,
                    first_at_s: input.at.map(Timestamp::secs),
                    first_reason: input.reason.clone(),
                }),
            }
        }
        report
    }

    /// One line a group for people, and one for all that are too many.
    pub fn lines(&self) -> Vec<String> {
        self.lines_beside(None)
    }

    /// The same beside an error that is told, too: what that says is not said twice.
    pub fn lines_beside(&self, error: Option<&str>) -> Vec<String> {
        let line = |group: &SkippedGroup| {
            if error.is_some_and(|error| error.ends_with(&group.first_reason)) {
                return format!("left out {} of {}", group.count, group.origin);
            }
            let at = group.first_at_s.map(|secs| format!(" at {secs:.3} s")).unwrap_or_default();
            let (origin, reason) = (&group.origin, say::without_numbers_of_errors(&group.first_reason));
            // A reason that names the place itself does not name it twice.
            let reason = reason.strip_prefix(&format!("{origin}: ")).unwrap_or(&reason);
            say::short(&format!("left out {} of {origin}; the first{at}: {reason}", group.count)).into_owned()
        };
        let (shown, others) = self.groups.split_at(self.groups.len().min(MAX_SHOWN));
        let num_more: usize = others.iter().map(|group| group.count).sum();
        let more = (num_more > 0).then(|| format!("left out {num_more} more, of {} others", others.len()));
        shown.iter().map(line).chain(more).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inputs_are_counted_by_origin() {
        let input = |origin: &str, reason: &str| SkippedInput {
            at: Some(Timestamp::from_secs(2.0)),
            origin: origin.to_owned(),
            reason: reason.to_owned(),
        };
        let report = SkippedReport::new(&[
            input("/odom", "NaN"),
            input("/image", "/image: cut (os error 5)"),
            input("/odom", "old"),
        ]);
        assert_eq!(report.count, 3);
        assert_eq!(
            report.lines(),
            [
                "left out 2 of /odom; the first at 2.000 s: NaN",
                "left out 1 of /image; the first at 2.000 s: cut"
            ]
        );
        let beside = report.lines_beside(Some("a.mcap: no image could be used; the first: NaN"));
        assert_eq!(beside[0], "left out 2 of /odom");
        assert_eq!(beside[1], report.lines()[1]);
        let images: Vec<SkippedInput> = (0..9).map(|i| input(&format!("{i}.jpg"), "cut")).collect();
        let lines = SkippedReport::new(&images).lines();
        assert_eq!((lines.len(), lines[5].as_str()), (6, "left out 4 more, of 4 others"));
    }
}
