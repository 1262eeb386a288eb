//! What is counted.

use visloc_locate::vision::{DropReason, FeatureKind, field::FilterSwitches};

/// A filter: its name, its switch, the reason that it gives, and the kinds of pixels that it judges.
pub(super) struct Filter {
    pub name: &'static str,
    pub switch: fn(&mut FilterSwitches) -> &mut bool,
    pub reason: DropReason,
    pub for_lines: bool,
    pub for_goals: bool,
}

const fn filter(
    name: &'static str,
    switch: fn(&mut FilterSwitches) -> &mut bool,
    reason: DropReason,
    (for_lines, for_goals): (bool, bool),
) -> Filter {
    Filter { name, switch, reason, for_lines, for_goals }
}

pub(super) const FILTERS: [Filter; 9] = [
    filter("beside carpet", |s| &mut s.beside_carpet, DropReason::NotBesideCarpet, (true, false)),
    filter("post or bar", |s| &mut s.post_or_bar, DropReason::NotPostOrBar, (false, true)),
    filter("isolated", |s| &mut s.isolated, DropReason::Isolated, (true, true)),
    filter("too thin", |s| &mut s.too_thin, DropReason::TooThin, (true, false)),
    filter("horizon", |s| &mut s.horizon, DropReason::BeyondHorizon, (true, false)),
    filter("own body", |s| &mut s.own_body, DropReason::OwnBody, (true, true)),
    filter("end of field", |s| &mut s.field_end, DropReason::BeyondFieldEnd, (true, false)),
    filter("goal blobs", |s| &mut s.goal_blobs, DropReason::NotInGoalBlob, (false, true)),
    filter("obstacles", |s| &mut s.obstacles, DropReason::InObstacle, (true, false)),
];

/// Kept pixels of one kind under one setting of the switches.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Kept {
    pub right: u64,
    pub wrong: u64,
}

impl Kept {
    pub fn count(&mut self, is_right: bool) {
        if is_right { self.right += 1 } else { self.wrong += 1 }
    }

    pub fn precision(self) -> Option<f64> {
        let all = self.right + self.wrong;
        (all > 0).then(|| self.right as f64 / all as f64)
    }

    /// Share of the right pixels before the filters that are still there.
    pub fn recall(self, before: Self) -> Option<f64> {
        (before.right > 0).then(|| self.right as f64 / before.right as f64)
    }
}

/// Lines, then goals.
pub(super) type ByKind<T> = [T; 2];

/// Whether an object is in the image and whether it is reported.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Found {
    pub visible: u64,
    pub found: u64,
    pub absent: u64,
    pub invented: u64,
}

/// All counts of a scene. `alone` and so on have an entry for each filter.
pub(super) struct SceneResult {
    pub name: &'static str,
    pub num_images: usize,
    pub none: ByKind<Kept>,
    pub alone: Vec<ByKind<Kept>>,
    pub without: Vec<ByKind<Kept>>,
    pub dropped: Vec<ByKind<Kept>>,
    pub chain: ByKind<Kept>,
    pub few: ByKind<Kept>,
    pub objects: [Found; 3],
}

/// The objects that are reported.
pub(super) const KINDS: [(FeatureKind, &str); 3] = [
    (FeatureKind::FieldLine, "lines"),
    (FeatureKind::YellowGoal, "yellow goal"),
    (FeatureKind::BlueGoal, "blue goal"),
];
