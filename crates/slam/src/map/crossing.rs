//! Frames that two maps know: the end of the one and the beginning of the next, where the camera was lost for a while between them.

use nalgebra::Matrix6;
use visloc_core::geom::{CameraFrame, Rigid3};

use super::{KeyframeId, Map, MapId};

/// Where a frame is in one map.
#[derive(Debug, Clone, Copy)]
pub struct Standing {
    /// The keyframe that it hangs on.
    pub keyframe: KeyframeId,
    /// Its pose relative to that keyframe.
    pub camera_from_keyframe: Rigid3<CameraFrame, CameraFrame>,
    /// Scale of the keyframe then, see [`Map::scale_of`].
    pub scale: f64,
    /// Covariance of the pose over a twist in the frame of the camera: translation first, map units and radians.
    pub covariance: Matrix6<f64>,
}

/// A frame that two maps know. How the maps lie to each other there is known but for the scale, which one frame does not tell.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// In the map that was tracked before.
    pub before: Standing,
    /// In the map that was started afterwards.
    pub after: Standing,
}

impl Standing {
    /// On a keyframe that is still there, in units of now.
    fn now(&self, map: &Map) -> Self {
        let pose = map.pose_on(self.keyframe, &self.camera_from_keyframe, self.scale);
        let keyframe = map.standing_for(self.keyframe);
        let grown = map.scale_of(self.keyframe) / self.scale;
        let mut covariance = self.covariance;
        covariance.fixed_rows_mut::<3>(0).scale_mut(grown);
        covariance.fixed_columns_mut::<3>(0).scale_mut(grown);
        let camera_from_keyframe = pose * map.pose_of(keyframe).inverse();
        Self { keyframe, camera_from_keyframe, scale: map.scale_of(keyframe), covariance }
    }
}

impl Crossing {
    /// Covariance of where one map has the frame as the other one sees it.
    #[must_use]
    pub fn covariance(&self) -> Matrix6<f64> {
        self.before.covariance + self.after.covariance
    }
}

impl Map {
    /// Takes note of a frame that two maps know.
    pub(crate) fn add_crossing(&mut self, crossing: Crossing) {
        self.crossings.push(crossing);
    }

    /// Whether a map that was started after the camera was lost began between two keyframes: that they follow each other says nothing.
    #[must_use]
    pub(crate) fn begins_between(&self, earlier: KeyframeId, later: KeyframeId) -> bool {
        self.crossings.iter().any(|crossing| (earlier.0 + 1..=later.0).contains(&crossing.after.keyframe.0))
    }

    /// Frames that another map and the active one know, where they are in either: in units of now, and on keyframes that are still there.
    pub(crate) fn crossings_to(&self, other: MapId) -> impl Iterator<Item = (Standing, Standing)> {
        let sides = self.crossings.iter().flat_map(|c| [(c.before, c.after), (c.after, c.before)]);
        let is_of = |side: &Standing, map: MapId| self.map_of(side.keyframe) == Some(map);
        sides
            .filter(move |(there, here)| is_of(there, other) && is_of(here, self.active))
            .map(|(there, here)| (there.now(self), here.now(self)))
    }

    /// Frames that are known by two parts of the map that is active, which were maps of their own: in units of now, and on keyframes that
    /// are still there.
    pub fn crossings(&self) -> impl Iterator<Item = Crossing> {
        let is_within = |side: &Standing| self.map_of(side.keyframe) == Some(self.active);
        let within = self.crossings.iter().filter(move |c| is_within(&c.before) && is_within(&c.after));
        let now = within
            .map(|crossing| Crossing { before: crossing.before.now(self), after: crossing.after.now(self) });
        // Where both sides hang on one keyframe by now, it says nothing any more.
        now.filter(|crossing| crossing.before.keyframe != crossing.after.keyframe)
    }
}
