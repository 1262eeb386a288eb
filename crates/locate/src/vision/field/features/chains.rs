//! Crossings of neighboring scan lines that continue each other: pieces of lines.

use super::{crossings::Crossing, view::GroundView};
use crate::vision::line_fit::LineFit;

/// Farthest scan line on which a chain goes on, pixels of an image 320 px wide.
const MAX_GAP_PX: f64 = 17.0;
/// Farthest from the first to the second crossing of a chain, meters.
const MAX_FIRST_STEP_M: f64 = 0.8;
/// How far a crossing may lie from the line of the chain, pixels.
const MAX_OFF_PX: f64 = 0.9;
/// The same for each length of the chain that the crossing lies beyond its end, pixels; at most two lengths count.
const MAX_OFF_AHEAD_PX: f64 = 0.5;

/// Crossings of one direction of scan lines, one on each scan line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chain {
    pub fit: LineFit,
    pub num: usize,
    pub first: usize,
    pub last: usize,
}

#[derive(Debug, Default)]
pub(super) struct Chains {
    pub all: Vec<Chain>,
    /// For each crossing the one before it in its chain.
    pub before: Vec<Option<usize>>,
}

impl Chains {
    /// Joins crossings, which come in the order of the scan lines.
    pub fn build(&mut self, crossings: &[Crossing], view: &GroundView, line_width_m: f64) {
        self.all.clear();
        self.before.clear();
        let max_gap_px = MAX_GAP_PX * view.scan_scale;
        let mut first_open = 0;
        for (i, crossing) in crossings.iter().enumerate() {
            let is_open = |chain: &Chain| {
                let last = &crossings[chain.last];
                last.direction == crossing.direction && crossing.line_px - last.line_px <= max_gap_px
            };
            while first_open < self.all.len() && !is_open(&self.all[first_open]) {
                first_open += 1;
            }
            let mut best: Option<(f64, usize)> = None;
            for (c, chain) in self.all.iter().enumerate().skip(first_open).filter(|(_, c)| is_open(c)) {
                if let Some(off) =
                    off_chain(crossings, chain, crossing, line_width_m, (view.scale, view.blur))
                    && best.is_none_or(|best| off < best.0)
                {
                    best = Some((off, c));
                }
            }
            if let Some((_, c)) = best {
                let chain = &mut self.all[c];
                self.before.push(Some(chain.last));
                chain.fit.add(&crossing.px);
                chain.num += 1;
                chain.last = i;
            } else {
                let mut fit = LineFit::default();
                fit.add(&crossing.px);
                self.before.push(None);
                self.all.push(Chain { fit, num: 1, first: i, last: i });
            }
        }
    }
}

/// How badly a crossing continues a chain; `None` if it does not.
fn off_chain(
    crossings: &[Crossing],
    chain: &Chain,
    next: &Crossing,
    line_width_m: f64,
    (scale, blur): (f64, f64),
) -> Option<f64> {
    let (first, last) = (&crossings[chain.first], &crossings[chain.last]);
    if next.line_px <= last.line_px {
        return None;
    }
    let step_px = (next.px - last.px).norm();
    let off = if chain.num == 1 {
        if (next.ground - last.ground).norm() > MAX_FIRST_STEP_M {
            return None;
        }
        // Of several the nearest.
        1.0 + step_px / 100.0
    } else {
        let line = chain.fit.line();
        let length_px = (last.px - first.px).norm();
        let ahead = (step_px / length_px.max(1.0)).min(2.0);
        let off = line.distance(&next.px) / scale;
        if off > MAX_OFF_PX + MAX_OFF_AHEAD_PX * ahead {
            return None;
        }
        off
    };
    let (along, along_px) = (next.ground - first.ground, (next.px - first.px).norm());
    let fits = next.fits_width(&along, along_px / blur, (line_width_m, blur))
        && (chain.num > 1 || last.fits_width(&along, along_px / blur, (line_width_m, blur)));
    fits.then_some(off)
}
