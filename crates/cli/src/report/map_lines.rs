//! A map as lines in space, to be laid over images.

use std::f64::consts::TAU;

use anyhow::{Result, bail};
use visloc_world::{Map, field::Field, office::Office};

/// The lines of a map through points of the world, meters.
pub fn map_lines(map: &Map) -> Result<Vec<Vec<[f64; 3]>>> {
    match map {
        Map::Field(field) => Ok(field_lines(field)),
        Map::Office(office) => Ok(office_lines(office)),
        other => bail!("{}: expected a field or a building", other.name()),
    }
}

/// Both borders of every line of a field, the circle, the axes of marks and goals.
fn field_lines(field: &Field) -> Vec<Vec<[f64; 3]>> {
    let half = 0.5 * field.dimensions().line_width_m;
    let mut all = Vec::new();
    for line in field.lines() {
        let along = (line.end - line.start).normalize();
        let side = nalgebra::Vector2::new(-along.y, along.x) * half;
        for s in [-1.0, 1.0] {
            // Outer borders of two lines that meet end in the corner that is seen.
            let (a, b) = (line.start + side * s - along * half, line.end + side * s + along * half);
            all.push(vec![[a.x, a.y, 0.0], [b.x, b.y, 0.0]]);
        }
    }
    for radius in [field.circle_radius_m() - half, field.circle_radius_m() + half] {
        let point = |i: i32| {
            let (sin, cos) = (f64::from(i) / 72.0 * TAU).sin_cos();
            [radius * cos, radius * sin, 0.0]
        };
        all.push((0..=72).map(point).collect());
    }
    for mark in field.marks() {
        all.push(vec![[mark.start.x, mark.start.y, 0.0], [mark.end.x, mark.end.y, 0.0]]);
    }
    for goal in field.goals() {
        let (x, y, z) = (goal.x_m, goal.post_y_m, goal.crossbar_z_m);
        all.push(vec![[x, -y, 0.0], [x, -y, z], [x, y, z], [x, y, 0.0]]);
    }
    all
}

/// Feet of the walls and outlines of the doors.
fn office_lines(office: &Office) -> Vec<Vec<[f64; 3]>> {
    let walls = office.walls().iter().map(|w| vec![[w.start.x, w.start.y, 0.0], [w.end.x, w.end.y, 0.0]]);
    let doors = office.doors().iter().map(|d| {
        let ((l, r), z) = ((d.left, d.right), d.height_m);
        vec![[l.x, l.y, 0.0], [l.x, l.y, z], [r.x, r.y, z], [r.x, r.y, 0.0]]
    });
    walls.chain(doors).collect()
}
