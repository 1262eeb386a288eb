//! The code inside of a dark square.

use nalgebra::{Matrix3, Point2};

use crate::{
    board::{GRID, nearest},
    saddles::FloatImage,
    solve::homography,
};

/// A tag that was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tag {
    /// Its number.
    pub id: usize,
    /// Which of the quad's corners is the tag's upper left one; the others follow clockwise.
    pub first_corner: usize,
}

/// Black and white of a tag must differ by this, of 255.
const MIN_CONTRAST: f64 = 8.0;

/// Reads the tag whose outer corners these are, clockwise. `None` if there is none.
pub fn read_tag(image: &FloatImage, corners_px: &[Point2<f64>; 4], border_cells: usize) -> Option<Tag> {
    let num_cells = (GRID + 2 * border_cells) as f64;
    let unit = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let pairs: Vec<_> = unit
        .iter()
        .zip(corners_px)
        .map(|((x, y), px)| (Point2::new(x * num_cells, y * num_cells), *px))
        .collect();
    let px_from_cells = homography(&pairs)?;
    let cell = |x: f64, y: f64| brightness(image, &px_from_cells, x, y);
    let border = (0..GRID + 2).flat_map(|i| {
        let (along, near, far) = (i as f64 + border_cells as f64 - 0.5, 0.5 * border_cells as f64, num_cells);
        [(along, near), (along, far - near), (near, along), (far - near, along)]
    });
    let mut black: Vec<f64> = border.map(|(x, y)| image.sample(&place(&px_from_cells, x, y))).collect();
    black.sort_by(f64::total_cmp);
    let black = black[black.len() / 2];
    let first = border_cells as f64 + 0.5;
    let cells: Vec<f64> =
        (0..GRID * GRID).map(|i| cell(first + (i % GRID) as f64, first + (i / GRID) as f64)).collect();
    let mut sorted = cells.clone();
    sorted.sort_by(f64::total_cmp);
    // Every code has more than a few white bits.
    let white = sorted[GRID * GRID - 5];
    if white - black < MIN_CONTRAST {
        return None;
    }
    let threshold = f64::midpoint(black, white);
    let bits = cells.iter().fold(0, |bits, v| bits << 1 | u64::from(*v > threshold));
    let (id, quarters) = nearest(bits)?;
    Some(Tag { id, first_corner: quarters })
}

fn place(px_from_cells: &Matrix3<f64>, x: f64, y: f64) -> Point2<f64> {
    let p = px_from_cells * Point2::new(x, y).to_homogeneous();
    Point2::new(p.x / p.z, p.y / p.z)
}

/// Mean of the middle of a cell.
fn brightness(image: &FloatImage, px_from_cells: &Matrix3<f64>, x: f64, y: f64) -> f64 {
    let offsets = [(0.0, 0.0), (0.2, 0.2), (-0.2, 0.2), (0.2, -0.2), (-0.2, -0.2)];
    offsets.iter().map(|(dx, dy)| image.sample(&place(px_from_cells, x + dx, y + dy))).sum::<f64>() / 5.0
}
