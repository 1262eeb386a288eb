//! White goal posts, which no color tells from walls, nets and robots: a bright run on the carpet as wide as a post that stands there,
//! whose two borders go on upright as far as a post is high.

use nalgebra::{Point2, Point3, Vector2};
use visloc_world::field::GoalColor;

use super::{
    posts::WIDTH_RANGE,
    row_profile::{RowProfile, third_of},
    upright_borders::{HEIGHTS, UprightBorders},
    view::{GroundView, Seen},
};
use crate::vision::{
    BorderPixel, GoalPost,
    color::ColorClass,
    field::scan::{Run, ScanLine},
};

/// Up to this height both borders have to be there: mostly it is below the camera, and what is behind is the floor. Meters.
const BOTH_BELOW_M: f64 = 0.3;
/// Up to this height one of them has to be there, where a wall as white as the post may hide the other: legs of robots are lower.
const ONE_BELOW_M: f64 = 0.45;
/// A border changes the brightness by this share of the post's own.
const MIN_CONTRAST: f64 = 0.05;
/// The brightness of a post changes from height to height by at most this share.
const MAX_STEP: f64 = 0.3;
/// Carpet is looked for so far to the sides of a post and so far behind it, meters.
const BESIDE_M: [f64; 3] = [0.1, 0.2, 0.3];
const BEHIND_M: f64 = 0.2;
/// Below a foot carpet comes within this share of the post's width, at least so many pixels.
const MAX_FOOT_GAP: f64 = 0.5;
const MIN_FOOT_GAP_PX: f64 = 3.0;

/// A white run, perhaps across a post.
#[derive(Debug, Clone, Copy)]
struct WhiteRun {
    start: f64,
    end: f64,
    row: f64,
    /// Luma that is white there.
    white: u32,
}

/// A post with what of its borders was seen.
#[derive(Debug, Clone, Copy)]
struct Found {
    post: GoalPost,
    /// Columns and rows that it covers, pixels: left, top, right, bottom.
    bounds_px: [f64; 4],
}

impl Found {
    /// Whether both stand on one foot: seen from one robot no post stands in front of another one's foot.
    fn is_same(&self, other: &Self) -> bool {
        let width_px = other.bounds_px[2] - other.bounds_px[0];
        (self.post.foot_px - other.post.foot_px).norm() < 0.5 * width_px
    }
}

/// Collects white runs from the horizontal scan lines.
#[derive(Debug, Default)]
pub(super) struct WhitePostFinder {
    runs: Vec<WhiteRun>,
    found: Vec<Found>,
    /// Sides of the posts of this image, from the foot up.
    borders: Vec<BorderPixel>,
    profile: RowProfile,
}

/// What is looked for, meters.
pub(super) struct PostSize {
    pub diameter_m: f64,
    /// To the middle of the crossbar.
    pub height_m: f64,
    /// How far away it may stand.
    pub range_m: f64,
}

impl WhitePostFinder {
    pub fn clear(&mut self) {
        self.runs.clear();
    }

    /// Adds the runs of the next horizontal scan line. What the border of the image cuts has no known width.
    pub fn add_row(&mut self, line: &ScanLine, runs: &[Run]) {
        let whole = |run: &&Run| run.class == ColorClass::White && run.start > line.from && run.end < line.to;
        self.runs.extend(runs.iter().filter(whole).map(|run| WhiteRun {
            start: f64::from(run.start),
            end: f64::from(run.end - 1),
            row: f64::from(line.fixed),
            white: run.white_luma,
        }));
    }

    /// The sides of the posts that were found.
    pub fn borders(&self) -> &[BorderPixel] {
        &self.borders
    }

    /// Judges the runs, those nearest to the robot first.
    pub fn finish(&mut self, view: &GroundView, size: &PostSize, out: &mut Vec<GoalPost>) {
        self.found.clear();
        self.borders.clear();
        for run in self.runs.iter().rev() {
            let center = run.center();
            let is_part = |found: &Found| {
                let [left, top, right, bottom] = found.bounds_px;
                (left..=right).contains(&center) && (top..=bottom).contains(&run.row)
            };
            if self.found.iter().any(is_part) {
                continue;
            }
            let Some((found, bar)) = run.post(view, size, &mut self.profile) else { continue };
            if self.found.iter().any(|before| before.is_same(&found)) {
                continue;
            }
            self.found.push(found);
            out.push(found.post);
            bar.add_borders(view, &mut self.borders);
        }
    }
}

impl WhiteRun {
    fn center(&self) -> f64 {
        f64::midpoint(self.start, self.end)
    }

    fn width(&self) -> f64 {
        self.end - self.start + 1.0
    }

    /// The post that this run is a part of.
    fn post(
        &self,
        view: &GroundView,
        size: &PostSize,
        profile: &mut RowProfile,
    ) -> Option<(Found, UprightBorders)> {
        let expected = |raw: &Point2<f64>| {
            let front = view.ground(&view.camera().ideal_px(raw))?;
            let distance_m = (front.coords - view.eye().xy()).norm().hypot(view.eye().z);
            Some((front, view.focal_px() * size.diameter_m / distance_m))
        };
        let fits = |width_px: f64, expected_px: f64| {
            (width_px + 1.0) / expected_px >= WIDTH_RANGE.start
                && (width_px - 1.0) / expected_px < WIDTH_RANGE.end
        };
        // The run may lie above the foot, where the ground that is seen beside it is farther away.
        let (_, farthest_px) = expected(&Point2::new(self.center(), self.row))?;
        if self.width() + 1.0 < WIDTH_RANGE.start * farthest_px {
            return None;
        }
        let foot = self.foot(view);
        let (front, expected_px) = expected(&foot)?;
        if (front.coords - view.eye().xy()).norm() > size.range_m
            || !fits(self.width(), expected_px)
            || !self.stands_on_carpet(view, &foot)
            || !carpet_goes_on(view, &front, size.diameter_m, self.white)
        {
            return None;
        }
        let width = self.width().clamp(0.8 * expected_px, 1.4 * expected_px);
        let bar = self.follow_up(view, (&foot, &front), width, size, profile)?;
        if !fits(bar.width_px, expected_px) {
            return None;
        }
        let foot_px = view.camera().ideal_px(&Point2::new(bar.column_at(foot.y), foot.y));
        let ahead = view.ray(&foot_px).xy().try_normalize(1e-9)?;
        let front = view.ground(&foot_px)?;
        let half = 0.5 * bar.width_px + 2.0;
        let top_row = bar.rows[bar.num - 1];
        let columns = [bar.column_at(foot.y), bar.column_at(top_row)];
        let found = Found {
            post: GoalPost {
                color: GoalColor::White,
                bearing_rad: ahead.y.atan2(ahead.x),
                base_in_robot: Some(front + ahead * (size.diameter_m / 2.0)),
                foot_px,
                side: None,
            },
            bounds_px: [
                columns[0].min(columns[1]) - half,
                top_row,
                columns[0].max(columns[1]) + half,
                foot.y + 2.0,
            ],
        };
        Some((found, bar))
    }

    /// Follows the white down the column of the run's middle.
    fn foot(&self, view: &GroundView) -> Point2<f64> {
        let mut at = Point2::new(self.center(), self.row);
        while view.class_at_raw(&Point2::new(at.x, at.y + 1.0), self.white) == Some(ColorClass::White) {
            at.y += 1.0;
        }
        at.y += 0.5;
        at
    }

    fn stands_on_carpet(&self, view: &GroundView, foot: &Point2<f64>) -> bool {
        let gap = (MAX_FOOT_GAP * self.width()).max(MIN_FOOT_GAP_PX * view.scale);
        let mut below = 1.0;
        while below <= gap {
            let px = view.camera().ideal_px(&Point2::new(foot.x, foot.y + below));
            // Below the image nothing says that it does not stand there, but neither how far away it is.
            match view.at_px(&px, self.white) {
                Seen::Carpet => return true,
                Seen::Nothing => return false,
                _ => below += 1.0,
            }
        }
        false
    }

    /// Looks for both borders in all heights of a post that stands at a place.
    fn follow_up(
        &self,
        view: &GroundView,
        (foot, front): (&Point2<f64>, &Point2<f64>),
        width: f64,
        size: &PostSize,
        profile: &mut RowProfile,
    ) -> Option<UprightBorders> {
        let bottom = view.raw_px_of(&Point3::new(front.x, front.y, 0.0))?;
        // As far as a wall goes on to the side, and a robot's body does not, in widths of the post.
        let wall = BESIDE_M[2] / size.diameter_m;
        let mut off = self.center() - foot.x;
        let mut luma = None;
        let mut bar = UprightBorders::default();
        for i in 0..HEIGHTS {
            let z_m = size.height_m * (i as f64 + 0.5) / HEIGHTS as f64;
            let at = view.raw_px_of(&Point3::new(front.x, front.y, z_m))?;
            let center = foot.x + at.x - bottom.x + off;
            let may_hide = (BOTH_BELOW_M..=ONE_BELOW_M).contains(&z_m);
            let reach = if may_hide { wall + 1.0 } else { 1.2 };
            if !profile.read(view, &Point2::new(center, at.y), reach * width + 2.0) {
                break;
            }
            let inside = profile.mean((center - 0.2 * width).round() as i64, (0.4 * width).ceil() as i64);
            if luma.is_some_and(|before: f64| (inside - before).abs() > MAX_STEP * before) {
                // The thing ends, and is lower than any post.
                if z_m <= ONE_BELOW_M {
                    return None;
                }
                break;
            }
            luma = Some(inside);
            // In front of carpet and floor a post is the brighter one, in front of walls and windows it may be either.
            let is_brighter = z_m <= BOTH_BELOW_M;
            let edges = [-0.5, 0.5].map(|side: f64| {
                let sign = is_brighter.then_some(-side.signum());
                profile.strongest_edge(center + side * width, width, sign, MIN_CONTRAST * inside)
            });
            if let [Some(left), Some(right)] = edges {
                off += 0.3 * (f64::midpoint(left, right) - center);
            }
            bar.borders.iter_mut().zip(edges).for_each(|(border, edge)| border[i] = edge);
            if may_hide {
                bar.is_hidden.iter_mut().zip([-1.0, 1.0]).for_each(|(hidden, side)| {
                    hidden[i] = profile.is_even(
                        center,
                        center + side * wall * width,
                        third_of(width),
                        MIN_CONTRAST * inside,
                    );
                });
            }
            (bar.rows[i], bar.num) = (at.y, i + 1);
            if z_m <= BOTH_BELOW_M {
                bar.num_both = bar.num;
            }
            if z_m <= ONE_BELOW_M {
                bar.num_one = bar.num;
            }
        }
        bar.judge(foot.y, width, view.blur).then_some(bar)
    }
}

/// Whether there is carpet beside and behind a foot: goals stand on it, what is beyond the field stands where it ends.
fn carpet_goes_on(view: &GroundView, front: &Point2<f64>, diameter_m: f64, white: u32) -> bool {
    let Some(ahead) = (front.coords - view.eye().xy()).try_normalize(1e-9) else { return false };
    let across = Vector2::new(-ahead.y, ahead.x);
    BESIDE_M.iter().flat_map(|m| [m + diameter_m / 2.0, -m - diameter_m / 2.0]).any(|beside_m| {
        let px = view.px(&(front + ahead * BEHIND_M + across * beside_m));
        px.is_some_and(|px| view.at_px(&px, white) == Seen::Carpet)
    })
}
