//! The rooms of the tours, and who walks in them.

use visloc_core::{Rng, RngTree, geom::PlanarPose};

use super::TourKind;
use crate::scene::{Color, Figure, FurnitureKind, Lamp, Room, Scene, Surface};

/// What is seen.
#[derive(Debug)]
pub(super) struct Place {
    pub(super) scene: Scene,
    people: Vec<(Figure, Way)>,
}

/// Back and forth between two points.
#[derive(Debug, Clone, Copy)]
struct Way {
    from: (f64, f64),
    to: (f64, f64),
    period_secs: f64,
}

impl Way {
    fn pose(&self, secs: f64) -> PlanarPose {
        let phase = (secs / self.period_secs).rem_euclid(1.0);
        let (share, is_back) = if phase < 0.5 { (2.0 * phase, false) } else { (2.0 - 2.0 * phase, true) };
        let (dx, dy) = (self.to.0 - self.from.0, self.to.1 - self.from.1);
        let yaw_rad = if is_back { (-dy).atan2(-dx) } else { dy.atan2(dx) };
        PlanarPose::new(self.from.0 + dx * share, self.from.1 + dy * share, yaw_rad)
    }
}

impl Place {
    pub(super) fn new(kind: TourKind, random: &RngTree) -> Self {
        let rng = &mut random.stream("place", 0);
        let (room, furniture) = match kind {
            TourKind::Hall => (room(12.0, 8.0, 4.0, 7), hall_furniture()),
            _ => (room(7.0, 5.6, 2.8, 5), room_furniture()),
        };
        let mut place = Self { scene: build(&room, &furniture, rng), people: Vec::new() };
        if kind == TourKind::Walking {
            place.add_people();
        }
        place
    }

    fn add_people(&mut self) {
        let ways = [
            (0x28_50a0, Way { from: (0.4, -2.0), to: (0.6, 2.0), period_secs: 9.0 }),
            (0xb0_3030, Way { from: (1.6, 2.2), to: (1.2, -1.8), period_secs: 12.0 }),
        ];
        for (shirt, way) in ways {
            let trousers = Color::from_hex(0x2c_2c38);
            let figure = self.scene.person_figure(1.75, Color::from_hex(shirt), trousers);
            self.people.push((figure, way));
        }
    }

    /// Surfaces of everybody who walks, at a time since the start.
    pub(super) fn moving(&self, secs: f64, out: &mut Vec<Surface>) {
        out.clear();
        for (figure, way) in &self.people {
            let stride_rad = (secs * 6.0).rem_euclid(std::f64::consts::TAU) as f32;
            figure.place(&self.scene, &way.pose(secs), (stride_rad, 1.0), out);
        }
    }
}

fn room(length_m: f32, width_m: f32, height_m: f32, posters_per_wall: u32) -> Room {
    Room { length_m, width_m, height_m, posters_per_wall, ..Room::default() }
}

fn build(room: &Room, furniture: &[(FurnitureKind, [f64; 3])], rng: &mut Rng) -> Scene {
    let mut lamps = Vec::new();
    for column in [-0.6_f32, 0.0, 0.6] {
        for row in [-0.5_f32, 0.5] {
            let (x_m, y_m) = (column * room.length_m / 2.0, row * room.width_m / 2.0);
            lamps.push(Lamp { x_m, y_m, z_m: room.height_m - 0.02, power: 1.0 + 0.15 * column * row });
        }
    }
    let mut scene = Scene::new(lamps.clone(), 0.6, (room.length_m / 2.0, room.width_m / 2.0));
    scene.add_room(room, &lamps, rng);
    for (kind, [x_m, y_m, yaw_deg]) in furniture {
        scene.add_furniture(*kind, &PlanarPose::new(*x_m, *y_m, yaw_deg.to_radians()), rng);
    }
    scene
}

/// Kind, x and y in meters, and where the front looks, degrees.
fn room_furniture() -> Vec<(FurnitureKind, [f64; 3])> {
    use FurnitureKind::{Bookshelf, Cabinet, Cartons, Chair, Crates, Desk};
    vec![
        (Desk, [-0.2, 0.1, 20.0]),
        (Chair, [0.4, 0.35, 200.0]),
        (Cartons, [0.5, -0.5, 35.0]),
        (Crates, [-0.6, -0.6, 120.0]),
        (Bookshelf, [-3.2, 1.2, 0.0]),
        (Bookshelf, [-3.2, -0.6, 0.0]),
        (Cabinet, [3.1, 1.4, 180.0]),
        (Bookshelf, [3.25, -1.0, 180.0]),
        (Crates, [1.8, 2.4, 270.0]),
        (Cartons, [-1.2, 2.4, 270.0]),
        (Cabinet, [-1.6, -2.4, 90.0]),
        (Bookshelf, [1.0, -2.55, 90.0]),
    ]
}

fn hall_furniture() -> Vec<(FurnitureKind, [f64; 3])> {
    use FurnitureKind::{Bookshelf, Cabinet, Cartons, Chair, Crates, Desk};
    let mut all = vec![
        (Desk, [0.0, 0.2, 10.0]),
        (Crates, [1.2, -0.3, 60.0]),
        (Cartons, [-1.1, -0.2, 200.0]),
        (Chair, [0.5, 0.7, 250.0]),
    ];
    for (i, x) in [-4.5, -2.2, 0.3, 2.6, 4.6].into_iter().enumerate() {
        let (near, far) = if i % 2 == 0 { (Bookshelf, Crates) } else { (Cartons, Bookshelf) };
        all.push((near, [x, 3.6, 270.0]));
        all.push((far, [x + 0.4, -3.6, 90.0]));
    }
    for y in [-1.8, 0.1, 2.0] {
        all.push((Cabinet, [5.6, y, 180.0]));
        all.push((Bookshelf, [-5.7, y + 0.3, 0.0]));
    }
    all
}
