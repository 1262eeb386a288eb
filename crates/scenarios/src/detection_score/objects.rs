//! What the detector of robots and balls finds of the robots that walk about a simulated field.

use nalgebra::Point3;
use visloc_core::{Frame, RngTree};
use visloc_locate::{
    PipelineConfig, analysis_for,
    vision::{
        DetectedObject, ObjectKind,
        field::{FieldAnalysisConfig, FieldAnalyzer},
    },
};
use visloc_sim::{Detection, DetectorSetup, Scenario, TeamSimulation};
use visloc_world::Map;

use super::DetectionScores;
use crate::RunError;

/// All that is in view, where it is.
const TRUTH: DetectorSetup = DetectorSetup {
    miss: 0.0,
    false_per_image: 0.0,
    bearing_sigma_rad: 0.0,
    range_sigma: 0.0,
    max_range_m: (5.0, 4.0),
};
/// Robots on the field.
const NUM_ROBOTS: usize = 5;
/// A detection is right within this share of the distance, and so far across the view, meters.
const RIGHT_RANGE: f64 = 0.35;
const RIGHT_ACROSS_M: f64 = 0.2;
/// Half of the width that must be in the image, and be hidden by nobody, meters.
const ROBOT_HALF_M: f64 = 0.25;
const BALL_HALF_M: f64 = 0.1;

impl DetectionScores {
    /// Adds what is found in some images, two a second, of five robots. What is seen in part only counts neither as found nor as missed, and
    /// so do robots beyond 5 m and balls beyond 4 m.
    ///
    /// # Errors
    /// If the game cannot be played.
    pub fn add_game(&mut self, scenario: &Scenario, seed: u64, num_images: usize) -> Result<(), RunError> {
        let scenario = Scenario { frames_per_sec: 2.0, ..scenario.clone() };
        let mut team = TeamSimulation::new(&scenario, NUM_ROBOTS, TRUTH, seed)?;
        let Map::Field(field) = team.map().clone() else { return Ok(()) };
        let analysis = analysis_for(&field, &PipelineConfig::default());
        let analyzer = FieldAnalyzer::new(FieldAnalysisConfig { detect_objects: true, ..analysis })?;
        let mut of_robots: Vec<FieldAnalyzer> = (0..NUM_ROBOTS).map(|_| analyzer.anew()).collect();
        let mut rng = RngTree::new(seed).stream("analysis", 0);
        for _ in 0..num_images {
            for (seen, analyzer) in team.step().into_iter().zip(&mut of_robots) {
                let frame = &seen.source.frame;
                let objects = &analyzer.analyze(frame, &mut rng)?.objects;
                self.add_objects(objects, frame, &seen.detections);
            }
        }
        Ok(())
    }

    fn add_objects(&mut self, objects: &[DetectedObject], frame: &Frame, truth: &[Detection]) {
        let mut is_found = vec![false; truth.len()];
        for object in objects {
            let hit = truth.iter().enumerate().position(|(i, t)| !is_found[i] && is_right(object, t));
            if let Some(i) = hit {
                is_found[i] = true;
                if !is_whole(frame, &truth[i]) {
                    continue;
                }
            }
            let score = self.0.entry(name(object.kind == ObjectKind::Ball)).or_default();
            score.num_found += 1;
            score.num_right += usize::from(hit.is_some());
            score.errors_m.extend(hit.map(|i| (object.in_robot.coords.norm() - truth[i].range_m).abs()));
        }
        for (t, is_found) in truth.iter().zip(is_found).filter(|(t, _)| is_whole(frame, t)) {
            let score = self.0.entry(name(t.is_ball)).or_default();
            score.num_visible += 1;
            score.num_recalled += usize::from(is_found);
        }
    }
}

fn name(is_ball: bool) -> &'static str {
    if is_ball { "ball" } else { "robot" }
}

fn is_right(object: &DetectedObject, truth: &Detection) -> bool {
    let range_m = object.in_robot.coords.norm();
    let bearing_rad = object.in_robot.y.atan2(object.in_robot.x);
    (object.kind == ObjectKind::Ball) == truth.is_ball
        && (range_m / truth.range_m - 1.0).abs() < RIGHT_RANGE
        && ((bearing_rad - truth.bearing_rad) * truth.range_m).abs() < RIGHT_ACROSS_M
}

/// Whether the foot of a robot or a ball is in the image, with all of its width.
fn is_whole(frame: &Frame, seen: &Detection) -> bool {
    let (sin, cos) = seen.bearing_rad.sin_cos();
    let half_m = if seen.is_ball { BALL_HALF_M } else { ROBOT_HALF_M };
    [-half_m, half_m].iter().all(|side_m| {
        let foot = Point3::new(seen.range_m * cos - side_m * sin, seen.range_m * sin + side_m * cos, 0.0);
        let in_camera = frame.robot_from_camera.inverse().transform(&foot);
        frame.camera.project(&in_camera).is_ok_and(|px| frame.camera.contains(&px))
    })
}
