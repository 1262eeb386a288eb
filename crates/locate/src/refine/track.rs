//! One track: a hypothesis with its filter and what speaks for it.

use nalgebra::Matrix3;

use super::{
    filter::{Agreement, PoseFilter},
    known::Known,
    likelihood::Told,
    mount::Mount,
    view::{Even, View, ViewEvidence},
};
use crate::{observation::features::FeatureModel, per_camera::OtherCameras};

/// What one image of landmarks that are all explained adds to the confirmation.
const CONFIRMATION: f64 = 0.1;
/// What one image of landmarks that are not explained takes away: less, since boards and clothes have colors of landmarks.
const CONTRADICTION: f64 = 0.02;
/// What a view that is all new adds on a map without landmarks, if it is explained this well.
const VIEW_CONFIRMATION: f64 = 0.04;
const GOOD_AGREEMENT: f64 = 0.8;

/// A fit with this much more evidence is another one, and not the same with other noise.
const BETTER_FIT: f64 = 1.0;

/// A filter that was fitted to the present image from a place that a search has come to.
#[derive(Debug)]
pub(super) struct FoundFit {
    pub filter: PoseFilter,
    pub agreement: f64,
    /// By how much the best track explains the image better.
    pub deficit: f64,
    /// What the camera that it needs takes from its odds.
    pub bend: f64,
    pub log_odds: f64,
    pub told: Told,
    /// What this image tells, against the other tracks.
    pub of_image: ViewEvidence,
    /// What the present view tells.
    pub of_view: ViewEvidence,
}

/// One hypothesis with its filter.
#[derive(Debug, Clone)]
pub(super) struct Track {
    pub id: u64,
    pub filter: PoseFilter,
    /// Agreement of the last image that it was fitted to.
    pub last_agreement: f64,
    /// By how much the best track that was fitted to that image explained it better.
    pub deficit: f64,
    /// Logarithm of the marginal likelihood of the last image that it was fitted to.
    pub last_told: Told,
    /// The image that it was last fitted to.
    pub fitted_in: u64,
    /// Agreement of late.
    pub agreement: f64,
    /// How far landmarks, or new views on a map without any, have confirmed it, 0 to 1.
    pub confirmed: f64,
    /// Where places look alike, how far doors have confirmed it, 0 to 1.
    pub seen_doors: f64,
    /// Logarithm of its odds against the best one: 0 or less.
    pub log_odds: f64,
    /// What of it earlier views have told, and what was known before; the rest is of the present view. On a map of look-alikes not in use.
    pub past_log_odds: f64,
    /// On a symmetric map, the probability that the robot is here rather than at the mirrored pose; otherwise 1.
    pub own_share: f64,
    /// What its odds have lost by the tilt and height of the camera that it needs.
    pub bend: f64,
    /// Where places look alike, what its odds still lack for having been found late.
    pub late: f64,
    /// How many searches of the whole map came to this place in earlier views.
    pub past_found: f64,
    /// What landmarks of earlier views have told, against landmarks that belong to nothing.
    pub past_landmarks: f64,
    /// What the images of the present view tell.
    pub view_evidence: ViewEvidence,
    /// Of each other camera what the images of its present view tell, and what its last image told.
    pub other_views: OtherCameras<(ViewEvidence, Told)>,
    /// How far off the place where the prior held was when the prior was last asked, meters.
    pub asked_spread_m: f64,
}

impl Track {
    /// Landmarks in view confirm the track or take its confirmation away; without landmarks new views do, slowly.
    pub fn confirm(&mut self, agreement: &Agreement, view: &View) {
        let step_by = |share: f64| share * if share > 0.0 { CONFIRMATION } else { CONTRADICTION };
        if !view.has_landmarks {
            if let Some(share) = agreement.of_landmarks() {
                self.seen_doors = (self.seen_doors + step_by(share)).clamp(0.0, 1.0);
            }
            let is_good = agreement.value() > GOOD_AGREEMENT;
            // A blurred image does not speak against anybody.
            let step = if is_good { VIEW_CONFIRMATION } else { -VIEW_CONFIRMATION * view.clearness };
            self.confirmed = (self.confirmed + step * view.novelty).clamp(0.0, 1.0);
        } else if let Some(share) = agreement.of_landmarks() {
            self.confirmed = (self.confirmed + step_by(share)).clamp(0.0, 1.0);
        }
    }

    /// Takes from its odds what the camera that it needs speaks against it.
    pub fn set_bend(&mut self, bend: f64) {
        self.log_odds += self.bend - bend;
        self.bend = bend;
    }

    /// Goes on from a pose that explains the image much better, with the odds of a new track if its own are worse: it lost them
    /// where the robot is not.
    pub fn correct(&mut self, found: FoundFit) {
        self.filter = found.filter;
        self.set_bend(found.bend);
        self.last_agreement = found.agreement;
        self.agreement = self.agreement.max(found.agreement);
        self.deficit = found.deficit;
        self.log_odds = self.log_odds.max(found.log_odds);
    }

    /// A search has come to this place again. If its fit explains the image better the track was stuck beside it.
    pub fn find_again(&mut self, found: FoundFit, model: &dyn FeatureModel) {
        let mut here = self.view_evidence;
        if !found.of_image.shows_landmarks() {
            here.landmarks = found.of_image.landmarks;
        }
        if found.of_image.log_odds() < here.log_odds() + BETTER_FIT {
            return;
        }
        let (here, there) = (self.filter.pose(), found.filter.pose());
        self.filter = found.filter;
        if let Some(mirrored) = model.mirrored(&there)
            && mirrored.distance_m(&here) < there.distance_m(&here)
        {
            self.filter.set_pose(&mirrored);
        }
        let before = self.view_evidence;
        self.view_evidence = ViewEvidence { num_found: before.num_found, ..found.of_view };
        if !found.of_image.shows_landmarks() {
            self.view_evidence.landmarks = before.landmarks;
        }
        self.last_told = found.told;
        self.bend = found.bend;
        self.weigh();
        self.last_agreement = found.agreement;
        self.agreement = self.agreement.max(self.last_agreement);
    }

    /// The next image is of another camera; see [`PoseFilter::look_through`].
    pub fn look_through(&mut self, cameras: (usize, usize), turn: &Matrix3<f64>, mount: &Mount) {
        self.filter.look_through(cameras, turn, mount);
        let mut view = (self.view_evidence, self.last_told);
        self.other_views.look_through(&mut view, cameras, |_| (ViewEvidence::default(), Told::default()));
        (self.view_evidence, self.last_told) = view;
    }

    /// Odds by the present views and all before, and by the camera that it needs.
    pub fn weigh(&mut self) {
        self.log_odds =
            self.past_log_odds + self.view_evidence.log_odds() + self.other_log_odds() - self.bend;
    }

    /// What the last image that it was fitted to is to a place whose view has odds of 1, if the robot is here.
    pub fn evenness(&self) -> Even {
        let (told, view) = (Even::from(&self.last_told), &self.view_evidence);
        Even {
            by_lines: told.by_lines - view.lines.log_odds,
            by_landmarks: told.by_landmarks - view.landmarks.log_odds,
        }
    }

    /// What landmarks have told, against landmarks that belong to nothing.
    pub fn told_by_landmarks(&self) -> f64 {
        self.past_landmarks + self.view_evidence.landmarks.log_evidence
    }

    /// What the present views of the other cameras tell.
    pub fn other_log_odds(&self) -> f64 {
        self.other_views.iter().map(|(_, (view, _))| view.log_odds()).sum()
    }

    /// What the other cameras may tell of a place that they have not been compared with: as much as of this one, until they look again.
    pub fn expected_other_views(&self) -> OtherCameras<(ViewEvidence, Told)> {
        let mut others = self.other_views.clone();
        others
            .values_mut()
            .for_each(|other| *other = (ViewEvidence::expected(other.0.log_odds()), Told::default()));
        others
    }

    /// The present view moves on.
    pub fn move_on(&mut self, novelty: f64) {
        let (log_odds, by_landmarks, found) = self.view_evidence.move_on(novelty);
        self.past_log_odds += log_odds;
        self.past_landmarks += by_landmarks;
        self.past_found += found;
    }

    /// Probability that the searches of the whole map have missed another place that explains as much: it would have been found as often.
    pub fn missed(&self) -> f64 {
        let others: f64 = self.other_views.iter().map(|(_, (view, _))| view.num_found).sum();
        (-self.past_found - self.view_evidence.num_found - others).exp()
    }

    /// How much more probable it is that what the present view shows is nothing that is on the map; the last image alone must not show that
    /// either, since somebody may have carried the robot just now.
    pub fn elsewhere(&self) -> f64 {
        let told = |view: &ViewEvidence, last: f64| view.log_evidence().min(last);
        let others: f64 = self.other_views.iter().map(|(_, (view, last))| told(view, last.by_all)).sum();
        (self.bend - told(&self.view_evidence, self.last_told.by_all) - others).exp()
    }

    /// Takes the more probable one of two mirrored poses. `share` is the probability of the present one.
    pub fn share(&mut self, share: f64, model: &dyn FeatureModel) {
        self.own_share = share;
        if share < 0.5
            && let Some(mirrored) = model.mirrored(&self.filter.pose())
        {
            self.filter.set_pose(&mirrored);
            self.own_share = 1.0 - share;
        }
    }

    /// Asks the prior again while the pose gets better: a first guess beside the line that parts two halves may be on the
    /// wrong side of it.
    pub fn ask(&mut self, known: &Known, model: &dyn FeatureModel) {
        let spread_m = known.spread_m(self.filter.spread_m());
        if spread_m < self.asked_spread_m
            && let Some(share) = known.share_by_prior(model, &self.filter.pose(), self.filter.spread_m())
        {
            self.asked_spread_m = spread_m;
            self.share(share, model);
        }
    }
}
