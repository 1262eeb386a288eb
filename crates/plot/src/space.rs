//! Paths and points in space, seen along two axes.

use visloc_core::quantile;

use crate::{Color, Picture, ScatterPicture, ScatterSeries, scatter};

/// Paths in space.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SpaceViews {
    /// Large, at the top.
    pub title: String,
    /// Below the title; the axes are added.
    pub subtitle: String,
    /// At the axes; meters if empty.
    pub unit: String,
    /// What the three axes are called; x, y and z if empty.
    pub names: [String; 3],
    /// Whether points of maps decide as well what part of space is shown: all but the farthest of them.
    pub shows_clouds: bool,
    /// Later ones are drawn over earlier ones.
    pub paths: Vec<SpacePath>,
}

/// How points of one kind are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SpaceShape {
    /// As a way, from each to the next.
    #[default]
    Line,
    /// One by one, as a map's, which does not decide alone what part of space is shown.
    Cloud,
    /// A ring around each.
    Rings,
}

/// Points of one kind.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SpacePath {
    /// In the legend.
    pub label: String,
    /// Of line or points.
    pub color: Color,
    /// How they are drawn.
    pub shape: SpaceShape,
    /// x, y and z, meters; not a number interrupts the line.
    pub points: Vec<[f64; 3]>,
    /// A color of its own for each point of a map; may be empty.
    pub colors: Vec<Color>,
}

impl SpacePath {
    /// A way.
    pub fn line(label: impl Into<String>, color: Color, points: Vec<[f64; 3]>) -> Self {
        Self { label: label.into(), color, points, ..Self::default() }
    }

    /// Points of a map.
    pub fn cloud(label: impl Into<String>, color: Color, points: Vec<[f64; 3]>) -> Self {
        Self { shape: SpaceShape::Cloud, ..Self::line(label, color, points) }
    }

    /// Places on a way that are pointed out.
    pub fn rings(label: impl Into<String>, color: Color, points: Vec<[f64; 3]>) -> Self {
        Self { shape: SpaceShape::Rings, ..Self::line(label, color, points) }
    }

    fn is_cloud(&self) -> bool {
        self.shape == SpaceShape::Cloud
    }
}

/// Border around the paths, share of their largest extent; with a map around them a wider one.
const BORDER: (f64, f64) = (0.08, 0.5);
/// Share of a map's points at each end of an axis that may lie outside of the picture.
const OUTSIDE_SHARE: f64 = 0.03;
/// Those do that lie beyond the quartiles by more than so many times the distance between these. Source: Tukey, "Exploratory Data Analysis",
/// 1977: the inner fences.
const FENCE: f64 = 1.5;
/// Radius of a ring, share of the longer side of the picture.
const RING_SHARE: f64 = 0.012;

/// Two pictures: along the axis in which the paths extend least (from above, for a camera on wheels), and with that axis
/// upwards.
pub fn space_views(input: &SpaceViews) -> [Picture; 2] {
    let ranges = [0, 1, 2].map(|axis| range(input, axis));
    let extent = |axis: &usize| ranges[*axis].1 - ranges[*axis].0;
    let least = [2, 1, 0].into_iter().min_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(2);
    let [first, second] = [[1, 2], [0, 2], [0, 1]][least];
    let widest = if extent(&first) >= extent(&second) { first } else { second };
    let has_cloud = !input.shows_clouds && input.paths.iter().any(|path| path.is_cloud());
    let share = if has_cloud { BORDER.1 } else { BORDER.0 };
    let border = share * extent(&widest).max(0.1);
    [view(input, [first, second], &ranges, border), view(input, [widest, least], &ranges, border)]
}

fn view(input: &SpaceViews, [x, y]: [usize; 2], ranges: &[(f64, f64); 3], border: f64) -> Picture {
    let name = |axis: usize| match input.names[axis].as_str() {
        "" => ["x", "y", "z"][axis],
        name => name,
    };
    let with_border = |axis: usize| (ranges[axis].0 - border, ranges[axis].1 + border);
    let width = |axis: usize| with_border(axis).1 - with_border(axis).0;
    let ring = RING_SHARE * width(x).max(width(y));
    let series = |path: &SpacePath| ScatterSeries {
        label: path.label.clone(),
        color: path.color,
        is_line: path.shape == SpaceShape::Line,
        radius_m: (path.shape == SpaceShape::Rings).then_some(ring),
        points: path.points.iter().map(|point| (point[x], point[y])).collect(),
        colors: path.colors.clone(),
    };
    let axes = format!("{} to the right, {} up", name(x), name(y));
    let subtitle = match input.subtitle.as_str() {
        "" => axes,
        text => format!("{text}; {axes}"),
    };
    let unit = if input.unit.is_empty() { "m" } else { &input.unit };
    scatter(&ScatterPicture {
        axes: [x, y].map(|axis| format!("{} [{unit}]", name(axis))),
        title: input.title.clone(),
        subtitle,
        x_m: with_border(x),
        y_m: with_border(y),
        series: input.paths.iter().map(series).collect(),
    })
}

/// Of all paths along an axis.
fn range(input: &SpaceViews, axis: usize) -> (f64, f64) {
    let points = input.paths.iter().filter(|path| !path.is_cloud()).flat_map(|path| &path.points);
    let values = points.map(|point| point[axis]).filter(|value| value.is_finite());
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let (low, high) = input
        .paths
        .iter()
        .filter(|path| path.is_cloud() && input.shows_clouds)
        .filter_map(|path| most_of(path, axis))
        .fold((low, high), |(low, high), (from, to)| (low.min(from), high.max(to)));
    if low <= high { (low, high) } else { (0.0, 1.0) }
}

/// Where all but the farthest points of a map are along an axis.
fn most_of(path: &SpacePath, axis: usize) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = path.points.iter().map(|p| p[axis]).filter(|v| v.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| quantile(&values, share);
    let (low, high) = (at(0.25)?, at(0.75)?);
    let fence = FENCE * (high - low);
    let (low, high) = ((low - fence).min(at(OUTSIDE_SHARE)?), (high + fence).max(at(1.0 - OUTSIDE_SHARE)?));
    let is_inside = |value: &&f64| (low..=high).contains(*value);
    Some((*values.iter().find(is_inside)?, *values.iter().rfind(is_inside)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_shown_but_for_its_farthest_points() {
        let way = SpacePath { points: vec![[0.0; 3], [1.0, 0.0, 0.5]], ..SpacePath::default() };
        let mut points: Vec<[f64; 3]> = (0..99).map(|i| [f64::from(i % 9), 0.0, f64::from(i % 7)]).collect();
        points.push([900.0, 0.0, 0.0]);
        let colors = vec![Color::ORANGE; points.len()];
        let cloud = SpacePath { colors, ..SpacePath::cloud("map", Color::GRAY, points) };
        let (unit, names) = ("map units".to_owned(), ["right", "ahead", "height"].map(str::to_owned));
        let mut input = SpaceViews { paths: vec![way, cloud], unit, names, ..SpaceViews::default() };
        assert_eq!(range(&input, 0), (0.0, 1.0));
        input.shows_clouds = true;
        assert_eq!(range(&input, 0), (0.0, 8.0));
        let [above, _] = space_views(&input);
        assert!(above.svg().contains("right [map units]") && above.svg().contains("height [map units]"));
        assert!(above.svg().contains(&Color::ORANGE.to_string()), "points have colors of their own");
    }

    #[test]
    fn corners_of_a_room_are_shown_however_it_is_turned() {
        let walls = (0..400).map(|i| {
            let along = f64::from(i % 100) / 50.0 - 1.0;
            let [x, y] = [[along, 1.0], [1.0, along], [along, -1.0], [-1.0, along]][i as usize / 100];
            [x - y, x + y, 0.0]
        });
        let cloud = SpacePath::cloud("map", Color::GRAY, walls.collect());
        let (low, high) = most_of(&cloud, 0).unwrap();
        assert!((low + 2.0).abs() < 0.1 && (high - 2.0).abs() < 0.1, "{low} to {high}");
    }

    #[test]
    fn places_pointed_out_are_rings_that_the_way_runs_through() {
        let way = SpacePath::line("way", Color::BLUE, vec![[0.0; 3], [4.0, 3.0, 0.0]]);
        let rings = SpacePath::rings("loop", Color::VERMILION, vec![[2.0, 1.5, 0.0]]);
        let num_circles = |paths| {
            let [above, _] = space_views(&SpaceViews { paths, ..SpaceViews::default() });
            above.svg().matches("<circle").count()
        };
        let without = num_circles(vec![way.clone()]);
        // In the legend one as well.
        assert_eq!(
            num_circles(vec![way, rings]) - without,
            3,
            "a ring with its center, and one in the legend"
        );
    }

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
