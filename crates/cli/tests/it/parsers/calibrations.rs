//! Calibrations in all forms.

use std::path::Path;

use visloc_core::geom::{Camera, Distortion};
use visloc_io::{
    camera_file::{CameraFormat, read_camera, write_camera},
    sequence::read_calibration,
};

use super::as_file;

fn cameras() -> [Camera; 3] {
    let lenses = [
        Distortion::None,
        Distortion::RadialTangential([-0.25, 0.09, 8e-4, -6e-4, 0.0]),
        Distortion::KannalaBrandt([0.03, -0.01, 0.006, -2e-3]),
    ];
    lenses.map(|lens| Camera::new((640, 480), (521.3, 523.1), (323.8, 236.4), lens).unwrap())
}

fn written(format: CameraFormat) -> impl Iterator<Item = Vec<u8>> {
    cameras().into_iter().map(move |camera| write_camera(&camera, format, "head").unwrap().into_bytes())
}

pub fn toml_seeds() -> Vec<Vec<u8>> {
    let by_hand: [&[u8]; 2] = [
        b"width = 640\nheight = 480\nfx = 500\nfy = 501\ncx = 319.5\ncy = 239.5\ndistortion = [0.1, -0.2, 0.001, 0.002]\nfps = 20\n",
        b"[camera]\nimage_width = 640\nimage_height = 480\nK = [[500, 0, 319.5], [0, 501, 239.5], [0, 0, 1]]\nD = [0.1, -0.2, 0.001]\n",
    ];
    written(CameraFormat::Toml).chain(by_hand.map(<[u8]>::to_vec)).collect()
}

pub fn toml(bytes: &[u8]) {
    as_file("camera.toml", bytes, read);
}

pub fn yaml_seeds() -> Vec<Vec<u8>> {
    let formats = [CameraFormat::Ros, CameraFormat::Kalibr, CameraFormat::OpenCv];
    let own: [&[u8]; 5] = [
        b"width: 640\nheight: 480\nfx: 500\nfy: 501\ncx: 319.5\ncy: 239.5\ndistortion: [0.1, -0.2, 0.001, 0.002]\nfps: 20\n",
        b"sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, \
          1]\nrate_hz: 20\nresolution: [752, 480]\ncamera_model: pinhole\nintrinsics: [458, 457, 367, 248]\ndistortion_model: \
          radial-tangential\ndistortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05]\n",
        b"Camera.fx: 517.3\nCamera.fy: 516.4\nCamera.cx: 318.6\nCamera.cy: 255.3\nCamera.k1: 0.26\nCamera.width: 640\n",
        b"P0: 707 0 601 0 0 708 183 0 0 0 1 0\nP1: 707 0 601 -379 0 708 183 0 0 0 1 0\n",
        b"2\na.png 1520 0 302 0 1525 246 0 0 1 1 0 0 0 1 0 0 0 1 0 0 0\n",
    ];
    formats.into_iter().flat_map(written).chain(own.map(<[u8]>::to_vec)).collect()
}

pub fn yaml(bytes: &[u8]) {
    as_file("camera.yaml", bytes, read);
}

fn read(path: &Path) {
    let _ = read_calibration(path);
    let Ok(camera) = read_camera(path) else { return };
    let text = write_camera(&camera, CameraFormat::Toml, "").unwrap();
    as_file("again.toml", text.as_bytes(), |path| {
        assert_eq!(read_camera(path).unwrap(), camera, "what is written is read back");
    });
}
