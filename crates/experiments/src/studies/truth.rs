//! Which feature pixels are right, by the labels of the simulator.

use nalgebra::Point2;
use visloc_locate::vision::FeatureKind;
use visloc_sim::{Label, LabelImage};

/// How far from a pixel its border may be, pixels: sub-pixel positions, blur, and the mixing of colors at borders.
const REACH_PX: i64 = 2;

/// Whether a pixel lies on the border of what it is said to be part of: for a line, where line and carpet meet; for a
/// goal, where a post or the crossbar of its color meets something behind it. A border that something in front makes is
/// not the object's own.
pub(super) fn is_true(labels: &LabelImage, kind: FeatureKind, px: &Point2<f64>) -> bool {
    let (mut has_object, mut has_background) = (false, false);
    let (x, y) = (px.x.round() as i64, px.y.round() as i64);
    for dy in -REACH_PX..=REACH_PX {
        for dx in -REACH_PX..=REACH_PX {
            let Some(label) = labels.get(x + dx, y + dy) else { continue };
            has_object |= is_object(kind, label);
            has_background |= is_background(kind, label);
        }
    }
    has_object && has_background
}

/// Whether a label is that of the object.
pub(super) fn is_object(kind: FeatureKind, label: Label) -> bool {
    match kind {
        FeatureKind::FieldLine => label == Label::Line,
        FeatureKind::YellowGoal => label == Label::YellowGoal,
        FeatureKind::BlueGoal => label == Label::BlueGoal,
        FeatureKind::WhiteGoal => label == Label::WhiteGoal,
        _ => false,
    }
}

fn is_background(kind: FeatureKind, label: Label) -> bool {
    match kind {
        FeatureKind::FieldLine => label == Label::Carpet,
        _ => matches!(label, Label::Carpet | Label::Line | Label::Other | Label::GoalBack),
    }
}
