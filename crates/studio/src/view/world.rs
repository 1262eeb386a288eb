//! A map as geometry that a page can draw.

use nalgebra::Point2;
use serde_json::{Value, json};
use visloc_world::{
    Map,
    field::{Field, Goal, GoalColor, Segment},
    office::Office,
};

/// The map as JSON: `kind`, `bounds_m` and what is drawn, meters of the world frame.
pub fn world_geometry(map: &Map) -> Value {
    match map {
        Map::Field(field) => field_geometry(field),
        Map::Office(office) => office_geometry(office),
        other => json!({ "kind": "unknown", "name": other.name() }),
    }
}

fn field_geometry(field: &Field) -> Value {
    let (half_x, half_y) = field.half_carpet_m();
    let d = field.dimensions();
    let strip = |segment: &Segment| [segment.start.x, segment.start.y, segment.end.x, segment.end.y];
    json!({
        "kind": "field",
        "name": d.name,
        "bounds_m": [-half_x, -half_y, half_x, half_y],
        "line_width_m": d.line_width_m,
        "lines": field.lines().iter().map(strip).collect::<Vec<_>>(),
        "marks": field.marks().iter().map(strip).collect::<Vec<_>>(),
        "circle_radius_m": field.circle_radius_m(),
        "goals": field.goals().iter().map(goal_geometry).collect::<Vec<_>>(),
    })
}

fn goal_geometry(goal: &Goal) -> Value {
    let color = match goal.color {
        GoalColor::Yellow => "#f2c521",
        GoalColor::Blue => "#3f7bea",
        GoalColor::White => "#f2f2f2",
    };
    json!({
        "color": color,
        "x_m": goal.x_m,
        "post_y_m": goal.post_y_m,
        "radius_m": goal.post_radius_m,
        "height_m": goal.crossbar_z_m,
    })
}

fn office_geometry(office: &Office) -> Value {
    let plan = office.plan();
    let [min, max] = office.free_space().bounds_m();
    let hex = |rgb: [u8; 3]| format!("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
    let ends = |a: &Point2<f64>, b: &Point2<f64>| [a.x, a.y, b.x, b.y];
    let doors = office.doors().iter().map(|door| {
        json!({
            "ends": ends(&door.left, &door.right),
            "height_m": door.height_m,
            "color": office.door_colors().get(usize::from(door.paint)).map(|color| hex(color.rgb)),
            "is_open": door.is_open,
        })
    });
    json!({
        "kind": "office",
        "name": plan.name,
        "bounds_m": [min.x, min.y, max.x, max.y],
        "height_m": plan.ceiling_height_m,
        "wall_color": hex(plan.wall_color.rgb),
        "floor_color": hex(plan.floor_color.rgb),
        "floors": plan.corridors.iter().map(|corridor| &corridor.outline).collect::<Vec<_>>(),
        "walls": office.walls().iter().map(|wall| ends(&wall.start, &wall.end)).collect::<Vec<_>>(),
        "doors": doors.collect::<Vec<_>>(),
    })
}
