//! Images and matrices between numpy and visloc.

use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray3,
    PyUntypedArrayMethods, ndarray::Array2,
};
use pyo3::prelude::*;
use visloc::{
    GrayImage, RgbImage, Rigid3,
    nalgebra::{Matrix3, Rotation3, Vector3},
};

use crate::{refuse, refused};

/// An image of `uint8`: height x width x 3 in the order red, green, blue, or height x width.
pub fn rgb_image(image: &Bound<'_, PyAny>) -> PyResult<RgbImage> {
    if let Ok(gray) = image.extract::<PyReadonlyArray2<'_, u8>>() {
        let (width, height) = size(gray.shape())?;
        let data = gray.as_array().iter().flat_map(|value| [*value; 3]).collect();
        return RgbImage::from_raw(width, height, data).map_err(refused);
    }
    let Ok(color) = image.extract::<PyReadonlyArray3<'_, u8>>() else { return wrong(image) };
    let (width, height) = size(color.shape())?;
    if color.shape()[2] != 3 {
        return wrong(image);
    }
    let data = match color.as_slice() {
        Ok(bytes) => bytes.to_vec(),
        Err(_) => color.as_array().iter().copied().collect(),
    };
    RgbImage::from_raw(width, height, data).map_err(refused)
}

/// As [`rgb_image`], as gray values.
pub fn gray_image(image: &Bound<'_, PyAny>) -> PyResult<GrayImage> {
    let Ok(gray) = image.extract::<PyReadonlyArray2<'_, u8>>() else {
        return Ok(GrayImage::from_rgb(&rgb_image(image)?));
    };
    let (width, height) = size(gray.shape())?;
    let data = match gray.as_slice() {
        Ok(bytes) => bytes.to_vec(),
        Err(_) => gray.as_array().iter().copied().collect(),
    };
    GrayImage::from_raw(width as usize, height as usize, data).map_err(refused)
}

fn wrong<T>(image: &Bound<'_, PyAny>) -> PyResult<T> {
    let found = match (image.getattr("shape"), image.getattr("dtype")) {
        (Ok(shape), Ok(kind)) => format!("{shape} of {kind}"),
        _ => image.get_type().to_string(),
    };
    refuse(format!(
        "image: expected uint8 of (height, width, 3), red first, or (height, width), found {found}"
    ))
}

fn size(shape: &[usize]) -> PyResult<(u32, u32)> {
    match (u32::try_from(shape[1]), u32::try_from(shape[0])) {
        (Ok(width), Ok(height)) => Ok((width, height)),
        _ => refuse(format!("image: expected at most 4 billion pixels along a side, found {shape:?}")),
    }
}

/// A transform as a 4 x 4 matrix.
pub fn matrix<'py, A, B>(py: Python<'py>, transform: &Rigid3<A, B>) -> Bound<'py, PyArray2<f64>> {
    let mut out = Array2::eye(4);
    for row in 0..3 {
        for column in 0..3 {
            out[(row, column)] = transform.rotation()[(row, column)];
        }
        out[(row, 3)] = transform.translation()[row];
    }
    out.into_pyarray(py)
}

/// A 4 x 4 matrix as a transform.
pub fn transform<A, B>(matrix: &PyReadonlyArray2<'_, f64>) -> PyResult<Rigid3<A, B>> {
    let values = matrix.as_array();
    if values.shape() != [4, 4] || !values.iter().all(|value| value.is_finite()) {
        return refuse(format!(
            "transform: expected a 4 x 4 matrix of numbers, found shape {:?}",
            values.shape()
        ));
    }
    let rotation = Matrix3::from_fn(|row, column| values[(row, column)]);
    if (rotation * rotation.transpose() - Matrix3::identity()).amax() > 1e-4 || rotation.determinant() < 0.0 {
        return refuse("transform: expected a rotation in its first three rows and columns");
    }
    let translation = Vector3::from_fn(|row, _| values[(row, 3)]);
    Ok(Rigid3::new(Rotation3::from_matrix(&rotation), translation))
}

/// A 3 x 3 matrix.
pub fn matrix3<'py>(py: Python<'py>, values: &Matrix3<f64>) -> Bound<'py, PyArray2<f64>> {
    Array2::from_shape_fn((3, 3), |at| values[at]).into_pyarray(py)
}

/// A color image; its pixels are moved, not copied.
pub fn color_array(py: Python<'_>, image: RgbImage) -> PyResult<Bound<'_, PyArray3<u8>>> {
    let shape = [image.height() as usize, image.width() as usize, 3];
    PyArray1::from_vec(py, image.into_raw()).reshape(shape)
}

/// A gray image.
pub fn gray_array<'py>(py: Python<'py>, image: &GrayImage) -> PyResult<Bound<'py, PyArray2<u8>>> {
    PyArray1::from_slice(py, image.data()).reshape([image.height(), image.width()])
}
