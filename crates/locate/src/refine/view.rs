//! The part of the world that the camera looks at, and what its images tell.

use visloc_core::geom::PlanarPose;

use crate::Region;

/// An image from so far away, or turned by so much, shows something new.
pub(super) const NEW_VIEW_M: f64 = 0.2;
pub(super) const NEW_VIEW_RAD: f64 = 0.2;

/// The mean over so many images of a view is free of the noise of each; if somebody has carried the robot it follows in as many.
const MAX_AVERAGED: f64 = 10.0;

/// What the tracks have to know about an image.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    /// How much of it is new, 0 to 1.
    pub novelty: f64,
    /// How clear it is, 0 to 1: a camera that turns blurs its image.
    pub clearness: f64,
    /// Whether the map has landmarks.
    pub has_landmarks: bool,
    /// Whether it is known where the robot is, up to the map's symmetry.
    pub is_localized: bool,
    /// Where the robot may be.
    pub region: Region,
}

/// The part of the world that the camera looks at.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PresentView {
    /// Direction and place of the camera when it began, as the odometry has them.
    first: Option<PlanarPose>,
    /// How much of it has gone out of view, 0 to 1.
    gone: f64,
}

impl PresentView {
    /// The camera is here now. How much of what it sees is new, 0 to 1: a camera that trembles sees nothing new.
    pub fn move_to(&mut self, camera: &PlanarPose) -> f64 {
        let away = self.first.map_or(1.0, |first| {
            first.distance_m(camera) / NEW_VIEW_M + first.heading_difference_rad(camera) / NEW_VIEW_RAD
        });
        let novelty = (away.min(1.0) - self.gone).max(0.0);
        self.gone += novelty;
        if away >= 1.0 {
            (self.first, self.gone) = (Some(*camera), 0.0);
        }
        novelty
    }
}

/// What the images of one view tell about a place: all of them show the same, with the same errors of map, lens and what stands in the way,
/// so that together they count as one.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ViewEvidence {
    /// Mean of the logarithm of the marginal likelihood of the last images.
    pub log_evidence: f64,
    /// Mean of the same against one zero for all tracks (`weigh_image` in `tracks.rs`): evidence of different images is not compared, since one
    /// shows more than the other.
    pub log_odds: f64,
    /// How many images the means are of.
    pub num_images: f64,
    /// How many searches of the whole map have come to this place.
    pub num_found: f64,
}

impl ViewEvidence {
    /// Of a place that one search has just come to.
    pub fn found(log_evidence: f64, even: f64) -> Self {
        let mut evidence = Self { num_found: 1.0, ..Self::default() };
        evidence.add(log_evidence, even);
        evidence
    }

    /// The same where images of the view before have shown the best place. If this one is explained better here, those were explained as well at
    /// most: else searches of them would have come here. That is as little known as one image tells.
    pub fn after(mut self, best: &Self) -> Self {
        let lead = self.log_odds - best.log_odds;
        if lead > 0.0 {
            self.log_odds = best.log_odds + lead / best.num_images.max(1.0);
        }
        self
    }

    /// Of a place that no image of this view has been compared with.
    pub fn expected(log_odds: f64) -> Self {
        Self { log_odds, ..Self::default() }
    }

    /// Takes in an image with its evidence for this place, and for one whose odds are even.
    pub fn add(&mut self, log_evidence: f64, even: f64) {
        self.num_images = (self.num_images + 1.0).min(MAX_AVERAGED);
        self.log_evidence += (log_evidence - self.log_evidence) / self.num_images;
        self.log_odds += (log_evidence - even - self.log_odds) / self.num_images;
    }

    /// The view moves on: a share of it is new. What the share that is out of view has told, and how often the place was found there.
    pub fn move_on(&mut self, novelty: f64) -> (f64, f64) {
        let found = novelty * self.num_found;
        self.num_images *= 1.0 - novelty;
        self.num_found -= found;
        (novelty * self.log_odds, found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_new_adds_up_to_one_for_each_view_and_trembling_shows_nothing() {
        let mut view = PresentView::default();
        let at = |yaw_rad: f64| PlanarPose::new(1.0, 2.0, yaw_rad);
        assert!((view.move_to(&at(0.0)) - 1.0).abs() < 1e-12, "all of the first image");
        let trembling: f64 = (0..1000).map(|i| view.move_to(&at(0.01 * f64::from(i % 2)))).sum();
        assert!((trembling - 0.05).abs() < 1e-9, "{trembling}");
        let turning: f64 = (1..=100).map(|i| view.move_to(&at(0.01 * f64::from(i)))).sum();
        assert!((4.7..4.96).contains(&turning), "nearly five views of 0.2 rad: {turning}");
    }

    #[test]
    fn images_of_one_view_count_as_one_and_those_of_others_add_up() {
        let mut evidence = ViewEvidence::found(5.0, 7.0);
        (0..100).for_each(|_| evidence.add(5.0, 7.0));
        assert!((evidence.log_odds + 2.0).abs() < 1e-12 && (evidence.log_evidence - 5.0).abs() < 1e-12);
        let gone = evidence.move_on(0.5);
        assert!((gone.0 + 1.0).abs() < 1e-12 && (gone.1 - 0.5).abs() < 1e-12);
        assert!((evidence.num_found - 0.5).abs() < 1e-12);
    }
}
