//! Relocalization by alignment against similar keyframes. Thesis, section 6.10; the order by similarity is an addition.

use nalgebra::Rotation3;
use visloc_core::geom::{Camera, Rigid3};

use crate::{
    config::SlamConfig,
    image::SmallImage,
    map::{KeyframeId, Map},
    track::{
        AlignFeature, AlignSchedule, Feature, Frame, FrameWork, Incoming, Quality, RotationAligner,
        TrackReport, Tracker, align_images,
    },
};

/// Pixels (of its level) around a predicted place that are searched.
const SEARCH_RADIUS: usize = 10;

/// Keyframes after the most similar one that get their turn.
const NEXT_PLACES: usize = 4;

/// Looks for the camera in a map.
#[derive(Debug, Clone)]
pub struct Relocator {
    camera: Camera,
    config: SlamConfig,
    rotation_aligner: RotationAligner,
    num_attempts: usize,
}

impl Relocator {
    /// For one camera.
    #[must_use]
    pub fn new(camera: &Camera, config: &SlamConfig) -> Self {
        Self {
            camera: *camera,
            config: config.clone(),
            rotation_aligner: RotationAligner::new(camera, 4),
            num_attempts: 0,
        }
    }

    /// Tries the keyframes that look most like the image. The report is that of the first that fits; with it comes the
    /// keyframe.
    pub fn attempt(
        &mut self,
        map: &Map,
        tracker: &Tracker,
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> Option<(TrackReport, KeyframeId)> {
        self.num_attempts += 1;
        let small = SmallImage::new(incoming.pyramid);
        let mut ranked: Vec<(f32, KeyframeId)> =
            map.keyframes().map(|(id, keyframe)| (keyframe.small.similarity(&small), id)).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let max_tries = self.config.relocation.max_tries;
        let places = (0..max_tries).map(|i| place_of_try((self.num_attempts - 1) * max_tries + i));
        let tried: Vec<KeyframeId> =
            places.filter_map(|place| ranked.get(place).map(|(_, id)| *id)).collect();
        for id in tried {
            let reference = frame_of(map, id)?;
            let Some(report) = self.try_keyframe(map, tracker, &reference, incoming, work) else {
                continue;
            };
            let is_found =
                report.num_converged >= self.config.relocation.min_matches && report.quality == Quality::Good;
            if is_found {
                return Some((report, id));
            }
        }
        None
    }

    fn try_keyframe(
        &self,
        map: &Map,
        tracker: &Tracker,
        reference: &Frame,
        incoming: &Incoming<'_>,
        work: &mut FrameWork<'_>,
    ) -> Option<TrackReport> {
        let pyramid = incoming.pyramid;
        let turn = self.rotation_aligner.align(&reference.pyramid, pyramid, &Rotation3::identity());
        let features: Vec<AlignFeature> = reference
            .features
            .iter()
            .map(|feature| {
                let point = map.landmark(feature.landmark).point_in_world;
                let depth = reference.camera_from_world.transform(&point).z;
                AlignFeature { px: feature.px, point: feature.ray * depth }
            })
            .collect();
        let start = Rigid3::new(turn, nalgebra::Vector3::zeros());
        let levels = (4, self.config.tracking.finest_align_level);
        let schedule = AlignSchedule { levels, max_iterations: 20 };
        let aligned = align_images(&self.camera, &reference.pyramid, pyramid, &features, &start, &schedule);
        if aligned.num_features < self.config.relocation.min_matches / 2 {
            return None;
        }
        let predicted = aligned.current_from_reference * reference.camera_from_world;
        // The alignment is only about right: look around first, then as in tracking.
        let wide = tracker.track_near(map, incoming, (&predicted, SEARCH_RADIUS), reference, work);
        if wide.num_matched < self.config.relocation.min_matches / 2 {
            return None;
        }
        Some(tracker.track_near(map, incoming, (&wide.frame.camera_from_world, 0), reference, work))
    }
}

/// Place among the most similar keyframes of a try, counted over all frames: every second try is the most similar one, the others
/// go through the next ones, so that a frame costs little and no candidate waits for long.
fn place_of_try(number: usize) -> usize {
    if number.is_multiple_of(2) { 0 } else { 1 + number / 2 % NEXT_PLACES }
}

/// A keyframe as a frame with its converged landmarks.
fn frame_of(map: &Map, id: KeyframeId) -> Option<Frame> {
    let keyframe = map.keyframe(id);
    let feature = |landmark: &crate::map::LandmarkId| {
        let observation = map.landmark(*landmark).observation_in(id)?;
        map.landmark(*landmark).is_converged().then_some(Feature {
            landmark: *landmark,
            px: observation.px,
            ray: observation.ray,
            level: observation.level,
            covariance_px: observation.covariance_px,
        })
    };
    Some(Frame {
        number: keyframe.frame,
        at: keyframe.at,
        pyramid: keyframe.pyramid.clone()?,
        camera_from_world: *keyframe.camera_from_world(),
        features: keyframe.landmarks.iter().filter_map(feature).collect(),
        turned_from: None,
    })
}
