//! Plans as SVG: lines, polylines, polygons, rectangles and straight paths.

use nalgebra::Matrix3;
use roxmltree::{Document, Node};

use super::drawing::{Role, Stroke, plan_of, role_by_name};
use crate::{
    MapError,
    office::{OfficePlan, SurfaceColor},
};

/// Reads the straight strokes of an SVG file; `name` is used in errors, and `title` becomes the name of the map.
///
/// What a stroke is, its `id`, `class` or Inkscape's layer name says, or that of the nearest group around it: `wall`,
/// `corridor` or `door` (`open` too: it stands open) as a part of the name. Strokes without such a name are doors if their
/// stroke has a hue, and walls if it is gray or black. One unit is a meter, unless the root element has an attribute
/// `data-meters-per-unit`. The y axis of the image, which points down, is turned up.
///
/// # Errors
/// If the text is not SVG, a stroke is not straight or a number cannot be read. The error names line and element.
pub fn read_svg(name: &str, title: &str, text: &str) -> Result<OfficePlan, MapError> {
    let syntax =
        |line: Option<usize>, reason: String| MapError::Syntax { name: name.to_owned(), line, reason };
    let document =
        Document::parse(text).map_err(|error| syntax(Some(error.pos().row as usize), error.to_string()))?;
    let root = document.root_element();
    let unit_m = match root.attribute("data-meters-per-unit") {
        None => 1.0,
        Some(value) => value.trim().parse().ok().filter(|unit: &f64| *unit > 0.0).ok_or_else(|| {
            syntax(None, format!("data-meters-per-unit: expected a number above 0, found {value:?}"))
        })?,
    };
    let mut strokes = Vec::new();
    for node in root.descendants().filter(Node::is_element) {
        let line = document.text_pos_at(node.range().start).row as usize;
        let fail = |reason: String| {
            let id = node.attribute("id").map(|id| format!(" {id:?}")).unwrap_or_default();
            syntax(Some(line), format!("<{}>{id}: {reason}", node.tag_name().name()))
        };
        let Some(mut drawn) = points(&node).map_err(fail)? else { continue };
        let Some(role) = role(&node) else { continue };
        let to_root = transform(&node).map_err(fail)?;
        for pieces in &mut drawn {
            for point in &mut pieces.points {
                let at = to_root * nalgebra::Vector3::new(point[0], point[1], 1.0);
                *point = [at.x * unit_m, -at.y * unit_m];
            }
            if pieces.points.len() < 2 || pieces.points.iter().flatten().any(|v| !v.is_finite()) {
                return Err(fail(format!("expected at least two points, found {}", pieces.points.len())));
            }
        }
        let with_role = |d: Drawn| Stroke { role, points: d.points, is_closed: d.is_closed };
        strokes.extend(drawn.into_iter().map(with_role));
    }
    if strokes.is_empty() {
        let reason = "expected straight strokes with wall, corridor or door in their id, class or layer, or with a \
                      color, found none";
        return Err(syntax(None, reason.to_owned()));
    }
    Ok(plan_of(title, &strokes))
}

/// Points of one connected line in the element's own units.
struct Drawn {
    points: Vec<[f64; 2]>,
    is_closed: bool,
}

/// What an element draws; `None` if it draws nothing that a plan has.
fn points(node: &Node<'_, '_>) -> Result<Option<Vec<Drawn>>, String> {
    let number = |key: &str| {
        let text = node.attribute(key).unwrap_or("0").trim();
        text.parse::<f64>().map_err(|_| format!("{key}: expected a number, found {text:?}"))
    };
    let tag = node.tag_name().name();
    let one = |points, is_closed| Ok(Some(vec![Drawn { points, is_closed }]));
    match tag {
        "line" => one(vec![[number("x1")?, number("y1")?], [number("x2")?, number("y2")?]], false),
        "polyline" | "polygon" => {
            let values = numbers(node.attribute("points").unwrap_or_default())?;
            one(values.chunks_exact(2).map(|xy| [xy[0], xy[1]]).collect(), tag == "polygon")
        }
        "rect" => {
            let [x, y, w, h] = [number("x")?, number("y")?, number("width")?, number("height")?];
            one(vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]], true)
        }
        "path" => path(node.attribute("d").unwrap_or_default()).map(Some),
        _ => Ok(None),
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let parts = text.split([',', ' ', '\n', '\t', '\r']).filter(|part| !part.is_empty());
    parts.map(|part| part.parse().map_err(|_| format!("expected a number, found {part:?}"))).collect()
}

/// A path of straight lines: `M`, `L`, `H`, `V` and `Z`, absolute or relative.
fn path(data: &str) -> Result<Vec<Drawn>, String> {
    let mut drawn: Vec<Drawn> = Vec::new();
    let mut at = [0.0, 0.0];
    let mut rest = data.trim_start();
    while let Some(command) = rest.chars().next() {
        if !command.is_ascii_alphabetic() {
            return Err(format!("d: expected a command, found {command:?}"));
        }
        let is_argument_end = |c: char| c.is_ascii_alphabetic() && c != 'e' && c != 'E';
        let end = rest[1..].find(is_argument_end).map_or(rest.len(), |i| i + 1);
        // "1-2" is short for "1 -2".
        let values = numbers(&rest[1..end].replace('-', " -").replace("e -", "e-"))?;
        let origin = |at: [f64; 2]| if command.is_ascii_lowercase() { at } else { [0.0, 0.0] };
        match command.to_ascii_uppercase() {
            'M' | 'L' => {
                for (i, xy) in values.chunks_exact(2).enumerate() {
                    at = [origin(at)[0] + xy[0], origin(at)[1] + xy[1]];
                    if i == 0 && command.eq_ignore_ascii_case(&'M') {
                        drawn.push(Drawn { points: Vec::new(), is_closed: false });
                    }
                    push(&mut drawn, at)?;
                }
            }
            axis @ ('H' | 'V') => {
                let axis = usize::from(axis == 'V');
                for value in values {
                    at[axis] = origin(at)[axis] + value;
                    push(&mut drawn, at)?;
                }
            }
            'Z' => {
                let last = drawn.last_mut().ok_or("d: expected M first")?;
                last.is_closed = true;
                at = last.points.first().copied().unwrap_or(at);
            }
            other => return Err(format!("d: expected straight lines (M, L, H, V, Z), found {other:?}")),
        }
        rest = rest[end..].trim_start();
    }
    Ok(drawn)
}

fn push(drawn: &mut [Drawn], at: [f64; 2]) -> Result<(), String> {
    drawn.last_mut().ok_or("d: expected M first")?.points.push(at);
    Ok(())
}

/// By name, or else by the color of the stroke.
fn role(node: &Node<'_, '_>) -> Option<Role> {
    let names = node.ancestors().filter(|n| n.is_element() && n.tag_name().name() != "svg").flat_map(|n| {
        let label = n.attributes().find(|a| a.name() == "label").map(|a| a.value());
        [n.attribute("id"), n.attribute("class"), label].into_iter().flatten()
    });
    let color = stroke_color(node);
    match role_by_name(names) {
        Some(Role::Door { is_open, .. }) => {
            Some(Role::Door { color: color.filter(|color| !color.is_gray()), is_open })
        }
        Some(role) => Some(role),
        None if color?.is_gray() => Some(Role::Wall),
        None => Some(Role::Door { color, is_open: false }),
    }
}

/// The color of the stroke, from the element or the nearest group that has one.
fn stroke_color(node: &Node<'_, '_>) -> Option<SurfaceColor> {
    node.ancestors().find_map(|n| {
        let styled = n.attribute("style").and_then(|style| {
            style.split(';').find_map(|rule| rule.trim().strip_prefix("stroke:")).map(str::trim)
        });
        styled.or(n.attribute("stroke")).and_then(|color| color.parse().ok())
    })
}

/// From the element's units to those of the root.
fn transform(node: &Node<'_, '_>) -> Result<Matrix3<f64>, String> {
    let mut all = Matrix3::<f64>::identity();
    for text in node.ancestors().filter_map(|n| n.attribute("transform")) {
        let mut own = Matrix3::<f64>::identity();
        for call in text.split(')').map(|call| call.trim_start_matches([' ', ','])).filter(|c| !c.is_empty())
        {
            let (function, arguments) = call.split_once('(').ok_or("transform: expected f(...)")?;
            own *= step(function.trim(), &numbers(arguments)?).ok_or_else(|| {
                format!("transform: expected matrix, translate, scale or rotate, found {call})")
            })?;
        }
        all = own * all;
    }
    Ok(all)
}

fn step(function: &str, values: &[f64]) -> Option<Matrix3<f64>> {
    Some(match (function, values) {
        ("matrix", [a, b, c, d, e, f]) => Matrix3::new(*a, *c, *e, *b, *d, *f, 0.0, 0.0, 1.0),
        ("translate", [x]) => Matrix3::new(1.0, 0.0, *x, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        ("translate", [x, y]) => Matrix3::new(1.0, 0.0, *x, 0.0, 1.0, *y, 0.0, 0.0, 1.0),
        ("scale", [s]) => Matrix3::new(*s, 0.0, 0.0, 0.0, *s, 0.0, 0.0, 0.0, 1.0),
        ("scale", [x, y]) => Matrix3::new(*x, 0.0, 0.0, 0.0, *y, 0.0, 0.0, 0.0, 1.0),
        ("rotate", [deg]) => {
            let (sin, cos) = deg.to_radians().sin_cos();
            Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
        }
        _ => return None,
    })
}
