//! Counts of all detectors.

use std::collections::BTreeMap;

use visloc_core::geom::PlanarPose;
use visloc_locate::vision::{JunctionKind, Percept};
use visloc_world::field::Field;

use super::{counts::DetectionScore, scene::Scene};

/// Counts of all detectors, by name.
#[derive(Debug, Clone, Default)]
pub struct DetectionScores(pub BTreeMap<&'static str, DetectionScore>);

impl DetectionScores {
    /// Counts the features of one image.
    pub fn add(&mut self, percept: &Percept, field: &Field, truth: &PlanarPose) {
        let scene = Scene::new(percept, field, truth);
        scene.score_lines(self.of("line"));
        for kind in JunctionKind::ALL {
            let name = match kind {
                JunctionKind::L => "junction L",
                JunctionKind::T => "junction T",
                JunctionKind::X => "junction X",
            };
            scene.score_junctions(kind, self.of(name));
        }
        scene.score_circle(self.of("center circle"));
        scene.score_halfway(self.of("halfway line"));
        scene.score_marks(self.of("penalty mark"));
        scene.score_posts(self.of("post"));
        scene.score_sides(self.of("post side"));
    }

    fn of(&mut self, name: &'static str) -> &mut DetectionScore {
        self.0.entry(name).or_default()
    }
}
