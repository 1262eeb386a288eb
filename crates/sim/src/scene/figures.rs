//! Robots and people: figures of round parts that may move.

use nalgebra::{Point3, Vector3};
use visloc_core::geom::PlanarPose;

use super::{Color, Cuboid, Label, Lighting, Scene, Shape, Surface, TextureId};

/// What a figure is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FigureKind {
    /// A small humanoid robot, 58 cm high, white with a colored jersey.
    Robot,
    /// A person; the first color is the shirt.
    Person,
}

/// A figure with its colors, ready to be placed anywhere.
#[derive(Debug, Clone, Copy)]
pub struct Figure {
    kind: FigureKind,
    height_m: f32,
    body: TextureId,
    cloth: TextureId,
    joints: TextureId,
    dark: TextureId,
}

impl Scene {
    /// Prepares a robot with a jersey.
    pub fn robot_figure(&mut self, jersey: Color) -> Figure {
        Figure {
            kind: FigureKind::Robot,
            height_m: 0.58,
            body: self.add_color(Color::from_hex(0xe4_e4e0)),
            cloth: self.add_color(jersey),
            joints: self.add_color(Color::from_hex(0x70_7478)),
            dark: self.add_color(Color::from_hex(0x20_2226)),
        }
    }

    /// Prepares a person of a height in meters.
    pub fn person_figure(&mut self, height_m: f32, shirt: Color, trousers: Color) -> Figure {
        Figure {
            kind: FigureKind::Person,
            height_m,
            body: self.add_color(Color::from_hex(0xc8_9474)),
            cloth: self.add_color(shirt),
            joints: self.add_color(trousers),
            dark: self.add_color(Color::from_hex(0x2a_211c)),
        }
    }
}

impl Figure {
    /// Appends the figure's surfaces at a pose on the floor; `stride_rad` is the phase of its walk, `swing` how far
    /// its legs move, 0 to 1.
    pub fn place(
        &self,
        scene: &Scene,
        pose: &PlanarPose,
        (stride_rad, swing): (f32, f32),
        out: &mut Vec<Surface>,
    ) {
        let chest = Point3::new(pose.x_m as f32, pose.y_m as f32, self.height_m * 0.6);
        let lighting = scene.lighting_around(&chest);
        let (sin, cos) = (pose.yaw_rad as f32).sin_cos();
        let label = match self.kind {
            FigureKind::Robot => Label::Robot,
            FigureKind::Person => Label::Other,
        };
        let mut placer = Placer { scene, origin: (chest.x, chest.y), sin, cos, lighting, label, out };
        match self.kind {
            FigureKind::Robot => self.place_robot(&mut placer, stride_rad, swing, pose.yaw_rad as f32),
            FigureKind::Person => self.place_person(&mut placer),
        }
    }

    fn place_robot(&self, placer: &mut Placer<'_>, stride_rad: f32, swing: f32, yaw_rad: f32) {
        let shadow = placer.scene.shadow(placer.origin, (0.6, 0.6));
        placer.out.push(shadow);
        for side in [1.0_f32, -1.0] {
            let stride = swing * 0.035 * (stride_rad).sin() * side;
            let lift = swing * 0.02 * (stride_rad.cos() * side).max(0.0);
            let y = 0.05 * side;
            placer.cuboid([0.02 + stride, y, lift], [0.15, 0.085, 0.05], yaw_rad, self.body);
            placer.bar([stride, y, 0.05 + lift], [0.0, y, 0.15], 0.038, self.body);
            placer.ball([0.005, y, 0.155], 0.036, self.joints);
            placer.bar([0.0, y, 0.16], [0.0, y, 0.26], 0.043, self.body);
            placer.ball([0.0, 0.098 * side, 0.415], 0.043, self.body);
            let reach = -1.2 * stride;
            placer.bar([0.0, 0.108 * side, 0.40], [0.02 + reach, 0.115 * side, 0.31], 0.029, self.body);
            placer.bar(
                [0.02 + reach, 0.115 * side, 0.31],
                [0.07 + reach, 0.11 * side, 0.24],
                0.026,
                self.body,
            );
            placer.ball([0.075 + reach, 0.11 * side, 0.232], 0.03, self.joints);
            placer.ball([0.0, 0.058 * side, 0.515], 0.03, self.joints);
            placer.ball([0.049, 0.022 * side, 0.525], 0.016, self.dark);
        }
        placer.bar([0.0, 0.0, 0.235], [0.0, 0.0, 0.285], 0.078, self.body);
        placer.bar([0.0, 0.0, 0.285], [0.005, 0.0, 0.40], 0.077, self.cloth);
        placer.ball([0.005, 0.0, 0.395], 0.077, self.body);
        placer.ball([0.062, 0.0, 0.375], 0.02, self.dark);
        placer.bar([0.0, 0.0, 0.44], [0.0, 0.0, 0.47], 0.03, self.joints);
        placer.ball([0.0, 0.0, 0.515], 0.063, self.body);
    }

    fn place_person(&self, placer: &mut Placer<'_>) {
        let shadow = placer.scene.shadow(placer.origin, (1.1, 1.1));
        placer.out.push(shadow);
        let h = self.height_m;
        for side in [1.0_f32, -1.0] {
            let y = 0.052 * h * side;
            placer.bar([0.03, y, 0.0], [0.03, y, 0.05], 0.05 * h / 1.7, self.dark);
            placer.bar([0.0, y, 0.03], [0.0, y * 0.9, 0.48 * h], 0.045 * h, self.joints);
            placer.ball([0.0, 0.11 * h * side, 0.79 * h], 0.042 * h, self.cloth);
            placer.bar(
                [0.0, 0.115 * h * side, 0.79 * h],
                [0.01, 0.14 * h * side, 0.62 * h],
                0.032 * h,
                self.cloth,
            );
            placer.bar(
                [0.01, 0.14 * h * side, 0.62 * h],
                [0.06, 0.13 * h * side, 0.46 * h],
                0.024 * h,
                self.body,
            );
        }
        placer.bar([0.0, 0.0, 0.46 * h], [0.0, 0.0, 0.80 * h], 0.095 * h, self.cloth);
        placer.ball([0.0, 0.0, 0.79 * h], 0.092 * h, self.cloth);
        placer.bar([0.0, 0.0, 0.8 * h], [0.0, 0.0, 0.88 * h], 0.032 * h, self.body);
        placer.ball([0.0, 0.0, 0.93 * h], 0.062 * h, self.body);
        placer.ball([-0.012 * h, 0.0, 0.945 * h], 0.062 * h, self.dark);
    }
}

/// Puts parts given in the figure's own frame into the world.
struct Placer<'a> {
    scene: &'a Scene,
    origin: (f32, f32),
    sin: f32,
    cos: f32,
    lighting: Lighting,
    label: Label,
    out: &'a mut Vec<Surface>,
}

impl Placer<'_> {
    fn point(&self, [x, y, z]: [f32; 3]) -> Point3<f32> {
        Point3::new(
            self.origin.0 + self.cos * x - self.sin * y,
            self.origin.1 + self.sin * x + self.cos * y,
            z,
        )
    }

    fn bar(&mut self, from: [f32; 3], to: [f32; 3], radius_m: f32, texture: TextureId) {
        let base = self.point(from);
        let shape = Shape::Cylinder { base, axis: self.point(to) - base, radius_m };
        self.out.push(Surface::new(shape, texture, self.lighting.clone()).labelled(self.label));
    }

    fn ball(&mut self, center: [f32; 3], radius_m: f32, texture: TextureId) {
        let shape = Shape::Sphere { center: self.point(center), radius_m };
        self.out.push(Surface::new(shape, texture, self.lighting.clone()).labelled(self.label));
    }

    fn cuboid(&mut self, at: [f32; 3], size: [f32; 3], yaw_rad: f32, texture: TextureId) {
        let cuboid = Cuboid { center: self.point(at), size: Vector3::from(size), yaw_rad };
        for shape in cuboid.faces() {
            self.out.push(Surface::new(shape, texture, self.lighting.clone()).labelled(self.label));
        }
    }
}
