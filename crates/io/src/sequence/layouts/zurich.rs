//! Zurich urban MAV: `MAV Images/NNNNN.jpg`, 30 Hz by their numbers, and `Log Files/GroundTruthAGL.csv` with the camera's place
//! every 30 images (UTM meters, less the first) and its orientation.
//!
//! The camera is that of the dataset's `calibration_data.npz`, which is the same in every copy. The orientation is read as omega, phi
//! and kappa of photogrammetry, degrees: R = Rx(omega) Ry(phi) Rz(kappa) from an image frame with y up to the map; errors of
//! positions do not use it.
//!
//! Source: Majdik et al., "The Zurich urban micro aerial vehicle dataset", 2017.

use std::path::Path;

use nalgebra::{Matrix3, Rotation3, Vector3};
use visloc_core::{
    CameraPose, CameraTrajectory, files,
    geom::{Distortion, Rigid3},
};

use super::{Contents, Layout, first_file, numbered::at_number};
use crate::{
    FileError,
    sequence::Calibration,
    text::{data_lines, parse_number},
};

pub(super) const LAYOUT: Layout = Layout {
    key: "zurich",
    name: "Zurich urban MAV",
    mark: "'MAV Images'",
    is_here: |folder| folder.join("MAV Images").is_dir(),
    read,
};

fn read(folder: &Path) -> Result<Contents, FileError> {
    let k = [-0.280_525_13, 0.115_806_413, -9.843_367_85e-4, 1.584_792_48e-4, -0.027_021_503_4];
    let calibration = Calibration {
        size_px: Some((1920, 1080)),
        distortion: Distortion::RadialTangential(k),
        ..Calibration::pinhole((893.390_108, 898.326_486), (951.131_004, 555.133_501))
    };
    let mut contents = Contents::numbered(folder, "MAV Images", calibration)?;
    if let Some(file) = first_file(folder, &["Log Files/GroundTruthAGL.csv"]) {
        contents.set_truth(read_truth(&file));
    }
    Ok(contents)
}

/// Lines `imgid, x, y, z, omega, phi, kappa, ...` below a header.
fn read_truth(path: &Path) -> Result<CameraTrajectory, FileError> {
    let text = files::read_text(path).map_err(FileError::io(path))?;
    let mut truth = CameraTrajectory::new();
    let mut origin = None;
    for (number, line) in data_lines(&text) {
        if line.starts_with(|c: char| c.is_alphabetic()) {
            continue;
        }
        let values: Result<Vec<f64>, String> =
            line.split(',').take(7).map(|field| parse_number(field.trim())).collect();
        let values = values.map_err(FileError::line(path, number))?;
        let [image, x, y, z, omega, phi, kappa] = values[..] else {
            let reason = format!("expected imgid, x, y, z, omega, phi, kappa, found '{line}'");
            return Err(FileError::line(path, number)(reason));
        };
        let position = Vector3::new(x, y, z);
        let origin = *origin.get_or_insert(position);
        let pose = CameraPose {
            at: at_number(image),
            world_from_camera: place(position - origin, [omega, phi, kappa]),
        };
        truth.push(pose).map_err(|refused| {
            let reason = format!("expected images in order, found {} again or late", refused.at);
            FileError::line(path, number)(reason)
        })?;
    }
    Ok(truth)
}

fn place<Dst, Src>(position: Vector3<f64>, degrees: [f64; 3]) -> Rigid3<Dst, Src> {
    let [omega, phi, kappa] = degrees.map(f64::to_radians);
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), omega)
        * Rotation3::from_axis_angle(&Vector3::y_axis(), phi)
        * Rotation3::from_axis_angle(&Vector3::z_axis(), kappa);
    // Photogrammetry's image frame has y up and looks along -z.
    let optical = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
    Rigid3::new(Rotation3::from_matrix_unchecked(turn.into_inner() * optical), position)
}
