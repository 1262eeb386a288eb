//! The renderer: buffers and the order of the steps.

use std::sync::Arc;

use nalgebra::Point3;
use visloc_core::{
    RgbImage,
    geom::{Camera, CameraFrame, Rigid3, World},
};

use super::{
    blur::{CameraMotion, blur},
    labels::{Floor, LabelImage},
    overlay::lay_over,
    prepare::{Prepared, View, prepare},
    raster::{NOTHING, Visible, inverse_depth},
    rays::Rays,
    sensor::Sensor,
    shade::{Run, shade_run},
};
use crate::scene::{Label, Scene, Surface};

/// Light of the sky or of a gap, where there is no surface.
const BACKGROUND: [f32; 4] = [0.02, 0.02, 0.02, 1.0];
/// The exposure at which white paint under mean light is nearly full scale.
const MEAN_EXPOSURE: f32 = 0.95;
/// Sub-pixel positions that smooth an edge: a rotated grid.
const EDGE_SAMPLES: [(f32, f32); 8] = [
    (-0.4375, -0.0625),
    (-0.3125, 0.3125),
    (-0.1875, -0.3125),
    (-0.0625, 0.1875),
    (0.0625, -0.1875),
    (0.1875, 0.4375),
    (0.3125, -0.4375),
    (0.4375, 0.0625),
];

/// How one picture is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shot {
    /// The chip.
    pub sensor: Sensor,
    /// Brightness as a factor; 1 shows the mean light of the scene well.
    pub gain: f32,
    /// Color of all light, red, green and blue; white is 1, 1, 1.
    pub light_color: [f32; 3],
    /// Motion while the shutter is open.
    pub motion: CameraMotion,
    /// Seed of the noise.
    pub noise_seed: u64,
}

impl Shot {
    /// Neither noise nor blur.
    pub fn ideal() -> Self {
        Self {
            sensor: Sensor::ideal(),
            gain: 1.0,
            light_color: [1.0; 3],
            motion: CameraMotion::default(),
            noise_seed: 0,
        }
    }
}

/// Draws scenes for one camera. Holds all buffers, so that a picture needs no memory but its own.
///
/// ```
/// use visloc_core::geom::{Camera, PlanarPose, nao};
/// use visloc_sim::{Renderer, Scene, Shot};
/// let camera = Camera::pinhole((64, 48), (75.0, 75.0), (31.5, 23.5))?;
/// let robot_from_camera =
///     nao::robot_from_camera(&nao::Torso::upright(), &nao::HeadAngles::default(), nao::NaoCamera::TopV4);
/// let world_from_camera = PlanarPose::default().to_rigid3() * robot_from_camera;
/// let scene = Scene::new(vec![], 1.0, (1.0, 1.0));
/// let image = Renderer::new(&camera).render(&scene, &[], &world_from_camera, &Shot::ideal());
/// assert_eq!((image.width(), image.height()), (64, 48));
/// # Ok::<(), visloc_core::geom::CameraError>(())
/// ```
#[derive(Debug)]
pub struct Renderer {
    rays: Arc<Rays>,
    visible: Visible,
    prepared: Vec<Prepared>,
    overlays: Vec<Prepared>,
    light: Vec<[f32; 4]>,
    other: Vec<[f32; 4]>,
    edges: Vec<(usize, [f32; 4])>,
    shading: (f32, Vec<f32>),
}

impl Renderer {
    /// A renderer for a camera with any lens.
    pub fn new(camera: &Camera) -> Self {
        Self::with_rays(Arc::new(Rays::new(camera)))
    }

    /// Another renderer for the same camera, for another thread.
    #[must_use]
    pub fn sibling(&self) -> Self {
        Self::with_rays(Arc::clone(&self.rays))
    }

    fn with_rays(rays: Arc<Rays>) -> Self {
        let num_pixels = rays.width * rays.height;
        Self {
            visible: Visible::new(num_pixels),
            prepared: Vec::new(),
            overlays: Vec::new(),
            light: vec![BACKGROUND; num_pixels],
            other: vec![BACKGROUND; num_pixels],
            edges: Vec::new(),
            shading: (0.0, vec![1.0; num_pixels]),
            rays,
        }
    }

    /// Takes a picture of a scene and of moving surfaces from a camera pose (at the middle of the exposure).
    pub fn render(
        &mut self,
        scene: &Scene,
        moving: &[Surface],
        world_from_camera: &Rigid3<World, CameraFrame>,
        shot: &Shot,
    ) -> RgbImage {
        self.find_visible(scene, moving, &view(world_from_camera));
        self.shade_all(scene, moving);
        self.smooth_edges();
        for overlay in &self.overlays {
            let surface = surface(scene, moving, overlay.surface);
            let texture = scene.texture(surface.texture);
            lay_over(&mut self.light, overlay, (surface, texture), &self.visible, &self.rays);
        }
        if blur(&self.light, &mut self.other, &shot.motion, &self.visible, &self.rays) {
            std::mem::swap(&mut self.light, &mut self.other);
        }
        if self.shading.0 != shot.sensor.vignetting {
            self.shading = (shot.sensor.vignetting, shot.sensor.lens_shading(&self.rays));
        }
        let mut image = RgbImage::new(self.rays.width as u32, self.rays.height as u32);
        let exposure = shot.light_color.map(|share| MEAN_EXPOSURE * shot.gain * share);
        shot.sensor.develop(&self.light, &self.shading.1, exposure, shot.noise_seed, &mut image);
        image
    }

    /// What every pixel shows, without blur.
    pub fn labels(
        &mut self,
        scene: &Scene,
        moving: &[Surface],
        world_from_camera: &Rigid3<World, CameraFrame>,
    ) -> LabelImage {
        let view = view(world_from_camera);
        self.find_visible(scene, moving, &view);
        let floor = Floor {
            marks: scene.ground_marks(),
            world_from_camera: view.camera_from_world.transpose(),
            camera_in_world: view.camera_in_world,
        };
        let rays = &*self.rays;
        let label = |(i, id): (usize, &u32)| match *id {
            NOTHING => Label::Other,
            id => match surface(scene, moving, self.prepared[id as usize].surface).label {
                Label::Carpet => floor.label(rays.x[i], rays.y[i]),
                other => other,
            },
        };
        let labels = self.visible.nearest.iter().enumerate().map(label).collect();
        LabelImage::new(rays.width, rays.height, labels)
    }

    fn find_visible(&mut self, scene: &Scene, moving: &[Surface], view: &View) {
        self.visible.clear();
        self.prepared.clear();
        self.overlays.clear();
        for (index, surface) in scene.surfaces().iter().chain(moving).enumerate() {
            let Some(prepared) = prepare(surface, index as u32, view, &self.rays) else { continue };
            if surface.is_overlay {
                self.overlays.push(prepared);
            } else {
                self.visible.draw(&prepared, self.prepared.len() as u32, &self.rays);
                self.prepared.push(prepared);
            }
        }
    }

    fn shade_all(&mut self, scene: &Scene, moving: &[Surface]) {
        let rays = &*self.rays;
        for row in 0..rays.height {
            let mut start = row * rays.width;
            let row_end = start + rays.width;
            while start < row_end {
                let id = self.visible.nearest[start];
                let rest = &self.visible.nearest[start..row_end];
                let end = start + rest.iter().position(|other| *other != id).unwrap_or(rest.len());
                let out = &mut self.light[start..end];
                if id == NOTHING {
                    out.fill(BACKGROUND);
                } else {
                    let prepared = &self.prepared[id as usize];
                    let surface = surface(scene, moving, prepared.surface);
                    let run = Run {
                        x: &rays.x[start..end],
                        y: &rays.y[start..end],
                        inverse_depth: &self.visible.inverse_depth[start..end],
                        pitch: rays.pitch,
                    };
                    shade_run(prepared, surface, scene.texture(surface.texture), run, out);
                }
                start = end;
            }
        }
    }

    /// Where neighbors see different surfaces, finds the share of each in the pixel and mixes their colors.
    fn smooth_edges(&mut self) {
        self.edges.clear();
        let (width, height) = (self.rays.width, self.rays.height);
        let nearest = &self.visible.nearest;
        for row in 1..height - 1 {
            let line = |row: usize| &nearest[row * width..(row + 1) * width];
            let (above, here, below) = (line(row - 1), line(row), line(row + 1));
            for column in 1..width - 1 {
                let id = here[column];
                let differs = (here[column - 1] ^ id)
                    | (here[column + 1] ^ id)
                    | (above[column] ^ id)
                    | (below[column] ^ id);
                let i = row * width + column;
                let around = [i, i - 1, i + 1, i - width, i + width];
                if differs != 0 && self.is_contrast(&around) {
                    self.edges.push((i, self.edge_color(i, &around)));
                }
            }
        }
        for (i, color) in &self.edges {
            self.light[*i] = *color;
        }
    }

    /// Whether mixing some pixels could be seen at all.
    fn is_contrast(&self, around: &[usize; 5]) -> bool {
        const LEAST: f32 = 0.01;
        let middle = self.light[around[0]];
        around[1..].iter().any(|i| {
            let other = self.light[*i];
            (0..3).any(|part| (middle[part] - other[part]).abs() > LEAST)
        })
    }

    fn edge_color(&self, i: usize, around: &[usize; 5]) -> [f32; 4] {
        let (rays, nearest) = (&*self.rays, &self.visible.nearest);
        let (x, y) = (rays.x[i], rays.y[i]);
        let to_right = (rays.x[i + 1] - x, rays.y[i + 1] - y);
        let to_down = (rays.x[i + rays.width] - x, rays.y[i + rays.width] - y);
        let mut sum = [0.0_f32; 4];
        for (right, down) in EDGE_SAMPLES {
            let ray_x = x + to_right.0 * right + to_down.0 * down;
            let ray_y = y + to_right.1 * right + to_down.1 * down;
            let (mut best, mut best_w) = (BACKGROUND, 0.0);
            for (k, j) in around.iter().enumerate() {
                let id = nearest[*j];
                if id == NOTHING || around[..k].iter().any(|earlier| nearest[*earlier] == id) {
                    continue;
                }
                let w = inverse_depth(&self.prepared[id as usize].local, ray_x, ray_y);
                if w > best_w {
                    (best, best_w) = (self.light[*j], w);
                }
            }
            for (total, part) in sum.iter_mut().zip(best) {
                *total += part;
            }
        }
        sum.map(|part| part / EDGE_SAMPLES.len() as f32)
    }
}

fn view(world_from_camera: &Rigid3<World, CameraFrame>) -> View {
    View {
        camera_from_world: world_from_camera.rotation().transpose().cast(),
        camera_in_world: Point3::from(world_from_camera.translation().cast::<f32>()),
    }
}

fn surface<'a>(scene: &'a Scene, moving: &'a [Surface], index: u32) -> &'a Surface {
    let index = index as usize;
    let fixed = scene.surfaces();
    fixed.get(index).unwrap_or_else(|| &moving[index - fixed.len()])
}
