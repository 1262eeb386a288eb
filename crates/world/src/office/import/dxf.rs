//! Plans as text DXF: lines and polylines on layers.
//!
//! Source: AutoCAD DXF reference, group codes. Only what a plan of walls and doors needs is read: `LINE`, `LWPOLYLINE` and
//! `POLYLINE` with their layer, color and points, and the unit of the drawing. Everything else is passed over.

use std::collections::BTreeSet;

use super::drawing::{Role, Stroke, plan_of, role_by_name};
use crate::{
    MapError,
    office::{OfficePlan, SurfaceColor},
};

/// One entity while it is read.
#[derive(Debug, Default)]
struct Entity {
    kind: String,
    line: usize,
    layer: String,
    color: Option<i64>,
    flags: i64,
    has_bulge: bool,
    points: Vec<[f64; 2]>,
    end: [Option<f64>; 2],
}

/// Reads the lines and polylines of a text DXF file; `name` is used in errors, and `title` becomes the name of the map. A
/// layer whose name has `wall`, `door` (`open` too: it stands open) or `corridor` in it says what its lines are; other
/// layers are passed over. Lengths follow `$INSUNITS`, without it they are meters.
///
/// # Errors
/// If the text is not DXF, a wall or door is not straight, or there are no walls. The error names the line.
pub fn read_dxf(name: &str, title: &str, text: &str) -> Result<OfficePlan, MapError> {
    let fail =
        |line: usize, reason: String| MapError::Syntax { name: name.to_owned(), line: Some(line), reason };
    let mut strokes = Vec::new();
    let mut other_layers = BTreeSet::new();
    let mut unit_m = 1.0;
    let (mut section, mut variable) = (String::new(), String::new());
    let mut entity = Entity::default();
    let mut lines = text.lines().enumerate();
    while let (Some((number, code)), Some((_, value))) = (lines.next(), lines.next()) {
        let (line, value) = (number + 1, value.trim());
        let code: i64 = code.trim().parse().map_err(|_| {
            fail(line, format!("expected a group code, found {:?}; only text DXF is read", code.trim()))
        })?;
        let coordinate = || {
            let parsed: Result<f64, _> = value.parse();
            parsed.map_err(|_| fail(line + 1, format!("expected a number, found {value:?}")))
        };
        let is_entity = section == "ENTITIES";
        match code {
            0 => {
                // The vertices of an old polyline are entities of their own.
                let goes_on = entity.kind == "POLYLINE" && value == "VERTEX";
                if is_entity && !goes_on {
                    strokes.extend(stroke(&entity, unit_m).map_err(|reason| fail(entity.line, reason))?);
                    if entity.kind.ends_with("LINE") && role_by_name([entity.layer.as_str()]).is_none() {
                        other_layers.insert(entity.layer);
                    }
                    entity = Entity { kind: value.to_owned(), line, ..Entity::default() };
                }
            }
            2 if section.is_empty() => value.clone_into(&mut section),
            9 => value.clone_into(&mut variable),
            70 if section == "HEADER" && variable == "$INSUNITS" => {
                unit_m = unit(value).ok_or_else(|| fail(line + 1, format!("unknown unit {value}")))?;
            }
            8 if is_entity => value.clone_into(&mut entity.layer),
            62 if is_entity => entity.color = value.parse().ok(),
            70 if is_entity => entity.flags |= value.parse::<i64>().unwrap_or(0),
            42 if is_entity => entity.has_bulge |= coordinate()?.abs() > 1e-9,
            10 if is_entity => entity.points.push([coordinate()?, 0.0]),
            20 if is_entity => {
                let y = coordinate()?;
                if let Some(point) = entity.points.last_mut() {
                    point[1] = y;
                }
            }
            11 if is_entity => entity.end[0] = Some(coordinate()?),
            21 if is_entity => entity.end[1] = Some(coordinate()?),
            _ => {}
        }
        if code == 0 && value == "ENDSEC" {
            section.clear();
        }
    }
    if !section.is_empty() {
        return Err(fail(
            text.lines().count(),
            format!("expected ENDSEC, found the end in section {section}"),
        ));
    }
    if strokes.is_empty() {
        let reason = format!(
            "expected lines on layers whose names contain wall, corridor or door, found {}",
            found_layers(&other_layers)
        );
        return Err(MapError::Syntax { name: name.to_owned(), line: None, reason });
    }
    Ok(plan_of(title, &strokes))
}

/// The layers that have lines, to be renamed in the drawing.
fn found_layers(layers: &BTreeSet<String>) -> String {
    const MAX_SHOWN: usize = 12;
    if layers.is_empty() {
        return "no lines".to_owned();
    }
    let names: Vec<&str> = layers.iter().take(MAX_SHOWN).map(String::as_str).collect();
    let rest = if layers.len() > MAX_SHOWN { ", ..." } else { "" };
    format!("lines on {}{rest}", names.join(", "))
}

/// The stroke of an entity, if it is one of a plan.
fn stroke(entity: &Entity, unit_m: f64) -> Result<Option<Stroke>, String> {
    let Some(mut role) = role_by_name([entity.layer.as_str()]) else { return Ok(None) };
    let place = format!("{} on layer {}", entity.kind, entity.layer);
    let mut points = entity.points.clone();
    match (entity.kind.as_str(), entity.end) {
        ("LINE", [Some(x), Some(y)]) => points.push([x, y]),
        ("LINE", _) => return Err(format!("{place}: expected two ends (codes 10, 20, 11, 21), found one")),
        ("LWPOLYLINE", _) => {}
        // The first point of an old polyline is a dummy.
        ("POLYLINE", _) if !points.is_empty() => {
            points.remove(0);
        }
        // Door swings, texts and dimensions on the same layer.
        _ => return Ok(None),
    }
    if entity.has_bulge {
        return Err(format!("{place}: expected straight lines, found an arc"));
    }
    if points.len() < 2 || points.iter().flatten().any(|value| !value.is_finite()) {
        return Err(format!("{place}: expected at least two points, found {}", points.len()));
    }
    if let Role::Door { color, .. } = &mut role {
        *color = entity.color.and_then(door_color);
    }
    let points = points.iter().map(|[x, y]| [x * unit_m, y * unit_m]).collect();
    Ok(Some(Stroke { role, points, is_closed: entity.flags & 1 == 1 }))
}

/// Meters in a unit of `$INSUNITS`.
fn unit(code: &str) -> Option<f64> {
    Some(match code {
        "0" | "6" => 1.0,
        "1" => 0.0254,
        "2" => 0.3048,
        "4" => 0.001,
        "5" => 0.01,
        _ => return None,
    })
}

/// The first colors of the AutoCAD color index; the others are left to the default.
fn door_color(index: i64) -> Option<SurfaceColor> {
    let name = match index {
        1 => "red",
        2 => "yellow",
        3 => "green",
        4 => "cyan",
        5 => "blue",
        6 => "purple",
        _ => return None,
    };
    name.parse().ok()
}
