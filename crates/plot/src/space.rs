//! Paths and points in space, seen along two axes.

use crate::{Color, Picture, ScatterPicture, ScatterSeries, scatter};

/// Paths in space.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SpaceViews {
    /// Large, at the top.
    pub title: String,
    /// Below the title; the axes are added.
    pub subtitle: String,
    /// Later ones are drawn over earlier ones.
    pub paths: Vec<SpacePath>,
}

/// Points of one kind.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SpacePath {
    /// In the legend.
    pub label: String,
    /// Of line or points.
    pub color: Color,
    /// Points of a map are drawn one by one; they do not decide what part of space is shown.
    pub is_cloud: bool,
    /// x, y and z, meters; not a number interrupts the line.
    pub points: Vec<[f64; 3]>,
}

/// Border around the paths, share of their largest extent; with a map around them a wider one.
const BORDER: (f64, f64) = (0.08, 0.5);

/// Two pictures: along the axis in which the paths extend least (from above, for a camera on wheels), and with that axis
/// upwards.
#[must_use]
pub fn space_views(input: &SpaceViews) -> [Picture; 2] {
    let ranges = [0, 1, 2].map(|axis| range(input, axis));
    let extent = |axis: &usize| ranges[*axis].1 - ranges[*axis].0;
    let least = [2, 1, 0].into_iter().min_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(2);
    let [first, second] = [[1, 2], [0, 2], [0, 1]][least];
    let widest = if extent(&first) >= extent(&second) { first } else { second };
    let has_cloud = input.paths.iter().any(|path| path.is_cloud);
    let share = if has_cloud { BORDER.1 } else { BORDER.0 };
    let border = share * extent(&widest).max(0.1);
    [view(input, [first, second], &ranges, border), view(input, [widest, least], &ranges, border)]
}

fn view(input: &SpaceViews, [x, y]: [usize; 2], ranges: &[(f64, f64); 3], border: f64) -> Picture {
    const NAMES: [&str; 3] = ["x", "y", "z"];
    let with_border = |axis: usize| (ranges[axis].0 - border, ranges[axis].1 + border);
    let series = |path: &SpacePath| ScatterSeries {
        label: path.label.clone(),
        color: path.color,
        is_line: !path.is_cloud,
        points: path.points.iter().map(|point| (point[x], point[y])).collect(),
        ..ScatterSeries::default()
    };
    let axes = format!("{} to the right, {} up", NAMES[x], NAMES[y]);
    let subtitle = match input.subtitle.as_str() {
        "" => axes,
        text => format!("{text}; {axes}"),
    };
    scatter(&ScatterPicture {
        title: input.title.clone(),
        subtitle,
        x_m: with_border(x),
        y_m: with_border(y),
        series: input.paths.iter().map(series).collect(),
    })
}

/// Of all paths along an axis.
fn range(input: &SpaceViews, axis: usize) -> (f64, f64) {
    let points = input.paths.iter().filter(|path| !path.is_cloud).flat_map(|path| &path.points);
    let values = points.map(|point| point[axis]).filter(|value| value.is_finite());
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low <= high { (low, high) } else { (0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_flat_axis_is_looked_along_first() {
        let points = (0..20).map(|i| [f64::from(i), 0.01 * f64::from(i % 2), f64::from(i % 7)]).collect();
        let input =
            SpaceViews { paths: vec![SpacePath { points, ..SpacePath::default() }], ..SpaceViews::default() };
        let [above, side] = space_views(&input);
        assert!(above.svg().contains("x to the right, z up"));
        assert!(side.svg().contains("x to the right, y up"));
        let _ = space_views(&SpaceViews::default());
    }
}
