//! The constant errors of the cameras that did not take the present image.

use nalgebra::{Const, DMatrix, DVector, Dyn, OMatrix, SMatrix};

use super::{
    filter::{CAMERA, CameraMatrix, Covariance, MOUNT, SLOW, STATE, State},
    mount::Mount,
};
use crate::observation::features::CameraVector;

/// Angles of the constant error of a camera.
const ANGLES: usize = 3;

/// What a track knows of them. They are part of its state like that of the present camera, which alone an image shows; the others follow by
/// their covariance with what it shows.
#[derive(Debug, Clone)]
pub(super) struct OtherMounts {
    /// Index of each camera.
    cameras: Vec<usize>,
    /// Their errors, one after the other.
    tilts_rad: DVector<f64>,
    /// Covariance with the state.
    with_state: OMatrix<f64, Dyn, Const<STATE>>,
    /// Covariance with each other.
    covariance: DMatrix<f64>,
}

impl Default for OtherMounts {
    fn default() -> Self {
        Self {
            cameras: Vec::new(),
            tilts_rad: DVector::zeros(0),
            with_state: OMatrix::<f64, Dyn, Const<STATE>>::zeros(0),
            covariance: DMatrix::zeros(0, 0),
        }
    }
}

impl OtherMounts {
    /// What is known of each of them, with the camera's index.
    pub fn iter(&self) -> impl Iterator<Item = (usize, Mount)> {
        self.cameras.iter().enumerate().map(|(slot, camera)| {
            let first = ANGLES * slot;
            let tilt_rad = self.tilts_rad.fixed_rows::<ANGLES>(first).into_owned();
            let covariance = self.covariance.fixed_view::<ANGLES, ANGLES>(first, first).into_owned();
            (*camera, Mount { tilt_rad, covariance })
        })
    }

    /// The next image is of the camera `to` instead of `from`: their errors change places. `mount` is what is known of a camera that has not
    /// taken an image yet.
    pub fn look_through(
        &mut self,
        (mean, covariance): (&mut State, &mut Covariance),
        (from, to): (usize, usize),
        mount: &Mount,
    ) {
        let slot = self.cameras.iter().position(|camera| *camera == to).unwrap_or_else(|| self.add(mount));
        self.cameras[slot] = from;
        let size = STATE + self.tilts_rad.len();
        let others = (STATE, STATE);
        let mut all = DMatrix::zeros(size, size);
        all.view_mut((0, 0), covariance.shape()).copy_from(covariance);
        all.view_mut((STATE, 0), self.with_state.shape()).copy_from(&self.with_state);
        all.view_mut((0, STATE), (STATE, self.tilts_rad.len())).copy_from(&self.with_state.transpose());
        all.view_mut(others, self.covariance.shape()).copy_from(&self.covariance);
        for axis in 0..ANGLES {
            let (here, there) = (MOUNT + axis, ANGLES * slot + axis);
            std::mem::swap(&mut mean[here], &mut self.tilts_rad[there]);
            all.swap_rows(here, STATE + there);
            all.swap_columns(here, STATE + there);
        }
        covariance.copy_from(&all.fixed_view::<STATE, STATE>(0, 0));
        self.with_state.copy_from(&all.view((STATE, 0), self.with_state.shape()));
        self.covariance.copy_from(&all.view(others, self.covariance.shape()));
    }

    /// One more camera, whose place among the others is returned.
    fn add(&mut self, mount: &Mount) -> usize {
        let slot = self.cameras.len();
        let (first, size) = (ANGLES * slot, ANGLES * (slot + 1));
        self.cameras.push(0);
        self.tilts_rad.resize_vertically_mut(size, 0.0);
        self.with_state.resize_vertically_mut(size, 0.0);
        self.covariance.resize_mut(size, size, 0.0);
        self.tilts_rad.fixed_rows_mut::<ANGLES>(first).copy_from(&mount.tilt_rad);
        self.covariance.fixed_view_mut::<ANGLES, ANGLES>(first, first).copy_from(&mount.covariance);
        slot
    }

    /// The state changes by this matrix.
    pub fn change(&mut self, change: &Covariance) {
        if !self.cameras.is_empty() {
            self.with_state *= change.transpose();
        }
    }

    /// An entry of the state begins anew.
    pub fn forget(&mut self, entry: usize) {
        self.with_state.column_mut(entry).fill(0.0);
    }

    /// Takes in what an image tells. `cross` is the covariance of the state with what the image sees.
    pub fn learn(
        &mut self,
        cross: &SMatrix<f64, STATE, CAMERA>,
        pull: &CameraVector,
        information: &CameraMatrix,
    ) {
        if self.cameras.is_empty() {
            return;
        }
        let mut own = self.with_state.fixed_columns::<CAMERA>(0).into_owned();
        let mut turn = own.fixed_columns_mut::<ANGLES>(SLOW);
        turn += self.with_state.fixed_columns::<ANGLES>(MOUNT);
        let told = &own * information;
        self.tilts_rad += own.clone() * pull;
        let covariance = &self.covariance - &told * own.transpose();
        self.covariance = (&covariance + covariance.transpose()) * 0.5;
        self.with_state -= told * cross.transpose();
    }
}
