//! What stays: field, building, or the floor below a camera without a map.

use serde_json::Value;
use visloc_studio::Message;

use super::read::{list, number, numbers, single, singles, text};
use crate::{
    Color, Entry, Shape,
    entry::{
        Mesh,
        Radius::{Meters, Screen},
    },
};

const MAP: &str = "world/map";
const LINE: Color = Color::rgb(0xee_f2_f0);
const CARPET: [Color; 2] = [Color::rgb(0x23_50_3a), Color::rgb(0x27_58_40)];
const FLOOR: Color = Color::rgb(0x3a_3a_35);
const WALL: Color = Color::rgb(0xa4_af_bb);
const OPEN_DOOR: Color = Color::rgb(0x20_25_2b);
const GRID: Color = Color::rgb(0x3a_46_54);
/// Lines lie so far above the carpet, meters: else they flicker.
const ABOVE_M: f32 = 0.004;
/// Walls are drawn low, so that one looks into the rooms, meters.
const WALL_M: f32 = 0.35;
/// Width of a stripe of the carpet, meters: gives the eye a scale.
const STRIPE_M: f64 = 0.5;

/// Least x and y, and largest x and y.
pub(super) fn bounds(scene: &Message) -> [f64; 4] {
    let bounds = scene.header.get("world").and_then(|world| numbers(world.get("bounds_m")));
    bounds.unwrap_or([-3.0, -2.0, 3.0, 2.0])
}

/// What is drawn for the whole recording.
pub(super) fn entries(scene: &Message) -> Vec<Entry> {
    let up = Entry::always("world", Shape::UpIsZ);
    let Some(world) = scene.header.get("world") else { return vec![up] };
    let bounds = bounds(scene);
    let mut entries = match text(world, "kind") {
        Some("field") => field(world, bounds),
        Some("office") => office(world),
        Some("space") => vec![grid(bounds, number(world, "floor_m").unwrap_or(0.0))],
        _ => Vec::new(),
    };
    entries.insert(0, up);
    entries
}

fn at(name: &str, shape: Shape) -> Entry {
    Entry::always(format!("{MAP}/{name}"), shape)
}

fn field(world: &Value, [x0, y0, x1, y1]: [f64; 4]) -> Vec<Entry> {
    let mut ground = Mesh::default();
    let num_stripes = 2.0 * ((x1 - x0) / 2.0 / STRIPE_M).round().max(1.0);
    let mut i = 0.0;
    while i < num_stripes {
        let [a, b] = [i, i + 1.0].map(|k| single(x0 + (x1 - x0) * k / num_stripes));
        let [low, high] = singles([y0, y1]);
        let color = CARPET[usize::from(i % 2.0 > 0.5)];
        ground.fan(&[[a, low, 0.0], [b, low, 0.0], [b, high, 0.0], [a, high, 0.0]], color);
        i += 1.0;
    }
    let width = single(number(world, "line_width_m").unwrap_or(0.05));
    let mut lines = Mesh::default();
    for line in list(world.get("lines")).chain(list(world.get("marks"))) {
        let Some([ax, ay, bx, by]) = numbers(Some(line)).map(singles::<4>) else { continue };
        // Ends reach to the borders of the lines that they meet.
        let length = (bx - ax).hypot(by - ay).max(1e-6);
        let (ex, ey) = ((bx - ax) / length * width / 2.0, (by - ay) / length * width / 2.0);
        lines.strip([ax - ex, ay - ey], [bx + ex, by + ey], width, ABOVE_M, LINE);
    }
    circle(&mut lines, single(number(world, "circle_radius_m").unwrap_or(0.0)), width);
    let goals = list(world.get("goals")).enumerate();
    let goals = goals.filter_map(|(i, goal)| Some(at(&format!("goal{i}"), goal_frame(goal)?)));
    [at("ground", Shape::Mesh(ground)), at("lines", Shape::Mesh(lines))].into_iter().chain(goals).collect()
}

fn circle(lines: &mut Mesh, radius: f32, width: f32) {
    const NUM_PIECES: u8 = 72;
    let point = |i: u8, radius: f32| {
        let angle = std::f32::consts::TAU * f32::from(i) / f32::from(NUM_PIECES);
        [radius * angle.cos(), radius * angle.sin(), ABOVE_M]
    };
    let (inner, outer) = (radius - width / 2.0, radius + width / 2.0);
    for i in 0..NUM_PIECES {
        lines.fan(&[point(i, inner), point(i, outer), point(i + 1, outer), point(i + 1, inner)], LINE);
    }
}

/// Posts and crossbar.
fn goal_frame(goal: &Value) -> Option<Shape> {
    let get = |key: &str| number(goal, key).map(single);
    let (x, y, height) = (get("x_m")?, get("post_y_m")?, get("height_m")?);
    let frame = vec![[x, -y, 0.0], [x, -y, height], [x, y, height], [x, y, 0.0]];
    let color = Color::from_hex(text(goal, "color").unwrap_or_default());
    let radius = Meters(get("radius_m").unwrap_or(0.05));
    Some(Shape::Lines { strips: vec![frame], colors: vec![color], radius })
}

fn office(world: &Value) -> Vec<Entry> {
    let mut ground = Mesh::default();
    for outline in list(world.get("floors")) {
        let corners = list(Some(outline)).filter_map(|corner| numbers(Some(corner)));
        let corners: Vec<[f32; 2]> = corners.map(singles).collect();
        for triangle in super::triangles::triangles(&corners) {
            ground.fan(&triangle.map(|[x, y]| [x, y, 0.0]), FLOOR);
        }
    }
    let mut walls = Mesh::default();
    for wall in list(world.get("walls")) {
        let Some([ax, ay, bx, by]) = numbers(Some(wall)).map(singles::<4>) else { continue };
        walls.wall([ax, ay], [bx, by], WALL_M, WALL);
        ground.strip([ax, ay], [bx, by], 0.05, ABOVE_M, WALL);
    }
    let mut doors = Mesh::default();
    for door in list(world.get("doors")) {
        let Some([ax, ay, bx, by]) = numbers(door.get("ends")).map(singles::<4>) else { continue };
        let is_open = door.get("is_open").and_then(Value::as_bool).unwrap_or(false);
        let color = text(door, "color").map_or(Color::rgb(0xb0_30_30), Color::from_hex);
        // A little in front of the wall, on the side from which it is seen.
        let length = (bx - ax).hypot(by - ay).max(1e-6);
        let (nx, ny) = ((by - ay) / length * 0.015, -(bx - ax) / length * 0.015);
        let (from, to) = ([ax + nx, ay + ny], [bx + nx, by + ny]);
        doors.wall(from, to, 1.25 * WALL_M, if is_open { OPEN_DOOR } else { color });
        doors.strip(from, to, 0.09, 2.0 * ABOVE_M, if is_open { OPEN_DOOR } else { color });
    }
    vec![at("ground", Shape::Mesh(ground)), at("walls", Shape::Mesh(walls)), at("doors", Shape::Mesh(doors))]
}

/// Lines on the floor around what a camera without a map has seen.
fn grid([x0, y0, x1, y1]: [f64; 4], floor_m: f64) -> Entry {
    let step = (((x1 - x0) / 24.0 * 2.0).ceil() / 2.0).max(0.5);
    let mut strips = Vec::new();
    let mut line = |a: [f64; 2], b: [f64; 2]| {
        strips.push([a, b].map(|[x, y]| singles([x, y, floor_m])).to_vec());
    };
    let (mut x, mut y) = ((x0 / step).ceil() * step, (y0 / step).ceil() * step);
    while x <= x1 {
        line([x, y0], [x, y1]);
        x += step;
    }
    while y <= y1 {
        line([x0, y], [x1, y]);
        y += step;
    }
    at("floor", Shape::Lines { strips, colors: vec![GRID], radius: Screen(0.5) })
}
