//! What the pictures show, read back from SVG and PNG.

#![allow(clippy::unwrap_used, reason = "a failed test panics")]

use std::f64::consts::FRAC_PI_2;

use image::RgbImage;
use resvg::usvg;
use visloc_core::geom::PlanarPose;
use visloc_plot::{
    Bar, BarChart, BarSeries, Color, FieldPath, FieldPicture, Grid, Group, HeatMap, Histogram,
    HistogramSeries, Kidnap, Mark, Panel, PathPoint, Picture, PlotError, PoseMark, ReferenceLine, Series,
    SeriesStyle, Span, TimeSeriesPicture, ValueAxis, bar_chart, field_picture, heat_map, histogram,
    time_series,
};
use visloc_world::{Map, field::Field};

fn field() -> Field {
    match Map::load("robocup-spl-2010") {
        Ok(Map::Field(field)) => field,
        other => panic!("a built-in field, found {other:?}"),
    }
}

fn pixels(picture: &Picture) -> RgbImage {
    image::load_from_memory(&picture.png(1.0).unwrap()).unwrap().to_rgb8()
}

fn poses(points: &[(f64, f64)]) -> Vec<PlanarPose> {
    points.iter().map(|&(x, y)| PlanarPose::new(x, y, 0.0)).collect()
}

/// Left, top, right and bottom of the ground, to which everything on it is clipped.
fn ground(svg: &str) -> [f64; 4] {
    let attribute = |element: &str, name: &str| -> f64 {
        let start = element.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
        element[start..].split('"').next().unwrap().parse().unwrap()
    };
    let clip = svg.split("<clipPath").nth(1).unwrap().split("/>").next().unwrap();
    let [x, y, width, height] = ["x", "y", "width", "height"].map(|name| attribute(clip, name));
    [x, y, x + width, y + height]
}

/// The data of the first path among the paths of a run.
fn first_path(svg: &str) -> &str {
    let paths = svg.split("class=\"paths\"").nth(1).unwrap();
    paths.split(" d=\"").nth(1).unwrap().split('"').next().unwrap()
}

fn every_picture(value: f64) -> Vec<Picture> {
    let pose = PlanarPose { x_m: value, y_m: -value, yaw_rad: value };
    let label = || "a <b> & \"c\" \u{7} °".to_owned();
    let input = FieldPicture {
        title: label(),
        truth: Some(FieldPath::new("truth", Color::BLACK, [pose, PlanarPose::default(), pose])),
        kidnaps: vec![Kidnap { from: pose, to: PlanarPose::default() }; 2],
        start: Some(pose),
        ..FieldPicture::default()
    };
    let axes = [
        ValueAxis::Auto,
        ValueAxis::Linear { min: value, max: 1.0 },
        ValueAxis::Log { min: value, max: 10.0 },
    ];
    let reference = ReferenceLine { value, label: label(), color: Color::GRAY };
    let panels = axes.map(|axis| Panel {
        label: label(),
        axis,
        series: vec![Series::new("s", Color::BLUE, vec![(0.0, 1.0), (value, value), (2.0, value)])],
        references: vec![reference.clone(); 3],
    });
    let series = TimeSeriesPicture {
        panels: panels.to_vec(),
        spans: vec![Span { start_secs: value, end_secs: 2.0, label: label() }],
        marks: vec![Mark { at_secs: value, label: label() }; 5],
        ..TimeSeriesPicture::default()
    };
    let grid =
        Grid { origin_m: [0.0, value], cell_m: value, num_columns: 2, values: vec![value, 1.0, 2.0, 3.0] };
    let marks = vec![PoseMark { label: label(), color: Color::BLUE, pose }];
    let heat = HeatMap { grid, marks, range: Some((value, 1.0)), ..HeatMap::default() };
    let bars = BarChart {
        series: vec![BarSeries { label: label(), color: Color::BLUE }],
        groups: vec![Group { label: label(), values: vec![Bar { value, interval: Some((0.0, value)) }] }],
        references: vec![reference],
        ..BarChart::default()
    };
    let values = vec![value, 1.0];
    let counts = Histogram {
        range: Some((0.0, value)),
        series: vec![HistogramSeries { label: label(), color: Color::BLUE, values }],
        num_bins: 3,
        ..Histogram::default()
    };
    let field = field();
    vec![
        field_picture(&field, &input),
        time_series(&series),
        heat_map(&heat, None),
        heat_map(&heat, Some((&field).into())),
        bar_chart(&bars),
        histogram(&counts),
    ]
}

#[test]
fn any_number_gives_valid_pictures_and_the_same_bytes_again() {
    for value in [0.3, 0.0, -1.0, 1e-300, 1e300, -1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for (i, (picture, again)) in every_picture(value).iter().zip(every_picture(value)).enumerate() {
            let tree = usvg::Tree::from_str(picture.svg(), &usvg::Options::default());
            assert!(tree.is_ok(), "picture {i} of {value}: {tree:?}");
            assert_eq!(*picture, again);
        }
    }
}

#[test]
fn truth_lies_at_its_pixels() {
    let truth = FieldPath::new("truth", Color::BLACK, poses(&[(0.0, 0.0), (0.25, 0.25), (0.5, 0.5)]));
    let picture = field_picture(&field(), &FieldPicture { truth: Some(truth), ..FieldPicture::default() });
    let [left, top, right, bottom] = ground(picture.svg());
    // the carpet measures 7.4 m x 5.4 m
    let px_per_m = (right - left) / 7.4;
    assert!(((bottom - top) / 5.4 - px_per_m).abs() < 0.01, "the field is to scale");
    let numbers: Vec<f64> =
        first_path(picture.svg()).split(['M', 'L', ' ']).filter_map(|part| part.parse().ok()).collect();
    let middle = (f64::midpoint(left, right), f64::midpoint(top, bottom));
    let expected = [0.0, 0.25, 0.5].map(|m| [middle.0 + m * px_per_m, middle.1 - m * px_per_m]);
    for (found, expected) in numbers.iter().zip(expected.as_flattened()) {
        assert!((found - expected).abs() < 0.02, "{numbers:?} instead of {expected:?}");
    }
    assert_eq!(numbers.len(), 6);
}

#[test]
fn truth_is_dashed_above_the_estimates_which_differ_by_dash_and_mark() {
    let way = |y: f64| poses(&(0..60).map(|i| (-2.5 + f64::from(i) * 0.08, y)).collect::<Vec<_>>());
    let estimate = |i: usize| FieldPath::new(&format!("algorithm {i}"), Color::series(i), way(0.1));
    let picture = field_picture(
        &field(),
        &FieldPicture {
            truth: Some(FieldPath::new("truth", Color::BLACK, way(0.0))),
            estimates: vec![estimate(0), estimate(1)],
            ..FieldPicture::default()
        },
    );
    let paths = picture.svg().split("class=\"paths\"").nth(1).unwrap().split("</g>").next().unwrap();
    let line_of = |color: Color| {
        let stroke = format!("stroke=\"{color}\"");
        let at = paths.find(&stroke).unwrap();
        (at, paths[at..].lines().next().unwrap().contains("stroke-dasharray"))
    };
    let [truth, first, second] = [Color::BLACK, Color::series(0), Color::series(1)].map(line_of);
    assert!(truth.0 > first.0 && truth.0 > second.0, "the truth is drawn last");
    assert_eq!((truth.1, first.1, second.1), (true, false, true), "dashes");
    assert!(paths.contains("<circle"), "the first has round marks");
}

#[test]
fn goals_have_their_colors_and_the_png_its_size() {
    let picture = field_picture(&field(), &FieldPicture::default());
    let image = pixels(&picture);
    let tree = usvg::Tree::from_str(picture.svg(), &usvg::Options::default()).unwrap();
    assert_eq!(image.width(), tree.size().width().round() as u32);
    let [left, top, right, bottom] = ground(picture.svg());
    let px_per_m = (right - left) / 7.4;
    let at = |x_m: f64| {
        let (x, y) = (f64::midpoint(left, right) + x_m * px_per_m, f64::midpoint(top, bottom));
        image.get_pixel(x as u32, y as u32).0
    };
    let [yellow, blue, carpet] = [at(3.0), at(-3.0), at(2.0)];
    assert!(yellow[0] > 200 && yellow[1] > 180 && yellow[2] < 80, "{yellow:?}");
    assert!(blue[2] > 180 && blue[0] < 80, "{blue:?}");
    assert!(carpet[1] > carpet[0] && carpet[1] > carpet[2], "{carpet:?}");
    let double = image::load_from_memory(&picture.png(2.0).unwrap()).unwrap();
    assert_eq!(double.width(), 2 * image.width());
}

#[test]
fn text_appears_in_the_png() {
    let dark = |title: &str| {
        let picture =
            time_series(&TimeSeriesPicture { title: title.to_owned(), ..TimeSeriesPicture::default() });
        let image = pixels(&picture);
        image.enumerate_pixels().filter(|(_, y, p)| *y < 38 && p.0.iter().all(|&c| c < 90)).count()
    };
    assert_eq!(dark(""), 0);
    assert!(dark("Seventy seconds") > 300);
    assert!(dark("\u{3b1} \u{b0} \u{2265}") > 30);
}

#[test]
fn not_a_number_breaks_a_line() {
    let num_lines = |points: Vec<(f64, f64)>| {
        let series = vec![Series::new("s", Color::rgb(1, 2, 3), points)];
        let panels = vec![Panel { series, ..Panel::default() }];
        let picture = time_series(&TimeSeriesPicture { panels, ..TimeSeriesPicture::default() });
        picture.svg().matches("stroke=\"#010203\" stroke-width=\"1.7\"").count()
    };
    assert_eq!(num_lines(vec![(0.0, 1.0), (1.0, 2.0), (2.0, 1.0), (3.0, 2.0)]), 1);
    assert_eq!(num_lines(vec![(0.0, 1.0), (1.0, 2.0), (1.5, f64::NAN), (2.0, 1.0), (3.0, 2.0)]), 2);
    assert_eq!(num_lines(Vec::new()), 0);
}

#[test]
fn faint_path_and_jumps_are_drawn_apart() {
    let mut estimate = FieldPath::new(
        "estimate",
        Color::rgb(1, 2, 3),
        poses(&[(0.0, 0.0), (0.2, 0.0), (2.0, 1.0), (2.2, 1.0)]),
    );
    estimate.points.push(PathPoint::not_localized(&PlanarPose::new(2.4, 1.0, FRAC_PI_2)));
    let input = FieldPicture { estimates: vec![estimate], ..FieldPicture::default() };
    let picture = field_picture(&field(), &input);
    let paths = picture.svg().split("class=\"paths\"").nth(1).unwrap();
    let lines = |width: &str| paths.matches(&format!("stroke=\"#010203\" stroke-width=\"{width}\"")).count();
    assert_eq!((lines("2.2"), lines("1.6")), (2, 1));
    assert!(picture.svg().contains(">not localized<"));
}

#[test]
fn values_outside_the_range_are_marked_at_the_border() {
    let num_marks = |axis| {
        let series = Series {
            label: String::new(),
            color: Color::rgb(1, 2, 3),
            style: SeriesStyle::Line,
            points: (0..100).map(|i| (f64::from(i), if i < 50 { 0.1 } else { 3.0 })).collect(),
        };
        let panels = vec![Panel { axis, series: vec![series], ..Panel::default() }];
        let picture = time_series(&TimeSeriesPicture { panels, ..TimeSeriesPicture::default() });
        picture.svg().matches("Z\" fill=\"#010203\"").count()
    };
    assert_eq!(num_marks(ValueAxis::Auto), 0);
    // half of the panel's width of 900 px, at least 10 px apart
    let marks = num_marks(ValueAxis::Linear { min: 0.0, max: 1.0 });
    assert!((20..=46).contains(&marks), "{marks}");
    assert!(num_marks(ValueAxis::Log { min: 0.5, max: 10.0 }) > 20);
}

#[test]
fn reference_labels_and_marks_are_shown_once() {
    let reference = |value| ReferenceLine { value, label: format!("line {value}"), color: Color::GRAY };
    let panels = vec![Panel {
        axis: ValueAxis::Linear { min: 0.0, max: 1.0 },
        references: vec![reference(0.6), reference(5.0)],
        ..Panel::default()
    }];
    let marks = vec![Mark { at_secs: 3.0, label: "kidnap 1".to_owned() }];
    let input =
        TimeSeriesPicture { panels, marks, range_secs: Some((0.0, 10.0)), ..TimeSeriesPicture::default() };
    let picture = time_series(&input);
    assert_eq!(picture.svg().matches(">line 0.6<").count(), 1);
    assert_eq!(picture.svg().matches(">line 5<").count(), 0, "outside the range");
    assert_eq!(picture.svg().matches(">kidnap 1<").count(), 1);
}

#[test]
fn heat_map_is_brightest_at_the_maximum() {
    let values = (0..100).map(|i| if i == 37 { 1.0 } else { 0.0 }).collect();
    let grid = Grid { origin_m: [0.0, 0.0], cell_m: 0.5, num_columns: 10, values };
    let picture = heat_map(&HeatMap { grid, ..HeatMap::default() }, None);
    let [left, top, right, bottom] = ground(picture.svg());
    let image = pixels(&picture);
    let at = |column: f64, row: f64| {
        let x = left + (column + 0.5) / 10.0 * (right - left);
        let y = bottom - (row + 0.5) / 10.0 * (bottom - top);
        image.get_pixel(x as u32, y as u32).0
    };
    assert!(at(7.0, 3.0)[1] > 200);
    assert!(at(6.0, 3.0)[1] < 40 && at(7.0, 4.0)[1] < 40);
}

#[test]
fn saving_writes_both_files_and_wrong_scales_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let picture = histogram(&Histogram::default());
    picture.save(&folder.path().join("new"), "v1.2").unwrap();
    assert_eq!(std::fs::read_to_string(folder.path().join("new/v1.2.svg")).unwrap(), picture.svg());
    assert!(folder.path().join("new/v1.2.png").exists());
    for scale in [0.0, -1.0, f32::NAN, f32::INFINITY, 1000.0] {
        assert!(matches!(picture.png(scale), Err(PlotError::Scale { .. })), "{scale}");
    }
    let file = folder.path().join("file");
    std::fs::write(&file, "x").unwrap();
    assert!(matches!(picture.save(&file, "a"), Err(PlotError::Write { .. })));
}
