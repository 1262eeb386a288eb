//! Pictures of several cameras, told by their names and by what each camera would be alone.

use std::collections::BTreeMap;

use crate::{Board, Calibration, LensModel, ViewInput, calibrate};

/// Standard deviations by which a parameter of two cameras differs: the pictures of one camera hardly ever differ by as much.
const MOST_SIGMAS: f64 = 6.0;
/// Fewest pictures of a group that is calibrated on its own.
const LEAST_VIEWS: usize = 6;

/// Two groups of pictures that one camera cannot have taken.
#[derive(Debug, Clone, PartialEq)]
pub struct SeveralCameras {
    /// What the names of the pictures begin with.
    pub groups: [String; 2],
    /// The parameter that differs most, in standard deviations.
    pub parameter: &'static str,
    /// Its value and standard deviation in each group.
    pub values: [(f64, f64); 2],
}

/// Calibrates pictures whose names begin alike on their own, as `left01` to `left13` and `right01` to `right13`, and compares the cameras. `None`
/// if there are no such groups, they are too few for a camera, or agree.
pub fn several_cameras(
    board: &Board,
    size_px: (u32, u32),
    views: &[ViewInput],
    model: LensModel,
) -> Option<SeveralCameras> {
    let mut groups: BTreeMap<&str, Vec<ViewInput>> = BTreeMap::new();
    for view in views {
        groups.entry(beginning(&view.name)).or_default().push(view.clone());
    }
    if groups.len() < 2 {
        return None;
    }
    let alone = groups.into_iter().filter_map(|(name, views)| {
        let found =
            (views.len() >= LEAST_VIEWS).then(|| calibrate(board, size_px, &views, model).ok()).flatten()?;
        Some((name.to_owned(), found))
    });
    let alone: Vec<(String, Calibration)> = alone.collect();
    let pairs = alone.iter().enumerate().flat_map(|(i, a)| alone[i + 1..].iter().map(move |b| (a, b)));
    let differences = pairs.flat_map(|(a, b)| {
        let parameters = a.1.parameters.iter().zip(&b.1.parameters).take(4);
        parameters.map(move |(of_a, of_b)| {
            let sigma = of_a.standard_deviation.hypot(of_b.standard_deviation).max(f64::MIN_POSITIVE);
            let values = [of_a, of_b].map(|parameter| (parameter.value, parameter.standard_deviation));
            let groups = [a.0.clone(), b.0.clone()];
            ((of_a.value - of_b.value).abs() / sigma, SeveralCameras { groups, parameter: of_a.name, values })
        })
    });
    let (sigmas, found) = differences.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (sigmas > MOST_SIGMAS).then_some(found)
}

/// The name of a picture without folder, ending, and the numbers behind it: of one that is a time nothing is left.
fn beginning(name: &str) -> &str {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    stem.trim_end_matches(|c: char| c.is_ascii_digit() || "._-".contains(c))
}
