//! The part of the world that the camera looks at, and what its images tell.

use visloc_core::geom::PlanarPose;

use super::likelihood::Told;
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

/// Mean of what the last images of a view tell about a place.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mean {
    /// Of the logarithm of the marginal likelihood.
    pub log_evidence: f64,
    /// Of the same against one zero for all tracks (`weigh_image` in `tracks.rs`): evidence of different images is not compared, since one
    /// shows more than the other.
    pub log_odds: f64,
    /// How many images it is of.
    pub num_images: f64,
}

impl Mean {
    fn add(&mut self, log_evidence: f64, even: f64) {
        self.num_images = (self.num_images + 1.0).min(MAX_AVERAGED);
        self.log_evidence += (log_evidence - self.log_evidence) / self.num_images;
        self.log_odds += (log_evidence - even - self.log_odds) / self.num_images;
    }

    /// See [`ViewEvidence::after`].
    fn after(&mut self, best: &Self) {
        let lead = self.log_odds - best.log_odds;
        if lead > 0.0 {
            self.log_odds = best.log_odds + lead / best.num_images.max(1.0);
        }
    }
}

/// What an image tells a place whose view has odds of 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Even {
    pub by_lines: f64,
    pub by_landmarks: f64,
}

impl From<&Told> for Even {
    fn from(told: &Told) -> Self {
        Self { by_lines: told.by_lines(), by_landmarks: told.by_landmarks.unwrap_or(0.0) }
    }
}

/// What the images of one view tell about a place: all of them show the same, with the same errors of map, lens and what stands in the way,
/// so that together they count as one. A landmark at the image's border is in some of them only, and the others say nothing of it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ViewEvidence {
    pub lines: Mean,
    /// Of the images that show landmarks.
    pub landmarks: Mean,
    /// How many searches of the whole map have come to this place.
    pub num_found: f64,
}

impl ViewEvidence {
    /// Of a place that one search has just come to.
    pub fn found(told: &Told, even: &Even) -> Self {
        let mut evidence = Self { num_found: 1.0, ..Self::default() };
        evidence.add(told, even);
        evidence
    }

    /// The same where images of the view before have shown the best place. If this one is explained better here, those were explained as well at
    /// most: else searches of them would have come here. That is as little known as one image tells. Landmarks that are out of the image may be
    /// where the best place has them.
    pub fn after(mut self, best: &Self) -> Self {
        self.lines.after(&best.lines);
        if self.shows_landmarks() {
            self.landmarks.after(&best.landmarks);
        } else {
            self.landmarks = Mean { num_images: 0.0, ..best.landmarks };
        }
        self
    }

    /// Of a place that no image of this view has been compared with.
    pub fn expected(log_odds: f64) -> Self {
        Self { lines: Mean { log_odds, ..Mean::default() }, ..Self::default() }
    }

    pub fn shows_landmarks(&self) -> bool {
        self.landmarks.num_images > 0.0
    }

    pub fn log_odds(&self) -> f64 {
        self.lines.log_odds + self.landmarks.log_odds
    }

    pub fn log_evidence(&self) -> f64 {
        self.lines.log_evidence + self.landmarks.log_evidence
    }

    /// Takes in an image with its evidence for this place, and for one whose odds are even.
    pub fn add(&mut self, told: &Told, even: &Even) {
        self.lines.add(told.by_lines(), even.by_lines);
        if let Some(by_landmarks) = told.by_landmarks {
            self.landmarks.add(by_landmarks, even.by_landmarks);
        }
    }

    /// The view moves on: a share of it is new. What the share that is out of view has told, how much of that by landmarks, and how often the
    /// place was found there.
    pub fn move_on(&mut self, novelty: f64) -> (f64, f64, f64) {
        let found = novelty * self.num_found;
        let told = (novelty * self.log_odds(), novelty * self.landmarks.log_evidence);
        self.lines.num_images *= 1.0 - novelty;
        // Landmarks that the next images do not show are gone.
        self.landmarks.num_images *= 1.0 - novelty;
        self.landmarks.log_odds *= 1.0 - novelty;
        self.landmarks.log_evidence *= 1.0 - novelty;
        self.num_found -= found;
        (told.0, told.1, found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(by_lines: f64) -> Told {
        Told { by_all: by_lines, by_landmarks: None }
    }

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
        let (told, even) = (lines(5.0), Even::from(&lines(7.0)));
        let mut evidence = ViewEvidence::found(&told, &even);
        (0..100).for_each(|_| evidence.add(&told, &even));
        assert!((evidence.log_odds() + 2.0).abs() < 1e-12 && (evidence.log_evidence() - 5.0).abs() < 1e-12);
        let gone = evidence.move_on(0.5);
        assert!((gone.0 + 1.0).abs() < 1e-12 && gone.1.abs() < 1e-12 && (gone.2 - 0.5).abs() < 1e-12);
        assert!((evidence.num_found - 0.5).abs() < 1e-12);
    }

    /// A robot turns its head past a goal. Its lines go on fitting the twin as well.
    #[test]
    fn a_goal_that_few_images_of_a_view_show_counts_as_much_as_one_that_all_show() {
        let with_goal = |by_goal: f64| Told { by_all: 20.0 + by_goal, by_landmarks: Some(by_goal) };
        let even = Even::from(&with_goal(9.0));
        let mut here = ViewEvidence::found(&with_goal(9.0), &even);
        let mut twin = ViewEvidence::found(&with_goal(-4.0), &even);
        (0..30).for_each(|_| {
            [&mut here, &mut twin].into_iter().for_each(|place| place.add(&lines(20.0), &even))
        });
        assert!((here.log_odds() - twin.log_odds() - 13.0).abs() < 1e-9);
        // A place that is found now may have the goal where this one has it.
        let late = ViewEvidence::found(&lines(20.0), &even).after(&here);
        assert!((late.log_odds() - here.log_odds()).abs() < 1e-9);
        // It is told once, however long the view goes on and moves.
        let gone: Vec<_> = (0..100).map(|_| (here.move_on(0.1), twin.move_on(0.1))).collect();
        let lead: f64 = gone.iter().map(|(here, twin)| here.0 - twin.0).sum();
        let by_goal: f64 = gone.iter().map(|(here, _)| here.1).sum();
        assert!((lead - 13.0).abs() < 0.01 && (by_goal - 9.0).abs() < 0.01, "{lead} {by_goal}");
        assert!((here.log_odds() - twin.log_odds()).abs() < 0.01);
    }
}
