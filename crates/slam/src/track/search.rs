//! Which landmarks of the local map are looked for in an image.

use std::cmp::Reverse;

use rand::seq::SliceRandom;

use super::{Feature, FrameWork, LocalMap, Matcher, depth_spread, focal_px};
use crate::{
    config::TrackingConfig,
    feature::CornerGrid,
    map::{LandmarkId, Map},
};

/// Matches after which a search that looks around its places ends.
const WIDE_MATCHES: usize = 50;
/// Share of the places where something is found around a pose that is about right, at least; and around a wrong one, at most.
pub(crate) const FOUND_AT_RIGHT: f64 = 0.15;
const FOUND_BY_CHANCE: f64 = 0.03;
/// Share of the right poses that a hasty search gives up.
const MOST_GIVEN_UP: f64 = 0.02;
/// Landmarks that are tried in one cell.
const TRIED_IN_CELL: usize = 4;
/// A candidate whose place in the image is known worse than this is not looked for: half of the length that it can lie on, pixels.
const SHARP_PX: f64 = 4.0;

/// What a search over the local map found.
#[derive(Debug, Default)]
pub struct Search {
    /// Landmarks that were found.
    pub features: Vec<Feature>,
    /// Landmarks that were looked for.
    pub tried: Vec<LandmarkId>,
    /// Places of the image that were searched.
    pub num_searched: usize,
    /// Of these, places of landmarks of a fixed map.
    pub num_fixed_searched: usize,
    radius: usize,
}

/// A landmark in the cell of the image where it is expected.
struct Expected {
    cell: usize,
    /// How often it was found, less twice how often it was missed.
    merit: u32,
    id: LandmarkId,
}

impl Search {
    /// At most one landmark for each cell, those found most often first; candidates where converged ones are few, beside a fixed map
    /// fewer than a pose needs. With a `radius` above 0, all pixels (of the level) within it are searched.
    pub fn run(
        map: &Map,
        matcher: &Matcher<'_>,
        local_map: &LocalMap,
        (config, radius): (&TrackingConfig, usize),
        work: &mut FrameWork<'_>,
    ) -> Self {
        let mut grid = CornerGrid::new(matcher.camera.size_px(), config.cell_px);
        let (mut expected, mut candidates) = (Vec::new(), Vec::new());
        for id in &local_map.landmarks {
            let landmark = map.landmark(*id);
            let Some(px) = matcher.project(&landmark.point_in_world) else { continue };
            let cell = grid.cell(&px);
            if landmark.is_converged() {
                let merit = landmark.num_found.saturating_sub(2 * landmark.num_missed);
                expected.push(Expected { cell, merit, id: *id });
            } else {
                candidates.push((*id, cell));
            }
        }
        expected.sort_unstable_by_key(|e| (e.cell, Reverse(e.merit), e.id));
        let mut cells: Vec<&[Expected]> = expected.chunk_by(|a, b| a.cell == b.cell).collect();
        cells.shuffle(work.rng);
        work.timer.end("projection");
        let mut search = Self { radius, ..Self::default() };
        search.find_expected(map, matcher, &cells, &mut grid, config.max_matches);
        // Depths of candidates are guessed. A map that grows has no length of its own that they could bend; a fixed one has.
        let is_known = map.has_fixed() && search.features.len() >= config.min_matches;
        let wanted = if radius > 0 || is_known { 0 } else { config.max_matches / 2 };
        search.find_candidates(map, matcher, &candidates, &mut grid, wanted);
        work.timer.end("matching");
        search
    }

    /// Whether so little was found that the pose is wrong. Source: Wald, "Sequential analysis", 1947.
    fn is_clearly_wrong(&self) -> bool {
        let num_found = self.features.len() as f64;
        let num_missed = self.num_searched as f64 - num_found;
        let by_found = (FOUND_AT_RIGHT / FOUND_BY_CHANCE).ln();
        let by_missed = ((1.0 - FOUND_AT_RIGHT) / (1.0 - FOUND_BY_CHANCE)).ln();
        num_found * by_found + num_missed * by_missed < MOST_GIVEN_UP.ln()
    }

    fn find_expected(
        &mut self,
        map: &Map,
        matcher: &Matcher<'_>,
        cells: &[&[Expected]],
        grid: &mut CornerGrid,
        max_matches: usize,
    ) {
        // Looking around is dear, and a few dozen matches are enough to go on from.
        let is_wide = self.radius > 0;
        let most = if is_wide { WIDE_MATCHES.min(max_matches) } else { max_matches };
        for in_cell in cells {
            let is_enough = self.features.len() >= most || (is_wide && self.num_searched >= 3 * WIDE_MATCHES);
            if is_enough || (matcher.seen_by.is_some() && self.is_clearly_wrong()) {
                break;
            }
            self.num_searched += 1;
            self.num_fixed_searched +=
                usize::from(in_cell.iter().take(TRIED_IN_CELL).any(|e| map.is_fixed_landmark(e.id)));
            for expected in in_cell.iter().take(TRIED_IN_CELL) {
                if self.try_landmark(map, matcher, expected.id) {
                    grid.take(expected.cell);
                    break;
                }
            }
        }
    }

    /// Looks for candidates in the cells that are free, until there are as many matches as wanted.
    fn find_candidates(
        &mut self,
        map: &Map,
        matcher: &Matcher<'_>,
        candidates: &[(LandmarkId, usize)],
        grid: &mut CornerGrid,
        wanted: usize,
    ) {
        let focal = focal_px(matcher.camera);
        for (id, cell) in candidates {
            if self.features.len() >= wanted {
                break;
            }
            let is_sharp = depth_spread(map, map.landmark(*id), &matcher.camera_from_world)
                .is_some_and(|spread| 2.0 * spread.norm() * focal < SHARP_PX);
            if is_sharp && !grid.is_taken(*cell) {
                self.num_searched += 1;
                if self.try_landmark(map, matcher, *id) {
                    grid.take(*cell);
                }
            }
        }
    }

    fn try_landmark(&mut self, map: &Map, matcher: &Matcher<'_>, id: LandmarkId) -> bool {
        self.tried.push(id);
        let landmark = map.landmark(id);
        let found = match self.radius {
            0 => matcher.find(map, landmark),
            radius => matcher.find_within(map, landmark, radius),
        };
        let Some(found) = found else { return false };
        self.features.push(Feature::new(id, &found));
        true
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix2, Point2, Vector3};

    use super::*;

    #[test]
    fn a_search_ends_early_only_where_next_to_nothing_is_found() {
        let feature = Feature {
            landmark: LandmarkId(0),
            px: Point2::origin(),
            ray: Vector3::z(),
            level: 0,
            covariance_px: Matrix2::identity(),
        };
        let ends_at = |found_every: usize| {
            let mut search = Search::default();
            (1..=3 * WIDE_MATCHES).find(|num| {
                search.num_searched = *num;
                if num.is_multiple_of(found_every) {
                    search.features.push(feature);
                }
                search.is_clearly_wrong()
            })
        };
        assert_eq!(ends_at(usize::MAX), Some(30));
        assert!(ends_at(40).is_some_and(|num| num < 80));
        assert_eq!(ends_at(7), None);
    }
}
