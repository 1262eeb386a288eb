//! Errors of a camera in space: numbers and pictures.

use std::path::Path;

use anyhow::Result;
use serde::Serialize;
use visloc_core::{
    CameraTrajectory,
    eval::camera::{AbsoluteError, Alignment, PosePair, RelativeErrors, Statistics},
};
use visloc_plot::{Color, Panel, Series, SpacePath, SpaceViews, TimeSeriesPicture, space_views, time_series};

/// Names and colors in the picture of errors.
const OF_POSES: (&str, Color) = ("error of poses", Color::BLUE);
const OF_MOTIONS: (&str, Color) = ("error of motions", Color::ORANGE);

/// All numbers of a comparison. Keys stay as they are; what is not known is `null`.
#[derive(Debug, Clone, Serialize)]
pub struct CameraReport {
    /// Always `camera`.
    pub kind: &'static str,
    /// Poses of the truth.
    pub truth_poses: usize,
    /// Poses of the estimate.
    pub estimate_poses: usize,
    /// Poses of the two that belong together.
    pub pairs: usize,
    /// Share of the truth's time for which there is an estimate, 0 to 1.
    pub coverage: Option<f64>,
    /// `none`, `se3` or `sim3`.
    pub alignment: &'static str,
    /// Meters of the truth for a unit of the estimate.
    pub scale: f64,
    /// Distances after alignment, meters.
    pub ate_m: Option<Statistics>,
    /// Angles after alignment, degrees.
    pub ate_rot_deg: Option<Statistics>,
    /// Length of the motions of the relative error: poses, or meters with an m.
    pub rpe_delta: String,
    /// Number of those motions.
    pub rpe_pairs: usize,
    /// Errors of their translations, meters.
    pub rpe_trans_m: Option<Statistics>,
    /// Errors of their rotations, degrees.
    pub rpe_rot_deg: Option<Statistics>,
}

impl CameraReport {
    /// Takes over errors.
    #[must_use]
    pub fn with_errors(self, absolute: &AbsoluteError, relative: &RelativeErrors) -> Self {
        let degrees = |angles: &[f64]| angles.iter().map(|angle| angle.to_degrees()).collect::<Vec<_>>();
        Self {
            scale: absolute.similarity.scale,
            ate_m: Some(absolute.statistics),
            ate_rot_deg: Statistics::of(&degrees(&absolute.each_rotation_rad)),
            rpe_pairs: relative.motions.len(),
            rpe_trans_m: Statistics::of(&relative.translation_m),
            rpe_rot_deg: Statistics::of(&degrees(&relative.rotation_rad)),
            ..self
        }
    }

    /// The errors for people, a line each.
    pub fn table(&self) -> String {
        let mut text = format!("{:<26}{:>10}{:>10}{:>10}{:>10}\n", "", "RMSE", "mean", "median", "max");
        let motions = format!("over {}", if self.rpe_delta == "1" { "1 pose".into() } else { self.delta() });
        for (label, statistics, factor) in [
            ("position [m]".to_owned(), self.ate_m, 1.0),
            ("rotation [deg]".to_owned(), self.ate_rot_deg, 1.0),
            (format!("{motions} [mm]"), self.rpe_trans_m, 1e3),
            (format!("{motions} [deg]"), self.rpe_rot_deg, 1.0),
        ] {
            if let Some(s) = statistics {
                let values =
                    [s.rmse, s.mean, s.median, s.max].map(|value| format!("{:>10.4}", value * factor));
                text += &format!("{label:<26}{}\n", values.concat());
            }
        }
        text
    }

    fn delta(&self) -> String {
        match self.rpe_delta.strip_suffix('m') {
            Some(meters) => format!("{meters} m"),
            None => format!("{} poses", self.rpe_delta),
        }
    }
}

/// Draws the errors over time, whose axis has a name, and both trajectories along two axes.
pub fn camera_pictures(
    folder: &Path,
    (title, time_label): (&str, &str),
    (truth, estimate): (&CameraTrajectory, &CameraTrajectory),
    pairs: &[PosePair],
    (absolute, relative, alignment): (&AbsoluteError, &RelativeErrors, Alignment),
) -> Result<()> {
    let subtitle = match alignment {
        Alignment::None => format!("RMSE {:.4} m, not aligned", absolute.statistics.rmse),
        _ => format!(
            "RMSE {:.4} m after alignment, scale {:.4}",
            absolute.statistics.rmse, absolute.similarity.scale
        ),
    };
    let start = truth.poses().first().map(|pose| pose.at).unwrap_or_default();
    let secs = |i: usize| pairs[i].truth.at.secs_since(start);
    let panel = |label: &str, (name, color), points| Panel {
        label: label.to_owned(),
        series: vec![Series::new(name, color, points)],
        ..Panel::default()
    };
    let at_pairs = |values: &[f64], factor: f64| -> Vec<(f64, f64)> {
        values.iter().enumerate().map(|(i, value)| (secs(i), value * factor)).collect()
    };
    let at_motions = |values: &[f64], factor: f64| -> Vec<(f64, f64)> {
        values.iter().zip(&relative.motions).map(|(value, (_, end))| (secs(*end), value * factor)).collect()
    };
    let degrees = 1_f64.to_degrees();
    let errors = TimeSeriesPicture {
        title: title.to_owned(),
        subtitle: subtitle.clone(),
        panels: vec![
            panel("position [m]", OF_POSES, at_pairs(&absolute.each, 1.0)),
            panel("rotation [deg]", OF_POSES, at_pairs(&absolute.each_rotation_rad, degrees)),
            panel("motion [m]", OF_MOTIONS, at_motions(&relative.translation_m, 1.0)),
            panel("motion [deg]", OF_MOTIONS, at_motions(&relative.rotation_rad, degrees)),
        ],
        x_label: time_label.to_owned(),
        ..TimeSeriesPicture::default()
    };
    time_series(&errors).save(folder, "errors")?;
    let place = |point: &nalgebra::Vector3<f64>| [point.x, point.y, point.z];
    let true_points = truth.poses().iter().map(|pose| place(pose.world_from_camera.translation())).collect();
    let moved = estimate.poses().iter();
    let moved = moved.map(|pose| absolute.similarity.place(pose.world_from_camera.translation()).coords);
    let [above, side] = space_views(&SpaceViews {
        title: title.to_owned(),
        subtitle,
        paths: vec![
            SpacePath::line("truth", Color::BLACK, true_points),
            SpacePath::line("estimate", Color::BLUE, moved.map(|point| place(&point)).collect()),
        ],
        ..SpaceViews::default()
    });
    above.save(folder, "trajectory")?;
    side.save(folder, "trajectory-side")?;
    Ok(())
}
