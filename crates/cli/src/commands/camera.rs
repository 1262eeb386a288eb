//! `visloc camera`: calibrations in other forms, boards to print, pictures of boards.

use std::{fmt::Write as _, path::Path};

use anyhow::{Context, Result, anyhow, bail};
use visloc_calib::{
    Board,
    render::{RenderSettings, random_pose, render},
};
use visloc_core::{RngTree, files};
use visloc_io::{
    camera_file::{CameraFormat, read_camera, write_camera},
    image_codec::encode_png,
};

use crate::{
    args::{CameraArgs, CameraCommand},
    calibration::{Start, by_hand_page},
    run::{expect_new_folder, write_text},
    say,
};

/// Runs the command.
pub fn execute(args: &CameraArgs) -> Result<()> {
    match &args.command {
        CameraCommand::Convert { input, output, format } => convert(input, output, *format),
        CameraCommand::Board { pattern, out } => {
            write_text(out, &board_svg(&pattern.board()?))?;
            say::line!("{}: print it at 100 %, measure it, and glue it to something flat", out.display());
            Ok(())
        }
        CameraCommand::ByHand { image, map, camera, pose, out } => {
            let start = Start { camera: camera.as_deref(), pose: *pose };
            write_text(out, &by_hand_page(image, map, &start)?)?;
            say::line!("{}: open it in a browser", out.display());
            Ok(())
        }
        CameraCommand::Render { camera, pattern, count, out, seed } => {
            render_pictures(camera, &pattern.board()?, *count, out, seed.value())
        }
    }
}

fn convert(input: &Path, output: &Path, format: Option<CameraFormat>) -> Result<()> {
    let camera = read_camera(input)?;
    let extension = output.extension().map(|e| e.to_string_lossy().to_lowercase());
    let is_toml = |format| matches!(format, CameraFormat::Toml);
    let format = match (format, extension.as_deref()) {
        (Some(format), Some(ending @ ("toml" | "yaml" | "yml"))) if is_toml(format) != (ending == "toml") => {
            bail!(
                "{}: expected a name that ends in {} for this --format, found .{ending}",
                output.display(),
                if is_toml(format) { ".toml" } else { ".yaml" }
            )
        }
        (Some(format), _) => format,
        (None, Some("toml")) => CameraFormat::Toml,
        (None, Some("yaml" | "yml")) => CameraFormat::Ros,
        _ => bail!("{}: expected .toml or .yaml, or a --format", output.display()),
    };
    let head = format!("Converted from {}.", input.display());
    let text =
        write_camera(&camera, format, &head).map_err(|error| anyhow!("{}: {error}", output.display()))?;
    write_text(output, &text)?;
    say::line!("{}", output.display());
    Ok(())
}

/// The board in millimeters.
fn board_svg(board: &Board) -> String {
    let [low, high] = board.bounds_m();
    let (width, height) = (1000.0 * (high.x - low.x), 1000.0 * (high.y - low.y));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.3}mm\" height=\"{height:.3}mm\" viewBox=\"0 0 {width:.3} \
         {height:.3}\" shape-rendering=\"crispEdges\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
    );
    for (corner, side, is_black) in board.squares() {
        let (x, y, side) = (1000.0 * (corner.x - low.x), 1000.0 * (corner.y - low.y), 1000.0 * side);
        let fill = if is_black { "#000" } else { "#fff" };
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.3}\" y=\"{y:.3}\" width=\"{side:.3}\" height=\"{side:.3}\" fill=\"{fill}\"/>"
        );
    }
    svg + "</svg>\n"
}

fn render_pictures(camera: &Path, board: &Board, count: u32, folder: &Path, seed: u64) -> Result<()> {
    let camera = read_camera(camera)?;
    expect_new_folder(folder)?;
    for index in 0..count {
        let mut rng = RngTree::new(seed).stream("board", u64::from(index));
        let pose = random_pose(board, &camera, &mut rng).ok_or_else(|| {
            anyhow!("the camera cannot see this board as a whole: is its focal length right?")
        })?;
        let gray = render(board, &camera, &pose, &RenderSettings::default(), &mut rng);
        let path = folder.join(format!("{index:03}.png"));
        files::replace(&path, encode_png(&gray.to_rgb())?).with_context(|| path.display().to_string())?;
    }
    say::line!("{count} pictures: {}", folder.display());
    Ok(())
}
