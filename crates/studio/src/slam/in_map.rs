//! A camera that is found in the map of an earlier session, to be watched.

use nalgebra::Point3;
use serde_json::Value;
use visloc_core::{
    CameraPose, CameraTrajectory, GrayFrame, Timestamp,
    geom::{Camera, CameraFrame, Rigid3, World},
};
use visloc_slam::SlamFrame;
use visloc_vmap::{CameraEstimate, MapLocalizer, ScaleSource, VisualMap};

use super::{display::Display, moment::SlamMoment, shapes::xyz, told::Told, viewer::SlamViewer};
use crate::StudioError;

/// Most places of a way that are kept; then every second one is left out.
const MAX_WAY: usize = 6000;

/// Shows where a camera is in a map.
#[derive(Debug)]
pub struct MapViewer {
    viewer: SlamViewer,
    /// Whether map and truth have the same frame.
    is_aligned: bool,
    /// The way as it is shown; places that are no number stand where it was interrupted.
    way: Vec<f64>,
}

impl MapViewer {
    /// Shows a camera in a map, in the frame of the map. The truth is shown where the map was aligned to it. `more` is a table that is laid
    /// over the scene message.
    pub fn new(
        camera: &Camera,
        title: &str,
        map: &VisualMap,
        truth: Option<CameraTrajectory>,
        more: Value,
    ) -> Self {
        let largest = map.largest();
        let is_aligned = largest.is_some_and(|id| map.scale(id).source == ScaleSource::Aligned);
        let is_level = largest.is_some_and(|id| map.is_level(id));
        let display = Display::of_map(is_level, truth.filter(|_| is_aligned));
        let of_map = map.map.with_active(largest.unwrap_or_default());
        let keyframes = of_map.keyframes().map(|(_, keyframe)| display.point(keyframe.center_in_world()));
        let landmarks = of_map.landmarks().map(|(_, landmark)| display.point(&landmark.point_in_world));
        let floor = floor_of(keyframes.chain(landmarks).collect());
        let viewer = SlamViewer::in_map(camera, title, display, floor, more);
        Self { viewer, is_aligned, way: Vec::new() }
    }

    /// The camera is looked for anew; numbers of frames and time go on. `more` is laid over the scene message instead of what was.
    pub fn start_anew(&mut self, more: Value) {
        self.viewer.change_scene(more);
        self.way.clear();
    }

    /// Another truth from now on, of a camera that somebody carries elsewhere.
    pub fn set_truth(&mut self, truth: CameraTrajectory) {
        if self.is_aligned {
            self.viewer.set_truth(truth);
        }
    }

    /// Where the camera was, if that is known.
    pub fn world_from_camera(&self, at: Timestamp) -> Option<&Rigid3<World, CameraFrame>> {
        self.viewer.world_from_camera(at)
    }

    /// Seconds from the first frame to this one.
    pub fn secs(&self, at: Timestamp) -> f64 {
        self.viewer.secs(at)
    }

    /// Takes in a frame that the localizer has taken; to be called for each one, shown or not.
    pub fn follow(&mut self, localizer: &MapLocalizer, frame: &GrayFrame) {
        if let Some(world_from_camera) = frame.truth.filter(|_| self.is_aligned) {
            self.viewer.add_truth(CameraPose { at: frame.at, world_from_camera });
        }
        let Some(outcome) = localizer.outcome() else { return };
        let place = localizer.estimate().filter(|estimate| estimate.is_localized());
        let is_broken = self.way.last().is_none_or(|z| z.is_nan());
        match place.map(|estimate| self.viewer.shown(estimate.world_from_camera.translation())) {
            Some(place) => {
                if place_is_new(localizer.estimate()) && !is_broken {
                    self.way.extend([f64::NAN; 3]);
                }
                self.way.extend(xyz(&place));
            }
            None if !is_broken => self.way.extend([f64::NAN; 3]),
            None => {}
        }
        if self.way.len() > 3 * MAX_WAY {
            self.way = halved(&self.way);
        }
        self.viewer.follow(localizer.slam(), &SlamFrame { at: frame.at, image: &frame.image, outcome });
    }

    /// Takes out what there is to see of the last frame; `more` is a table that is laid over the state message. `None` before the first
    /// frame.
    ///
    /// # Errors
    /// If the scene cannot be encoded.
    pub fn moment(
        &mut self,
        localizer: &MapLocalizer,
        frame: &GrayFrame,
        more: &Value,
    ) -> Result<Option<SlamMoment>, StudioError> {
        let Some(outcome) = localizer.outcome() else { return Ok(None) };
        let told = Told::in_map(localizer.estimate(), outcome, &self.way);
        let frame = SlamFrame { at: frame.at, image: &frame.image, outcome };
        self.viewer.moment_of(localizer.slam(), &frame, &told, more).map(Some)
    }

    pub(super) fn viewer(&mut self) -> &mut SlamViewer {
        &mut self.viewer
    }
}

/// Share of the places of a map on each side of an axis that may be mistakes: they lie beside the floor that is drawn.
const BESIDE: f64 = 0.03;
/// Floor beyond the others, share of its length.
const MARGIN: f64 = 0.15;

/// Least x and y, largest x and y of a floor below the places of a map, and its height.
fn floor_of(places: Vec<Point3<f64>>) -> ([f64; 4], f64) {
    let range = |axis: usize| {
        let mut values: Vec<f64> = places.iter().map(|place| place[axis]).collect();
        values.sort_by(f64::total_cmp);
        let beside = (values.len() as f64 * BESIDE) as usize;
        let least = values.get(beside).copied().unwrap_or(-1.0);
        (least, values.iter().rev().nth(beside).copied().unwrap_or(1.0))
    };
    let [x, y, z] = [0, 1, 2].map(range);
    let margin = MARGIN * (x.1 - x.0).max(y.1 - y.0);
    ([x.0 - margin, y.0 - margin, x.1 + margin, y.1 + margin], z.0)
}

/// Whether the camera did not come here on its way.
fn place_is_new(estimate: Option<&CameraEstimate>) -> bool {
    estimate.is_some_and(|estimate| estimate.is_found)
}

/// Every second place, and all interruptions.
fn halved(way: &[f64]) -> Vec<f64> {
    let kept = way.chunks_exact(3).enumerate().filter(|(i, place)| i % 2 == 0 || place[0].is_nan());
    kept.flat_map(|(_, place)| place.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_floor_lies_below_a_map_of_any_unit() {
        let place =
            |i: u32| Point3::new(f64::from(i % 10) * 1e-3, f64::from(i / 10) * 1e-3, f64::from(i % 7) * 1e-3);
        let mut places: Vec<Point3<f64>> = (0..100).map(place).collect();
        places.push(Point3::new(1e6, -1e6, -1e6));
        let ([x, y, right, top], z) = floor_of(places);
        assert!(x < 0.0 && y < 0.0 && (9e-3..0.02).contains(&right) && (9e-3..0.02).contains(&top));
        assert!(z.abs() < 1e-9, "{z}");
        assert!(floor_of(Vec::new()).0.iter().all(|value| value.is_finite()));
    }

    #[test]
    fn a_long_way_keeps_its_interruptions() {
        let way = [1.0, 1.0, 1.0, f64::NAN, f64::NAN, f64::NAN, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0];
        let halved = halved(&way);
        assert_eq!(halved.len(), 9);
        assert!(halved[3].is_nan() && halved[6] == 2.0, "{halved:?}");
    }
}
