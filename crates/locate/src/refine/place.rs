//! Which tracks are at a place.

use visloc_core::geom::PlanarPose;

use super::{RefinementConfig, filter::PoseFilter, track::Track};
use crate::observation::features::FeatureModel;

/// The tracks at this place or its mirrored one, or at some times the distance.
pub(super) fn near<'a>(
    tracks: &'a [Track],
    model: &dyn FeatureModel,
    place: &'a PlanarPose,
    factor: f64,
    config: &'a RefinementConfig,
) -> impl Iterator<Item = usize> + 'a {
    let mirrored = model.mirrored(place);
    let is_there = move |track: &Track| {
        is_near(&track.filter, place, factor, config)
            || mirrored.is_some_and(|place| is_near(&track.filter, &place, factor, config))
    };
    (0..tracks.len()).filter(move |i| is_there(&tracks[*i]))
}

fn is_near(filter: &PoseFilter, place: &PlanarPose, factor: f64, config: &RefinementConfig) -> bool {
    let max_m = factor * config.merge_distance_m;
    // Most of many tracks are far away along x: that is quickly told.
    if (filter.x_m() - place.x_m).abs() >= max_m {
        return false;
    }
    is_same(&filter.pose(), place, factor, config)
}

/// Whether two poses are the same place, or at some times the distance.
pub(super) fn is_same(a: &PlanarPose, b: &PlanarPose, factor: f64, config: &RefinementConfig) -> bool {
    a.distance_m(b) < factor * config.merge_distance_m
        && a.heading_difference_rad(b) < factor * config.merge_turn_rad
}
