//! What happened in a recording, found by itself.

use serde::Serialize;

use super::timeline::{Lane, Row};

/// A carry that ends nearer than this to its start is no kidnap, meters.
const KIDNAP_M: f64 = 0.5;
/// An estimate that moves farther than this from one frame to the next jumps, meters.
const JUMP_M: f64 = 0.5;
/// What is lost for less than this is not worth a word, seconds.
const LOST_SECS: f64 = 0.3;

/// What kind of thing happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AnnotationKind {
    /// Somebody carried the robot away.
    Kidnap,
    /// An algorithm no longer knows the place.
    Lost,
    /// It knows the place again, or for the first time.
    Found,
    /// Its estimate jumps although it claims to know the place.
    Jump,
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Annotation {
    /// What.
    pub kind: AnnotationKind,
    /// Number of the frame, from 0.
    pub frame: usize,
    /// When, since the first frame.
    pub secs: f64,
    /// Number of the algorithm, from 0, if it is about one.
    pub lane: Option<usize>,
    /// For people.
    pub text: String,
}

/// Everything that happened, in order.
pub fn annotate(rows: &[Row]) -> Vec<Annotation> {
    let mut all = kidnaps(rows);
    let num_lanes = rows.iter().map(|row| row.lanes.len()).max().unwrap_or(0);
    for lane in 0..num_lanes {
        all.extend(changes(rows, Some(lane), |row| {
            row.lanes.get(lane).is_some_and(|lane| lane.is_localized)
        }));
        all.extend(jumps(rows, lane));
    }
    if num_lanes == 0 {
        all.extend(changes(rows, None, |row| !row.is_lost));
    }
    all.sort_by_key(|annotation| annotation.frame);
    all
}

fn kidnaps(rows: &[Row]) -> Vec<Annotation> {
    let mut found = Vec::new();
    let mut start: Option<(usize, [f64; 3])> = None;
    for (frame, row) in rows.iter().enumerate() {
        match (row.is_carried, start, row.truth) {
            (true, None, Some(_)) => {
                let before = frame.checked_sub(1).and_then(|before| rows[before].truth);
                start = before.or(row.truth).map(|truth| (frame, truth));
            }
            (false, Some((from, place)), Some(truth)) => {
                let way_m = (truth[0] - place[0]).hypot(truth[1] - place[1]);
                if way_m > KIDNAP_M {
                    found.push(annotation(
                        AnnotationKind::Kidnap,
                        rows,
                        from,
                        None,
                        format!("kidnap, {way_m:.1} m"),
                    ));
                }
                start = None;
            }
            _ => {}
        }
    }
    found
}

/// Where knowledge comes and goes; what lasts for a moment only is left out.
fn changes(rows: &[Row], lane: Option<usize>, is_known: impl Fn(&Row) -> bool) -> Vec<Annotation> {
    let mut found: Vec<Annotation> = Vec::new();
    let mut was_known = lane.is_none();
    for (frame, row) in rows.iter().enumerate() {
        let is_known = is_known(row);
        if is_known == was_known {
            continue;
        }
        was_known = is_known;
        let name = lane.and_then(|lane| row.lanes.get(lane)).map_or("camera", |lane| lane.name.as_str());
        let (kind, word) = match is_known {
            true => (AnnotationKind::Found, "knows the place"),
            false => (AnnotationKind::Lost, "is lost"),
        };
        let is_brief = found.last().is_some_and(|last| {
            last.kind == AnnotationKind::Lost && is_known && row.secs - last.secs < LOST_SECS
        });
        if is_brief {
            found.pop();
        } else {
            found.push(annotation(kind, rows, frame, lane, format!("{name} {word}")));
        }
    }
    found
}

fn jumps(rows: &[Row], lane: usize) -> Vec<Annotation> {
    let mut found = Vec::new();
    let mut last: Option<&Lane> = None;
    for (frame, row) in rows.iter().enumerate() {
        let now = row.lanes.get(lane);
        if let (Some(before), Some(now)) = (last, now)
            && before.is_localized
            && now.is_localized
        {
            let way_m = (now.pose[0] - before.pose[0]).hypot(now.pose[1] - before.pose[1]);
            if way_m > JUMP_M {
                let text = format!("{} jumps {way_m:.1} m", now.name);
                found.push(annotation(AnnotationKind::Jump, rows, frame, Some(lane), text));
            }
        }
        last = now;
    }
    found
}

fn annotation(
    kind: AnnotationKind,
    rows: &[Row],
    frame: usize,
    lane: Option<usize>,
    text: String,
) -> Annotation {
    Annotation { kind, frame, secs: rows[frame].secs, lane, text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(i: usize, x: f64, is_carried: bool, is_localized: bool) -> Row {
        let lane = Lane { name: "mc".to_owned(), pose: [x, 0.0, 0.0], is_localized, ..Lane::default() };
        let truth = Some([x, 0.0, 0.0]);
        Row { secs: i as f64 * 0.1, is_carried, truth, lanes: vec![lane], ..Row::default() }
    }

    #[test]
    fn a_kidnap_a_loss_and_the_way_back_are_found() {
        let rows: Vec<Row> = (0..60)
            .map(|i| match i {
                0..10 => row(i, 0.0, false, i > 3),
                10..20 => row(i, 0.3 * (i - 9) as f64, true, false),
                20..40 => row(i, 3.0, false, false),
                _ => row(i, 3.0, false, true),
            })
            .collect();
        let all: Vec<(AnnotationKind, usize)> = annotate(&rows).iter().map(|a| (a.kind, a.frame)).collect();
        use AnnotationKind::{Found, Kidnap, Lost};
        assert_eq!(all, [(Found, 4), (Kidnap, 10), (Lost, 10), (Found, 40)]);
    }

    #[test]
    fn a_jump_is_told_and_a_short_doubt_or_a_lift_is_not() {
        let mut rows: Vec<Row> =
            (0..30).map(|i| row(i, if i < 20 { 0.0 } else { 2.0 }, false, i != 7)).collect();
        rows[12].is_carried = true;
        let all: Vec<_> = annotate(&rows).iter().map(|a| (a.kind, a.frame)).collect();
        assert_eq!(all, [(AnnotationKind::Found, 0), (AnnotationKind::Jump, 20)]);
    }
}
