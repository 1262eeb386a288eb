//! `visloc calibrate`: a camera from pictures of a board.

use std::path::Path;

use anyhow::{Result, anyhow};
use visloc_calib::{Board, Calibration, LensModel, calibrate, coverage, several_cameras};
use visloc_io::camera_file::{CameraFormat, write_camera};

use crate::{
    args::CalibrateArgs,
    calibration::{
        CalibrationReport, Detected, NamedImage, OF_BOARD, calibrate_by_motion, camera_toml, draw, end,
        find_boards, markdown, open_images, print,
    },
    host::stop_at_signals,
    report::save_json,
    run::{Saving, write_text},
    say,
};

/// Runs the command.
pub fn execute(args: &CalibrateArgs) -> Result<()> {
    if !args.pattern.is_given() {
        return calibrate_by_motion(args);
    }
    let board = args.pattern.board()?;
    stop_at_signals();
    let pictures = open_images(&args.source, &args.options, OF_BOARD)?;
    let done = calibrate_from(args, &board, &pictures.images);
    end(done, pictures.damage)
}

fn calibrate_from(args: &CalibrateArgs, board: &Board, images: &[NamedImage]) -> Result<()> {
    let detected = find_boards(board, images)?;
    let found = calibrate(
        board,
        detected.size_px,
        &detected.views,
        args.model.unwrap_or(LensModel::RadialTangential),
    )
    .map_err(|error| anyhow!("{}: {error}{}", args.source, first_reject(&detected)))?;
    let coverage = coverage(&found);
    print(&found, &coverage, &detected);
    if let Some(several) = several_cameras(
        board,
        detected.size_px,
        &detected.views,
        args.model.unwrap_or(LensModel::RadialTangential),
    ) {
        let [(a, b), (c, d)] = several.values;
        let [first, second] = &several.groups;
        say::note!(
            "pictures {first}* and {second}* look like those of two cameras: alone {} is {a:.1} +- {b:.1} and {c:.1} +- {d:.1} px; calibrate each \
             from its own pictures",
            several.parameter
        );
    }
    let report = CalibrationReport::new(&found, &coverage, &detected);
    let mut saving = Saving::default();
    saving.write("camera", args.out.as_deref(), |path| write_text(path, &camera_toml(&found)?));
    saving.write("CameraInfo", args.ros.as_deref(), |path| {
        write_text(path, &write_camera(&found.camera, CameraFormat::Ros, "").map_err(|error| anyhow!(error))?)
    });
    saving.save_if(args.json.json.as_deref(), |path| save_json(path, &report));
    saving.save_if(args.report.as_deref(), |folder| {
        write_text(&folder.join("report.md"), &markdown(&args.source, &report))?;
        draw_all(folder, &found, &coverage, images)?;
        say::line!("report: {}", folder.join("report.md").display());
        Ok(())
    });
    saving.end()
}

/// Why the board was not found in the first picture where it was not.
fn first_reject(detected: &Detected) -> String {
    detected.rejected.first().map_or_else(String::new, |(name, reason)| format!("; {name}: {reason}"))
}

fn draw_all(
    folder: &Path,
    found: &Calibration,
    coverage: &visloc_calib::Coverage,
    images: &[NamedImage],
) -> Result<()> {
    let worst = found.views.iter().max_by(|a, b| a.rms_px().total_cmp(&b.rms_px()));
    let image = worst.and_then(|view| images.iter().find(|image| image.name == view.name));
    let pixels =
        image.map(|image| Ok::<_, anyhow::Error>((image.name.as_str(), image.read()?))).transpose()?;
    draw(folder, found, coverage, pixels.as_ref().map(|(name, image)| (*name, image)))
}
