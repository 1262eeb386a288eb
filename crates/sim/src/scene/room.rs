//! A rectangular room around the field.

use nalgebra::{Point3, Vector3};
use serde::Deserialize;
use visloc_core::Rng;

use super::{Canvas, Color, Lamp, Lighting, Paint, Pattern, Scene, Shape, Surface, Texture, Wrap};

visloc_core::with_defaults! {
    /// A room with the origin in the middle of its floor.
    /// By default a hall that leaves about 1.8 m around the 2010 field.
    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    pub struct Room {
        /// Length along x, meters.
        pub length_m: f32 = 11.0,
        /// Width along y, meters.
        pub width_m: f32 = 8.8,
        /// Height, meters.
        pub height_m: f32 = 3.4,
        /// Color of the walls.
        pub wall_color: Color = Color::from_hex(0xdc_dad2),
        /// Color of the floor.
        pub floor_color: Color = Color::from_hex(0x8f_8d88),
        /// Random posters on each wall.
        pub posters_per_wall: u32 = 3,
    }
}

impl Room {
    /// The four walls as (from, to), from at the left for somebody inside: +y, +x, -y, -x.
    fn walls(&self) -> [((f32, f32), (f32, f32)); 4] {
        let (x, y) = (self.length_m / 2.0, self.width_m / 2.0);
        [((-x, y), (x, y)), ((x, y), (x, -y)), ((x, -y), (-x, -y)), ((-x, -y), (-x, y))]
    }
}

impl Scene {
    /// Adds floor, walls, ceiling, the lamps in it and posters.
    pub fn add_room(&mut self, room: &Room, lamps: &[Lamp], rng: &mut Rng) {
        const BELOW_CARPET_M: f32 = 0.004;
        const TILE_PX: u32 = 512;
        const FLOOR_PX_PER_M: f32 = 120.0;
        let floor_paint = Paint::of(Pattern::Concrete, room.floor_color);
        let tile_m = TILE_PX as f32 / FLOOR_PX_PER_M;
        let floor_canvas = floor_paint.canvas((tile_m, tile_m), FLOOR_PX_PER_M, rng);
        // Lengths in pixels are rounded; a repeating texture needs the exact power of two.
        let canvas = if floor_canvas.size_px() == (TILE_PX, TILE_PX) {
            floor_canvas
        } else {
            Canvas::new((TILE_PX, TILE_PX), room.floor_color)
        };
        let floor = self.add_texture(Texture::new(&canvas, Wrap::Repeat));
        let shape = Shape::level((0.0, 0.0), (room.length_m, room.width_m), -BELOW_CARPET_M);
        let repeats = (room.length_m / tile_m, room.width_m / tile_m);
        self.add_surface(Surface { repeats, ..self.surface(shape, floor) });

        let ceiling = self.add_color(Color::from_hex(0xe0_e0dc));
        let (x, y, z) = (room.length_m / 2.0, room.width_m / 2.0, room.height_m);
        let down = Vector3::new(0.0, 2.0 * y, 0.0);
        let right = Vector3::new(2.0 * x, 0.0, 0.0);
        self.add(Shape::Quad { corner: Point3::new(-x, -y, z), right, down }, ceiling);
        let panel = self.add_color(Color::from_hex(0xff_ffff));
        for lamp in lamps {
            let shape = Shape::level((lamp.x_m, lamp.y_m), (1.2, 0.3), lamp.z_m.min(z - 0.01));
            self.add_surface(Surface::new(shape, panel, Lighting::Even(3.0)));
        }
        for (from, to) in room.walls() {
            let paint = Paint {
                second_color: Color::from_hex(0x5c_5a58),
                ..Paint::of(Pattern::Wall, room.wall_color)
            };
            self.add_painted(Shape::upright(from, to, 0.0, room.height_m), &paint, 90.0, rng);
            self.add_posters(from, to, room.posters_per_wall, rng);
        }
    }

    /// Hangs random posters on the wall between two points.
    fn add_posters(&mut self, from: (f32, f32), to: (f32, f32), count: u32, rng: &mut Rng) {
        use rand::RngExt as _;
        const GROUNDS: [u32; 5] = [0xe8_e6e0, 0xd8_c8a0, 0x90_b0c8, 0xd0_8060, 0x60_8868];
        const OFF_WALL_M: f32 = 0.01;
        let along = Vector3::new(to.0 - from.0, to.1 - from.1, 0.0);
        let length_m = along.norm();
        let along = along / length_m;
        let inwards = Vector3::new(along.y, -along.x, 0.0) * OFF_WALL_M;
        let pitch_m = length_m / count.max(1) as f32;
        for poster in 0..count {
            let width_m = rng.random_range(0.5..1.0_f32).min(pitch_m * 0.8);
            let slack_m = (pitch_m - width_m).max(0.01);
            let start_m = poster as f32 * pitch_m + rng.random_range(0.0..slack_m);
            let at = |s: f32| (from.0 + along.x * s + inwards.x, from.1 + along.y * s + inwards.y);
            let shape = Shape::upright(
                at(start_m),
                at(start_m + width_m),
                rng.random_range(0.9..1.6),
                rng.random_range(0.4..0.9),
            );
            let ground = Color::from_hex(GROUNDS[rng.random_range(0..GROUNDS.len())]);
            self.add_painted(shape, &Paint::of(Pattern::Poster, ground), 150.0, rng);
        }
    }
}
