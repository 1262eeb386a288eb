//! All places that explain one image.

use visloc_core::{Rng, geom::PlanarPose};

use super::{
    RefinementConfig,
    evidence::{log_evidence, surprise},
    filter::PoseFilter,
    mount::Mount,
    search::{Candidate, Effort, PlaceSearch},
    tracks::BIRTH_GATES_PX,
    turned::Turned,
};
use crate::{
    ObservationModel, Region,
    observation::features::{CameraState, FeatureModel},
    vision::Percept,
};

/// A place that explains an image.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Explanation {
    /// The pose of the robot and the camera's errors that fit best.
    pub camera: CameraState,
    /// Logarithm of the marginal likelihood of the image's features against that of features that belong to nothing on the map: how well they
    /// fit, less for what may be anything before and has to be just so.
    pub log_evidence: f64,
}

/// Searches places for one image at leisure.
pub(crate) struct SingleImage {
    features: Box<dyn FeatureModel>,
    places: PlaceSearch,
    turned: Turned,
}

impl SingleImage {
    /// A search on a map; `features` are matched to it, `pixels` weigh places.
    pub fn new(features: Box<dyn FeatureModel>, pixels: Box<dyn ObservationModel>) -> Self {
        Self { features, places: PlaceSearch::new(pixels), turned: Turned::default() }
    }

    /// The pose from which everything looks the same.
    pub fn mirrored(&self, pose: &PlanarPose) -> Option<PlanarPose> {
        self.features.mirrored(pose)
    }

    /// Appends the places that fit: of the suggestions the best ones are fitted. The camera may be off as `config` says.
    pub fn explain(
        &mut self,
        percept: &Percept,
        config: &RefinementConfig,
        effort: Effort,
        rng: &mut Rng,
        found: &mut Vec<Explanation>,
    ) {
        let mount = Mount::unknown(config);
        let rounds = mount.num_draws(config);
        let effort = Effort { num_poses: effort.num_poses.div_ceil(rounds), ..effort };
        self.places.begin();
        for _ in 0..rounds {
            let tilt_rad = mount.draw(rng);
            let turned = self.turned.turn(percept, &tilt_rad);
            self.features.condition_on(turned);
            self.places.search((turned, &tilt_rad), self.features.as_ref(), effort, |_| false, rng);
        }
        self.features.condition_on(percept);
        if self.features.num_features() > 0 {
            let region = self.places.region();
            let candidates = self.places.found();
            found.extend(candidates.filter_map(|candidate| self.fit(&candidate, &mount, &region, config)));
        }
    }

    fn fit(
        &self,
        candidate: &Candidate,
        mount: &Mount,
        region: &Region,
        config: &RefinementConfig,
    ) -> Option<Explanation> {
        let model = self.features.as_ref();
        let mut filter = PoseFilter::new(&candidate.world_from_robot, mount, config);
        // Nothing is known of the place before this image, so a few steps more settle it.
        let gates_px: Vec<f64> = BIRTH_GATES_PX.into_iter().chain([config.gate_px; 3]).collect();
        let fit = filter.update_from(&candidate.tilt_rad, model, &gates_px, config);
        let camera = CameraState::from(&fit.at);
        let is_inside = fit.at.iter().all(|v| v.is_finite()) && region.contains(&camera.world_from_robot);
        is_inside.then(|| {
            let log_evidence = log_evidence(model, &fit, region, config).by_all - surprise(&fit, config);
            Explanation { camera, log_evidence }
        })
    }
}
