//! Things that stand around: what a camera sees beyond the carpet.

use nalgebra::{Point3, Vector3};
use serde::Deserialize;
use visloc_core::{Rng, geom::PlanarPose};

use super::{Color, Cuboid, Paint, Pattern, Scene};

/// Kinds of furniture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FurnitureKind {
    /// A shelf with books, 1 m wide, 1.8 m high.
    Bookshelf,
    /// A desk with drawers and a monitor.
    Desk,
    /// A pile of cartons.
    Cartons,
    /// Two green metal boxes on each other.
    Crates,
    /// A chair of wood.
    Chair,
    /// A gray cabinet with drawers.
    Cabinet,
}

impl Scene {
    /// Adds furniture whose front looks along the heading of the pose.
    pub fn add_furniture(&mut self, kind: FurnitureKind, pose: &PlanarPose, rng: &mut Rng) {
        let mut builder = Builder { scene: self, pose, rng };
        match kind {
            FurnitureKind::Bookshelf => builder.bookshelf(),
            FurnitureKind::Desk => builder.desk(),
            FurnitureKind::Cartons => builder.cartons(),
            FurnitureKind::Crates => builder.crates(),
            FurnitureKind::Chair => builder.chair(),
            FurnitureKind::Cabinet => builder.cabinet(),
        }
    }
}

struct Builder<'a> {
    scene: &'a mut Scene,
    pose: &'a PlanarPose,
    rng: &'a mut Rng,
}

impl Builder<'_> {
    /// A box at a place in the furniture's own frame (x to the front, y to the left), meters.
    fn part(&mut self, at: [f32; 3], size: [f32; 3], front: &Paint, sides: &Paint) {
        let floor = self.pose.transform(&nalgebra::Point2::new(f64::from(at[0]), f64::from(at[1])));
        let cuboid = Cuboid {
            center: Point3::new(floor.x as f32, floor.y as f32, at[2]),
            size: Vector3::from(size),
            yaw_rad: self.pose.yaw_rad as f32,
        };
        self.scene.add_cuboid(&cuboid, front, sides, self.rng);
    }

    fn shadow(&mut self, size_m: f32) {
        let center = (self.pose.x_m as f32, self.pose.y_m as f32);
        self.scene.add_shadow(center, (size_m, size_m));
    }

    fn bookshelf(&mut self) {
        let wood = Color::from_hex(0x9a_6c3c);
        self.shadow(1.9);
        let (front, sides) = (Paint::of(Pattern::Books, wood), Paint::of(Pattern::Wood, wood));
        self.part([0.0, 0.0, 0.0], [0.3, 1.0, 1.8], &front, &sides);
    }

    fn desk(&mut self) {
        let top = Paint::of(Pattern::Wood, Color::from_hex(0xb0_8450));
        let metal = Paint::flat(Color::from_hex(0x40_444a));
        self.shadow(2.0);
        self.part([0.0, 0.0, 0.71], [0.7, 1.4, 0.03], &top, &top);
        for (x, y) in [(0.3, 0.65), (0.3, -0.65), (-0.3, 0.65), (-0.3, -0.65)] {
            self.part([x, y, 0.0], [0.04, 0.04, 0.71], &metal, &metal);
        }
        let gray = Color::from_hex(0x9c_a0a4);
        let (front, sides) = (Paint::of(Pattern::Drawers, gray), Paint::flat(gray));
        self.part([0.0, -0.38, 0.05], [0.55, 0.42, 0.58], &front, &sides);
        let dark = Paint::flat(Color::from_hex(0x1c_1e22));
        self.part([-0.1, 0.15, 0.74], [0.16, 0.2, 0.1], &dark, &dark);
        self.part([-0.05, 0.15, 0.84], [0.04, 0.55, 0.34], &dark, &dark);
    }

    fn cartons(&mut self) {
        let carton = Paint::of(Pattern::Carton, Color::from_hex(0xa8_7a48));
        self.shadow(1.3);
        self.part([0.0, 0.18, 0.0], [0.4, 0.5, 0.4], &carton, &carton);
        self.part([0.05, -0.30, 0.0], [0.35, 0.38, 0.32], &carton, &carton);
        self.part([-0.02, 0.12, 0.4], [0.35, 0.4, 0.3], &carton, &carton);
    }

    fn crates(&mut self) {
        let green = Paint::of(Pattern::Carton, Color::from_hex(0x5c_6c2c));
        self.shadow(1.2);
        self.part([0.0, 0.0, 0.0], [0.45, 0.7, 0.42], &green, &green);
        self.part([0.0, -0.12, 0.42], [0.4, 0.42, 0.38], &green, &green);
    }

    fn chair(&mut self) {
        let wood = Paint::of(Pattern::Wood, Color::from_hex(0x8a_5a30));
        self.shadow(0.9);
        self.part([0.0, 0.0, 0.42], [0.42, 0.42, 0.04], &wood, &wood);
        for (x, y) in [(0.18, 0.18), (0.18, -0.18), (-0.18, 0.18), (-0.18, -0.18)] {
            self.part([x, y, 0.0], [0.04, 0.04, 0.42], &wood, &wood);
        }
        self.part([-0.19, 0.0, 0.46], [0.03, 0.42, 0.45], &wood, &wood);
    }

    fn cabinet(&mut self) {
        let gray = Color::from_hex(0x88_8e96);
        self.shadow(1.3);
        let (front, sides) = (Paint::of(Pattern::Drawers, gray), Paint::flat(gray));
        self.part([0.0, 0.0, 0.0], [0.5, 0.8, 1.1], &front, &sides);
    }
}
