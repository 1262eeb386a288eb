//! Calibration of a camera from pictures of a board.

use numpy::{IntoPyArray, PyArray2, ndarray::Array2};
use pyo3::prelude::*;
use visloc::calib::{self, AprilGrid, Board, Checkerboard, LensModel, ViewInput};

use crate::{arrays::gray_image, refuse, refused, world::Camera};

/// A board in words: `9x6 @ 0.03` (inner corners, side of a square in meters) or `aprilgrid 6x6 @ 0.088 : 0.3` (tags, side of a tag in
/// meters, gap as a share of it).
fn board_of(text: &str) -> PyResult<Board> {
    let wrong = || {
        refuse(format!(
            "board: expected '9x6 @ 0.03' (inner corners, side in meters) or 'aprilgrid 6x6 @ 0.088 : 0.3', found '{text}'"
        ))
    };
    let (is_grid, rest) = match text.trim().strip_prefix("aprilgrid") {
        Some(rest) => (true, rest),
        None => (false, text.trim()),
    };
    let Some((counts, sizes)) = rest.split_once('@') else { return wrong() };
    let Some((columns, rows)) = counts.split_once('x') else { return wrong() };
    let (Ok(columns), Ok(rows)) = (columns.trim().parse(), rows.trim().parse()) else { return wrong() };
    let (side, gap) = sizes.split_once(':').unwrap_or((sizes, "0.3"));
    let (Ok(side_m), Ok(spacing)) = (side.trim().parse(), gap.trim().parse()) else { return wrong() };
    let board = if is_grid {
        Board::AprilGrid(AprilGrid { columns, rows, tag_m: side_m, spacing, first_id: 0, border_cells: 2 })
    } else {
        Board::Checkerboard(Checkerboard { columns, rows, square_m: side_m })
    };
    board.check().map_err(refused)?;
    Ok(board)
}

/// Corners of a board in an image: their numbers and pixels, (N, 2).
#[pyfunction]
pub fn find_board<'py>(
    py: Python<'py>,
    board: &str,
    image: &Bound<'py, PyAny>,
) -> PyResult<(Vec<usize>, Bound<'py, PyArray2<f64>>)> {
    let (board, image) = (board_of(board)?, gray_image(image)?);
    let found = py.detach(|| calib::detect(&board, &image)).map_err(refused)?;
    let ids = found.corners.iter().map(|corner| corner.id).collect();
    let pixels = Array2::from_shape_fn((found.corners.len(), 2), |(i, axis)| found.corners[i].px[axis]);
    Ok((ids, pixels.into_pyarray(py)))
}

/// A calibration and how good it is.
#[pyclass(frozen, get_all, module = "visloc")]
pub struct Calibration {
    camera: Camera,
    rms_px: f64,
    /// Name, value and standard deviation of each.
    parameters: Vec<(String, f64, f64)>,
    num_used: usize,
    /// Pictures that were left out, with reasons.
    dropped: Vec<String>,
}

/// Calibrates a camera from pictures of a board.
#[pyfunction]
#[pyo3(signature = (board, images, *, model = "radial-tangential"))]
pub fn calibrate(
    py: Python<'_>,
    board: &str,
    images: Vec<Bound<'_, PyAny>>,
    model: &str,
) -> PyResult<Calibration> {
    let board = board_of(board)?;
    let model = match model {
        "radial-tangential" => LensModel::RadialTangential,
        "radial-tangential-4" => LensModel::RadialTangential4,
        "kannala-brandt" => LensModel::KannalaBrandt,
        other => {
            return refuse(format!(
                "model: expected radial-tangential, radial-tangential-4 or kannala-brandt, found '{other}'"
            ));
        }
    };
    let images = images.iter().map(gray_image).collect::<PyResult<Vec<_>>>()?;
    let Some(first) = images.first() else { return refuse("images: expected at least one, found none") };
    let size = (first.width(), first.height());
    let (Ok(width), Ok(height)) = (u32::try_from(size.0), u32::try_from(size.1)) else {
        return refuse("images: too large");
    };
    if let Some(i) = images.iter().position(|image| (image.width(), image.height()) != size) {
        return refuse(format!(
            "images: expected all of {width} x {height} px, found another size at number {i}"
        ));
    }
    py.detach(|| {
        let mut dropped = Vec::new();
        let mut views = Vec::new();
        for (i, image) in images.iter().enumerate() {
            match calib::detect(&board, image) {
                Ok(found) => views.push(ViewInput { name: i.to_string(), corners: found.corners }),
                Err(reason) => dropped.push(format!("{i}: {reason}")),
            }
        }
        let result = calib::calibrate(&board, (width, height), &views, model).map_err(refused)?;
        dropped.extend(result.dropped.iter().map(|view| format!("{}: {}", view.name, view.reason)));
        let parameters = result.parameters.iter();
        Ok(Calibration {
            camera: Camera(result.camera),
            rms_px: result.rms_px,
            parameters: parameters.map(|p| (p.name.to_owned(), p.value, p.standard_deviation)).collect(),
            num_used: result.views.len(),
            dropped,
        })
    })
}
