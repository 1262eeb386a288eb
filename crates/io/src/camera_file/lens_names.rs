//! Names of lens models, as programs write them.

use super::tables::plain;

/// The name that ROS has for a lens model with these coefficients: `plumb_bob`, `rational_polynomial` or `equidistant`.
///
/// librealsense has two variants of Brown's model: where they differ from it, they are refused.
///
/// # Errors
/// What was expected and what was found.
pub(super) fn ros_model(model: &str, k: &[f64]) -> Result<&'static str, String> {
    const RADIAL_TANGENTIAL: [&str; 8] =
        ["", "radialtangential", "radtan", "plumbbob", "brownconrady", "opencv", "pinhole", "none"];
    const FISHEYE: [&str; 6] =
        ["equidistant", "kannalabrandt", "kannalabrandt4", "kannalabrandt8", "fisheye", "opencvfisheye"];
    let name = plain(model);
    let name = name.strip_prefix("distortion").unwrap_or(&name);
    let is_tangential = k.iter().skip(2).take(2).any(|p| *p != 0.0);
    if FISHEYE.contains(&name) {
        return Ok("equidistant");
    }
    if name == "rationalpolynomial" {
        return Ok("rational_polynomial");
    }
    let is_known = RADIAL_TANGENTIAL.contains(&name) || (name == "modifiedbrownconrady" && !is_tangential);
    // Without coefficients the word may be the name of the camera.
    if is_known || k.iter().all(|k| *k == 0.0) {
        return Ok("plumb_bob");
    }
    let why = match name {
        "inversebrownconrady" => ", which says where a pixel would be without the lens: calibrate the camera",
        "modifiedbrownconrady" => ", whose p1 and p2 mean something else there: calibrate the camera",
        _ => "",
    };
    Err(format!(
        "expected distortion_model radial-tangential, or equidistant with 4 coefficients, found '{model}'{why}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_of_a_model_are_told_from_it() {
        let k = [0.1, -0.2, 0.0, 0.0, 0.0];
        for (model, is_radial) in [
            ("Distortion.Brown_Conrady", true),
            ("distortion.modified_brown_conrady", true),
            ("distortion.inverse_brown_conrady", false),
            ("KannalaBrandt8", false),
        ] {
            assert_eq!(ros_model(model, &k).is_ok_and(|name| name == "plumb_bob"), is_radial, "{model}");
        }
        assert_eq!(ros_model("RATIONAL_POLYNOMIAL", &k), Ok("rational_polynomial"));
        let ideal = ros_model("distortion.inverse_brown_conrady", &[0.0; 5]);
        assert_eq!(ideal, Ok("plumb_bob"));
        let error = ros_model("modified_brown_conrady", &[0.1, 0.0, 0.001, 0.0]).unwrap_err();
        assert!(error.contains("p1 and p2"), "{error}");
    }
}
