//! Lens models by the names that ROS gives them in `sensor_msgs/msg/CameraInfo`.

use visloc_core::geom::Distortion;

/// The lens of a `distortion_model` with its coefficients `d`. An empty model with coefficients is `plumb_bob`.
///
/// # Errors
/// What was expected and what was found, if the model is not known or the number of coefficients does not fit.
pub(crate) fn distortion_of_ros(model: &str, d: &[f64]) -> Result<Distortion, String> {
    if let ("equidistant" | "fisheye", [k1, k2, k3, k4]) = (model, d) {
        // Zeros are a lens too: the ideal equidistant one.
        return Ok(Distortion::KannalaBrandt([*k1, *k2, *k3, *k4]));
    }
    let is_known = matches!(model, "plumb_bob" | "rational_polynomial" | "");
    if d.iter().all(|value| *value == 0.0) && !matches!(model, "equidistant" | "fisheye") {
        return Ok(Distortion::None);
    }
    let has_higher_terms = d.iter().skip(5).any(|value| *value != 0.0);
    if !is_known || has_higher_terms || d.len() < 4 {
        return Err(format!(
            "lens distortion '{model}' with coefficients {d:?}: expected 'plumb_bob' (k1, k2, p1, p2, k3), \
             'rational_polynomial' with zeros behind these five or 'equidistant' (k1, k2, k3, k4); calibrate the camera with \
             one of them"
        ));
    }
    let mut coefficients = [0.0; 5];
    for (coefficient, value) in coefficients.iter_mut().zip(d) {
        *coefficient = *value;
    }
    Ok(Distortion::RadialTangential(coefficients))
}

/// Name and coefficients of a lens for a `CameraInfo`.
pub(crate) fn ros_distortion(lens: Distortion) -> (&'static str, Vec<f64>) {
    match lens {
        Distortion::KannalaBrandt(k) => ("equidistant", k.to_vec()),
        Distortion::RadialTangential(k) => ("plumb_bob", k.to_vec()),
        _ => ("plumb_bob", vec![0.0; 5]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distortion_models() {
        let distortion = distortion_of_ros;
        let k = [-0.3, 0.1, 0.0, 0.001, 0.0];
        assert_eq!(distortion("plumb_bob", &k), Ok(Distortion::RadialTangential(k)));
        assert_eq!(distortion("plumb_bob", &k[..4]), Ok(Distortion::RadialTangential(k)));
        let rational = [&k[..], &[0.0; 3]].concat();
        assert_eq!(distortion("rational_polynomial", &rational), Ok(Distortion::RadialTangential(k)));
        assert_eq!(distortion("equidistant", &[0.0; 4]), Ok(Distortion::KannalaBrandt([0.0; 4])));
        assert_eq!(distortion("equidistant", &[0.1; 4]), Ok(Distortion::KannalaBrandt([0.1; 4])));
        assert_eq!(distortion("", &[]), Ok(Distortion::None));
        assert!(distortion("equidistant", &[0.1; 5]).unwrap_err().contains("equidistant"));
        assert!(distortion("thin_prism", &[0.1; 4]).unwrap_err().contains("thin_prism"));
        assert!(distortion("rational_polynomial", &[0.1; 8]).is_err());
        assert!(distortion("plumb_bob", &[0.1]).is_err());
    }

    #[test]
    fn a_lens_comes_back() {
        for lens in [
            Distortion::None,
            Distortion::RadialTangential([0.1, 0.2, 0.3, 0.4, 0.5]),
            Distortion::KannalaBrandt([0.1, 0.0, 0.0, 0.2]),
        ] {
            let (model, d) = ros_distortion(lens);
            assert_eq!(distortion_of_ros(model, &d), Ok(lens));
        }
    }
}
