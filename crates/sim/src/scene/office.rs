//! A building from inside: floor, ceiling, walls with a baseboard, doors, lamps along the corridors.

use nalgebra::{Point2, Point3, Vector3};
use rand::RngExt as _;
use visloc_core::Rng;
use visloc_world::office::{Door, Office, SurfaceColor, Wall};

use super::{Color, Label, Lamp, Lighting, Paint, Pattern, Scene, Shape, Surface};

/// Floor and ceiling are laid in squares, so that light and texture stay fine, meters.
const TILE_M: f64 = 4.0;
/// Longer walls are built of several pieces, meters.
const MAX_WALL_M: f64 = 8.0;
const FLOOR_PX_PER_M: f32 = 100.0;
const WALL_PX_PER_M: f32 = 110.0;
const DOOR_PX_PER_M: f32 = 160.0;
/// Doors stand out of the wall by this much, meters.
const DOOR_OFF_WALL_M: f64 = 0.005;
/// From one lamp to the next, meters.
const LAMP_PITCH_M: f64 = 2.5;

impl Scene {
    /// Adds everything that a building's map says, and the ceiling with its lamps.
    pub fn add_office(&mut self, office: &Office, lamps: &[Lamp], rng: &mut Rng) {
        self.add_levels(office, rng);
        for wall in office.walls() {
            self.add_wall(office, wall, rng);
        }
        for door in office.doors() {
            self.add_door(office, door, rng);
        }
        let panel = self.add_color(Color::from_hex(0xff_ffff));
        for lamp in lamps {
            let shape = Shape::level((lamp.x_m, lamp.y_m), (0.8, 0.8), lamp.z_m);
            self.add_surface(Surface::new(shape, panel, Lighting::Even(3.0)));
        }
    }

    /// Floor and ceiling wherever there is floor nearby.
    fn add_levels(&mut self, office: &Office, rng: &mut Rng) {
        let [min, max] = office.free_space().bounds_m();
        let floor = Paint::of(Pattern::Concrete, color(office.plan().floor_color));
        let ceiling = self.add_color(Color::from_hex(0xe0_e0dc));
        let height_m = office.plan().ceiling_height_m as f32;
        let count = |size_m: f64| (size_m / TILE_M).ceil() as usize;
        for column in 0..count(max.x - min.x) {
            for row in 0..count(max.y - min.y) {
                let corner = Point2::new(min.x + column as f64 * TILE_M, min.y + row as f64 * TILE_M);
                if !has_floor(office, &corner) {
                    continue;
                }
                let middle = ((corner.x + TILE_M / 2.0) as f32, (corner.y + TILE_M / 2.0) as f32);
                let size = (TILE_M as f32, TILE_M as f32);
                let shape = Shape::level(middle, size, 0.0);
                let paint = self.add_paint(&shape, &floor, FLOOR_PX_PER_M, rng);
                self.add_labelled(shape, paint, Label::Floor);
                let shape = Shape::Quad {
                    corner: Point3::new(corner.x as f32, corner.y as f32, height_m),
                    right: Vector3::new(TILE_M as f32, 0.0, 0.0),
                    down: Vector3::new(0.0, TILE_M as f32, 0.0),
                };
                self.add(shape, ceiling);
            }
        }
    }

    fn add_wall(&mut self, office: &Office, wall: &Wall, rng: &mut Rng) {
        let paint = Paint {
            second_color: Color::from_hex(0x8a_8680),
            ..Paint::of(Pattern::Wall, color(office.plan().wall_color))
        };
        let height_m = office.plan().ceiling_height_m as f32;
        let pieces = ((wall.end - wall.start).norm() / MAX_WALL_M).ceil().max(1.0);
        let at = |i: f64| {
            let point = wall.start + (wall.end - wall.start) * (i / pieces);
            (point.x as f32, point.y as f32)
        };
        let mut i = 0.0;
        while i < pieces {
            let shape = Shape::upright(at(i), at(i + 1.0), 0.0, height_m);
            let texture = self.add_paint(&shape, &paint, WALL_PX_PER_M, rng);
            self.add_labelled(shape, texture, Label::Wall);
            i += 1.0;
        }
    }

    fn add_door(&mut self, office: &Office, door: &Door, rng: &mut Rng) {
        let off = office.walls()[door.wall].normal() * DOOR_OFF_WALL_M;
        let at = |point: Point2<f64>| ((point.x + off.x) as f32, (point.y + off.y) as f32);
        let known = office.door_colors().get(usize::from(door.paint));
        let paint = match known {
            Some(known) if !door.is_open => Paint::of(Pattern::Door, color(*known)),
            // What is behind an open door is dark.
            _ => Paint::flat(Color::from_hex(0x24_2628)),
        };
        let shape = Shape::upright(at(door.left), at(door.right), 0.0, door.height_m as f32);
        let texture = self.add_paint(&shape, &paint, DOOR_PX_PER_M, rng);
        self.add_labelled(shape, texture, if door.is_open { Label::Other } else { Label::Door });
    }
}

/// Lamps along the middle of the corridors, each with a random strength from 1 - `unevenness` to 1 + `unevenness`.
pub(crate) fn office_lamps(office: &Office, unevenness: f32, rng: &mut Rng) -> Vec<Lamp> {
    let z_m = office.plan().ceiling_height_m as f32 - 0.02;
    lamp_places(office)
        .into_iter()
        .map(|place| Lamp {
            x_m: place.x as f32,
            y_m: place.y as f32,
            z_m,
            power: 1.0 + rng.random_range(-1.0..=1.0) * unevenness,
        })
        .collect()
}

/// Free places as far from the walls as possible, the pitch of lamps apart.
fn lamp_places(office: &Office) -> Vec<Point2<f64>> {
    let mut free: Vec<(f64, Point2<f64>)> = spots(office, 0.25)
        .into_iter()
        .map(|spot| (office.walls().iter().map(|wall| wall.distance_m(&spot)).fold(f64::MAX, f64::min), spot))
        .collect();
    // Stable: places equally far from the walls keep their order along the building.
    free.sort_by(|a, b| (b.0 * 8.0).round().total_cmp(&(a.0 * 8.0).round()));
    let mut places: Vec<Point2<f64>> = Vec::new();
    for (_, spot) in free {
        if places.iter().all(|place| (place - spot).norm() >= LAMP_PITCH_M) {
            places.push(spot);
        }
    }
    places
}

/// Free places on a regular grid.
pub(crate) fn spots(office: &Office, step_m: f64) -> Vec<Point2<f64>> {
    let [min, max] = office.free_space().bounds_m();
    let count = |size_m: f64| (size_m / step_m).floor() as usize;
    let (columns, rows) = (count(max.x - min.x), count(max.y - min.y));
    let at = |i: usize| {
        min + nalgebra::Vector2::new((i % columns.max(1)) as f64 + 0.5, (i / columns.max(1)) as f64 + 0.5)
            * step_m
    };
    (0..columns * rows).map(at).filter(|spot| office.free_space().contains(spot.x, spot.y)).collect()
}

/// Whether there is floor in a square.
fn has_floor(office: &Office, corner: &Point2<f64>) -> bool {
    let steps = 0..(TILE_M / 0.25) as usize;
    steps.clone().any(|i| {
        steps.clone().any(|j| {
            office.free_space().contains(corner.x + 0.25 * i as f64 + 0.12, corner.y + 0.25 * j as f64 + 0.12)
        })
    })
}

fn color(color: SurfaceColor) -> Color {
    let [r, g, b] = color.rgb;
    Color::from_hex(u32::from_be_bytes([0, r, g, b]))
}
