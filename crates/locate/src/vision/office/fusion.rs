//! Joins edges that are pieces of one line.

use super::{EdgeSegment, Labelled};

/// Directions of one line differ by less than this: sine of 5 degrees.
const MAX_TURN_SIN: f64 = 0.087;
/// Ends of one piece lie this near to the other piece's line, pixels.
const MAX_OFF_PX: f64 = 2.0;

/// Joins edges of one kind that lie on one line with at most a small gap between them, until none is left to join.
pub(super) fn fuse(lines: &mut Vec<Labelled>, max_gap_px: f64) {
    let mut i = 0;
    while i < lines.len() {
        let partner = (i + 1..lines.len()).find(|j| {
            lines[i].kind == lines[*j].kind
                && lines[i].kind.is_some()
                && is_one_line(&lines[i].segment, &lines[*j].segment, max_gap_px)
        });
        match partner {
            Some(j) => {
                let other = lines.swap_remove(j);
                lines[i].segment = lines[i].segment.joined(&other.segment);
            }
            None => i += 1,
        }
    }
}

fn is_one_line(a: &EdgeSegment, b: &EdgeSegment, max_gap_px: f64) -> bool {
    let (long, short) = if a.length_px() >= b.length_px() { (a, b) } else { (b, a) };
    let along = long.direction();
    if along.perp(&short.direction()).abs() > MAX_TURN_SIN {
        return false;
    }
    if long.offset_px(&short.start) > MAX_OFF_PX || long.offset_px(&short.end) > MAX_OFF_PX {
        return false;
    }
    let place = |point: &nalgebra::Point2<f64>| (point - long.start).dot(&along);
    let (from, to) = {
        let (s, e) = (place(&short.start), place(&short.end));
        (s.min(e), s.max(e))
    };
    from - long.length_px() <= max_gap_px && -to <= max_gap_px
}
