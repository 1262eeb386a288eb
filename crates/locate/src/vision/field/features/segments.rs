//! Straight lines: chains that lie on one line, checked against the image.

use nalgebra::Point2;

use super::{
    chains::{Chain, Chains},
    crossings::Crossing,
    view::{GroundView, Seen},
};
use crate::vision::{
    LineSegment,
    line_fit::{ImageLine, LineFit},
};

/// Fewest crossings of a line.
const MIN_CROSSINGS: usize = 4;
/// Shortest line, meters and pixels.
const MIN_LENGTH_M: f64 = 0.2;
const MIN_LENGTH_PX: f64 = 12.0;
/// Two pieces are one line if their ends are this near to it, and it fits this well, pixels.
const MAX_JOIN_OFF_PX: f64 = 1.8;
const MAX_RMS_PX: f64 = 0.9;
const MAX_FINAL_RMS_PX: f64 = 0.45;
/// Widest gap between two pieces of a line, meters.
const MAX_GAP_M: f64 = 2.0;
/// Share of carpet from which a gap is a gap in the line, and not something that stands before it.
const MAX_CARPET_IN_GAP: f64 = 0.3;
/// Shares of the samples that must be white on the line and carpet on each side.
const MIN_WHITE: f64 = 0.75;
const MIN_CARPET: f64 = 0.5;
/// How far an end is followed beyond the last crossing, pixels.
const MAX_EXTENSION_PX: f64 = 40.0;

/// A line in the making.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    pub fit: LineFit,
    pub line: ImageLine,
    /// Positions of the ends along the line, pixels.
    pub from: f64,
    pub to: f64,
    pub num_crossings: usize,
    /// Luma that is white here.
    pub white: u32,
    pub ends_in_robot: [Point2<f64>; 2],
}

impl Segment {
    fn new(chain: &Chain, crossings: &[Crossing]) -> Self {
        let line = chain.fit.line();
        let [a, b] = [chain.first, chain.last].map(|i| line.position(&crossings[i].px));
        Self {
            fit: chain.fit,
            line,
            from: a.min(b),
            to: a.max(b),
            num_crossings: chain.num,
            white: crossings[chain.first].white,
            ends_in_robot: [crossings[chain.first].ground, crossings[chain.last].ground],
        }
    }

    pub fn ends_px(&self) -> [Point2<f64>; 2] {
        [self.line.at(self.from), self.line.at(self.to)]
    }

    pub fn length_px(&self) -> f64 {
        self.to - self.from
    }

    pub fn length_m(&self) -> f64 {
        (self.ends_in_robot[1] - self.ends_in_robot[0]).norm()
    }

    pub fn perceived(&self) -> LineSegment {
        LineSegment {
            ends_in_robot: self.ends_in_robot,
            ends_px: self.ends_px(),
            num_crossings: self.num_crossings,
        }
    }

    /// Both as one line, if they lie on one and nothing but an obstacle is between them.
    fn joined(&self, other: &Self, view: &GroundView) -> Option<Self> {
        let fit = self.fit.joined(&other.fit);
        let line = fit.line();
        let off = MAX_JOIN_OFF_PX * view.scale;
        let is_on_line = |p: &Point2<f64>| line.distance(p) < off;
        if line.rms_px > MAX_RMS_PX * view.scale
            || !self.ends_px().iter().chain(&other.ends_px()).all(is_on_line)
        {
            return None;
        }
        let range = |s: &Self| {
            let [a, b] = s.ends_px().map(|p| line.position(&p));
            (a.min(b), a.max(b))
        };
        let (a, b) = (range(self), range(other));
        let gap = (a.1.min(b.1), a.0.max(b.0));
        if gap.1 - gap.0 > 2.0 * view.scale && !is_bridged(&line, gap, self.white, view) {
            return None;
        }
        Some(Self {
            fit,
            line,
            from: a.0.min(b.0),
            to: a.1.max(b.1),
            num_crossings: self.num_crossings + other.num_crossings,
            ..*self
        })
    }

    /// Follows the white beyond both ends, and finds the ends on the ground.
    fn extend(&mut self, view: &GroundView) -> Option<()> {
        self.from -= white_length(&self.line, self.from, -1.0, self.white, view);
        self.to += white_length(&self.line, self.to, 1.0, self.white, view);
        let [a, b] = self.ends_px().map(|px| view.ground(&px));
        self.ends_in_robot = [a?, b?];
        Some(())
    }

    /// White along the middle and carpet along both sides.
    fn is_line(&self, view: &GroundView, line_width_m: f64) -> bool {
        let across = self.line.across();
        let along_m = (self.ends_in_robot[1] - self.ends_in_robot[0]).normalize();
        let side_m = nalgebra::Vector2::new(-along_m.y, along_m.x);
        let count = (self.length_px() / (5.0 * view.blur)).clamp(6.0, 20.0);
        let (mut white, mut carpet, mut seen) = (0.0, [0.0; 2], [1e-9; 2]);
        let mut i = 0.5;
        while i < count {
            let px = self.line.at(self.from + self.length_px() * i / count);
            i += 1.0;
            let is_white = |off: f64| view.at_px(&(px + across * off), self.white) == Seen::White;
            white += f64::from(u8::from(is_white(0.0) || is_white(view.blur) || is_white(-view.blur)));
            let Some(ground) = view.ground(&px) else { continue };
            let beside = line_width_m + 2.0 * view.scale * view.meters_per_px(&ground, &side_m);
            for (k, sign) in [1.0, -1.0].into_iter().enumerate() {
                let Some(px) = view.px(&(ground + side_m * beside * sign)) else { continue };
                let Some(is_carpet) = view.is_carpet(&px) else { continue };
                carpet[k] += f64::from(u8::from(is_carpet));
                seen[k] += 1.0;
            }
        }
        white >= MIN_WHITE * count && (0..2).all(|k| carpet[k] >= MIN_CARPET * seen[k] - 1e-9)
    }
}

/// Collects the lines of an image, the longest in the image first.
pub(super) fn find(
    chains: &Chains,
    crossings: &[Crossing],
    view: &GroundView,
    line_width_m: f64,
    out: &mut Vec<Segment>,
) {
    out.clear();
    out.extend(chains.all.iter().filter(|chain| chain.num >= 3).map(|chain| Segment::new(chain, crossings)));
    sort(out);
    let mut kept = 0;
    for i in 0..out.len() {
        let next = out[i];
        let joined = (0..kept).find_map(|k| Some((k, out[k].joined(&next, view)?)));
        match joined {
            Some((k, joined)) => out[k] = joined,
            None => {
                out[kept] = next;
                kept += 1;
            }
        }
    }
    out.truncate(kept);
    out.retain_mut(|segment| {
        segment.num_crossings >= MIN_CROSSINGS
            && segment.line.rms_px < MAX_FINAL_RMS_PX * view.scale
            && segment.extend(view).is_some()
            && segment.length_px() >= MIN_LENGTH_PX * view.scale
            && segment.length_m() >= MIN_LENGTH_M
            && segment.is_line(view, line_width_m)
    });
    sort(out);
}

fn sort(segments: &mut [Segment]) {
    segments.sort_unstable_by(|a, b| b.length_px().total_cmp(&a.length_px()));
}

/// How far it is white from a position on, pixels.
fn white_length(line: &ImageLine, from: f64, sign: f64, white: u32, view: &GroundView) -> f64 {
    let across = line.across();
    let mut length = 0.0;
    while length < MAX_EXTENSION_PX * view.scale {
        let px = line.at(from + sign * (length + 1.0));
        let is_white = |off: f64| view.at_px(&(px + across * off), white) == Seen::White;
        if !(is_white(0.0) || is_white(view.blur) || is_white(-view.blur)) {
            break;
        }
        length += 1.0;
    }
    length
}

/// Whether little carpet shows in a gap of a line.
fn is_bridged(line: &ImageLine, gap: (f64, f64), white: u32, view: &GroundView) -> bool {
    let [a, b] = [gap.0, gap.1].map(|t| view.ground(&line.at(t)));
    if a.zip(b).is_none_or(|(a, b)| (b - a).norm() > MAX_GAP_M) {
        return false;
    }
    let (count, mut carpet) = (8.0, 0.0);
    let across = line.across();
    let mut i = 0.5;
    while i < count {
        let px = line.at(gap.0 + (gap.1 - gap.0) * i / count);
        let is = |off: f64, seen| view.at_px(&(px + across * off), white) == seen;
        let is_white = is(view.blur, Seen::White) || is(-view.blur, Seen::White);
        carpet += f64::from(u8::from(is(0.0, Seen::Carpet) && !is_white));
        i += 1.0;
    }
    carpet <= MAX_CARPET_IN_GAP * count
}
