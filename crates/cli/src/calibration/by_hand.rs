//! The page on which map and image are laid over each other by hand.

use std::{f64::consts::TAU, path::Path};

use anyhow::{Context, Result, bail};
use serde::Serialize;
use visloc_core::{files, geom::Camera};
use visloc_io::{
    camera_file::{CameraToml, read_camera},
    image_codec::read_gray_image,
};
use visloc_plot::base64;
use visloc_world::{Map, field::Field, office::Office};

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
///
/// # Errors
/// If image, map or camera cannot be read.
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

/// The lines of a map through points of the world, meters.
///
/// # Errors
/// If the map is of a kind that has none.
pub fn map_lines(map: &Map) -> Result<Vec<Vec<[f64; 3]>>> {
    match map {
        Map::Field(field) => Ok(field_lines(field)),
        Map::Office(office) => Ok(office_lines(office)),
        other => bail!("{}: expected a field or a building", other.name()),
    }
}

/// Both borders of every line of a field, the circle, the axes of marks and goals.
fn field_lines(field: &Field) -> Vec<Vec<[f64; 3]>> {
    let half = 0.5 * field.dimensions().line_width_m;
    let mut all = Vec::new();
    for line in field.lines() {
        let along = (line.end - line.start).normalize();
        let side = nalgebra::Vector2::new(-along.y, along.x) * half;
        for s in [-1.0, 1.0] {
            // Outer borders of two lines that meet end in the corner that is seen.
            let (a, b) = (line.start + side * s - along * half, line.end + side * s + along * half);
            all.push(vec![[a.x, a.y, 0.0], [b.x, b.y, 0.0]]);
        }
    }
    for radius in [field.circle_radius_m() - half, field.circle_radius_m() + half] {
        let point = |i: i32| {
            let (sin, cos) = (f64::from(i) / 72.0 * TAU).sin_cos();
            [radius * cos, radius * sin, 0.0]
        };
        all.push((0..=72).map(point).collect());
    }
    for mark in field.marks() {
        all.push(vec![[mark.start.x, mark.start.y, 0.0], [mark.end.x, mark.end.y, 0.0]]);
    }
    for goal in field.goals() {
        let (x, y, z) = (goal.x_m, goal.post_y_m, goal.crossbar_z_m);
        all.push(vec![[x, -y, 0.0], [x, -y, z], [x, y, z], [x, y, 0.0]]);
    }
    all
}

/// Feet of the walls and outlines of the doors.
fn office_lines(office: &Office) -> Vec<Vec<[f64; 3]>> {
    let walls = office.walls().iter().map(|w| vec![[w.start.x, w.start.y, 0.0], [w.end.x, w.end.y, 0.0]]);
    let doors = office.doors().iter().map(|d| {
        let ((l, r), z) = ((d.left, d.right), d.height_m);
        vec![[l.x, l.y, 0.0], [l.x, l.y, z], [r.x, r.y, z], [r.x, r.y, 0.0]]
    });
    walls.chain(doors).collect()
}
