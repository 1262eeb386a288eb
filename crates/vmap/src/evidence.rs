//! What speaks for a place, and what against it.

use visloc_core::geom::{CameraFrame, Rigid3, World};
use visloc_slam::{
    FrameOutcome,
    map::{LandmarkId, MapId},
    recognize::Rival,
};

/// Landmarks of the map from which on an image shows the place. Of fewer, the pose is that of the landmarks that were added since.
pub const LEAST_OF_MAP: usize = 12;
/// Places of landmarks of the map in an image of which one in five is enough for [`LEAST_OF_MAP`]: so many should show the place.
const SHOULD_SHOW: usize = 5 * LEAST_OF_MAP;
/// Odds that a place that was recognized by the fewest landmarks is another one: a door, a window, a poster that is there twice has that
/// many.
const MISTAKEN: f64 = 1.5;
/// The fewest landmarks that a place is recognized by.
const FEWEST: usize = 20;
/// Landmarks more in one image for which the odds of a mistake fall to a third: things that are there twice end somewhere.
const MORE: f64 = 15.0;
/// Share of the views of a mapped place that do not show it: other light, moved things, somebody in front of it. Those of a wrong place do not
/// where what is there twice ends.
const UNSEEN: f64 = 0.2;
/// Landmarks that are found or missed together, since they are on one thing.
const TOGETHER: f64 = 4.0;
/// Standard deviation of the share that is found at a right place from one place to the next: light, and which landmarks the map has of it.
const SPREAD: f64 = 0.15;
/// A logistic distribution of this steepness is nearly the normal one.
const LOGISTIC: f64 = 1.702;
/// Factor on the odds of places that are known to look alike: a wrong claim harms as much as so many moments without one.
const CAUTION: f64 = 10.0;

/// A place where the camera may be.
#[derive(Debug, Clone, Copy)]
pub struct Hypothesis {
    /// The map.
    pub map: MapId,
    /// Pose of the camera, map units.
    pub world_from_camera: Rigid3<World, CameraFrame>,
    /// Its probability, 0 to 1.
    pub probability: f64,
}

/// Another place where an image fits as well.
#[derive(Debug, Clone, Copy)]
struct Elsewhere {
    map: MapId,
    /// From the place here to that one.
    there_from_here: Rigid3<World, World>,
    /// Odds that it is rather that one.
    odds: f64,
}

/// What speaks for a place since it was recognized.
#[derive(Debug, Clone, Default)]
pub struct Evidence {
    /// Most landmarks found in one image: what is there twice is there twice in each of them.
    most_found: usize,
    /// Views in a row that should show the place and do not.
    num_unseen: i32,
    /// What the last of them should show: images that should show mostly the same are one view.
    unseen: Vec<LandmarkId>,
    /// Other places, of the last image in which they were looked for.
    elsewhere: Vec<Elsewhere>,
}

impl Evidence {
    /// Takes note of an image, taken here if it is the place.
    pub fn add(&mut self, outcome: &FrameOutcome, world_from_camera: &Rigid3<World, CameraFrame>) {
        let (expected, num_searched) = (&outcome.fixed_tried, outcome.num_fixed_searched);
        let num_found = outcome.fixed.len();
        if num_found >= LEAST_OF_MAP {
            self.most_found = self.most_found.max(num_found);
        }
        if num_found >= FEWEST {
            self.num_unseen = 0;
        } else if num_found < LEAST_OF_MAP && num_searched >= SHOULD_SHOW && self.is_new_view(expected) {
            self.num_unseen += 1;
            self.unseen.clone_from(expected);
            self.unseen.sort_unstable();
        }
        if let Some(rivals) = &outcome.rivals {
            let elsewhere = |rival: &Rival| Elsewhere {
                map: rival.map,
                there_from_here: rival.camera_from_world.inverse() * world_from_camera.inverse(),
                odds: odds((rival.num_matched, rival.num_searched), (num_found, num_searched)),
            };
            self.elsewhere = rivals.iter().map(elsewhere).collect();
        }
    }

    fn is_new_view(&self, expected: &[LandmarkId]) -> bool {
        let num_known = expected.iter().filter(|id| self.unseen.binary_search(id).is_ok()).count();
        self.num_unseen == 0 || 2 * num_known < expected.len()
    }

    /// How far the place can be trusted, 0 to 1.
    pub fn reliability(&self) -> f64 {
        1.0 / (1.0 + self.odds_mistaken() + CAUTION * self.odds_elsewhere())
    }

    /// Probability of the place.
    pub fn probability(&self) -> f64 {
        1.0 / (1.0 + self.odds_mistaken() + self.odds_elsewhere())
    }

    /// Odds that it is none of the places that are known.
    fn odds_mistaken(&self) -> f64 {
        let more = self.most_found as f64 - FEWEST as f64;
        MISTAKEN * 3.0_f64.powf(-more / MORE) / UNSEEN.powi(self.num_unseen)
    }

    fn odds_elsewhere(&self) -> f64 {
        self.elsewhere.iter().map(|place| place.odds).sum()
    }

    /// The other places, for a camera that is here with its probability.
    pub fn elsewhere(&self, world_from_camera: &Rigid3<World, CameraFrame>) -> Vec<Hypothesis> {
        let hypothesis = |place: &Elsewhere| Hypothesis {
            map: place.map,
            world_from_camera: place.there_from_here * *world_from_camera,
            probability: self.probability() * place.odds,
        };
        self.elsewhere.iter().map(hypothesis).collect()
    }
}

/// Odds that an image was taken there rather than here, by how many landmarks of those that should be seen are found: how probably that share
/// is really the larger one.
fn odds(there: (usize, usize), here: (usize, usize)) -> f64 {
    let share = |(found, searched): (usize, usize)| (found as f64 + 0.5) / (searched as f64 + 1.0);
    let both = share((there.0 + here.0, there.1 + here.1));
    let parts = 1.0 / (there.1 as f64 + 1.0) + 1.0 / (here.1 as f64 + 1.0);
    let variance = TOGETHER * both * (1.0 - both) * parts + 2.0 * SPREAD * SPREAD;
    (LOGISTIC * (share(there) - share(here)) / variance.sqrt()).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_that_shows_as_much_of_itself_is_as_probable_and_one_that_shows_less_is_not() {
        assert!((odds((40, 80), (40, 80)) - 1.0).abs() < 1e-9);
        assert!(odds((20, 80), (60, 80)) < 0.1 && odds((60, 80), (20, 80)) > 10.0);
        assert!(odds((50, 80), (60, 80)) > 0.2, "places differ in what is found of them");
        // Few tell little.
        assert!(odds((2, 8), (6, 8)) > odds((20, 80), (60, 80)));
    }
}
