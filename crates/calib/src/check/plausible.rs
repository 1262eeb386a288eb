//! The checks.

use nalgebra::Point2;
use visloc_core::{
    GrayImage,
    geom::{Camera, Distortion},
    median,
};

use super::{CameraCheck, Severity, lines::bows_px};

/// Distance of the principal point from the middle, as a share of the image's side: unusual, impossible.
const CENTER: (f64, f64) = (0.1, 0.3);
/// fx / fy, from and to: usual, possible.
const RATIO: [(f64, f64); 2] = [(0.97, 1.03), (0.8, 1.25)];
/// Angle of view across, degrees: usual, possible.
const VIEW_DEG: [(f64, f64); 2] = [(25.0, 120.0), (5.0, 150.0)];
const FISHEYE_VIEW_DEG: [(f64, f64); 2] = [(60.0, 178.0), (25.0, 179.0)];
/// A pixel comes back from its ray within this, pixels.
const ROUND_TRIP_PX: f64 = 0.1;
/// Bend of long edges, as a share of the image's diagonal: unusual, impossible.
const BEND: (f64, f64) = (0.0012, 0.004);
/// Fewer long edges than this say nothing.
const MIN_EDGES: usize = 6;

/// Says whether a camera is plausible for images. Without images only the camera itself is looked at.
pub fn check_camera(camera: &Camera, images: &[GrayImage]) -> CameraCheck {
    let mut check = CameraCheck::default();
    check_center(camera, &mut check);
    check_ratio(camera, &mut check);
    check_view(camera, &mut check);
    let is_invertible = check_lens(camera, &mut check);
    if check_size(camera, images, &mut check) && is_invertible {
        check_lines(camera, images, &mut check);
    }
    check
}

fn graded(value: f64, limits: (f64, f64)) -> Severity {
    if value > limits.1 {
        Severity::Wrong
    } else if value > limits.0 {
        Severity::Warning
    } else {
        Severity::Fine
    }
}

fn within(value: f64, [usual, possible]: [(f64, f64); 2]) -> Severity {
    if (usual.0..=usual.1).contains(&value) {
        Severity::Fine
    } else if (possible.0..=possible.1).contains(&value) {
        Severity::Warning
    } else {
        Severity::Wrong
    }
}

fn size(camera: &Camera) -> (f64, f64) {
    (f64::from(camera.size_px().0), f64::from(camera.size_px().1))
}

fn check_center(camera: &Camera, check: &mut CameraCheck) {
    let ((width, height), (cx, cy)) = (size(camera), camera.center_px());
    let off = ((cx + 0.5) / width - 0.5).abs().max(((cy + 0.5) / height - 0.5).abs());
    let mut message = format!(
        "({cx:.1}, {cy:.1}) px, {:.1} % of the image away from its middle; usual are up to {:.0} %",
        100.0 * off,
        100.0 * CENTER.0
    );
    let severity = graded(off, CENTER);
    if severity != Severity::Fine {
        message += ": is it the calibration of a cropped image, or of another camera?";
    }
    check.add("principal point", severity, message);
}

fn check_ratio(camera: &Camera, check: &mut CameraCheck) {
    let (fx, fy) = camera.focal_px();
    let severity = within(fx / fy, RATIO);
    let mut message = format!("fx {fx:.1}, fy {fy:.1} px, ratio {:.3}; pixels are nearly square", fx / fy);
    if severity != Severity::Fine {
        message += ": was the image squeezed after the calibration?";
    }
    check.add("focal lengths", severity, message);
}

fn check_view(camera: &Camera, check: &mut CameraCheck) {
    let ((width, _), (_, cy)) = (size(camera), camera.center_px());
    let angle = |x: f64| {
        let ray = camera.bearing(&Point2::new(x, cy));
        ray.x.atan2(ray.z)
    };
    let view_deg = (angle(width - 0.5) - angle(-0.5)).to_degrees();
    let is_fisheye = matches!(camera.distortion(), Distortion::KannalaBrandt(_));
    let limits = if is_fisheye { FISHEYE_VIEW_DEG } else { VIEW_DEG };
    let severity = within(view_deg, limits);
    let mut message =
        format!("{view_deg:.1} degrees across; usual are {:.0} to {:.0}", limits[0].0, limits[0].1);
    if severity != Severity::Fine {
        message += ": is the focal length in pixels, of this resolution?";
    }
    check.add("field of view", severity, message);
}

/// Every pixel of the border has a ray that comes back to it.
fn check_lens(camera: &Camera, check: &mut CameraCheck) -> bool {
    let (width, height) = (camera.size_px().0 - 1, camera.size_px().1 - 1);
    let steps = (0..=16).map(|i| f64::from(i) / 16.0);
    let mut border: Vec<Point2<f64>> = Vec::new();
    for share in steps {
        let (x, y) = (share * f64::from(width), share * f64::from(height));
        let (right, bottom) = (f64::from(width), f64::from(height));
        border.extend([
            Point2::new(x, 0.0),
            Point2::new(x, bottom),
            Point2::new(0.0, y),
            Point2::new(right, y),
        ]);
    }
    let comes_back = |px: &Point2<f64>| {
        let ray = camera.bearing(px);
        let point = nalgebra::Point3::from(ray);
        ray.iter().all(|v| v.is_finite())
            && camera.project(&point).is_ok_and(|b| (b - px).norm() < ROUND_TRIP_PX)
    };
    let lost = border.iter().filter(|px| !comes_back(px)).count();
    let largest = border.iter().map(|px| (camera.ideal_px(px) - px).norm()).fold(0.0, f64::max);
    if lost == 0 {
        let message = format!("invertible up to the border; moves pixels by up to {largest:.1} px");
        check.add("lens", Severity::Fine, message);
        return true;
    }
    let message = format!(
        "{lost} of {} places at the border have no ray: the distortion folds back inside of the image. The pictures of the \
         calibration did not reach the corners; calibrate again with the board there, or with the fisheye model",
        border.len()
    );
    check.add("lens", Severity::Wrong, message);
    false
}

/// Whether all images have the camera's size.
fn check_size(camera: &Camera, images: &[GrayImage], check: &mut CameraCheck) -> bool {
    let (width, height) = (camera.size_px().0 as usize, camera.size_px().1 as usize);
    let other = images.iter().find(|image| (image.width(), image.height()) != (width, height));
    let Some(image) = other else {
        if let Some(first) = images.first() {
            let message = format!("{} x {} px, as the camera", first.width(), first.height());
            check.add("image size", Severity::Fine, message);
        }
        return !images.is_empty();
    };
    let ratio = image.width() as f64 / width as f64;
    let is_shape = |(width, height): (usize, usize)| {
        (height as f64 * image.width() as f64 / width as f64 - image.height() as f64).abs() <= 1.0
    };
    let hint = if is_shape((width, height)) {
        format!("the same shape: scale the calibration by {ratio:.4}")
    } else if is_shape((height, width)) {
        "turned by a quarter; turn the images back, or calibrate with images that are turned so".to_owned()
    } else {
        "another shape: cropped or another camera; calibrate with these images".to_owned()
    };
    let message =
        format!("expected {width} x {height} px, found {} x {}; {hint}", image.width(), image.height());
    check.add("image size", Severity::Wrong, message);
    false
}

/// Long edges that are nearly straight should be straight without the distortion.
fn check_lines(camera: &Camera, images: &[GrayImage], check: &mut CameraCheck) {
    let bows: Vec<(f64, f64)> = images.iter().flat_map(|image| bows_px(camera, image)).collect();
    if bows.len() < MIN_EDGES {
        let message = format!(
            "{} long edges in {} images, too few to tell whether they are straight: give images with walls, doors or \
             lines near the border",
            bows.len(),
            images.len()
        );
        check.add("straight lines", Severity::Fine, message);
        return;
    }
    let (width, height) = size(camera);
    let usual = |bow: fn(&(f64, f64)) -> f64| median(bows.iter().map(bow)).unwrap_or(0.0);
    let (seen, ideal) = (usual(|b| b.0), usual(|b| b.1));
    let severity = graded(ideal.abs() / width.hypot(height), BEND);
    let way = if ideal > 0.0 {
        "outwards: distortion is left"
    } else {
        "inwards: too much distortion is taken off"
    };
    let mut message = format!(
        "{} long edges bend by {seen:+.2} px as seen and {ideal:+.2} px without the distortion (median, outwards positive)",
        bows.len()
    );
    if severity != Severity::Fine {
        message += &format!("; they bend {way}");
    }
    check.add("straight lines", severity, message);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn severity_of(camera: &Camera, images: &[GrayImage], subject: &str) -> Severity {
        let check = check_camera(camera, images);
        check.findings.iter().find(|f| f.subject == subject).map_or(Severity::Fine, |f| f.severity)
    }

    #[test]
    fn each_fault_is_named() {
        let size = (640, 480);
        let good = Camera::pinhole(size, (500.0, 501.0), (321.0, 240.0)).unwrap();
        assert_eq!(check_camera(&good, &[]).severity(), Severity::Fine);
        let faults = [
            (
                Camera::pinhole(size, (500.0, 501.0), (20.0, 240.0)).unwrap(),
                "principal point",
                Severity::Wrong,
            ),
            (
                Camera::pinhole(size, (500.0, 501.0), (420.0, 240.0)).unwrap(),
                "principal point",
                Severity::Warning,
            ),
            (
                Camera::pinhole(size, (500.0, 600.0), (321.0, 240.0)).unwrap(),
                "focal lengths",
                Severity::Warning,
            ),
            (Camera::pinhole(size, (0.5, 0.5), (321.0, 240.0)).unwrap(), "field of view", Severity::Wrong),
            (
                Camera::new(
                    size,
                    (400.0, 400.0),
                    (320.0, 240.0),
                    Distortion::RadialTangential([-0.6, 0.0, 0.0, 0.0, 0.0]),
                )
                .unwrap(),
                "lens",
                Severity::Wrong,
            ),
        ];
        for (camera, subject, expected) in faults {
            assert_eq!(severity_of(&camera, &[], subject), expected, "{subject}");
        }
        assert_eq!(severity_of(&good, &[GrayImage::new(320, 240)], "image size"), Severity::Wrong);
        assert_eq!(severity_of(&good, &[GrayImage::new(640, 480)], "image size"), Severity::Fine);
        for (size, hint) in
            [((320, 240), "0.5000"), ((480, 640), "turned by a quarter"), ((640, 400), "cropped")]
        {
            let check = check_camera(&good, &[GrayImage::new(size.0, size.1)]);
            let finding = check.findings.iter().find(|finding| finding.subject == "image size").unwrap();
            assert!(finding.message.contains(hint), "{}", finding.message);
        }
    }
}
