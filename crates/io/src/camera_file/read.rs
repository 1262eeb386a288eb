//! Reading, whatever the form.

use std::path::Path;

use visloc_core::{files, geom::Camera};

use super::{CameraToml, calibration::read_calibration, tables::Table, yaml_forms};
use crate::FileError;

/// Reads the camera of a file; the form is told from its content.
///
/// # Errors
/// If the file cannot be read, has none of the forms, or no camera has its values.
pub fn read_camera(path: &Path) -> Result<Camera, FileError> {
    let text = files::read_text(path).map_err(FileError::io(path))?;
    if let Some(camera) = in_known_form(path, &text) {
        return camera.map_err(|reason| FileError::form(path, reason));
    }
    let calibration = read_calibration(path)?;
    let size_px = calibration.size_px.ok_or_else(|| {
        FileError::form(path, "expected the size of the images (width, height), found none")
    })?;
    calibration.camera(size_px, path)
}

/// Whether a file is TOML, by its name.
pub(super) fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit())
}

/// The camera, if the text has one of the forms that are told from each other here.
pub(crate) fn in_known_form(path: &Path, text: &str) -> Option<Result<Camera, String>> {
    if is_toml(path) {
        return Table::of_foreign_toml(text)
            .is_none()
            .then(|| CameraToml::read(text).and_then(|table| table.camera()));
    }
    let is_cam = |line: &str| {
        line.strip_prefix("cam").and_then(|rest| rest.trim_end().strip_suffix(':')).is_some_and(is_number)
    };
    text.lines().any(is_cam).then(|| yaml_forms::kalibr(text))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use visloc_core::geom::Distortion;

    use super::*;
    use crate::camera_file::{CameraFormat, write_camera};

    fn cameras() -> [Camera; 3] {
        let lens = [
            Distortion::None,
            Distortion::RadialTangential([-0.25, 0.09, 8e-4, -6e-4, 0.0]),
            Distortion::KannalaBrandt([0.03, -0.01, 0.006, -2e-3]),
        ];
        lens.map(|lens| Camera::new((640, 480), (521.3, 523.1), (323.8, 236.4), lens).unwrap())
    }

    #[test]
    fn every_form_gives_the_camera_back() {
        let folder = tempfile::tempdir().unwrap();
        for camera in cameras() {
            for (name, format) in [
                ("a.toml", CameraFormat::Toml),
                ("b.yaml", CameraFormat::Ros),
                ("c.yaml", CameraFormat::Kalibr),
                ("d.yml", CameraFormat::OpenCv),
            ] {
                let path = folder.path().join(name);
                fs::write(&path, write_camera(&camera, format, "head").unwrap()).unwrap();
                assert_eq!(read_camera(&path).unwrap(), camera, "{name}");
            }
        }
    }

    #[test]
    fn files_of_the_tools_themselves() {
        let folder = tempfile::tempdir().unwrap();
        let read = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            read_camera(&path)
        };
        let opencv = "%YAML:1.0\n---\ncalibration_time: \"Mon\"\nimage_width: 640\nimage_height: 480\ncamera_matrix: \
                      !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 521.3, 0., 323.8, 0., 523.1, 236.4, 0.,\n       0., \
                      1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [ \
                      -0.25, 0.09, 8.0e-04, -6.0e-04, 0. ]\navg_reprojection_error: 3.1e-01\n";
        assert_eq!(read("o.yml", opencv).unwrap(), cameras()[1]);
        let kalibr = "cam0:\n  cam_overlaps: []\n  camera_model: pinhole\n  distortion_coeffs: [0.03, -0.01, 0.006, -0.002]\n  \
                      distortion_model: equidistant\n  intrinsics: [521.3, 523.1, 323.8, 236.4]\n  resolution: [640, 480]\n  \
                      rostopic: /cam0/image_raw\n";
        assert_eq!(read("k.yaml", kalibr).unwrap(), cameras()[2]);
        assert_eq!(read("k.yaml", &kalibr.replace("cam0", "cam1")).unwrap(), cameras()[2]);
        let two = format!("{kalibr}\n{}", kalibr.replace("cam0", "cam1"));
        let error = read("two.yaml", &two).unwrap_err().to_string();
        assert!(error.contains("expected one camera, found 2 (cam0"), "{error}");
        let nameless = two.lines().filter(|line| !line.contains("rostopic")).collect::<Vec<_>>().join("\n");
        let error = read("two.yaml", &nameless).unwrap_err().to_string();
        assert!(error.contains("found 2 (cam0, cam1): keep"), "{error}");
        let error = read("omni.yaml", &kalibr.replace("pinhole", "omni")).unwrap_err().to_string();
        assert!(error.contains("omni.yaml: cam0: expected camera_model pinhole, found 'omni'"), "{error}");
        let error = read("x.toml", "model = \"pinhole\"\nsize_px = [640]\n").unwrap_err().to_string();
        assert!(error.contains("x.toml: line 2: size_px:"), "{error}");
        assert!(error.contains("focal_px = [fx, fy], center_px = [cx, cy], found none"), "{error}");
        // As the page by hand saves it.
        let by_hand = "model = \"radial-tangential\"\nsize_px = [640, 480]\nfocal_px = [521.3, 523.1]\ncenter_px = [323.8, 236.4]\n\
                       distortion = [-0.25, 0.09, 0.0008, -0.0006, 0.0]\n\n[pose]\nposition_m = [0.0, 0.0, 0.5]\nheading_deg = 0.0\n\
                       pitch_down_deg = 15.0\nroll_clockwise_deg = 0.0\n";
        assert_eq!(read("by-hand.toml", by_hand).unwrap(), cameras()[1]);
        assert!(read("empty.yaml", "").is_err());
    }
}
