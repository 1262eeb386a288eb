//! The map over a photo, as it is seen from a place.

use anyhow::Result;
use nalgebra::Point3;
use visloc_locate::{Photo, PhotoPose};
use visloc_plot::{Color, ImageLine, ImagePicture, Picture, image_picture};
use visloc_world::Map;

use super::map_lines;

/// Lines are drawn in pieces of this length, since lenses bend them, meters.
const PIECE_M: f64 = 0.05;

/// Draws what of the map is seen from a place.
pub fn draw_overlay(photo: &Photo, map: &Map, pose: &PhotoPose, title: String) -> Result<Picture> {
    let mut lines = Vec::new();
    for line in map_lines(map)? {
        for points_px in seen(&line, photo, pose) {
            let label = if lines.is_empty() { "map" } else { "" };
            lines.push(ImageLine { label: label.to_owned(), color: Color::VERMILION, points_px });
        }
    }
    Ok(image_picture(&ImagePicture {
        title,
        image: photo.image.clone(),
        enlargement: 2,
        lines,
        ..ImagePicture::default()
    }))
}

/// The pieces of a line through points of the world that are in the image.
fn seen(line: &[[f64; 3]], photo: &Photo, pose: &PhotoPose) -> Vec<Vec<(f64, f64)>> {
    let camera_from_world = pose.world_from_camera.inverse();
    let mut pieces: Vec<Vec<(f64, f64)>> = vec![Vec::new()];
    for ends in line.windows(2) {
        let (start, end) = (Point3::from(ends[0]), Point3::from(ends[1]));
        let num_steps = ((end - start).norm() / PIECE_M).ceil().max(1.0) as u32;
        for i in 0..=num_steps {
            let point = start + (end - start) * (f64::from(i) / f64::from(num_steps));
            let px = photo.camera.project(&camera_from_world.transform(&point)).ok();
            match (px.filter(|px| photo.camera.contains(px)), pieces.last_mut()) {
                (Some(px), Some(piece)) => piece.push((px.x, px.y)),
                _ => pieces.push(Vec::new()),
            }
        }
    }
    pieces.retain(|piece| piece.len() > 1);
    pieces
}
