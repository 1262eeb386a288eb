//! The scene and how things are added to it.

use nalgebra::Point3;
use visloc_core::Rng;

use super::{
    Canvas, Color, Cuboid, GroundMark, Label, Lamp, Lighting, Paint, Shape, Surface, Texture, TextureId,
    Wrap,
    light::{Light, LightGrid},
};

/// Everything that can be seen.
#[derive(Debug, Clone)]
pub struct Scene {
    textures: Vec<Texture>,
    surfaces: Vec<Surface>,
    light: Light,
    shadow: TextureId,
    ground_marks: Vec<GroundMark>,
}

impl Scene {
    /// An empty scene. `ambient` is the light from everywhere as a multiple of the lamps' mean light on the floor; the
    /// light is scaled so that its mean over the floor of the given half sizes, meters, is 1. Without lamps there is
    /// ambient light only.
    pub fn new(lamps: Vec<Lamp>, ambient: f32, half_floor_m: (f32, f32)) -> Self {
        Self::lit(Light::new(lamps, ambient, half_floor_m))
    }

    /// An empty scene whose light has the mean 1 over spots of the floor, (x, y, 0) in meters.
    pub fn lit_over(lamps: Vec<Lamp>, ambient: f32, spots: &[Point3<f32>]) -> Self {
        Self::lit(Light::over(lamps, ambient, spots))
    }

    fn lit(light: Light) -> Self {
        let shadow = Texture::new(&shadow_canvas(), Wrap::Clamp);
        Self {
            textures: vec![shadow],
            surfaces: Vec::new(),
            light,
            shadow: TextureId(0),
            ground_marks: Vec::new(),
        }
    }

    /// Takes a texture in.
    pub fn add_texture(&mut self, texture: Texture) -> TextureId {
        self.textures.push(texture);
        TextureId(self.textures.len() as u32 - 1)
    }

    /// A texture of one color.
    pub fn add_color(&mut self, color: Color) -> TextureId {
        self.add_texture(Texture::new(&Canvas::new((1, 1), color), Wrap::Clamp))
    }

    /// Adds a shape that stays where it is.
    pub fn add(&mut self, shape: Shape, texture: TextureId) {
        self.surfaces.push(self.surface(shape, texture));
    }

    /// A shape in the light of its place.
    pub fn surface(&self, shape: Shape, texture: TextureId) -> Surface {
        let lighting = match LightGrid::new(&self.light, &shape) {
            Some(grid) => Lighting::Grid(grid),
            None => self.lighting_around(&shape.middle()),
        };
        Surface::new(shape, texture, lighting)
    }

    /// Adds a shape as part of something.
    pub fn add_labelled(&mut self, shape: Shape, texture: TextureId, label: Label) {
        self.surfaces.push(self.surface(shape, texture).labelled(label));
    }

    /// Adds a surface as it is.
    pub fn add_surface(&mut self, surface: Surface) {
        self.surfaces.push(surface);
    }

    /// Adds a shape with paint of the given resolution.
    pub fn add_painted(&mut self, shape: Shape, paint: &Paint, px_per_m: f32, rng: &mut Rng) {
        let texture = self.add_paint(&shape, paint, px_per_m, rng);
        self.add(shape, texture);
    }

    /// Paints a shape's texture with the given resolution.
    pub(super) fn add_paint(
        &mut self,
        shape: &Shape,
        paint: &Paint,
        px_per_m: f32,
        rng: &mut Rng,
    ) -> TextureId {
        let canvas = paint.canvas(shape.size_m(), px_per_m, rng);
        self.add_texture(Texture::new(&canvas, Wrap::Clamp))
    }

    /// Adds a box: `front` on its +x side, `sides` on the others.
    pub fn add_cuboid(&mut self, cuboid: &Cuboid, front: &Paint, sides: &Paint, rng: &mut Rng) {
        const PX_PER_M: f32 = 120.0;
        let [front_face, others @ ..] = cuboid.faces();
        self.add_painted(front_face, front, PX_PER_M, rng);
        let canvas = sides.canvas((cuboid.size.x.max(cuboid.size.y), cuboid.size.z), PX_PER_M, rng);
        let texture = self.add_texture(Texture::new(&canvas, Wrap::Clamp));
        for face in others {
            self.add(face, texture);
        }
    }

    /// Adds the soft shadow of something that stays where it is.
    pub fn add_shadow(&mut self, center: (f32, f32), size_m: (f32, f32)) {
        let shadow = self.shadow(center, size_m);
        self.surfaces.push(shadow);
    }

    /// A soft shadow on the floor.
    pub fn shadow(&self, center: (f32, f32), size_m: (f32, f32)) -> Surface {
        const ABOVE_FLOOR_M: f32 = 0.002;
        let shape = Shape::level(center, size_m, ABOVE_FLOOR_M);
        Surface { is_overlay: true, ..Surface::new(shape, self.shadow, Lighting::Even(0.0)) }
    }

    /// Light for round and moving things around a point.
    pub fn lighting_around(&self, point: &Point3<f32>) -> Lighting {
        let (ambient, toward) = self.light.around(point);
        Lighting::Shaded { ambient, toward }
    }

    /// Tells the labels where the carpet is painted.
    pub(super) fn set_ground_marks(&mut self, marks: Vec<GroundMark>) {
        self.ground_marks = marks;
    }

    pub(crate) fn ground_marks(&self) -> &[GroundMark] {
        &self.ground_marks
    }

    /// All surfaces.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    pub(crate) fn texture(&self, id: TextureId) -> &Texture {
        &self.textures[id.0 as usize]
    }
}

/// Black with an opacity that falls from the middle.
fn shadow_canvas() -> Canvas {
    const SIZE: u32 = 64;
    let mut canvas = Canvas::new((SIZE, SIZE), Color::from_hex(0));
    let offset = |i: u32| (i as f32 + 0.5) / SIZE as f32 * 2.0 - 1.0;
    canvas.set_opacity(|x, y| {
        let r2 = offset(x).powi(2) + offset(y).powi(2);
        0.8 * (1.0 - r2).max(0.0).powf(1.6)
    });
    canvas
}
