//! The steps of a calibration.

use visloc_core::{geom::Camera, median};

use super::{
    CalibrateError, Calibration, DropReason, DroppedView, Parameter, SeenCorner, View, same_view::same_views,
};
use crate::{
    Board, BoardCorner, LensModel,
    solve::{CameraFromBoard, Intrinsics, Observation, RefineSettings, Refined, refine, residual, start},
};

/// The corners of one picture.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewInput {
    /// For messages.
    pub name: String,
    /// What was found. Corners whose pixels are not finite, or that the board does not have, are left out.
    pub corners: Vec<BoardCorner>,
}

/// Fewest pictures.
const MIN_VIEWS: usize = 3;
/// A picture is dropped if its median residual is so many times the usual one.
const VIEW_OUTLIER_FACTOR: f64 = 4.0;
/// A corner is left out if its residual is so many standard deviations: of a normal distribution in the plane, 4 in a million are
/// beyond.
const CORNER_OUTLIER_SIGMAS: f64 = 5.0;
const MIN_CORNERS: usize = 8;
/// A picture is never dropped for a median residual below this, pixels.
const HARMLESS_PX: f64 = 0.3;
/// Largest standard deviation of a focal length, as a share of it, and of the principal point, as a share of the image.
const MAX_SPREAD: f64 = 0.05;
/// A corner that lies farther outside of the picture, as a share of its size, is of a picture of another size; a nearer one may be a false one.
const MAX_OUTSIDE: f64 = 0.1;
const NAMES: [[&str; 9]; 2] = [
    ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"],
    ["fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", ""],
];

/// The views that are still in use.
struct Work {
    names: Vec<String>,
    ids: Vec<Vec<usize>>,
    observations: Vec<Vec<Observation>>,
    poses: Vec<CameraFromBoard>,
    intrinsics: Intrinsics,
    iterations: usize,
    covariance: Option<nalgebra::SMatrix<f64, 9, 9>>,
}

/// Calibrates a camera from the corners of a board in several pictures of `size_px`, with a lens of a model.
///
/// Pictures that show the same view as another one, as neighbors in a video do, are not counted again: the standard deviations hold for
/// views. First guess from homographies; robust refinement; pictures that do not fit are dropped, one after the other; corners that
/// do not fit are left out; final refinement without weights, for honest standard deviations.
///
/// # Errors
/// If the board is impossible, a corner lies far outside of `size_px`, or the pictures are too few or do not determine the camera.
pub fn calibrate(
    board: &Board,
    size_px: (u32, u32),
    inputs: &[ViewInput],
    model: LensModel,
) -> Result<Calibration, CalibrateError> {
    board.check()?;
    let mut dropped = Vec::new();
    let mut work = first_guess(board, size_px, inputs, model, &mut dropped)?;
    work.refine(100.0 * HARMLESS_PX, 60);
    work.refine(2.0, 60);
    while let Some(worst) = work.worst_view(VIEW_OUTLIER_FACTOR) {
        dropped.push(work.remove(worst));
        if work.names.len() < MIN_VIEWS {
            return Err(too_few(work.names.len(), dropped));
        }
        work.refine(2.0, 60);
    }
    let sigma_px = work.robust_sigma_px();
    work.refine(2.5 * sigma_px, 100);
    let limit_px = CORNER_OUTLIER_SIGMAS * work.robust_sigma_px();
    let all = work.observations.clone();
    work.keep_within(limit_px);
    work.refine(f64::INFINITY, 200);
    work.finish(board, size_px, model, &all, dropped)
}

fn too_few(found: usize, dropped: Vec<DroppedView>) -> CalibrateError {
    CalibrateError::TooFewViews { expected: MIN_VIEWS, found, dropped }
}

fn first_guess(
    board: &Board,
    size_px: (u32, u32),
    inputs: &[ViewInput],
    model: LensModel,
    dropped: &mut Vec<DroppedView>,
) -> Result<Work, CalibrateError> {
    let mut usable = Vec::new();
    for input in inputs {
        let is_known = |c: &&BoardCorner| c.id < board.num_corners() && c.px.iter().all(|v| v.is_finite());
        let corners: Vec<BoardCorner> = input.corners.iter().filter(is_known).copied().collect();
        let is_within = |at: f64, side: u32| (at / f64::from(side) - 0.5).abs() <= 0.5 + MAX_OUTSIDE;
        if let Some(odd) =
            corners.iter().find(|c| !is_within(c.px.x, size_px.0) || !is_within(c.px.y, size_px.1))
        {
            return Err(CalibrateError::Outside {
                name: input.name.clone(),
                px: (odd.px.x, odd.px.y),
                size_px,
            });
        }
        if corners.len() < MIN_CORNERS {
            let reason = DropReason::FewCorners(corners.len());
            dropped.push(DroppedView { name: input.name.clone(), reason });
        } else {
            usable.push(ViewInput { name: input.name.clone(), corners });
        }
    }
    let same = same_views(&usable, size_px);
    let of_same =
        same.iter().zip(&usable).filter_map(|(same, view)| Some((view, usable[(*same)?].name.clone())));
    dropped.extend(
        of_same.map(|(view, of)| DroppedView { name: view.name.clone(), reason: DropReason::SameView(of) }),
    );
    let mut is_used = same.iter().map(Option::is_none);
    usable.retain(|_| is_used.next().unwrap_or_default());
    if usable.len() < MIN_VIEWS {
        return Err(too_few(usable.len(), std::mem::take(dropped)));
    }
    let observe = |c: &BoardCorner| Observation { point_in_board: board.corner_in_board(c.id), px: c.px };
    let observations: Vec<Vec<Observation>> =
        usable.iter().map(|view| view.corners.iter().map(observe).collect()).collect();
    let guess = start(model, size_px, &observations).ok_or(CalibrateError::NoStart)?;
    let mut work = Work {
        names: Vec::new(),
        ids: Vec::new(),
        observations: Vec::new(),
        poses: Vec::new(),
        intrinsics: guess.intrinsics,
        iterations: 0,
        covariance: None,
    };
    for ((ViewInput { name, corners }, view), pose) in usable.into_iter().zip(observations).zip(guess.poses) {
        let Some(pose) = pose else {
            dropped.push(DroppedView { name, reason: DropReason::NotAPlane });
            continue;
        };
        work.names.push(name);
        work.ids.push(corners.iter().map(|c| c.id).collect());
        work.observations.push(view);
        work.poses.push(pose);
    }
    if work.names.len() < MIN_VIEWS {
        return Err(too_few(work.names.len(), std::mem::take(dropped)));
    }
    Ok(work)
}

impl Work {
    fn refine(&mut self, huber_px: f64, max_iterations: usize) {
        let settings = RefineSettings { max_iterations, huber_px };
        let Refined { intrinsics, poses, unit_covariance, iterations } =
            refine(self.intrinsics, std::mem::take(&mut self.poses), &self.observations, &settings);
        (self.intrinsics, self.poses, self.covariance) = (intrinsics, poses, unit_covariance);
        self.iterations += iterations;
    }

    /// Distances between corners and projections, pixels, of one picture.
    fn distances_px(&self, view: usize) -> Vec<f64> {
        let pose = &self.poses[view];
        let distance =
            |o: &Observation| residual(&self.intrinsics, pose, o).map_or(f64::INFINITY, |r| r.norm());
        self.observations[view].iter().map(distance).collect()
    }

    /// The picture whose residuals are farthest above the usual ones, if any is.
    fn worst_view(&self, factor: f64) -> Option<(usize, DropReason)> {
        let of_view = |view| median(self.distances_px(view)).unwrap_or(0.0);
        let medians: Vec<f64> = (0..self.poses.len()).map(of_view).collect();
        let usual_px = median(medians.iter().copied()).unwrap_or(0.0);
        let (worst, median_px) = medians.into_iter().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let is_bad = median_px > (factor * usual_px).max(HARMLESS_PX);
        is_bad.then_some((worst, DropReason::LargeResiduals { median_px, usual_px }))
    }

    fn remove(&mut self, (view, reason): (usize, DropReason)) -> DroppedView {
        self.ids.remove(view);
        self.observations.remove(view);
        self.poses.remove(view);
        DroppedView { name: self.names.remove(view), reason }
    }

    /// Standard deviation along one axis, from the median distance: of a normal distribution in the plane it is 1.1774 of it.
    fn robust_sigma_px(&self) -> f64 {
        let all = (0..self.poses.len()).flat_map(|view| self.distances_px(view));
        (median(all).unwrap_or(0.0) / 1.177_41).max(1e-6)
    }

    fn keep_within(&mut self, limit_px: f64) {
        for view in 0..self.poses.len() {
            let distances = self.distances_px(view);
            let mut distance = distances.iter();
            self.observations[view].retain(|_| distance.next().is_some_and(|d| *d <= limit_px));
        }
    }

    fn finish(
        self,
        board: &Board,
        size_px: (u32, u32),
        model: LensModel,
        all: &[Vec<Observation>],
        dropped: Vec<DroppedView>,
    ) -> Result<Calibration, CalibrateError> {
        let used: Vec<f64> = (0..self.poses.len()).flat_map(|view| self.distances_px(view)).collect();
        let sum: f64 = used.iter().map(|d| d * d).sum();
        let num_parameters = self.intrinsics.num_parameters() + 6 * self.poses.len();
        let freedom = (2.0 * used.len() as f64 - num_parameters as f64).max(1.0);
        let corner_noise_px = (sum / freedom).sqrt();
        let parameters = self.parameters(model, corner_noise_px)?;
        self.check_spread(&parameters, size_px)?;
        let camera: Camera = self.intrinsics.camera(size_px).map_err(|_| CalibrateError::NoStart)?;
        Ok(Calibration {
            camera,
            model,
            board: *board,
            parameters,
            views: self.views(all),
            dropped,
            rms_px: (sum / used.len().max(1) as f64).sqrt(),
            median_px: median(used).unwrap_or(0.0),
            corner_noise_px,
            iterations: self.iterations,
        })
    }

    fn parameters(&self, model: LensModel, noise_px: f64) -> Result<Vec<Parameter>, CalibrateError> {
        let names = &NAMES[usize::from(model == LensModel::KannalaBrandt)];
        let Some(covariance) = &self.covariance else {
            return Err(self.degenerate("the camera", "no finite covariance".to_owned()));
        };
        let parameter = |i: usize| Parameter {
            name: names[i],
            value: self.intrinsics.values[i],
            standard_deviation: covariance[(i, i)].max(0.0).sqrt() * noise_px,
        };
        Ok((0..self.intrinsics.num_parameters()).map(parameter).collect())
    }

    fn check_spread(&self, parameters: &[Parameter], size_px: (u32, u32)) -> Result<(), CalibrateError> {
        let longer = f64::from(size_px.0.max(size_px.1));
        for (parameter, scale) in
            parameters.iter().zip([parameters[0].value, parameters[1].value, longer, longer])
        {
            let is_known = parameter.standard_deviation <= MAX_SPREAD * scale;
            if !is_known {
                let reason =
                    format!("{:.1} px, known to {:.1} px", parameter.value, parameter.standard_deviation);
                return Err(self.degenerate(parameter.name, reason));
            }
        }
        Ok(())
    }

    fn degenerate(&self, parameter: &str, reason: String) -> CalibrateError {
        let tilts = self.poses.iter().map(|pose| pose.rotation()[(2, 2)].abs().min(1.0).acos());
        let tilt_deg = tilts.fold(0.0, f64::max).to_degrees();
        CalibrateError::Degenerate { parameter: parameter.to_owned(), reason, tilt_deg }
    }

    /// All corners with their residuals, those that were left out included.
    fn views(&self, all: &[Vec<Observation>]) -> Vec<View> {
        let view = |i: usize| {
            let pose = self.poses[i];
            let corners = self.ids[i].iter().zip(&all[i]).map(|(id, o)| SeenCorner {
                id: *id,
                px: o.px,
                residual_px: residual(&self.intrinsics, &pose, o).unwrap_or_default(),
                is_outlier: !self.observations[i].contains(o),
            });
            View { name: self.names[i].clone(), camera_from_board: pose, corners: corners.collect() }
        };
        (0..self.poses.len()).map(view).collect()
    }
}
