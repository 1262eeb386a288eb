//! Where the elements of an SVG are: their shapes, and the way from their units to the map.

use std::str::FromStr;

use kurbo::{Affine, BezPath, Ellipse, PathEl, Point, Rect, RoundedRect, Shape};
use roxmltree::Node;
use svgtypes::{Length, LengthUnit, Transform, ViewBox};

use crate::import::drawing::{FLAT_M, Lines, is_far, push_curve};

/// Where the page lies in the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Page {
    unit_m: f64,
    /// The lower left corner, in units of the root element.
    corner: [f64; 2],
    /// The same corner in the map.
    origin_m: [f64; 2],
}

impl Page {
    pub fn of(root: &Node<'_, '_>) -> Result<Self, String> {
        let unit_m = match root.attribute("data-meters-per-unit") {
            None => unit_of_size(root).unwrap_or(1.0),
            Some(value) => {
                let parsed = value.trim().parse().ok().filter(|unit: &f64| *unit > 0.0 && unit.is_finite());
                parsed.ok_or_else(|| {
                    format!("data-meters-per-unit: expected a number above 0, found {value:?}")
                })?
            }
        };
        let origin_m = match root.attribute("data-origin").map(numbers).transpose()?.as_deref() {
            None => [0.0, 0.0],
            Some([x, y]) => [*x, *y],
            Some(_) => {
                return Err("data-origin: expected x and y of the lower left corner, meters".to_owned());
            }
        };
        let corner = match root.attribute("viewBox") {
            Some(text) => {
                let view = ViewBox::from_str(text)
                    .map_err(|_| format!("viewBox: expected left, top, width and height, found {text:?}"))?;
                [view.x, view.y + view.h]
            }
            // Without a height nobody knows where the page ends below: its upper edge is the axis.
            None => [0.0, length(root, "height").unwrap_or(0.0)],
        };
        Ok(Self { unit_m, corner, origin_m })
    }

    /// A unit of the root element, meters.
    pub fn unit_m(&self) -> f64 {
        self.unit_m
    }

    /// From the units of the root element to the map; y points down there and up here.
    pub fn to_map(self) -> Affine {
        let [left, bottom] = self.corner;
        let to_corner =
            Affine::new([self.unit_m, 0.0, 0.0, -self.unit_m, -left * self.unit_m, bottom * self.unit_m]);
        Affine::translate((self.origin_m[0], self.origin_m[1])) * to_corner
    }
}

/// A unit of the view box in meters, if the page says how large it is in units of the world. Pixels are none.
fn unit_of_size(root: &Node<'_, '_>) -> Option<f64> {
    let view = ViewBox::from_str(root.attribute("viewBox")?).ok()?;
    let of = |key: &str, units: f64| Some(meters(root.attribute(key)?)? / units);
    of("width", view.w).or_else(|| of("height", view.h)).filter(|unit| *unit > 0.0 && unit.is_finite())
}

/// A length of the world. Meters are no unit of SVG, but of people.
fn meters(text: &str) -> Option<f64> {
    let text = text.trim();
    if let Some(number) = text.strip_suffix('m').and_then(|number| number.trim().parse::<f64>().ok()) {
        return Some(number);
    }
    let Length { number, unit } = Length::from_str(text).ok()?;
    match unit {
        LengthUnit::Mm => Some(number / 1e3),
        LengthUnit::Cm => Some(number / 1e2),
        LengthUnit::In => Some(number * 0.0254),
        _ => None,
    }
}

/// What an element draws, in its own units; `None` if it draws neither lines nor areas.
pub(super) fn shape(node: &Node<'_, '_>) -> Result<Option<BezPath>, String> {
    let of = |key: &str| length(node, key);
    Ok(Some(match node.tag_name().name() {
        "line" => {
            let mut path = BezPath::new();
            path.move_to((of("x1")?, of("y1")?));
            path.line_to((of("x2")?, of("y2")?));
            path
        }
        tag @ ("polyline" | "polygon") => {
            let mut path = BezPath::new();
            let values = numbers(node.attribute("points").unwrap_or_default())?;
            if !values.len().is_multiple_of(2) {
                return Err(format!("points: expected pairs of x and y, found {} numbers", values.len()));
            }
            for (i, xy) in values.chunks_exact(2).enumerate() {
                let point = Point::new(xy[0], xy[1]);
                path.push(if i == 0 { PathEl::MoveTo(point) } else { PathEl::LineTo(point) });
            }
            if tag == "polygon" && !values.is_empty() {
                path.close_path();
            }
            path
        }
        "rect" => {
            let (corner, size) = ((of("x")?, of("y")?), (of("width")?, of("height")?));
            let rect = Rect::from_origin_size(corner, size);
            let radius = of("rx")?.max(of("ry")?);
            if rect.area() <= 0.0 {
                BezPath::new()
            } else if radius > 0.0 {
                RoundedRect::from_rect(rect, radius).to_path(1e-3 * radius)
            } else {
                rect.to_path(1.0)
            }
        }
        tag @ ("circle" | "ellipse") => {
            let radii = if tag == "circle" { (of("r")?, of("r")?) } else { (of("rx")?, of("ry")?) };
            if radii.0 > 0.0 && radii.1 > 0.0 {
                Ellipse::new((of("cx")?, of("cy")?), radii, 0.0).to_path(1e-3 * radii.0.max(radii.1))
            } else {
                BezPath::new()
            }
        }
        "path" => {
            let data = node.attribute("d").unwrap_or_default();
            BezPath::from_svg(data).map_err(|error| format!("d: expected a path, found {error}"))?
        }
        _ => return Ok(None),
    }))
}

/// The lines of a path in the map, curves as short straight ones.
pub(super) fn drawn(path: &BezPath, to_map: Affine) -> Result<Vec<Lines>, String> {
    let mut drawn: Vec<Lines> = Vec::new();
    for element in (to_map * path).elements() {
        let ends = match element {
            PathEl::MoveTo(p) | PathEl::LineTo(p) => vec![*p],
            PathEl::QuadTo(a, p) => vec![*a, *p],
            PathEl::CurveTo(a, b, p) => vec![*a, *b, *p],
            PathEl::ClosePath => Vec::new(),
        };
        if let Some(far) = ends.iter().find(|end| is_far(end.x, end.y)) {
            return Err(format!(
                "expected places at most 10000 m from the origin, found ({}, {})",
                far.x, far.y
            ));
        }
        if let PathEl::MoveTo(point) = element {
            drawn.push(Lines { points: vec![[point.x, point.y]], ..Lines::default() });
            continue;
        }
        let Some(Lines { points, curves, is_closed }) = drawn.last_mut() else { continue };
        let last = points[points.len() - 1];
        match element {
            PathEl::MoveTo(_) => {}
            PathEl::LineTo(point) => points.push([point.x, point.y]),
            PathEl::QuadTo(..) | PathEl::CurveTo(..) => {
                let mut flat = Vec::new();
                kurbo::flatten([PathEl::MoveTo(Point::new(last[0], last[1])), *element], FLAT_M, |piece| {
                    if let PathEl::LineTo(point) = piece {
                        flat.push([point.x, point.y]);
                    }
                });
                push_curve(points, curves, &flat);
            }
            PathEl::ClosePath => {
                *is_closed = true;
                // Back at the first point already: the closing side has no length.
                if points.len() > 2 && points[0] == last && curves.is_empty() {
                    points.pop();
                }
            }
        }
    }
    Ok(drawn.into_iter().map(with_joined_curves).collect())
}

/// Curves that follow each other are one: an arc may come in several parts.
fn with_joined_curves(mut drawn: Lines) -> Lines {
    let mut joined: Vec<[usize; 2]> = Vec::with_capacity(drawn.curves.len());
    for [from, to] in drawn.curves {
        match joined.last_mut() {
            Some(last) if last[1] == from => last[1] = to,
            _ => joined.push([from, to]),
        }
    }
    drawn.curves = joined;
    drawn
}

/// `x` and `y` of an element that moves what is inside.
pub(super) fn offset(node: &Node<'_, '_>) -> Result<Affine, String> {
    Ok(Affine::translate((length(node, "x")?, length(node, "y")?)))
}

pub(super) fn transform(node: &Node<'_, '_>) -> Result<Affine, String> {
    let Some(text) = node.attribute("transform") else { return Ok(Affine::IDENTITY) };
    let Transform { a, b, c, d, e, f } = Transform::from_str(text).map_err(|_| {
        format!("transform: expected matrix, translate, scale, rotate or skew, found {text:?}")
    })?;
    Ok(Affine::new([a, b, c, d, e, f]))
}

/// A length in units of the drawing; 0 if it is not said.
fn length(node: &Node<'_, '_>, key: &str) -> Result<f64, String> {
    /// Units of an inch.
    const INCH: f64 = 96.0;
    let Some(text) = node.attribute(key).map(str::trim).filter(|text| !text.is_empty() && *text != "auto")
    else {
        return Ok(0.0);
    };
    let wrong = || format!("{key}: expected a number, found {text:?}");
    let Length { number, unit } = Length::from_str(text).map_err(|_| wrong())?;
    Ok(match unit {
        LengthUnit::None | LengthUnit::Px => number,
        LengthUnit::In => number * INCH,
        LengthUnit::Cm => number * INCH / 2.54,
        LengthUnit::Mm => number * INCH / 25.4,
        LengthUnit::Pt => number * INCH / 72.0,
        LengthUnit::Pc => number * INCH / 6.0,
        LengthUnit::Em | LengthUnit::Ex | LengthUnit::Percent => return Err(wrong()),
    })
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    // "1-2" is short for "1 -2".
    let text = text.replace('-', " -").replace("e -", "e-").replace("E -", "E-");
    let parts = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|part| !part.is_empty());
    parts.map(|part| part.parse().map_err(|_| format!("expected a number, found {part:?}"))).collect()
}
