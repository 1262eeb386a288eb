//! The page on which map and image are laid over each other by hand.

use std::path::Path;

use anyhow::{Context, Result, bail};
use serde::Serialize;
use visloc_core::{files, geom::Camera};
use visloc_io::{
    camera_file::{CameraToml, read_camera},
    image_codec::read_gray_image,
};
use visloc_plot::base64;
use visloc_world::Map;

use crate::report::map_lines;

/// Most bytes of an image.
const MAX_IMAGE_BYTES: u64 = 1 << 28;
/// Angle of view of a camera that is not known, degrees.
const USUAL_VIEW_DEG: f64 = 60.0;

/// Where the page begins.
#[derive(Debug, Clone, Copy, Default)]
pub struct Start<'a> {
    /// The camera.
    pub camera: Option<&'a Path>,
    /// x, y, height (meters), heading, pitch down, roll clockwise (degrees).
    pub pose: Option<[f64; 6]>,
}

/// What the page is given.
#[derive(Serialize)]
struct Input {
    name: String,
    image: String,
    camera: CameraToml,
    pose: [f64; 6],
    /// Lines through points of the world, meters.
    lines: Vec<Vec<[f64; 3]>>,
}

/// The page as one file that needs nothing else.
pub fn by_hand_page(image: &Path, map: &str, start: &Start<'_>) -> Result<String> {
    let place = || image.display().to_string();
    let pixels = read_gray_image(image).with_context(place)?;
    let size_px = (u32::try_from(pixels.width())?, u32::try_from(pixels.height())?);
    let bytes = files::read(image, MAX_IMAGE_BYTES).with_context(place)?;
    let kind = if bytes.starts_with(&[0x89, b'P', b'N', b'G']) { "png" } else { "jpeg" };
    let camera = match start.camera {
        Some(path) => read_camera(path)?,
        None => usual_camera(size_px)?,
    };
    if camera.size_px() != size_px {
        let ((w, h), (cw, ch)) = (size_px, camera.size_px());
        bail!("{}: expected {cw} x {ch} px as the camera, found {w} x {h} px", image.display());
    }
    let input = Input {
        name: image.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        image: format!("data:image/{kind};base64,{}", base64(&bytes)),
        camera: CameraToml::from(&camera),
        pose: start.pose.unwrap_or([0.0, 0.0, 0.5, 0.0, 15.0, 0.0]),
        lines: map_lines(&Map::load(map)?)?,
    };
    Ok(visloc_plot::by_hand_page(&serde_json::to_string(&input)?))
}

fn usual_camera((width, height): (u32, u32)) -> Result<Camera> {
    let focal = f64::from(width) / 2.0 / (USUAL_VIEW_DEG.to_radians() / 2.0).tan();
    let center = ((f64::from(width) - 1.0) / 2.0, (f64::from(height) - 1.0) / 2.0);
    Ok(Camera::pinhole((width, height), (focal, focal), center)?)
}
